"""Initial value problems: where they begin and end, and what their motions conserve."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

SITES = 1024
#: Sizes of the wide problems.
BODIES = int(os.environ.get("BODIES", "10"))
SPECIES = int(os.environ.get("SPECIES", "20"))


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


def bodies():
    """Initial spins of a ring of bodies, shape (3 BODIES,)."""
    at = np.arange(BODIES)
    spins = [1 + 0.1 * np.sin(at), 0.7 * np.cos(at), 0.8 + 0.05 * at / BODIES]
    return np.stack(spins, 1).ravel()


def bodies_energy(x):
    """sum_i m_i1^2/2 + m_i2^2/1.5 + m_i3^2/2.5 + m_i1 m_(i+1)1/10."""
    m = x.reshape(len(x), BODIES, 3)
    own = (m**2 / [2, 1.5, 2.5]).sum((1, 2))
    return own + 0.1 * (m[:, :, 0] * np.roll(m[:, :, 0], -1, 1)).sum(1)


def food_web():
    """Its antisymmetric matrix a_ij and its equilibrium c_i."""
    numbers = np.random.default_rng(5)
    a = np.triu(numbers.uniform(-1, 1, (SPECIES, SPECIES)) / SPECIES**0.5, 1).round(3)
    return a - a.T, (1 + 0.1 * np.sin(np.arange(SPECIES))).round(3)


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
    "heavy_top": Problem(
        title="Heavy top, T = 100",
        initial=np.array([0.5, 1.0, 1.5, 0.6, 0.0, 0.8]),
        time=100.0,
        energy=lambda x: (x[:, :3] ** 2 / [2, 1.5, 2.5]).sum(1) + 0.3 * x[:, 3] + x[:, 5],
        casimir=lambda x: (x[:, :3] * x[:, 3:]).sum(1),
    ),
    "coupled_bodies": Problem(
        title=f"A ring of {BODIES} rigid bodies, T = 20",
        initial=bodies(),
        time=20.0,
        energy=bodies_energy,
        casimir=lambda x: (x[:, :3] ** 2).sum(1),
    ),
    "food_web": Problem(
        title=f"A food web of {SPECIES} species, T = 20",
        initial=1 + 0.3 * np.sin(2.1 * np.arange(SPECIES) + 0.4),
        time=20.0,
        energy=lambda x: (x - food_web()[1] * np.log(x)).sum(1),
        casimir=lambda x: np.zeros(len(x)),
    ),
    "henon_heiles": Problem(
        title="Hénon–Heiles, T = 200",
        initial=np.array([0.0, 0.1, 0.3872983346207417, 0.1]),
        time=200.0,
        energy=lambda x: (x**2).sum(1) / 2 + x[:, 0] ** 2 * x[:, 1] - x[:, 1] ** 3 / 3,
        casimir=lambda x: np.zeros(len(x)),
    ),
    "magnetic": Problem(
        title="A charge in a magnetic field and a well, T = 100",
        initial=np.array([1.0, 0.5, -0.5, 0.3, 0.2, 0.4]),
        time=100.0,
        energy=lambda x: (x**2).sum(1) / 2,
        casimir=lambda x: np.zeros(len(x)),
    ),
    "kepler": Problem(
        title="A Kepler orbit of eccentricity 0.9, T = 20",
        initial=np.array([0.1, 0.0, 0.0, 4.358898943540674]),
        time=20.0,
        energy=lambda x: (x[:, 2:] ** 2).sum(1) / 2 - 1 / np.hypot(x[:, 0], x[:, 1]),
        casimir=lambda x: np.zeros(len(x)),
    ),
    "volterra_lattice": Problem(
        title=f"Volterra lattice, N = {SITES}, T = 100",
        initial=1 + 0.1 * np.sin(2 * np.pi * np.arange(SITES) / SITES),
        time=100.0,
        energy=lambda x: x.sum(1),
        casimir=lambda x: np.log(x).sum(1),
    ),
}
