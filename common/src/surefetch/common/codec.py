"""Messages to bytes and back: strict, versioned, bounded, readable with plain MessagePack.

A message travels as ``{"surefetch": 1, "message": "Frame", "body": {...}}``. An array in a body is
``{"dtype": "<f4", "shape": [480, 640], "data": <bytes>}``, row by row, little-endian.
"""

from functools import cache
from math import prod
from typing import Annotated, Any, Final, TypeVar, get_args

import msgspec
import numpy as np
from numpy.typing import NDArray

from surefetch.common.errors import CodecError
from surefetch.common.finite import check_finite
from surefetch.common.messages.base import Message

WIRE_VERSION: Final = 1
"""Raised with every change of a message; all machines of a cell are upgraded together."""

M = TypeVar("M", bound=Message)


class _Version(msgspec.Struct):
    """What every version of the envelope has."""

    surefetch: int


class _Envelope(msgspec.Struct, forbid_unknown_fields=True):
    surefetch: int
    message: str
    body: msgspec.Raw


class _Outgoing(msgspec.Struct):
    surefetch: int
    message: str
    body: Message


class _Array(msgspec.Struct, forbid_unknown_fields=True):
    dtype: str
    shape: Annotated[tuple[Annotated[int, msgspec.Meta(ge=0)], ...], msgspec.Meta(max_length=4)]
    data: bytes


def encode(message: Message, *, max_bytes: int) -> bytes:
    """The bytes of a message.

    Raises:
        CodecError: the message is larger than allowed or holds what cannot travel: a number that
            is not finite, an array of objects.
    """
    name = type(message).__name__
    try:
        check_finite(message)
        encoded = _ENCODER.encode(_Outgoing(WIRE_VERSION, name, message))
    except (ValueError, TypeError, AttributeError, OverflowError) as error:
        raise CodecError(f"{name} cannot be sent: {error}") from None
    _check_size(encoded, name, max_bytes)
    return encoded


def decode(encoded: bytes, expected: type[M], *, max_bytes: int) -> M:
    """The message in the bytes, whole and checked; its arrays are closed to writing.

    Raises:
        CodecError: too many bytes (told before anything is decoded), another wire version or
            message, a missing, unknown or mistyped field, an array of another dtype or shape, a
            number that is not finite. The text names the field.
    """
    name = expected.__name__
    _check_size(encoded, name, max_bytes)
    try:
        version = _VERSION.decode(encoded).surefetch
        if version != WIRE_VERSION:
            raise CodecError(
                f"{name}: wire version {version} is not understood; this side speaks version "
                f"{WIRE_VERSION}. Run the same surefetch on all machines of the cell."
            )
        envelope = _ENVELOPE.decode(encoded)
        if envelope.message != name:
            raise CodecError(f"expected a message {name}, found {envelope.message[:128]!r}")
        message: M = _decoder(expected).decode(envelope.body)
        check_finite(message)
    except (msgspec.MsgspecError, ValueError, RecursionError) as error:
        raise CodecError(f"{name}: {error}") from None
    return message


def _check_size(encoded: bytes, name: str, max_bytes: int) -> None:
    if len(encoded) > max_bytes:
        raise CodecError(f"{name}: {len(encoded)} bytes, and at most {max_bytes} are allowed")


@cache
def _decoder(expected: type[Message]) -> "msgspec.msgpack.Decoder[Any]":
    return msgspec.msgpack.Decoder(expected, dec_hook=_array_from)


def _plain_from(value: object) -> object:
    """Arrays and NumPy's own numbers as plain MessagePack can hold them."""
    if isinstance(value, np.ndarray):
        if value.dtype.kind not in "biuf":
            raise ValueError(f"an array of dtype {value.dtype} cannot travel")
        little = np.ascontiguousarray(value, dtype=value.dtype.newbyteorder("<"))
        return {"dtype": little.dtype.str, "shape": value.shape, "data": little.tobytes()}
    if isinstance(value, np.bool_ | np.integer | np.floating):
        return value.item()
    raise TypeError(f"a value of type {type(value).__name__} cannot travel")


def _array_from(kind: Any, value: Any) -> NDArray[Any]:
    """The array of one field; `kind` is its annotation, ``NDArray[np.float32]``."""
    (wanted,) = get_args(get_args(kind)[1])
    dtype = np.dtype(wanted).newbyteorder("<")
    try:
        parts = msgspec.convert(value, _Array)
    except msgspec.ValidationError as error:  # as a ValueError it is told with the field's name
        raise ValueError(f"no array: {error}") from None
    if parts.dtype != dtype.str:
        raise ValueError(f"expected an array of dtype {dtype.str}, found {parts.dtype[:16]!r}")
    n_bytes = prod(parts.shape) * dtype.itemsize
    if n_bytes != len(parts.data):
        raise ValueError(
            f"shape {parts.shape} of {dtype.str} needs {n_bytes} bytes, found {len(parts.data)}"
        )
    array: NDArray[Any] = np.ndarray(parts.shape, dtype, parts.data)
    if dtype.kind == "f" and not np.isfinite(array).all():
        raise ValueError("the array holds numbers that are not finite")
    return array


_ENCODER: Final = msgspec.msgpack.Encoder(enc_hook=_plain_from)
_VERSION: Final = msgspec.msgpack.Decoder(_Version)
_ENVELOPE: Final = msgspec.msgpack.Decoder(_Envelope)
