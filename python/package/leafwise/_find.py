"""Brackets of equations of motion."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ._arrays import count, number, table
from ._commands import command
from ._scene import Scene

#: Exit codes of the command: found, and none found.
_ANSWERS = (0, 5)


@dataclass(frozen=True)
class Found:
    """A bracket with x' = {x, H}, proved, or the reasons why there is none.

    Attributes:
        kind: ``"constant"``, ``"log canonical"``, ``"affine"`` or ``"first integrals"``; ``None`` where no bracket was found.
        bracket: formulas of {x, y} by ``"x,y"``; pairs left out are zero.
        hamiltonian: H, a formula.
        casimirs: formulas by name.
        family: dimension of the linear family in which the tensor was chosen.
        has_parameters: whether the parameters are held as names; otherwise numbers stand in their places.
        integrals: first integrals that were looked at, up to ``degree``.
        degree: the degree of the first integrals, 0 where none was needed.
        refused: kinds without a bracket, each with ``kind``, ``reason`` and ``is_proved``.
        never: an equilibrium near which no bracket of any kind exists, and the reason.
        system: the ``[system]`` table of a scene, as TOML.
    """

    kind: str | None
    bracket: dict[str, str]
    hamiltonian: str | None
    casimirs: dict[str, str]
    family: int | None
    has_parameters: bool
    integrals: list[str]
    degree: int
    refused: list[dict[str, Any]] = field(repr=False)
    never: str | None
    system: str | None = field(repr=False)

    def __bool__(self) -> bool:
        """Whether a bracket was found."""
        return self.kind is not None

    def scene(self, initial: Sequence[float], time_step: float, steps: int) -> Scene:
        """The scene of the found system with ``realization`` and ``dynamics`` chosen by ``"auto"``.

        Raises:
            ValueError: no bracket was found.
            SceneError: another number of initial values than of variables.
        """
        if self.system is None:
            raise ValueError("no bracket was found: `refused` and `never` say why")
        return Scene.parse(
            f"{self.system}\n[method]\nrealization = \"auto\"\ndynamics = \"auto\"\ntime-step = {float(time_step)!r}\n"
            f"\n[run]\ninitial = {[float(value) for value in initial]!r}\nsteps = {int(steps)}\n"
        )


def casimirs(scene: Scene, degree: int | None = None) -> dict[str, str]:
    """Casimirs of a scene's bracket, found in exact algebra: formulas by name; none where none of these kinds exists.

    Args:
        scene: gives the bracket.
        degree: the degree in the variables, their logarithms and the functions in the tensor; by default 2.

    Raises:
        LeafwiseError: a bracket that exact algebra cannot read, or a degree with too many coefficients.
        TypeError, ValueError: an argument is none.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"scene is of {type(scene).__name__}: give a leafwise.Scene")
    arguments = [] if degree is None else ["--degree", str(count("degree", degree, 1))]
    report: dict[str, Any] = scene.command("find", *arguments)
    return dict(report["casimirs"])


def find(
    equations: Mapping[str, str], *, parameters: Mapping[str, float] | None = None, degree: int | None = None
) -> Found:
    """Find a bracket {·, ·} and a Hamiltonian H with x' = {x, H} for given equations, in exact algebra.

    Args:
        equations: the formula of x' for each variable x, in the order of the state: ``{"q": "p", "p": "-sin(q)"}``.
        parameters: numbers for the other names in the formulas. Decimals are exact.
        degree: the degree of first integrals and Casimirs; by default that of the equations, at least 2 and at most 3.

    Returns:
        The bracket, or why there is none; ``bool(found)`` says which.

    Raises:
        LeafwiseError: an equation that cannot be read, or a degree with too many coefficients.
        TypeError, ValueError: an argument is none.
    """
    arguments: list[str] = []
    for name, formula in table("equations", equations).items():
        if not isinstance(formula, str):
            raise TypeError(f"equations[{name!r}] is of {type(formula).__name__}: give the formula of {name}' as text")
        arguments += ["-e", f"{name}={formula}"]
    for name, value in table("parameters", parameters).items():
        arguments += ["-p", f"{name}={json.dumps(number(f'parameters[{name!r}]', value))}"]
    if degree is not None:
        arguments += ["--degree", str(count("degree", degree, 1))]
    report: dict[str, Any] = command("find", *arguments, accept=_ANSWERS)
    del report["outcome"]
    return Found(**report)
