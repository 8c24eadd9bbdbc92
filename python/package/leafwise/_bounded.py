"""Least squares within bounds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ._arrays import Array, number, table

#: Rounds of the search for which values lie on their bounds, for each value.
_ROUNDS = 10


def corrections(
    slopes: Array, left: Array, low: Array, high: Array, solve: Callable[[Array, Array, list[int]], Array]
) -> tuple[Array, NDArray[np.bool_]]:
    """The correction c with low ≤ c ≤ high and the least ‖left − slopes·c‖, and which of its entries lie on no bound.

    ``solve`` gives the one without bounds of these columns. Zero lies within the bounds. The search goes towards the
    solution of the free entries until the first reaches its bound, and holds that entry there. It frees an entry again where that
    makes the sum smaller.
    """
    count = len(low)
    found, free = np.zeros(count), np.ones(count, dtype=bool)
    for _ in range(_ROUNDS * (count + 1)):
        if free.any():
            columns = np.flatnonzero(free)
            aim = solve(slopes[:, free], left - slopes[:, ~free] @ found[~free], columns.tolist())
            way = aim - found[free]
            room = np.where(way > 0, high[free] - found[free], low[free] - found[free])
            parts = np.full(len(way), np.inf)
            np.divide(room, way, out=parts, where=way != 0)
            first = int(np.argmin(parts))
            if parts[first] < 1:
                found[free] += parts[first] * way
                at = columns[first]
                found[at] = high[at] if way[first] > 0 else low[at]
                free[at] = False
                continue
            found[free] = aim
        slope = slopes.T @ (left - slopes @ found)
        inwards = np.where(free, 0.0, np.where(found >= high, -slope, slope))
        worst = int(np.argmax(inwards))
        if inwards[worst] <= 0:
            break
        free[worst] = True
    return found, free


def bounds_of(given: Mapping[str, object] | None, names: Sequence[str], at: Array) -> tuple[Array, Array]:
    """The least and the largest values, infinite where none are given.

    Raises:
        ValueError, TypeError: bounds that are none, or that values do not lie within.
    """
    low, high = np.full(len(names), -np.inf), np.full(len(names), np.inf)
    for name, ends in table("bounds", given).items():
        if name not in names:
            raise ValueError(f"bounds name {name!r}, which is not fitted; the fitted ones are {', '.join(names)}")
        if not (isinstance(ends, (tuple, list)) and len(ends) == 2):
            raise TypeError(f"the bounds of {name} are {ends!r}, not a pair as (0, None)")
        place = list(names).index(name)
        for array, end in ((low, ends[0]), (high, ends[1])):
            if end is not None and not (isinstance(end, float) and np.isinf(end)):
                array[place] = number(f"bounds[{name!r}]", end)
        if not low[place] < high[place]:
            raise ValueError(f"the bounds of {name} are {ends!r}: the first is the smaller one")
        if not low[place] <= at[place] <= high[place]:
            raise ValueError(f"{name} begins at {at[place]:g}, outside of its bounds {ends!r}: set it in the scene first")
    return low, high


def priors_of(given: Mapping[str, object] | None, names: Sequence[str]) -> tuple[Array, Array]:
    """Prior knowledge of values: means, and one over standard deviations, 0 where nothing is.

    Raises:
        ValueError, TypeError: priors that are none.
    """
    means, weights = np.zeros(len(names)), np.zeros(len(names))
    for name, prior in table("priors", given).items():
        if name not in names:
            raise ValueError(f"priors name {name!r}, which is not fitted; the fitted ones are {', '.join(names)}")
        if not (isinstance(prior, (tuple, list)) and len(prior) == 2):
            raise TypeError(f"the prior of {name} is {prior!r}, not a mean with its standard deviation as (1.0, 0.1)")
        mean, deviation = (number(f"priors[{name!r}]", of) for of in prior)
        if deviation <= 0:
            raise ValueError(f"the prior of {name} has the standard deviation {deviation:g}, which must be positive")
        place = list(names).index(name)
        means[place], weights[place] = mean, 1 / deviation
    return means, weights
