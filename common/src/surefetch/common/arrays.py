"""Run-time checks of the arrays that messages carry: dtype and shape, with the field's name."""

from collections.abc import Sequence

import numpy as np


def check(name: str, value: object, dtype: type[np.generic], shape: Sequence[int | None]) -> None:
    """Refuse an array of another dtype or shape (None fits any size), or with non-finite numbers.

    Raises:
        ValueError: names the field, what was found and what is expected.
    """
    if not isinstance(value, np.ndarray):
        raise ValueError(f"{name}: expected an array, found {type(value).__name__}")
    if value.dtype != np.dtype(dtype):
        raise ValueError(f"{name}: expected dtype {np.dtype(dtype)}, found {value.dtype}")
    fits = len(shape) == value.ndim and all(
        want is None or want == have for want, have in zip(shape, value.shape, strict=True)
    )
    if not fits:
        wanted = tuple("any" if n is None else n for n in shape)
        raise ValueError(f"{name}: expected shape {wanted}, found {value.shape}")
    if np.issubdtype(value.dtype, np.floating) and not np.isfinite(value).all():
        raise ValueError(f"{name}: holds numbers that are not finite")
