"""Arrays that come from outside, checked."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def reals(name: str, values: Any, *shape: int | None) -> Array:
    """The values as contiguous doubles of this shape, in which None is any length.

    Raises:
        TypeError: they are no real numbers.
        ValueError: they have another shape, or one is not finite.
    """
    given = np.asarray(values)
    if given.dtype.kind not in "iuf":
        raise TypeError(f"{name} holds {given.dtype}, not real numbers")
    fits = given.ndim == len(shape) and all(
        length in (None, own) for own, length in zip(given.shape, shape, strict=True)
    )
    if not fits:
        wanted = ", ".join("n" if length is None else str(length) for length in shape)
        raise ValueError(f"{name} has the shape {given.shape}, not ({wanted}{',' * (len(shape) == 1)})")
    found = np.ascontiguousarray(given, dtype=np.float64)
    odd = np.argwhere(~np.isfinite(found))
    if len(odd):
        place = ", ".join(str(at) for at in odd[0])
        raise ValueError(f"{name}[{place}] is {found[tuple(odd[0])]}, not a finite number")
    return found


def number(name: str, value: Any) -> float:
    """A finite real number.

    Raises:
        TypeError, ValueError: it is none.
    """
    if np.ndim(value):
        raise ValueError(f"{name} has the shape {np.shape(value)}, and one number is needed")
    return float(reals(name, np.reshape(value, 1), 1)[0])
