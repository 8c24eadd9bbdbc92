"""Periodic orbits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import Array, count, number
from ._scene import Scene


@dataclass(frozen=True)
class Orbit:
    """A periodic orbit.

    Attributes:
        period: the time of a turn.
        time_step: that time over the number of steps.
        steps: steps of a turn.
        turns: turns of the orbit in the period that was looked for: more than 1 where that is a multiple of its own.
        state: a state on it, by the names of the variables.
        closure: the largest distance of a coordinate after a turn from its value before.
        corrections: corrections by Newton's method.
        stable: whether all multipliers lie on the unit circle.
        trivial: multipliers that are 1 by the time and the integrals.
        multipliers: all others, the largest first.
        pairing: the largest distance of the products μ·(1/μ) from 1.
    """

    period: float
    time_step: float
    steps: int
    turns: int
    state: dict[str, float]
    closure: float
    corrections: int
    stable: bool
    trivial: int
    multipliers: NDArray[np.complex128]
    pairing: float

    @property
    def x(self) -> Array:
        """The state as an array: shape (d,)."""
        return np.array(list(self.state.values()))


def orbit(scene: Scene, period: float | None = None, *, steps: int | None = None, hold_period: bool = False) -> Orbit:
    """Close a periodic orbit near a scene's initial state by Newton's method, with energy and Casimirs held.

    Args:
        scene: gives the system, the method and the initial state.
        period: the period, about; by default the time that the scene's run takes.
        steps: steps of a turn; by default as many as take no longer than the scene's.
        hold_period: hold the period in place of the energy.

    Returns:
        The orbit with its multipliers and its stability.

    Raises:
        LeafwiseError: no orbit closes near here, or the scene has none.
        TypeError, ValueError: an argument is none.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"scene is of {type(scene).__name__}: give a leafwise.Scene")
    arguments: list[str] = []
    if period is not None:
        arguments += ["--period", repr(number("period", period))]
    if steps is not None:
        arguments += ["--steps", str(count("steps", steps, 1))]
    if hold_period:
        arguments += ["--hold-period"]
    report: dict[str, Any] = scene.command("orbit", *arguments)
    report["multipliers"] = np.array([complex(*parts) for parts in report["multipliers"]], dtype=complex)
    return Orbit(**report)
