"""Poisson maps from pairs of states, by linear least squares."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from os import fspath
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import count, in_order, number, reals, table
from ._errors import LeafwiseWarning
from ._scene import Scene

#: The beginning of what is said of a table that costs more than the steps.
_NO_GAIN = "the table does not pay"

#: Exit codes of the command: learned, and learned with a motion that is left.
_ANSWERS = (0, 5)


@dataclass(frozen=True)
class Learned:
    """A Poisson map learned from pairs of states, and the Hamiltonian whose flow it is.

    Attributes:
        scene: the scene with the learned Hamiltonian and generating function: one step of it is the learned map.
        hamiltonian: H, a formula; Casimirs may be added to it.
        degree: the degree of the basis.
        degrees: root mean square of the residual of held-out pairs, by degree; empty for a given degree.
        coefficients: coefficients of H by function.
        errors: their errors, from the residuals and from how far H is found from orbits of the learned map.
        pairs: how many pairs of a weight above 0 there were, each counted once.
        residual: root mean square of the residual of a direction of x' - x along leaves.
        step_error: standard error of a learned step, by the residuals.
        energy_error: error of H less its mean, over the pairs.
        warnings: limits of the result.
        report: everything that ``leafwise learn --json`` prints.
    """

    scene: Scene
    hamiltonian: str
    degree: int
    degrees: dict[int, float]
    coefficients: dict[str, float] = field(repr=False)
    errors: dict[str, float] = field(repr=False)
    pairs: int
    residual: float
    step_error: float
    energy_error: float
    warnings: list[str]
    report: dict[str, Any] = field(repr=False)


@dataclass(frozen=True)
class Tabulated:
    """Many steps of a scene as one step with a generating function.

    Attributes:
        scene: the scene whose step is the table.
        steps: how many steps of the scene that is.
        time_step: the time of them.
        functions: how many coefficients the table has.
        error: root mean square of a coordinate of the table less the steps, at states that no pair has.
        largest_error: the largest of these.
        determinant: the least det(1 + DΦ) without its sign, 1 for no motion and 0 where the table ends; for constant and log-canonical
            brackets, else ``None``.
        seconds: the time of a step of the table for each state.
        method_seconds: the time of the steps that it stands for.
        warnings: what is to be known, also where the table does not pay.
        report: everything that ``leafwise tabulate --json`` prints.
    """

    scene: Scene
    steps: int
    time_step: float
    functions: int
    error: float
    largest_error: float
    determinant: float | None
    seconds: float
    method_seconds: float
    warnings: list[str]
    report: dict[str, Any] = field(repr=False)


def tabulate(
    scene: Scene,
    steps: int,
    box: Mapping[str, tuple[float, float]] | None = None,
    *,
    states: ArrayLike | None = None,
    basis: str | Mapping[str, str] | None = None,
    degree: int | Mapping[str, int] | None = None,
    pairs: int | None = None,
) -> Tabulated:
    """Put many steps of a scene together into one step, a table that is as exactly Poisson as the realization is.

    Args:
        scene: whose steps. Where its Hamiltonian names the time, all begin at t = 0 or `t0`: take a period.
        steps: how many.
        box: the range of each variable; by default that of the scene's own orbit.
        states: states in place of a box, of shape (N, d). Every fifth measures the table.
        basis: as in :func:`learn`; by default ``"centred"``.
        degree: as in :func:`learn`.
        pairs: the number of pairs of states; by default eight equations for each coefficient.

    Returns:
        The table, and how well it meets the steps. Its warnings are issued as :class:`LeafwiseWarning` too, but whether it pays.

    Raises:
        LeafwiseError: the chart ends within the region, or the table misses the steps.
        TypeError, ValueError: an argument is none.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"scene is of {type(scene).__name__}: give a leafwise.Scene")
    arguments = ["--steps", str(count("steps", steps, 1)), *_basis(basis), *_degree(degree)]
    if pairs is not None:
        arguments += ["--pairs", str(count("pairs", pairs, 1))]
    for name, bounds in table("box", box).items():
        least, largest = (number(f"box[{name!r}]", bound) for bound in bounds)
        arguments += ["--box", f"{name}={least!r}:{largest!r}"]
    with tempfile.TemporaryDirectory() as folder:
        if states is not None:
            if box is not None:
                raise ValueError("states replace a box: give one of them")
            names = scene.variables
            file = Path(folder) / "states.npy"
            np.save(file, reals("states", in_order("states", states, names), None, len(names)))
            arguments += ["--states", fspath(file)]
        report: dict[str, Any] = scene.command("tabulate", *arguments)
    for warning in report["warnings"]:
        # Whether a table pays is a measured time, which no program should branch on.
        if not warning.startswith(_NO_GAIN):
            warnings.warn(warning, LeafwiseWarning, stacklevel=2)
    return Tabulated(
        scene=Scene.parse(report["text"]),
        steps=report["steps"],
        time_step=report["time_step"],
        functions=report["functions"],
        error=report["error"],
        largest_error=report["largest_error"],
        determinant=report["determinant"],
        seconds=report["seconds"],
        method_seconds=report["method"]["seconds"],
        warnings=report["warnings"],
        report=report,
    )


