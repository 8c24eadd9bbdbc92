"""The number of steps for an accuracy, predicted by the method's order."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, Protocol, TypeVar

#: The steps of the first run: a prime, so that steps fall in with no period of the span's.
FIRST = 61
#: Every run has at least so many times the steps of the one before: all runs together then take less than 1.5 times the last one's.
LEAST = 3
#: And at most so many times: far away the order does not show yet.
MOST = 8
#: The part of what is asked that the result may err by, where that is foreseen and not seen.
ACCEPTED = 1 / 8
#: The part that is aimed at.
AIMED = 1 / 16
#: How many times larger a difference may be than what the runs before foresaw.
SURPRISE = 4.0


class Tried(Protocol):
    """A run with so many steps."""

    @property
    def success(self) -> bool:
        """Whether it came to the end."""

    @property
    def is_interrupted(self) -> bool:
        """Whether Ctrl-C ended it."""


T = TypeVar("T", bound=Tried)


class Refined(NamedTuple):
    """Result of the search."""

    steps: list[int]
    """The numbers of steps of all runs, the result's last."""
    difference: float
    """How far the last two are from each other."""
    is_met: bool
    """Whether the accuracy is met."""


def refined(
    attempt: Callable[[int], T], difference_of: Callable[[T, T], float], order: int, rtol: float, most: int
) -> tuple[T, Refined]:
    """A run that errs by at most rtol, as runs with fewer steps show.

    Two runs differ by the error of the coarser one. Errors fall as steps**-order, which says how many steps are enough; a third
    run shows whether they do, and errs by that much less. Where they do not, the last two have to agree themselves.
    """
    power = max(order, 1)
    made: list[int] = []
    steps, difference = FIRST, math.inf
    coarse: T | None = None
    foreseen: float | None = None
    while True:
        fine = attempt(steps)
        made.append(steps)
        if fine.is_interrupted:
            return fine, Refined(made, difference, False)
        growth = LEAST
        if coarse is not None and coarse.success and fine.success:
            difference = difference_of(fine, coarse)
            error = difference / ((steps / made[-2]) ** power - 1)
            is_shown = order > 0 and foreseen is not None and difference <= SURPRISE * foreseen
            if difference <= rtol or (is_shown and error <= ACCEPTED * rtol):
                return fine, Refined(made, difference, True)
            if (is_shown or foreseen is None) and math.isfinite(error):
                growth = _growth((error / (AIMED * rtol)) ** (1 / power))
            foreseen = error
        else:
            foreseen = None
        longest = most // steps
        if longest < 2:
            return fine, Refined(made, difference, False)
        coarse, steps = fine, min(growth, longest) * steps


def _growth(needed: float) -> int:
    """How many times the steps the next run has: all that is needed, or half of the way there."""
    if needed > MOST:
        needed = min(MOST, math.sqrt(needed))
    return max(LEAST, math.ceil(needed))
