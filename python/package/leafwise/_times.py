"""Trajectories at times of their own, between the steps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import Array
from ._gradient import Trajectory


class Moved(NamedTuple):
    """States and their tangents."""

    x: Array
    dx: Array
    growth: None = None


class AtTimes:
    """The states of a trajectory at times, shape (n, d), and their tangents: ends of shorter steps of the method."""

    def __init__(self, trajectory: Trajectory, times: Array) -> None:
        self._along = trajectory
        self._times = np.ascontiguousarray(times)

    @property
    def parameters(self) -> list[str]:
        """The names of the parameters."""
        return self._along.parameters

    @property
    def x0(self) -> Array:
        """The scene's initial state."""
        return self._along.x0

    @property
    def values(self) -> Array:
        """The scene's values of the parameters."""
        return self._along.values

    def __call__(self, x0: ArrayLike | None = None, values: ArrayLike | None = None) -> Array:
        """The states."""
        none = np.zeros((0, len(self.x0)))
        return self._push(x0, values, none, none[:, :0])[0]

    def jvp(
        self, dx0: Array | None, dvalues: Array | None, *, x0: ArrayLike | None = None, values: ArrayLike | None = None
    ) -> Moved:
        """The states, and how they change in k directions: shape (n, k, d)."""
        count = max(len(of) for of in (dx0, dvalues) if of is not None)
        of_state = np.zeros((count, len(self.x0))) if dx0 is None else np.ascontiguousarray(dx0)
        by_values = np.zeros((count, len(self._along._all) if dvalues is not None else 0))
        if dvalues is not None:
            by_values[:, self._along._at] = dvalues
        return Moved(*self._push(x0, values, of_state, by_values))

    def _push(self, x0: ArrayLike | None, values: ArrayLike | None, dx0: Array, by_values: Array) -> tuple[Array, Array]:
        along = self._along
        return along._map.push_to(along._initial(x0), along._whole(values), dx0, by_values, self._times)

    def _part(self, samples: int) -> AtTimes:
        """The same with the first times alone."""
        return AtTimes(self._along, self._times[:samples])


def times_of(given: Array, step: float) -> Array:
    """Times on the way of steps of this length, from 0 on.

    Raises:
        ValueError: they are not.
    """
    forward = given * np.sign(step)
    if (forward < 0).any():
        raise ValueError(f"times[{int(np.argmin(forward))}] is {given[np.argmin(forward)]:g}: the run begins at t = 0 and goes the other way")
    back = np.flatnonzero(np.diff(forward) < 0)
    if len(back):
        raise ValueError(f"times[{back[0] + 1}] is {given[back[0] + 1]:g}, before times[{back[0]}]: sort the observations by their times")
    return given
