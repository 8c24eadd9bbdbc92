"""Solutions as functions: the method's own states, in a few steps from those that are kept."""

import numpy as np
import pytest

import leafwise as lw
from test_solve import BODY, OSCILLATOR


@pytest.mark.parametrize("span", [(0.0, 30.0), (2.0, -28.0)])
@pytest.mark.parametrize("method", [None, "splitting", {"stepper": "splitting", "composition": "suzuki-4"}, "rk4"])
def test_states_are_the_runs_to_the_bit(span: tuple[float, float], method: object) -> None:
    solution = lw.solve(**BODY, t_span=span, step=0.013, method=method)
    rng = np.random.default_rng(3)
    times = np.concatenate([rng.uniform(*sorted(span), 40), solution.t[[0, 1, 17, -2, -1]], span])
    ordered = np.unique(times)[:: 1 if span[1] > span[0] else -1]
    there = lw.solve(**BODY, t_span=span, step=0.013, method=method, t_eval=ordered)
    place = {time: at for at, time in enumerate(there.t.tolist())}
    for time in times:
        np.testing.assert_array_equal(solution(time), there.y[:, place[time]])
    np.testing.assert_array_equal(solution(times), there.y[:, [place[time] for time in times.tolist()]])
    assert solution(times.reshape(-1, 1)).shape == (3, len(times), 1)


def test_a_call_takes_a_thousandth_of_the_steps() -> None:
    steps = 100_000
    solution = lw.solve(**OSCILLATOR, t_span=(0, 1000), t_eval=[1000.0], step=1000 / steps)
    solution(1000.0)
    states = solution.scene._states()
    assert steps <= states.steps <= steps + 1
    for time in (999.99, 500.0, 3.3, 765.4321):
        before = states.steps
        solution(time)
        assert states.steps - before <= steps / 512 + 2
    # As a root finder asks: after the first, a step each.
    before = states.steps
    for time in np.linspace(765.43215, 765.43218, 50):
        solution(time)
    assert states.steps - before <= 50
    np.testing.assert_allclose(solution(765.4321)[0], np.cos(765.4321), atol=1e-6)


def test_times_outside_and_steps_that_fail() -> None:
    solution = lw.solve(**OSCILLATOR, t_span=(0, 10), step=0.1)
    for wrong in (-0.1, 10.1, [1.0, 11.0]):
        with pytest.raises(ValueError, match="leaves t_span"):
            solution(wrong)
    # x' = x² has left every bound at t = 1.
    system = {"bracket": {"x,y": "1"}, "convention": "{x,H}", "hamiltonian": "x^2*y", "x0": [1.0, 1.0]}
    solution = lw.solve(**system, t_span=(0, 2), step=0.01, method="implicit-midpoint")
    assert not solution.success
    np.testing.assert_allclose(solution(0.5)[0], 2.0, rtol=1e-3)
    with pytest.raises(lw.IntegrationError, match="step [0-9]+ failed at t"):
        solution(1.9)
    np.testing.assert_allclose(solution(0.25)[0], 4 / 3, rtol=1e-3)


def test_systems_that_name_the_time() -> None:
    driven = OSCILLATOR | {"hamiltonian": "p^2/2 + q^2/2 + q*cos(2*t)"}
    solution = lw.solve(**driven, t_span=(0, 9), rtol=1e-9)
    times = np.array([0.0, 0.7, 4.4, 9.0])
    # q'' = −q − cos 2t with q(0) = 1, q'(0) = 0.
    np.testing.assert_allclose(solution(times)[0], (2 * np.cos(times) + np.cos(2 * times)) / 3, atol=1e-8)
