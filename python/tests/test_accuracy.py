"""The number of steps that an accuracy takes: what all runs cost, and whether it is met."""

import warnings

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import leafwise as lw

#: Systems with x' as functions, initial states and lengths.
PROBLEMS = {
    "pendulum": (
        {"bracket": {"q,p": "1"}, "convention": "{x,H}", "hamiltonian": "p^2/2 - cos(q)"},
        lambda t, x: [x[1], -np.sin(x[0])],
        [0.0, 1.0],
        20.0,
    ),
    "rigid body": (
        {"bracket": {"x1,x2": "-x3", "x2,x3": "-x1", "x3,x1": "-x2"}, "hamiltonian": "x1^2/2 + x2^2/1.5 + x3^2/2.5"},
        lambda t, x: np.cross(x / [1.0, 0.75, 1.25], x),
        [1.0, 3.0, 3.0],
        30.0,
    ),
    "Henon and Heiles": (
        {
            "bracket": {"x,px": "1", "y,py": "1"},
            "convention": "{x,H}",
            "hamiltonian": "(px^2 + py^2 + x^2 + y^2)/2 + x^2*y - y^3/3",
        },
        lambda t, s: [s[1], -s[0] - 2 * s[0] * s[2], s[3], -s[2] - s[0] ** 2 + s[2] ** 2],
        [0.0, 0.35, 0.1, 0.1],
        60.0,
    ),
    "Kepler": (
        {"bracket": {"x,px": "1", "y,py": "1"}, "convention": "{x,H}", "hamiltonian": "(px^2 + py^2)/2 - 1/sqrt(x^2 + y^2)"},
        lambda t, s: [s[1], -s[0] / np.hypot(s[0], s[2]) ** 3, s[3], -s[2] / np.hypot(s[0], s[2]) ** 3],
        [0.4, 0.0, 0.0, 2.0],
        20.0,
    ),
    "driven": (
        {"bracket": {"q,p": "1"}, "convention": "{x,H}", "hamiltonian": "p^2/2 + q^4/4 - q*cos(2*t)"},
        lambda t, x: [x[1], -(x[0] ** 3) + np.cos(2 * t)],
        [0.5, 0.0],
        15.0,
    ),
}


@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-9])
def test_all_runs_take_less_than_half_as_many_steps_again_and_meet_what_is_asked(problem: str, rtol: float) -> None:
    system, motion, x0, end = PROBLEMS[problem]
    points = np.linspace(0, end, 23)
    found = lw.solve(**system, x0=x0, t_span=(0, end), t_eval=points, rtol=rtol)
    assert found.success and found.trials[-1] == found.run.steps
    assert sum(found.trials) <= 1.5 * found.trials[-1], found.trials
    exact = solve_ivp(motion, (0, end), x0, "DOP853", points, rtol=1e-12, atol=1e-13).y
    assert np.abs(found.y - exact).max() <= rtol * np.abs(exact).max()


@pytest.mark.parametrize("method", ["splitting", "rk4", "implicit-midpoint"])
def test_orders_are_those_of_the_method(method: str) -> None:
    system, motion, x0, end = PROBLEMS["pendulum"]
    found = lw.solve(**system, x0=x0, t_span=(0, end), rtol=1e-5, method=method)
    assert found.success and sum(found.trials) <= 1.5 * found.trials[-1], found.trials
    assert len(found.t) == found.trials[-1] + 1
    exact = solve_ivp(motion, (0, end), x0, "DOP853", found.t, rtol=1e-12, atol=1e-13).y
    assert np.abs(found.y - exact).max() <= 1e-5 * np.abs(exact).max()


@pytest.mark.filterwarnings("ignore::leafwise.LeafwiseWarning")
@pytest.mark.parametrize("end", [5.1, 7.3, 8.8])
def test_where_the_order_does_not_show_two_runs_agree_themselves(end: float) -> None:
    """H = p²/2 + |q|: parabolas that meet at q = 0, where a splitting of order 2 errs like one of order 1."""
    system = {"bracket": {"q,p": "1"}, "convention": "{x,H}", "hamiltonian": "p^2/2 + sqrt(q^2)", "x0": [0.5, 0.0]}
    found = lw.solve(**system, t_span=(0, end), rtol=1e-2, method="splitting")
    s = np.mod(found.t, 4)
    exact = np.select([s <= 1, s <= 3, s <= 4], [0.5 - s**2 / 2, -0.5 + (s - 2) ** 2 / 2, 0.5 - (4 - s) ** 2 / 2])
    assert found.success and sum(found.trials) <= 1.5 * found.trials[-1], found.trials
    assert np.abs(found.y[0] - exact).max() <= 1e-2


@pytest.mark.parametrize("at, width", [(31.7, 0.02), (54.321, 0.05), (71.1, 0.005)])
def test_a_pulse_between_the_steps_is_not_passed_over(at: float, width: float) -> None:
    """An oscillator's kick by q·exp(−((t − a)/w)²), in closed form: p(t) = ∫ cos(t − s) f(s) ds with the transform of a Gaussian."""
    force = f"exp(-((t - {at})/{width})^2)"
    times = np.array([at + 8 * width + 3.0, 100.0])
    found = lw.solve(
        bracket={"q,p": "1"},
        convention="{x,H}",
        hamiltonian=f"p^2/2 + q^2/2 - q*{force}",
        x0=[1.0, 0.0],
        t_span=(0, 100),
        t_eval=times,
    )
    kick = np.sqrt(np.pi) * width * np.exp(-(width**2) / 4)
    exact = [np.cos(times) + kick * np.sin(times - at), -np.sin(times) + kick * np.cos(times - at)]
    assert found.success and np.abs(found.y - exact).max() < 1e-6


def test_the_error_of_a_run_is_estimated() -> None:
    """A pendulum of order 4 against SciPy's solution; what the estimate leaves out is of the next even order."""
    system = {"variables": ["q", "p"], "bracket": "canonical", "hamiltonian": "p^2/2 - cos(q)"}
    method = {"stepper": "splitting", "composition": "blanes-moan-4", "time-step": 0.2}
    scene = lw.Scene(system=system, method=method, run={"initial": [1.0, 0.0], "steps": 100})
    exact = solve_ivp(lambda t, x: [x[1], -np.sin(x[0])], (0, 20), [1.0, 0.0], method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    error = np.abs(scene.run().x[-1] - exact).max()
    estimate = scene.state_error()
    assert estimate.at_end == pytest.approx(error, rel=0.05)
    assert estimate.largest >= estimate.at_end
    assert not estimate.is_large
    assert scene.state_error(steps=10).time <= 2.0 + 1e-12
    assert scene.run().state_error is None
    asking = scene.set(run__error="estimate")
    assert asking.run().state_error == estimate
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        assert asking.set(method={"stepper": "taylor", "time-step": 0.2}).run().state_error is None
    assert any("error not estimated: a tolerance" in str(warning.message) for warning in told)
    noisy = lw.Scene(system=system | {"noise": [{"hamiltonian": "q", "strength": "0.1"}]}, method={"time-step": 0.1}, run={"initial": [1.0, 0.0], "steps": 10})
    with pytest.raises(lw.LeafwiseError, match="draw new noise"):
        noisy.state_error()
