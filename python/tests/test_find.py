"""Brackets of equations, found and integrated."""

import numpy as np
import pytest

import leafwise as lw

BODY = {"x": "y*z", "y": "-x*z", "z": "-0.51*x*y"}


def test_a_rigid_body_is_found_and_moves_as_its_equations_do() -> None:
    found = lw.find(BODY)
    assert found and found.kind == "affine"
    run = found.scene(initial=[0, 1, 1], time_step=0.05, steps=200).run()
    x, y, z = run.x.T
    # Two integrals of the equations, whatever the bracket; the first is kept to the method's order, or to round-off where it is a Casimir.
    for integral in (x**2 + y**2, 0.51 * x**2 + z**2):
        assert np.ptp(integral) < 1e-6
    assert run.drift["C"] < 1e-13
    # dx/dt of the states is y*z to the error of central differences.
    slope = (x[2:] - x[:-2]) / 0.1
    assert np.max(np.abs(slope - (y * z)[1:-1])) < 2e-3


def test_parameters_stay_names_where_the_tensor_is_constant() -> None:
    found = lw.find({"q": "p", "p": "-k*sin(q)"}, parameters={"k": 0.5})
    assert found.has_parameters and found.hamiltonian == "p^2/2 - k*cos(q)"
    assert found.bracket == {"q,p": "1"}
    assert found.scene([1, 0], 0.1, 5).set(system__parameters__k=0.7).run().x.shape == (6, 2)


def test_a_damped_pendulum_has_none() -> None:
    found = lw.find({"q": "p", "p": "-sin(q) - 0.1*p"})
    assert not found and found.never is not None
    assert [refused["is_proved"] for refused in found.refused][:2] == [True, False]
    with pytest.raises(ValueError, match="no bracket was found"):
        found.scene([1, 0], 0.1, 5)


def test_mistakes_are_told() -> None:
    with pytest.raises(lw.SceneError, match="unknown function `foo`"):
        lw.find({"q": "p", "p": "foo(q)"})
    with pytest.raises(lw.LeafwiseError, match="degree"):
        lw.find(BODY, degree=99)


def test_a_scene_may_hold_the_equations() -> None:
    scene = lw.Scene(
        system={"equations": BODY, "bracket": "find"},
        method={"realization": "auto", "dynamics": "auto", "time-step": 0.1},
        run={"initial": [0, 1, 1], "steps": 10},
    )
    assert scene.variables == ["x", "y", "z"]
    assert scene.run().drift["C"] < 1e-14


def test_casimirs_of_a_scene() -> None:
    scene = lw.Scene(
        system={
            "variables": ["x", "y", "z"],
            "bracket": {"x,y": "-z", "y,z": "-x", "z,x": "-y"},
            "hamiltonian": "x^2/2 + y^2",
            "casimirs": "find",
        },
        method={"realization": "auto", "dynamics": {"name": "hamilton-jacobi", "order": 4}, "time-step": 0.1},
        run={"initial": [0.3, 0.9, 0.4], "steps": 20},
    )
    assert lw.casimirs(scene) == {"C": "x^2 + y^2 + z^2"}
    assert scene.run().drift["C"] < 1e-14
    with pytest.raises(TypeError, match="give a leafwise.Scene"):
        lw.casimirs("scene.toml")  # type: ignore[arg-type]
