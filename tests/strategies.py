"""Hypothesis strategies: one per message type, read off the type's own fields.

Arrays are the exception: their shapes depend on other fields, so the types that hold arrays say
here how they are made.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import msgspec
import numpy as np
from hypothesis import strategies as st
from msgspec import inspect
from numpy.typing import NDArray

from surefetch.common import messages as m
from surefetch.common.messages.base import INFINITE
from surefetch.common.topics import STREAMS, TOPICS

finite_numbers = st.floats(allow_nan=False, allow_infinity=False)
wire_integers = st.integers(-(2**63), 2**63 - 1)


def table_messages() -> tuple[type[m.Message], ...]:
    """Every message type in the topic table, and the refusal that every topic may answer."""
    kinds = {kind for topic in TOPICS for kind in (topic.request, topic.reply)}
    kinds |= {stream.message for stream in STREAMS} | {m.RefusedReply}
    return tuple(sorted(kinds, key=lambda kind: kind.__name__))


@cache
def messages_of(kind: type[m.Message]) -> st.SearchStrategy[Any]:
    """Values of one message type, all of its fields drawn."""
    info = inspect.type_info(kind)
    assert isinstance(info, inspect.StructType)
    fields = {
        field.name: _values_of(field.type)
        for field in info.fields
        if not isinstance(field.type, inspect.CustomType) and not _is_optional_array(field.type)
    }
    make: Callable[..., st.SearchStrategy[Any]] = _WITH_ARRAYS.get(kind, st.builds)
    return make(kind, **fields)


def numbers(
    *shape: int, dtype: type[np.generic] = np.float64, low: float = -1e6
) -> st.SearchStrategy[NDArray[Any]]:
    """Arrays of one shape; few random draws make them, so that examples stay small."""

    def made(seed: int) -> NDArray[Any]:
        rng = np.random.default_rng(seed)
        return rng.uniform(low, 1e6, shape).astype(dtype)

    return st.integers(0, 2**32 - 1).map(made)


def _values_of(kind: inspect.Type) -> st.SearchStrategy[Any]:
    match kind:
        case inspect.Metadata(type=inner, extra=extra):
            infinite = st.just(float("inf")) | st.just(float("-inf"))
            return _values_of(inner) | infinite if extra == INFINITE else _values_of(inner)
        case inspect.StructType(cls=cls):
            return messages_of(cls)
        case inspect.UnionType(types=types):
            return st.one_of([_values_of(one) for one in types])
        case inspect.LiteralType(values=values):
            return st.sampled_from(values)
        case inspect.VarTupleType(item_type=item):
            return st.lists(_values_of(item), max_size=2).map(tuple)
        case inspect.TupleType(item_types=items):
            return st.tuples(*map(_values_of, items))
        case inspect.DictType(key_type=key, value_type=value):
            return st.dictionaries(_values_of(key), _values_of(value), max_size=3)
        case _:
            return _plain_values_of(kind)


def _plain_values_of(kind: inspect.Type) -> st.SearchStrategy[Any]:
    match kind:
        case inspect.NoneType():
            return st.none()
        case inspect.BoolType():
            return st.booleans()
        case inspect.IntType():
            return wire_integers
        case inspect.FloatType():
            return finite_numbers
        case inspect.StrType(min_length=least, max_length=most):
            return st.text(min_size=least or 0, max_size=min(most or 20, 20))
        case inspect.BytesType():
            return st.binary(max_size=50)
        case _:
            raise NotImplementedError(f"no strategy for a field of type {kind}")


def _is_optional_array(kind: inspect.Type) -> bool:
    return isinstance(kind, inspect.UnionType) and any(
        isinstance(one, inspect.CustomType) for one in kind.types
    )


def _with_points(name: str) -> Any:
    """A type with one array of 3-D points."""

    def made(kind: Any, **fields: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
        points = st.integers(0, 3).flatmap(lambda n: numbers(n, 3, dtype=np.float32))
        return st.builds(kind, **{name: points}, **fields)

    return made


def _frame_infos(kind: Any, **fields: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    sizes = st.integers(1, 4)
    fields |= {"width": sizes, "height": sizes}
    return st.builds(kind, K=numbers(3, 3), T_world_camera=numbers(4, 4), **fields)


@st.composite
def _frames(draw: st.DrawFn, /, kind: Any, **fields: st.SearchStrategy[Any]) -> m.Frame:
    info = draw(messages_of(m.FrameInfo))
    rgb = numbers(info.height, info.width, 3, low=0).map(lambda a: (a % 256).astype(np.uint8))
    depth_m = numbers(info.height, info.width, dtype=np.float32)
    others = {name: values for name, values in fields.items() if name != "info"}
    frame: m.Frame = draw(st.builds(kind, info=st.just(info), rgb=rgb, depth_m=depth_m, **others))
    return frame


@st.composite
def _motions(draw: st.DrawFn, /, kind: Any, **fields: st.SearchStrategy[Any]) -> m.Motion:
    n = draw(st.integers(0, 3))
    arrays = {"times_s": numbers(n), "q_rad": numbers(n, 6), "gripper_width_m": numbers(n)}
    motion: m.Motion = draw(st.builds(kind, **arrays, **fields))
    return motion


def _truths(kind: Any, **fields: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    segmentation = numbers(2, 3, low=0).map(lambda a: (a % 9).astype(np.int16) - 6)
    return st.builds(kind, segmentation=st.none() | segmentation, **fields)


_WITH_ARRAYS: dict[type[msgspec.Struct], Any] = {
    m.Detection: _with_points("points_world_m"),
    m.Track: _with_points("points_world_m"),
    m.Estimate: _with_points("obstacle_points_world_m"),
    m.Observations: _with_points("obstacle_points_world_m"),
    m.FrameInfo: _frame_infos,
    m.Frame: _frames,
    m.Motion: _motions,
    m.Truth: _truths,
}
