"""Which numbers of a message must be finite, worked out once per type and then checked fast."""

import math
from collections.abc import Callable
from functools import cache
from typing import Any

from msgspec import inspect

from surefetch.common.messages.base import INFINITE, Message

Check = Callable[[Any, str], None]
"""Value and its path; raises ValueError that names the path."""


def check_finite(message: Message) -> None:
    """Refuse NaN and infinity in every float field, nested ones too; arrays are not looked into.

    Raises:
        ValueError: names the field.
    """
    check = _check_of_struct(type(message))
    if check is not None:
        check(message, "$")


@cache
def _check_of_struct(cls: type) -> Check | None:
    info = inspect.type_info(cls)
    if not isinstance(info, inspect.StructType):
        return None
    checks = [(field.name, _check_of(field.type)) for field in info.fields]
    wanted = [(name, check) for name, check in checks if check is not None]

    def check_fields(value: Any, path: str) -> None:
        for name, check in wanted:
            check(getattr(value, name), f"{path}.{name}")

    return check_fields if wanted else None


def _check_of(kind: inspect.Type) -> Check | None:
    """The check for one type; None where no float can be inside."""
    match kind:
        case inspect.FloatType():
            return _check_float
        case inspect.Metadata(type=inner, extra=extra):
            return _check_number if extra == INFINITE else _check_of(inner)
        case inspect.StructType(cls=cls):
            return _check_of_struct(cls)
        case inspect.UnionType(types=types):
            return _check_of_union(types)
        case inspect.VarTupleType(item_type=item):
            return _check_of_items(_check_of(item))
        case inspect.TupleType(item_types=items):
            return _check_of_tuple([_check_of(item) for item in items])
        case inspect.DictType(value_type=item):
            return _check_of_values(_check_of(item))
        case _:
            return None


def _check_float(value: float, path: str) -> None:
    if not math.isfinite(value):
        raise ValueError(f"{value} is not a finite number - at `{path}`")


def _check_number(value: float, path: str) -> None:
    if math.isnan(value):
        raise ValueError(f"{value} is not a number - at `{path}`")


def _check_of_union(types: tuple[inspect.Type, ...]) -> Check | None:
    structs = {
        kind.cls: _check_of_struct(kind.cls)
        for kind in types
        if isinstance(kind, inspect.StructType)
    }
    others = [
        check
        for kind in types
        if not isinstance(kind, inspect.StructType) and (check := _check_of(kind)) is not None
    ]
    if not others and not any(structs.values()):
        return None

    def check_union(value: Any, path: str) -> None:
        if value is None or isinstance(value, str):
            return
        check = structs.get(type(value))
        for one in [check] if type(value) in structs else others:
            if one is not None:
                one(value, path)

    return check_union


def _check_of_items(item: Check | None) -> Check | None:
    if item is None:
        return None

    def check_items(value: Any, path: str) -> None:
        for index, one in enumerate(value):
            item(one, f"{path}[{index}]")

    return check_items


def _check_of_tuple(items: list[Check | None]) -> Check | None:
    if not any(items):
        return None

    def check_tuple(value: Any, path: str) -> None:
        for index, (one, item) in enumerate(zip(value, items, strict=True)):
            if item is not None:
                item(one, f"{path}[{index}]")

    return check_tuple


def _check_of_values(item: Check | None) -> Check | None:
    if item is None:
        return None

    def check_values(value: Any, path: str) -> None:
        for key, one in value.items():
            item(one, f"{path}[{key!r}]")

    return check_values
