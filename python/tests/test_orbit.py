"""Periodic orbits."""

import math

import pytest

import leafwise as lw


def pendulum() -> lw.Scene:
    return lw.Scene(
        system={"variables": ["q", "p"], "bracket": "canonical", "hamiltonian": "p^2/2 - cos(q)"},
        method={"realization": "auto", "dynamics": {"name": "hamilton-jacobi", "order": 8}, "time-step": 0.05},
        run={"initial": [2.0, 0.0], "steps": 170},
    )


def test_a_pendulum_has_the_period_of_the_closed_form() -> None:
    found = lw.orbit(pendulum())
    a, b = 1.0, math.cos(1.0)
    for _ in range(8):
        a, b = (a + b) / 2, math.sqrt(a * b)
    assert abs(found.period - 2 * math.pi / a) < 1e-8
    assert found.closure < 1e-12 and found.stable
    assert found.x.shape == (2,) and found.trivial == 2 and len(found.multipliers) == 0


def test_what_does_not_close_is_told() -> None:
    with pytest.raises(lw.LeafwiseError, match="no period"):
        lw.orbit(pendulum(), -1.0)
