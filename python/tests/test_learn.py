"""Poisson maps learned from arrays of pairs."""

import numpy as np
import pytest

import leafwise as lw

OSCILLATOR = lw.Scene(
    system={"variables": ["q", "p"], "bracket": {"q,p": "1"}, "convention": "{x,H}", "hamiltonian": "0*q", "parameters": {}},
    method={"realization": "constant", "dynamics": {"name": "hamilton-jacobi", "order": 2}, "time-step": 0.4},
    run={"initial": [1, 0], "steps": 10},
)
TURN = np.array([[np.cos(0.4), np.sin(0.4)], [-np.sin(0.4), np.cos(0.4)]])


def pairs(count: int = 60) -> tuple[np.ndarray, np.ndarray]:
    before = np.random.default_rng(0).uniform(-1, 1, size=(count, 2))
    return before, before @ TURN.T


def test_a_rotation_is_learned_with_its_energy() -> None:
    before, after = pairs()
    learned = lw.learn((before, after), OSCILLATOR, degree=2)
    # tan(h/2)/h (q^2 + p^2) generates the rotation, whose H is (q^2 + p^2)/2 to the differences' (h/2)^16.
    assert learned.coefficients["q^2"] == pytest.approx(0.5, abs=1e-9)
    assert learned.coefficients["q*p"] == pytest.approx(0, abs=1e-9)
    # The last differences over 8 steps change it by 0.16 s^14, s = sin(h/2) = 0.2: 3e-11. All further ones change it by less.
    assert abs(learned.coefficients["q^2"] - 0.5) < learned.errors["q^2"] < 1e-10 and learned.pairs == 60
    run = learned.scene.run(steps=100)
    exact = np.linalg.matrix_power(TURN, 100) @ [1, 0]
    # 100 steps of round-off.
    assert np.max(np.abs(run.x[-1] - exact)) < 1e-11


def test_trajectories_are_pairs_and_the_degree_is_chosen() -> None:
    states = np.stack([np.linalg.matrix_power(TURN, k) @ x for x in ([1, 0], [0.3, 0.5]) for k in range(30)]).reshape(2, 30, 2)
    learned = lw.learn(states, OSCILLATOR)
    assert learned.pairs == 58 and min(learned.degrees) >= 1
    assert learned.residual < 1e-13
    one = lw.learn(states[0], OSCILLATOR, {"q": "polynomial", "p": "polynomial"}, degree=2, weights=np.ones(29), ridge=1e-9)
    assert one.pairs == 29


def test_mistakes_are_told() -> None:
    before, after = pairs(4)
    with pytest.raises(lw.LeafwiseError, match="4 pairs give 8 equations"):
        lw.learn((before, after), OSCILLATOR, degree=4)
    with pytest.raises(ValueError, match="states before the step"):
        lw.learn((before, after[:3]), OSCILLATOR)
    with pytest.raises(ValueError, match="not a finite number"):
        lw.learn((before, after * np.nan), OSCILLATOR)
    with pytest.raises(lw.LeafwiseError, match="no pair moves"):
        lw.learn((before, before), OSCILLATOR, degree=1)
    with pytest.raises(lw.LeafwiseError, match="is no basis"):
        lw.learn(pairs(), OSCILLATOR, "wavelets")
    with pytest.raises(TypeError, match="give a leafwise.Scene"):
        lw.learn(pairs(), "scene.toml")  # type: ignore[arg-type]
