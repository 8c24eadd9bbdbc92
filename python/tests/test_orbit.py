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


def test_a_family_has_the_periods_of_the_closed_form() -> None:
    family = lw.orbit_family(pendulum(), "energy", 0.6)
    assert family.along == "energy" and family.ends == "reached" and family.reason is None
    assert family.values.shape == family.periods.shape == (len(family.orbits),) and family.x.shape[1] == 2
    assert family.marks == (None,) * len(family.orbits)
    for energy, period in zip(family.energies, family.periods):
        a, b = 1.0, math.sqrt((1 - energy) / 2)
        for _ in range(8):
            a, b = (a + b) / 2, math.sqrt(a * b)
        assert abs(period - 2 * math.pi / a) < 1e-7
    few = lw.orbit_family(pendulum(), "energy", 0.6, orbits=2)
    assert few.ends == "many" and len(few.orbits) == 2
    with pytest.raises(lw.LeafwiseError, match="no parameter"):
        lw.orbit_family(pendulum(), "mass", 2.0)
    with pytest.raises(TypeError, match="along"):
        lw.orbit_family(pendulum(), 1, 2.0)  # type: ignore[arg-type]


def test_a_body_turns_about_its_axes() -> None:
    for axis, stability in enumerate(["stable", "unstable", "stable"]):
        initial = [0.05, 0.02, -0.03]
        initial[axis] = 1.0
        scene = lw.Scene(
            system={"library": "rigid-body", "parameters": {"I1": 1.0, "I2": 2.0, "I3": 3.0}},
            method={"realization": "auto", "dynamics": {"name": "hamilton-jacobi", "order": 2}, "time-step": 0.1},
            run={"initial": initial, "steps": 10},
        )
        found = lw.equilibrium_point(scene)
        assert found.stability == stability and found.leaf == 2
        assert abs(found.x[axis] - math.hypot(*initial)) < 1e-12
        assert found.eigenvalues.shape == (2,) and found.curvatures.shape == (2,)
        assert found.multiples is not None and len(found.multiples) == len(found.casimirs)
