"""Initial value problems: where they begin and end, and what their motions conserve."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

SITES = 1024


class Problem(NamedTuple):
    """One of them."""

    title: str
    initial: Any
    """Shape (d,)."""
    time: float
    """Where it ends."""
    energy: Callable[[Any], Any]
    """Of states (n, d), shape (n,)."""
    casimir: Callable[[Any], Any]
    """Of states (n, d), shape (n,)."""


PROBLEMS = {
    "rigid_body": Problem(
        title="Rigid body, T = 200",
        initial=np.array([1.0, 3.0, 3.0]),
        time=200.0,
        energy=lambda x: x[:, 0] ** 2 / 2 + x[:, 1] ** 2 / 1.5 + x[:, 2] ** 2 / 2.5,
        casimir=lambda x: (x**2).sum(1),
    ),
    "lotka_volterra": Problem(
        title="Periodic Lotka–Volterra, T = 300",
        initial=np.array([1.0, 1.9, 0.5]),
        time=300.0,
        energy=lambda x: 2 * x[:, 0] + x[:, 1] + 2 * x[:, 2] + np.log(x[:, 1]) - 2 * np.log(x[:, 2]),
        casimir=lambda x: 2 * np.log(x[:, 0]) + np.log(x[:, 1]) + np.log(x[:, 2]),
    ),
    "volterra_lattice": Problem(
        title=f"Volterra lattice, N = {SITES}, T = 100",
        initial=1 + 0.1 * np.sin(2 * np.pi * np.arange(SITES) / SITES),
        time=100.0,
        energy=lambda x: x.sum(1),
        casimir=lambda x: np.log(x).sum(1),
    ),
}
