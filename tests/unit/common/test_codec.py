"""Laws of the codec, for every message type in the topic table."""

import copy
from collections.abc import Iterator
from typing import Any

import msgpack
import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import messages_of, table_messages

from surefetch.common import codec
from surefetch.common import messages as m
from surefetch.common.errors import CodecError

MAX = 1 << 20
EVERY_TYPE = pytest.mark.parametrize("kind", table_messages(), ids=lambda kind: kind.__name__)
laws = settings(max_examples=12, deadline=None)


def encoded(message: m.Message) -> bytes:
    return codec.encode(message, max_bytes=MAX)


def decoded(content: bytes, kind: type[m.Message]) -> m.Message:
    return codec.decode(content, kind, max_bytes=MAX)


def repacked(tree: Any) -> bytes:
    packed: bytes = msgpack.packb(tree)
    return packed


def same(one: Any, other: Any) -> bool:
    """Equal in type and value, through all fields, arrays bit by bit."""
    if isinstance(one, np.ndarray):
        return bool(one.dtype == other.dtype and one.shape == other.shape and (one == other).all())
    if isinstance(one, msgspec.Struct):
        fields = (same(getattr(one, f), getattr(other, f)) for f in one.__struct_fields__)
        return type(one) is type(other) and all(fields)
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return type(one) is type(other) and bool(one == other)


