"""Numbers and arrays that come from outside, checked."""

from __future__ import annotations

import math
import operator
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: The largest whole number of a scene.
_LARGEST = 2**63 - 1


def given(name: str, values: Any) -> NDArray[Any]:
    """Values as an array, in which nothing is masked and nothing has units.

    Raises:
        TypeError: the values have units, a scene has none.
        ValueError: some are masked.
    """
    if _has_units(values) or (isinstance(values, (list, tuple)) and any(_has_units(one) for one in values)):
        raise TypeError(
            f"{name} has units, and numbers of a scene have none: give the numbers in the units of the scene, "
            f"as values.to_value(unit) of astropy or values.m_as(unit) of pint"
        )
    hidden = masked(values)
    if hidden is not None and hidden.any():
        raise ValueError(f"{_place(name, np.argwhere(hidden)[0])} is masked: every number is needed here, fill it or leave its row out")
    try:
        return np.asarray(values)
    except RecursionError:
        raise TypeError(f"{name} holds itself, or is nested without an end") from None


def masked(values: Any) -> NDArray[np.bool_] | None:
    """Where values of ``numpy.ma`` are masked; None for other values."""
    if isinstance(values, (list, tuple)) and any(isinstance(one, np.ma.MaskedArray) for one in values):
        values = np.ma.stack([np.ma.asarray(one) for one in values])
    return np.ma.getmaskarray(values) if isinstance(values, np.ma.MaskedArray) else None


def _has_units(values: Any) -> bool:
    # Quantities of astropy, pint and unyt; an array of xarray has at most a label.
    kind = type(values)
    return any(hasattr(kind, unit) for unit in ("unit", "units")) and hasattr(kind, "to")


def reals(name: str, values: Any, *shape: int | None) -> Array:
    """The values as contiguous doubles of this shape, in which None is any length.

    Raises:
        TypeError: they are no real numbers, or have units.
        ValueError: they have another shape, or one is masked or not finite.
    """
    found = real_numbers(name, values)
    fits = found.ndim == len(shape) and all(
        length in (None, own) for own, length in zip(found.shape, shape, strict=True)
    )
    if not fits:
        wanted = ", ".join("n" if length is None else str(length) for length in shape)
        raise ValueError(f"{name} has the shape {found.shape}, not ({wanted}{',' * (len(shape) == 1)})")
    odd = np.argwhere(~np.isfinite(found))
    if len(odd):
        raise ValueError(f"{_place(name, odd[0])} is {found[tuple(odd[0])]}, not a finite number")
    return found


def real_numbers(name: str, values: Any) -> Array:
    """The values as contiguous doubles, NaN and infinity among them.

    Raises:
        TypeError: they are no real numbers, or have units.
        ValueError: one is masked, or rows have different lengths.
    """
    found = given(name, values)
    if found.dtype.kind not in "iuf":
        raise TypeError(f"{name} holds {found.dtype}, not real numbers")
    return np.require(found, np.float64, ["C", "A"]).reshape(found.shape)


def with_gaps(name: str, values: Any) -> Array:
    """The same with NaN where values of ``numpy.ma`` are masked.

    Raises:
        TypeError: they are no real numbers, or have units.
    """
    hidden = masked(values)
    if hidden is None:
        return real_numbers(name, values)
    whole = np.ma.stack([np.ma.asarray(one) for one in values]) if isinstance(values, (list, tuple)) else values
    found = real_numbers(name, np.ma.getdata(whole)).copy()
    found[hidden] = np.nan
    return found


def in_order(name: str, values: Any, coordinates: Sequence[str]) -> Any:
    """The columns of a frame or a labelled array in the order of the coordinates, by their names; anything else unchanged.

    Names that are none of the coordinates, such as 0, 1, …, give no order.

    Raises:
        ValueError: there are the names of some coordinates, and others.
    """
    names = labels(values)
    known = [label for label in names or [] if label in coordinates]
    if names is None or not known:
        return values
    if sorted(map(str, names)) != sorted(coordinates):
        told = ", ".join(map(str, names))
        raise ValueError(f"{name} has the columns {told}, and the coordinates are {', '.join(coordinates)}")
    at = [names.index(label) for label in coordinates]
    if getattr(getattr(values, "dtype", None), "names", None):
        return np.stack([values[name] for name in coordinates], axis=-1)
    if hasattr(values, "iloc"):
        return values.iloc[:, at] if np.ndim(values) == 2 else values.iloc[at]
    return np.asarray(values)[..., at]


