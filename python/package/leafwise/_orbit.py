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
        energy: the Hamiltonian on it.
        time_step: that time over the number of steps.
        steps: steps of a turn.
        turns: turns of the orbit in the period of the search: more than 1 where that is a multiple of the orbit's period.
        state: a state on it, by the names of the variables.
        closure: the largest distance of a coordinate after a turn from its value before.
        corrections: corrections by Newton's method.
        stable: whether all multipliers lie on the unit circle.
        trivial: multipliers that are 1 by the time and the integrals.
        multipliers: all others, the largest first.
        pairing: the largest distance of the products μ·(1/μ) from 1.
    """

    period: float
    energy: float
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


@dataclass(frozen=True)
class OrbitFamily:
    """Periodic orbits along a parameter, the energy or the period.

    Attributes:
        along: the continued quantity.
        ends: where the family ends: ``"reached"`` at the wanted value, ``"returned"`` past its beginning by a fold,
            ``"many"`` at the greatest number of orbits, ``"no-branch"`` before the wanted branch point, ``"equilibrium"`` where
            the orbits shrink to one, ``"lost"`` where no further one closes.
        reason: why, where it is lost.
        orbits: the orbits in their order.
        values: the continued quantity of each orbit: shape (n,).
        marks: events at each orbit: ``"fold"``, ``"branch"``, ``"period-doubling"``, ``"energy-fold"``, ``"krein"`` or None.
    """

    along: str
    ends: str
    reason: str | None
    orbits: tuple[Orbit, ...]
    values: Array
    marks: tuple[str | None, ...]

    @property
    def energies(self) -> Array:
        """The energy of each orbit: shape (n,)."""
        return np.array([orbit.energy for orbit in self.orbits])

    @property
    def periods(self) -> Array:
        """The period of each orbit: shape (n,)."""
        return np.array([orbit.period for orbit in self.orbits])

    @property
    def x(self) -> Array:
        """A state on each orbit: shape (n, d)."""
        return np.array([orbit.x for orbit in self.orbits])


@dataclass(frozen=True)
class EquilibriumPoint:
    """A point at rest in its leaf.

    Attributes:
        state: the state, by the names of the variables.
        stability: ``"stable"`` where the energy is a strict minimum or maximum in the leaf, ``"spectrally-stable"`` where no
            neighbour parts exponentially, ``"unstable"``, ``"alone"`` where the leaf is a point, or ``"undecided"``.
        energy: the Hamiltonian.
        casimirs: the Casimirs, those of the scene's initial state.
        multiples: λ with ∇H = Σ λ_c ∇C_c; None where ∇H is no such sum.
        speed: the largest rate of change of a coordinate.
        corrections: corrections by Newton's method.
        leaf: the leaf's dimension.
        eigenvalues: of the linearized motion in the leaf, the largest first.
        curvatures: of the energy in the leaf, in an orthonormal basis.
    """

    state: dict[str, float]
    stability: str
    energy: float
    casimirs: dict[str, float]
    multiples: Array | None
    speed: float
    corrections: int
    leaf: int
    eigenvalues: NDArray[np.complex128]
    curvatures: Array

    @property
    def x(self) -> Array:
        """The state as an array: shape (d,)."""
        return np.array(list(self.state.values()))


def _options(period: float | None, steps: int | None, hold_period: bool) -> list[str]:
    arguments: list[str] = []
    if period is not None:
        arguments += ["--period", repr(number("period", period))]
    if steps is not None:
        arguments += ["--steps", str(count("steps", steps, 1))]
    if hold_period:
        arguments += ["--hold-period"]
    return arguments


def _orbit(report: dict[str, Any]) -> Orbit:
    report["multipliers"] = np.array([complex(*parts) for parts in report["multipliers"]], dtype=complex)
    return Orbit(**report)


def _scene(scene: Scene) -> Scene:
    if not isinstance(scene, Scene):
        raise TypeError(f"scene is of {type(scene).__name__}: give a leafwise.Scene")
    return scene


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
    return _orbit(_scene(scene).command("orbit", *_options(period, steps, hold_period)))


def orbit_family(
    scene: Scene,
    along: str,
    to: float,
    period: float | None = None,
    *,
    steps: int | None = None,
    hold_period: bool = False,
    orbits: int = 200,
    branch: int | None = None,
) -> OrbitFamily:
    """Close a periodic orbit as ``orbit`` does, and follow its family by pseudo-arclength.

    Args:
        scene: gives the system, the method and the initial state.
        along: what is continued: ``"energy"``, ``"period"`` or a parameter of the system.
        to: the value where it ends.
        period: the period of the first orbit, about; by default the time that the scene's run takes.
        steps: steps of a turn; by default as many as take no longer than the scene's.
        hold_period: along a parameter, hold the period in place of the energy.
        orbits: orbits, at most.
        branch: follow the other family from the branch point with this number on, from 1; with the other sign on its other side.

    Returns:
        The orbits, with folds, branches and doublings of the period located among them.

    Raises:
        LeafwiseError: no orbit closes near the scene's initial state, or there is no such parameter.
        TypeError, ValueError: an argument is none.
    """
    if not isinstance(along, str):
        raise TypeError(f"along is of {type(along).__name__}: give \"energy\", \"period\" or the name of a parameter")
    arguments = _options(period, steps, hold_period)
    arguments += ["--continue", f"{along}={number('to', to)!r}", "--orbits", str(count("orbits", orbits, 1))]
    if branch is not None:
        arguments += ["--branch", str(branch)]
    report: dict[str, Any] = _scene(scene).command("orbit", *arguments, accept=(0, 6))
    values = [member.pop("value") for member in report["orbits"]]
    marks = [member.pop("mark") for member in report["orbits"]]
    return OrbitFamily(
        along=report["along"],
        ends=report["ends"],
        reason=report["reason"],
        orbits=tuple(_orbit(member) for member in report["orbits"]),
        values=np.array(values),
        marks=tuple(marks),
    )


def equilibrium_point(scene: Scene) -> EquilibriumPoint:
    """Find an equilibrium near a scene's initial state by Newton's method, with the Casimirs held, and judge its stability.

    Args:
        scene: gives the system and the initial state.

    Returns:
        The equilibrium.

    Raises:
        LeafwiseError: there is none near, or the scene has none.
        TypeError: scene is no scene.
    """
    report: dict[str, Any] = _scene(scene).command("orbit", "--equilibrium")
    report["eigenvalues"] = np.array([complex(*parts) for parts in report["eigenvalues"]], dtype=complex)
    report["curvatures"] = np.array(report["curvatures"])
    if report["multiples"] is not None:
        report["multiples"] = np.array(report["multiples"])
    return EquilibriumPoint(**report)