def _basis(basis: str | Mapping[str, str] | None) -> list[str]:
    if basis is None:
        return []
    if isinstance(basis, str):
        return ["--basis", basis]
    if not isinstance(basis, Mapping):
        raise TypeError(f"basis is of {type(basis).__name__}: give the name of a family, or one for each variable")
    arguments = []
    for name, family in basis.items():
        if not (isinstance(name, str) and isinstance(family, str)):
            raise TypeError(f"basis holds {name!r}: {family!r}, not the name of a variable and one of a family")
        arguments += ["--basis", f"{name}={family}"]
    return arguments


def _degree(degree: int | Mapping[str, int] | None) -> list[str]:
    if degree is None:
        return []
    if isinstance(degree, Mapping):
        return ["--degree", ",".join(f"{name}={count(f'degree[{name!r}]', own, 0)}" for name, own in degree.items())]
    return ["--degree", str(count("degree", degree, 1))]


def learn(
    pairs: ArrayLike | tuple[ArrayLike, ArrayLike],
    scene: Scene,
    basis: str | Mapping[str, str] | None = None,
    *,
    degree: int | Mapping[str, int] | None = None,
    time_step: float | None = None,
    ridge: float = 0.0,
    weights: ArrayLike | None = None,
    noisy: bool = False,
) -> Learned:
    """Learn a Poisson map from pairs of states x, x' one step apart, over the bracket of a scene, by linear least squares.

    Args:
        pairs: two arrays (x, x') of shape (N, d), or the states of a trajectory, (T, d), or of several, (R, T, d).
        scene: gives the variables, the bracket and the time step. Its Hamiltonian is not looked at.
        basis: ``"polynomial"``, ``"centred"``, ``"spline"``, ``"exponential"``, ``"fourier"``, ``"fourier:PERIOD"``, each with ``"+ln"``
            for logarithms; or one for each of some variables, by name. By default polynomials, with logarithms for a log-canonical bracket.
        degree: the degree, or one for each variable, by name. By default it is the lowest that is as good as the best on held-out
            pairs.
        time_step: the time between x and x'; by default the scene's.
        ridge: the penalty of coefficients, relative to columns of unit length.
        weights: a weight for each pair. Only their ratios count, and pairs of weight 0 are left out.
        noisy: whether both x and x' have errors of one size. Both are then corrected: total least squares.

    Returns:
        The learned map and its Hamiltonian. Warnings are issued as :class:`LeafwiseWarning` too.

    Raises:
        LeafwiseError: the pairs determine nothing, with the reason.
        TypeError, ValueError: an argument is none.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"scene is of {type(scene).__name__}: give a leafwise.Scene")
    names = scene.variables
    if isinstance(pairs, tuple) and len(pairs) == 2:
        before, after = (
            reals(f"pairs[{at}]", in_order(f"pairs[{at}]", states, names), None, len(names)) for at, states in enumerate(pairs)
        )
        if before.shape != after.shape:
            raise ValueError(f"pairs has {len(before)} states before the step and {len(after)} after it")
        states = np.stack([before, after], axis=1)
    else:
        given = in_order("pairs", pairs, names)
        states = reals("pairs", given, *([None] * (np.ndim(given) - 1) if np.ndim(given) in (2, 3) else [None]), len(names))
    arguments = _degree(degree) + _basis(basis)
    if time_step is not None:
        scene = scene.set(method__time_step=number("time_step", time_step))
    arguments += ["--ridge", repr(number("ridge", ridge))]
    if not isinstance(noisy, (bool, np.bool_)):
        raise TypeError(f"noisy is of {type(noisy).__name__}: give True or False")
    if noisy:
        arguments.append("--noisy")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "pairs.npy"
        np.save(file, states)
        if weights is not None:
            weighed = Path(folder) / "weights.npy"
            np.save(weighed, reals("weights", weights, None))
            arguments += ["--weights", fspath(weighed)]
        report: dict[str, Any] = scene.command("learn", fspath(file), *arguments, accept=_ANSWERS)
    for warning in report["warnings"]:
        warnings.warn(warning, LeafwiseWarning, stacklevel=2)
    functions = report["functions"]
    return Learned(
        scene=Scene.parse(report["text"]),
        hamiltonian=report["hamiltonian"],
        degree=report["degree"],
        degrees={tried["degree"]: tried["error"] for tried in report["degrees"]},
        coefficients={own["function"]: own["hamiltonian"] for own in functions},
        errors={own["function"]: own["error"] for own in functions},
        pairs=report["pairs"],
        residual=report["residual"],
        step_error=report["step_error"],
        energy_error=report["energy_error"],
        warnings=report["warnings"],
        report=report,
    )