def labels(values: Any) -> list[Any] | None:
    """Names of the last axis: columns of a frame, the index of a series, a coordinate of xarray, fields of a table."""
    if hasattr(values, "columns"):
        return list(values.columns)
    if hasattr(values, "iloc") and hasattr(values, "index"):
        return list(values.index)
    if hasattr(values, "dims") and hasattr(values, "coords"):
        last = values.dims[-1] if values.dims else None
        return np.asarray(values.coords[last]).tolist() if last in values.coords else None
    names = getattr(getattr(values, "dtype", None), "names", None)
    return list(names) if names else None


def plain(name: str, value: Any) -> Any:
    """An array, a number of one or another mapping as lists, numbers and tables of Python, which scenes hold.

    Raises:
        TypeError: it holds none of these.
        ValueError: a part of it is masked.
    """
    if isinstance(value, Mapping):
        return dict(value)
    names = labels(value)
    if names and np.ndim(value) == 1 and all(isinstance(label, str) for label in names):
        return dict(zip(names, np.asarray(value).tolist(), strict=True))
    found = given(name, value)
    kind = found.dtype.kind
    if found.dtype.names or (kind == "O" and found.ndim == 0):
        raise TypeError(f"{name}: a scene holds numbers, strings, booleans, lists and tables, not {type(value).__name__}")
    if kind == "f" and found.dtype.itemsize > 8:
        raise TypeError(f"{name} holds {found.dtype}, and a scene doubles: round it by astype(float)")
    if kind not in "biufUO":
        raise TypeError(f"{name}: a scene holds numbers, strings, booleans, lists and tables, not {found.dtype}")
    return found.tolist()


def table(name: str, value: Any) -> dict[str, Any]:
    """A mapping of names; an empty one for None.

    Raises:
        TypeError: it is none.
    """
    if value is None:
        return {}
    if not isinstance(value, Mapping) and not (hasattr(value, "keys") and hasattr(value, "__getitem__")):
        raise TypeError(f"{name} is {short(value)}, not a table: give names with their values, {{'name': value}}")
    found = {key: value[key] for key in value.keys()}
    for key in found:
        if not isinstance(key, str):
            raise TypeError(f"{name}: names are strings, not {short(key)}")
    return found


def listed(name: str, value: Any) -> list[Any]:
    """A list; of names a text is none, whose letters would be taken one by one.

    Raises:
        TypeError: it is none.
    """
    if isinstance(value, (str, bytes, Mapping)):
        raise TypeError(f"{name} is {short(value)}, not a list: give [{short(value)}]")
    try:
        return list(value)
    except TypeError:
        raise TypeError(f"{name} is {short(value)}, not a list") from None


def names(name: str, value: Any) -> list[str]:
    """A list of names.

    Raises:
        TypeError: it is none.
    """
    found = listed(name, value)
    for one in found:
        if not isinstance(one, str):
            raise TypeError(f"{name} holds {short(one)}, not names alone")
    return [str(one) for one in found]


def count(name: str, value: Any, least: int) -> int:
    """A whole number from ``least`` on.

    Raises:
        TypeError: it is no whole number.
        ValueError: it is smaller, or larger than a scene holds.
    """
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    try:
        found = None if isinstance(value, bool) else operator.index(value)
    except TypeError:
        found = None
    if found is None:
        raise TypeError(f"{name} is {short(value)}, not a whole number")
    if found < least:
        raise ValueError(f"{name} is {found}, less than {least}")
    if found > _LARGEST:
        raise ValueError(f"{name} is {short(found)}, and at most {_LARGEST} can be counted")
    return found


def number(name: str, value: Any) -> float:
    """A finite number.

    Raises:
        TypeError: it is no number.
        ValueError: it is not finite.
    """
    return float(reals(name, value))


def _place(name: str, at: Any) -> str:
    return f"{name}[{', '.join(map(str, at))}]" if len(at) else name


def short(value: Any) -> str:
    """A value as a message shows it."""
    if not isinstance(value, (bool, int, float, complex, str, bytes, np.generic, type(None))):
        return f"of {type(value).__name__}"
    if isinstance(value, int) and abs(value) > 10**20:
        return f"about {'-' if value < 0 else ''}1e{int(math.log10(2) * value.bit_length())}"
    told = repr(value)
    return told if len(told) <= 60 else f"{told[:57]}..."
