"""Initial value problems: closed forms, SciPy's fields, and what is refused."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import leafwise as lw

OSCILLATOR = {
    "bracket": {"q,p": "1"},
    "convention": "{x,H}",
    "hamiltonian": "p^2/2 + q^2/2",
    "x0": [1.0, 0.0],
}
BODY = {
    "bracket": {"x1,x2": "-x3", "x2,x3": "-x1", "x3,x1": "-x2"},
    "hamiltonian": "x1^2/2 + x2^2/(2*I2) + x3^2/2.5",
    "parameters": {"I2": 0.75},
    "casimirs": {"spin": "x1^2 + x2^2 + x3^2"},
    "x0": [1.0, 3.0, 3.0],
}


def test_points_lie_where_they_are_asked_for() -> None:
    times = np.array([0.0, 0.1, 0.35, 0.7, 2.0, 9.99, 10.0])
    found = lw.solve(**OSCILLATOR, t_span=(0, 10), t_eval=times, step=0.1)
    assert found.success and found.status == 0 and found.nfev >= 100
    np.testing.assert_array_equal(found.t, times)
    assert found.y.shape == (2, 7)
    # The phase errs by less than h⁴ a unit of time, the orbit's radius by round-off alone.
    np.testing.assert_allclose(found.y, [np.cos(times), -np.sin(times)], atol=10 * 0.1**4)
    at_steps = lw.solve(**OSCILLATOR, t_span=(0, 10), step=0.1)
    assert at_steps.y.shape == (2, 101) and at_steps.t[-1] == 10.0
    np.testing.assert_array_equal(found.y[:, [0, 1, 3, 4, 6]], at_steps.y[:, [0, 1, 7, 20, 100]])
    for points in ([], [3.3], [0.0], [10.0]):
        one = lw.solve(**OSCILLATOR, t_span=(0, 10), t_eval=points, step=0.1)
        assert one.t.tolist() == points and one.y.shape == (2, len(points))


def test_the_fields_are_scipys() -> None:
    found = lw.solve(**BODY, t_span=(0, 5), t_eval=np.linspace(0, 5, 11), rtol=1e-8)

    def motion(_: float, x: np.ndarray) -> np.ndarray:
        return np.cross(x / [1.0, 0.75, 1.25], x)

    other = solve_ivp(motion, (0, 5), BODY["x0"], "DOP853", found.t, rtol=1e-12, atol=1e-12)
    assert set(other) - {"sol"} <= {name for name in dir(found) if not name.startswith("_")}
    np.testing.assert_array_equal(found.t, other.t)
    np.testing.assert_allclose(found.y, other.y, atol=1e-8 * np.abs(other.y).max())
    assert (found["status"], found["success"]) == (other.status, other.success)
    np.testing.assert_allclose(found.casimirs["spin"], 19.0, rtol=1e-14)
    assert found.energy.shape == (11,) and found.drift["spin"] < 1e-13
    # As a function: the method's own states, in any order and shape.
    np.testing.assert_array_equal(found.sol(found.t), found.y)
    again = found([[2.0, 0.25], [2.0, 5.0]])
    assert again.shape == (3, 2, 2)
    np.testing.assert_array_equal(again[:, 0, 0], found.y[:, 4])
    np.testing.assert_array_equal(again[:, 1, 1], found.y[:, -1])
    assert found(1.0).shape == (3,)


def test_a_span_may_go_back_and_begin_anywhere() -> None:
    found = lw.solve(**OSCILLATOR, t_span=(2, -3), t_eval=[2, 0.5, -3], step=-0.01)
    assert found.t.tolist() == [2.0, 0.5, -3.0]
    np.testing.assert_allclose(found.y[0], np.cos(found.t - 2), atol=1e-7)
    np.testing.assert_array_equal(found([-3, 2]), found.y[:, [2, 0]])


def driven(t: float, x: np.ndarray) -> np.ndarray:
    return np.array([x[1], -x[0] - 0.1 * np.cos(t)])


def shaken(t: float, x: np.ndarray) -> np.ndarray:
    return np.array([x[1], -(1 + 0.3 * np.cos(2 * t)) * np.sin(x[0])])


@pytest.mark.parametrize(
    "system, motion",
    [
        ({"library": "driven-oscillator"}, driven),
        ({"library": "driven-pendulum"}, shaken),
        (OSCILLATOR | {"hamiltonian": "p^2/2 + q^2/2 + 0.1*q*cos(t)"}, driven),
        (OSCILLATOR | {"hamiltonian": "p^2/2 + q^2/2 + c*q", "define": {"c": "cos(t)/10"}}, driven),
    ],
)
@pytest.mark.parametrize("span", [(0.0, 20.0), (5.0, 25.0), (20.0, 0.0), (-3.0, -1.5)])
def test_t_in_a_formula_is_the_time_of_the_span(system: dict[str, object], motion: object, span: tuple[float, float]) -> None:
    points = np.linspace(*span, 7)
    found = lw.solve(**(system | {"x0": [1.0, 0.5]}), t_span=span, t_eval=points, rtol=1e-9)
    other = solve_ivp(motion, span, [1.0, 0.5], "DOP853", points, rtol=1e-12, atol=1e-13)
    assert found.success
    np.testing.assert_array_equal(found.t, points)
    # Twice rtol of the largest coordinate, 2 at most, and what DOP853 errs by.
    np.testing.assert_allclose(found.y, other.y, atol=4e-9)
    np.testing.assert_array_equal(found(points[3:5]), found.y[:, 3:5])


PACED = {"realization": "auto", "dynamics": {"name": "hamilton-jacobi", "order": 4}, "pace": "1 + q^2"}


def test_with_a_pace_points_are_in_t_all_the_same() -> None:
    for pace in ("1 + q^2", "2"):
        method = PACED | {"pace": pace}
        whole = lw.solve(**OSCILLATOR, t_span=(0, 10), rtol=1e-8, method=method)
        assert whole.success and whole.t[-1] == 10.0 and (np.diff(whole.t) > 0).all()
        np.testing.assert_allclose(whole.y, [np.cos(whole.t), -np.sin(whole.t)], atol=2e-8)
        # Steps are not all alike but where the pace is a number.
        assert (np.ptp(np.diff(whole.t)[:-1]) > 1e-4) == (pace != "2")
    times = np.array([3.0, 2.5, -1.0, -4.0])
    found = lw.solve(**OSCILLATOR, t_span=(3, -4), t_eval=times, rtol=1e-8, method=PACED)
    np.testing.assert_allclose(found.y, [np.cos(times - 3), -np.sin(times - 3)], atol=2e-8)
    stepped = lw.solve(**OSCILLATOR, t_span=(0, 10), step=0.01, method=PACED)
    np.testing.assert_allclose(stepped.y, [np.cos(stepped.t), -np.sin(stepped.t)], atol=1e-6)


def test_no_points_are_no_points() -> None:
    for how in ({"rtol": 1e-6}, {"step": 0.1}, {}):
        found = lw.solve(**OSCILLATOR, t_span=(0, 1), t_eval=[], **how)
        assert found.success and found.t.shape == (0,) and found.y.shape == (2, 0)


def test_the_first_example_of_the_package_warns_of_nothing() -> None:
    text = str(lw.__doc__)
    example = text[text.index("    solution = lw.solve(") : text.index("Units are those")]
    found: dict[str, object] = {"lw": lw}
    exec("if True:\n" + example, found)
    assert found["solution"].success  # type: ignore[attr-defined]


def test_an_accuracy_is_met_or_said_to_be_missed() -> None:
    for rtol in (1e-4, 1e-9):
        found = lw.solve(**OSCILLATOR, t_span=(0, 20), t_eval=[20.0], rtol=rtol)
        assert found.success
        assert np.hypot(*(found.y[:, 0] - [np.cos(20), -np.sin(20)])) < rtol
    found = lw.solve(**OSCILLATOR, t_span=(0, 20), t_eval=[20.0], rtol=1e-13, max_steps=256)
    assert (found.success, found.status) == (False, -1)
    assert "with 183 steps two runs still differ" in found.message


def test_a_step_that_fails_ends_the_solution() -> None:
    # x' = x² has left every bound at t = 1.
    system = {"bracket": {"x,y": "1"}, "convention": "{x,H}", "hamiltonian": "x^2*y", "x0": [1.0, 1.0]}
    times = np.linspace(0, 2, 41)
    found = lw.solve(**system, t_span=(0, 2), t_eval=times, step=0.01, method="implicit-midpoint")
    assert not found.success and "failed at t" in found.message
    assert 0 < len(found.t) < 41 and found.y.shape == (2, len(found.t))
    np.testing.assert_allclose(found.y[0, :11], 1 / (1 - found.t[:11]), rtol=1e-3)


@pytest.mark.parametrize(
    "changed, error, words",
    [
        ({"x0": [1.0, np.nan]}, ValueError, r"x0\[1\] is nan"),
        ({"x0": [[1.0, 0.0]]}, ValueError, r"x0 has the shape \(1, 2\), not \(n,\)"),
        ({"x0": ["a", "b"]}, TypeError, "x0 holds .*, not real numbers"),
        ({"x0": [1j, 0]}, TypeError, "complex128"),
        ({"x0": [1.0]}, lw.SceneError, "2, one for each variable"),
        ({"t_span": (0, 0)}, ValueError, "two different finite times"),
        ({"t_span": (0, np.inf)}, ValueError, "two different finite times"),
        ({"t_eval": [0.0, 11.0]}, ValueError, "leaves t_span"),
        ({"t_eval": [1.0, 0.5]}, ValueError, "another way"),
        ({"t_eval": [1.0, 1.0]}, ValueError, "a time twice"),
        ({"t_eval": [[1.0]]}, ValueError, r"not \(n,\)"),
        ({"step": 0}, ValueError, "step is 0"),
        ({"step": np.nan}, ValueError, "step is nan"),
        ({"step": 0.1, "rtol": 1e-3}, ValueError, "not both"),
        ({"rtol": 0}, ValueError, "rtol is 0"),
        ({"rtol": [1e-3]}, ValueError, r"rtol has the shape \(1,\), not"),
        ({"rtol": "1e-3"}, TypeError, "rtol holds <U4, not real numbers"),
        ({"t_span": [0, 1, 2]}, ValueError, r"two times, the first and the last, not \[0, 1, 2\]"),
        ({"t_span": 3.0}, ValueError, "two times"),
        ({"max_steps": 10**30}, ValueError, "max_steps is about 1e30"),
        ({"max_steps": 0}, ValueError, "max_steps is 0, less than 1"),
        ({"bracket": np.array([[0, 1], [-1, 0]])}, TypeError, "bracket is of ndarray: give the brackets of pairs"),
        ({"method": 4}, TypeError, "method is of int"),
        ({"parameters": [1.0]}, TypeError, "parameters is of list, not a table"),
        ({"variables": "qp"}, TypeError, "not a list"),
        ({"system": "so3"}, TypeError, "not a leafwise.System"),
        ({"hamiltonian": "p^2 + r", "step": 0.1}, lw.SceneError, "unknown name `r`"),
        ({"method": "rk5", "step": 0.1}, lw.SceneError, "rk5"),
    ],
)
def test_what_is_refused(changed: dict[str, object], error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        lw.solve(**(OSCILLATOR | {"t_span": (0, 10)} | changed))