def places(tree: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """Every value in a plain tree with the keys that lead there."""
    yield path, tree
    items = tree.items() if isinstance(tree, dict) else ()
    for key, value in [*items, *(enumerate(tree) if isinstance(tree, list) else ())]:
        yield from places(value, (*path, key))


def changed(tree: Any, path: tuple[Any, ...], value: Any) -> Any:
    """A copy of the tree with another value at one place."""
    out = copy.deepcopy(tree)
    at = out
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = value
    return out


def is_array(value: Any) -> bool:
    return isinstance(value, dict) and set(value) == {"dtype", "shape", "data"}


@EVERY_TYPE
@laws
@given(st.data())
def test_decode_undoes_encode(kind: type[m.Message], data: st.DataObject) -> None:
    message = data.draw(messages_of(kind))
    assert same(decoded(encoded(message), kind), message)


@EVERY_TYPE
@laws
@given(st.data())
def test_any_client_reads_every_message_with_plain_messagepack(
    kind: type[m.Message], data: st.DataObject
) -> None:
    message = data.draw(messages_of(kind))
    plain = msgpack.unpackb(encoded(message))
    assert plain["surefetch"] == codec.WIRE_VERSION
    assert plain["message"] == kind.__name__
    assert set(plain["body"]) == {"type", *kind.__struct_fields__}
    for path, value in places(plain["body"]):
        if is_array(value):
            array = np.frombuffer(value["data"], value["dtype"]).reshape(value["shape"])
            assert same(array, _at(message, path))


def _at(value: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        value = getattr(value, key) if isinstance(key, str) else value[key]
    return value


@EVERY_TYPE
@laws
@given(st.data())
def test_decoded_arrays_are_closed_to_writing(kind: type[m.Message], data: st.DataObject) -> None:
    message = data.draw(messages_of(kind))
    back = decoded(encoded(message), kind)
    for path, value in places(msgpack.unpackb(encoded(message))["body"]):
        if is_array(value):
            assert not _at(back, path).flags.writeable


@EVERY_TYPE
@laws
@given(st.data())
def test_another_wire_version_is_refused_by_its_number(
    kind: type[m.Message], data: st.DataObject
) -> None:
    tree = msgpack.unpackb(encoded(data.draw(messages_of(kind))))
    tree["surefetch"] = data.draw(st.integers(2, 1000))
    with pytest.raises(CodecError, match=f"version {tree['surefetch']} "):
        decoded(repacked(tree), kind)


def test_a_later_version_is_told_even_if_its_envelope_has_more_in_it() -> None:
    tree = {"surefetch": 2, "signature": b"x", "message": "Empty", "body": {"type": "Empty"}}
    with pytest.raises(CodecError, match="version 2 "):
        decoded(repacked(tree), m.Empty)


@EVERY_TYPE
@laws
@given(st.data())
def test_a_missing_field_is_named(kind: type[m.Message], data: st.DataObject) -> None:
    tree = msgpack.unpackb(encoded(data.draw(messages_of(kind))))
    defaults = set(kind.__struct_defaults__ and _with_default(kind))
    for name in set(tree["body"]) - {"type"} - defaults:
        without = {key: value for key, value in tree["body"].items() if key != name}
        with pytest.raises(CodecError, match=f"`{name}`"):
            decoded(repacked(tree | {"body": without}), kind)


def _with_default(kind: type[m.Message]) -> list[str]:
    return [field.name for field in msgspec.structs.fields(kind) if not field.required]


@EVERY_TYPE
@laws
@given(st.data())
def test_an_unknown_field_is_named(kind: type[m.Message], data: st.DataObject) -> None:
    tree = msgpack.unpackb(encoded(data.draw(messages_of(kind))))
    tree["body"]["surplus"] = 1
    with pytest.raises(CodecError, match="surplus"):
        decoded(repacked(tree), kind)


@EVERY_TYPE
@laws
@given(st.data())
def test_a_value_of_a_wrong_type_is_refused_where_it_stands(
    kind: type[m.Message], data: st.DataObject
) -> None:
    tree = msgpack.unpackb(encoded(data.draw(messages_of(kind))))
    for name in set(tree["body"]) - {"type"}:
        wrong = changed(tree, ("body", name), msgpack.ExtType(5, b"no such value"))
        with pytest.raises(CodecError, match=rf"\$\.{name}`"):
            decoded(repacked(wrong), kind)


WITH_ARRAYS = pytest.mark.parametrize(
    "kind",
    [m.FrameInfo, m.Frame, m.Motion, m.Estimate, m.Track, m.Detection, m.Observations],
    ids=lambda kind: kind.__name__,
)


@WITH_ARRAYS
@laws
@given(st.data())
def test_an_array_of_another_dtype_shape_or_size_is_refused_by_its_field(
    kind: type[m.Message], data: st.DataObject
) -> None:
    tree = msgpack.unpackb(encoded(data.draw(messages_of(kind))))
    for path, array in [*places(tree)]:
        if not is_array(array):
            continue
        name = path[-1]
        for part, value in (
            ("dtype", "<f2"),
            ("dtype", "|O"),
            ("shape", [*array["shape"], 1]),
            ("shape", [-1]),
            ("shape", [2**40, 2**40]),
            ("data", array["data"] + b"\0"),
        ):
            with pytest.raises(CodecError, match=f"{name}"):
                decoded(repacked(changed(tree, (*path, part), value)), kind)


@WITH_ARRAYS
@laws
@given(st.data())
def test_a_consistent_array_of_a_wrong_shape_is_refused_by_its_field(
    kind: type[m.Message], data: st.DataObject
) -> None:
    tree = msgpack.unpackb(encoded(data.draw(messages_of(kind))))
    for path, array in [*places(tree)]:
        if is_array(array):
            size = int(np.dtype(array["dtype"]).itemsize)
            wrong = {"dtype": array["dtype"], "shape": [2, 7], "data": bytes(14 * size)}
            with pytest.raises(CodecError, match=f"{path[-1]}"):
                decoded(repacked(changed(tree, path, wrong)), kind)


@EVERY_TYPE
@laws
@given(st.data())
def test_a_number_that_is_not_finite_is_refused_both_ways_by_its_field(
    kind: type[m.Message], data: st.DataObject
) -> None:
    tree = msgpack.unpackb(encoded(data.draw(messages_of(kind))))
    for path, value in [*places(tree)]:
        if isinstance(value, float):
            names = [key for key in path if isinstance(key, str)]
            field = next(name for name in reversed(names) if name.isidentifier())
            with pytest.raises(CodecError, match=rf"not (a finite )?a? ?number.*{field}"):
                decoded(repacked(changed(tree, path, float("nan"))), kind)


def test_an_array_with_a_number_that_is_not_finite_is_refused_by_its_field() -> None:
    motion = m.Motion(
        label="x", times_s=np.zeros(1), q_rad=np.zeros((1, 6)), gripper_width_m=np.zeros(1)
    )
    tree = msgpack.unpackb(encoded(motion))
    data = np.full((1, 6), np.inf).tobytes()
    with pytest.raises(CodecError, match="finite.*q_rad"):
        decoded(repacked(changed(tree, ("body", "q_rad", "data"), data)), m.Motion)


def test_a_number_that_is_not_finite_is_not_sent() -> None:
    box = m.Box3d(center_world_m=(0.0, float("nan"), 0.0), size_m=(1.0, 1.0, 1.0), yaw_rad=0.0)
    with pytest.raises(CodecError, match=r"center_world_m\[1\]"):
        encoded(box)


def test_only_the_threshold_may_be_infinite() -> None:
    stopped = m.Stopped(was_moving=True, took_s=float("inf"))
    with pytest.raises(CodecError, match="took_s"):
        encoded(stopped)


@EVERY_TYPE
@laws
@given(st.data())
def test_oversize_is_refused_both_ways_by_the_number_of_bytes(
    kind: type[m.Message], data: st.DataObject
) -> None:
    message = data.draw(messages_of(kind))
    content = encoded(message)
    assert codec.encode(message, max_bytes=len(content)) == content
    with pytest.raises(CodecError, match=f"{len(content)} bytes"):
        codec.encode(message, max_bytes=len(content) - 1)
    with pytest.raises(CodecError, match=f"{len(content)} bytes"):
        codec.decode(content, kind, max_bytes=len(content) - 1)


@EVERY_TYPE
def test_another_message_is_refused_by_its_name(kind: type[m.Message]) -> None:
    other = m.Cancel if kind is not m.Cancel else m.FrameId
    tree = {"surefetch": 1, "message": other.__name__, "body": {"type": other.__name__}}
    with pytest.raises(CodecError, match=f"expected a message {kind.__name__}, found"):
        decoded(repacked(tree), kind)


@EVERY_TYPE
@laws
@given(st.binary(max_size=200))
def test_random_bytes_are_refused(kind: type[m.Message], content: bytes) -> None:
    with pytest.raises(CodecError):
        decoded(content, kind)


@EVERY_TYPE
@settings(max_examples=40, deadline=None)
@given(st.data())
def test_damaged_bytes_are_refused_or_make_a_whole_message(
    kind: type[m.Message], data: st.DataObject
) -> None:
    content = bytearray(encoded(data.draw(messages_of(kind))))
    for _ in range(data.draw(st.integers(1, 3))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    content = content[: data.draw(st.integers(0, len(content)))]
    try:
        message = decoded(bytes(content), kind)
    except CodecError:
        return
    assert same(decoded(encoded(message), kind), message)


@pytest.mark.parametrize(
    "bomb",
    [
        b"\xdd\xff\xff\xff\xff",
        b"\xdf\xff\xff\xff\xff",
        b"\xc6\xff\xff\xff\xff",
        b"\xdb\xff\xff\xff\xff",
        b"\x91" * 100_000,
        b"\x81\xa1a" * 100_000,
    ],
    ids=["array", "map", "bytes", "text", "nested arrays", "nested maps"],
)
def test_bytes_that_promise_more_than_they_hold_are_refused(bomb: bytes) -> None:
    start = b"\x83\xa9surefetch\x01\xa7message\xa8Instruct\xa4body"
    for content in (bomb, start + bomb):
        with pytest.raises(CodecError):
            decoded(content, m.Instruct)


def test_what_messagepack_cannot_hold_is_not_sent() -> None:
    with pytest.raises(CodecError, match="JournalPage"):
        encoded(m.JournalPage(offset=2**64))
    with pytest.raises(CodecError, match="Cancel"):
        encoded(m.Cancel(episode="\ud800"))
