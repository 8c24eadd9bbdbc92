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
    with pytest.raises(lw.LeafwiseError, match="is not a basis"):
        lw.learn(pairs(), OSCILLATOR, "wavelets")
    with pytest.raises(TypeError, match="give a leafwise.Scene"):
        lw.learn(pairs(), "scene.toml")  # type: ignore[arg-type]


DRIVEN = lw.Scene(
    system={"variables": ["q", "p"], "bracket": {"q,p": "1"}, "convention": "{x,H}", "hamiltonian": "p^2/2 - 0.02*cos(q)*cos(4*t)"},
    method={"realization": "auto", "dynamics": {"name": "hamilton-jacobi", "order": 4}, "time-step": np.pi / 64},
    run={"initial": [0.3, 0.2], "steps": 320},
)


def test_a_period_is_one_step() -> None:
    table = lw.tabulate(
        DRIVEN, 32, {"q": (0, 2 * np.pi), "p": (-1, 1)}, basis={"q": "fourier"}, degree={"q": 5, "p": 7}
    )
    # (2*5 + 1)*(7 + 1) products but for 1.
    assert (table.functions, table.steps) == (87, 32)
    assert table.time_step == pytest.approx(np.pi / 2) and 0 < table.error <= table.largest_error < 1e-6
    assert table.determinant is not None and 0.5 < table.determinant < 1.5
    apart = np.abs(table.scene.run(steps=10).x[-1] - DRIVEN.run().x[-1])
    # Ten errors, twice the largest that 200 states show. Each grows no more than a change of q'' = a q does.
    root = np.sqrt(0.02)
    after = root * np.pi / 2 * np.arange(10)
    assert np.max(apart) < np.sum(np.cosh(after) + np.sinh(after) / root) * 2 * table.largest_error
    states = np.random.default_rng(1).uniform([0, -1], [2 * np.pi, 1], size=(900, 2))
    given = lw.tabulate(DRIVEN, 32, states=states, basis={"q": "fourier"}, degree={"q": 4, "p": 5})
    assert given.report["unseen"] == 180 and given.error < 1e-4


def test_what_has_no_table_is_told() -> None:
    turn = OSCILLATOR.set(system__hamiltonian="(q^2 + p^2)/2", method__time_step=np.pi / 8)
    with pytest.raises(lw.LeafwiseError, match="no generating function in the whole region"):
        lw.tabulate(turn, 8, {"q": (-1, 1), "p": (-1, 1)}, degree=2)
    with pytest.raises(ValueError, match="give one of them"):
        lw.tabulate(turn, 2, {"q": (-1, 1), "p": (-1, 1)}, states=np.ones((9, 2)))
    with pytest.raises(TypeError, match="give a leafwise.Scene"):
        lw.tabulate("scene.toml", 2)  # type: ignore[arg-type]
