"""Events of a solution, against closed forms and SciPy's."""

import pickle

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import leafwise as lw
from test_solve import BODY, OSCILLATOR


def body_motion(_: float, x: np.ndarray) -> np.ndarray:
    return np.cross(x / [1.0, 0.75, 1.25], x)


@pytest.mark.parametrize("span", [(0.0, 12.0), (12.0, 0.0)])
@pytest.mark.parametrize("direction", [0, 1, -1])
@pytest.mark.parametrize("terminal", [False, True, 3])
def test_events_are_scipys(span: tuple[float, float], direction: int, terminal: object) -> None:
    functions = [lambda t, x: x[0] - 0.5, lambda t, x: x[1] + x[2] * 0.5]
    functions[1].direction, functions[1].terminal = direction, terminal  # type: ignore[attr-defined]
    other = solve_ivp(body_motion, span, BODY["x0"], "DOP853", rtol=1e-11, atol=1e-11, events=functions)
    events = ["x1 = 0.5", {"at": "x2 + x3/2 = 0", "direction": direction, "terminal": terminal}]
    found = lw.solve(**BODY, t_span=span, rtol=1e-10, events=events)
    assert found.status == other.status and found.success
    assert found["t_events"] is found.t_events
    for own, own_y, times, states in zip(found.t_events, found.y_events, other.t_events, other.y_events, strict=True):
        assert own.shape == times.shape and own_y.shape == (len(times), 3)
        np.testing.assert_allclose(own, times, atol=1e-7)
        np.testing.assert_allclose(own_y, states.reshape(-1, 3), atol=1e-7)
    # On the surface to round-off, and on the leaf.
    np.testing.assert_allclose(found.y_events[0][:, 0], 0.5, atol=1e-13)
    np.testing.assert_allclose(found.y_events[1] @ [0, 1, 0.5], 0, atol=1e-13)
    np.testing.assert_allclose((found.y_events[1] ** 2).sum(1), 19, rtol=1e-13)
    if found.status == 1:
        assert found.t[-1] == found.t_events[1][-1]
        np.testing.assert_array_equal(found.y[:, -1], found.y_events[1][-1])
        np.testing.assert_allclose(found(found.t[-1]), found.y[:, -1], atol=1e-13)
        assert "the event x2 + x3/2 = 0 ended it" in found.message
        with pytest.raises(ValueError, match="leaves t_span"):
            found(span[1])


def test_events_are_ends_of_shorter_steps_of_the_same_run() -> None:
    plain = lw.solve(**OSCILLATOR, t_span=(0, 20), step=0.3)
    found = lw.solve(**OSCILLATOR, t_span=(0, 20), step=0.3, events="q = 0")
    np.testing.assert_array_equal(found.y, plain.y)
    (times,), (states,) = found.t_events, found.y_events
    # Of order 4: the phase errs by less than h⁴ a unit of time.
    np.testing.assert_allclose(times, np.pi / 2 + np.pi * np.arange(6), atol=20 * 0.3**4)
    np.testing.assert_allclose(np.abs(states), [[0, 1]] * 6, atol=1e-14)


def test_an_event_in_front_of_another_within_one_step() -> None:
    """q = 0 at π/2 is terminal; p = −0.999 is crossed before it, and q = −0.01 behind it, all within one step."""
    events = [{"at": "q = -0.01"}, {"at": "q = 0", "terminal": True}, "p = -0.999"]
    found = lw.solve(**OSCILLATOR, t_span=(0, 6), step=0.4, events=events)
    assert [len(times) for times in found.t_events] == [0, 1, 1] and found.status == 1
    assert found.t_events[2][0] < found.t_events[1][0] == found.t[-1]
    assert len(found.t) == 5 and (np.diff(found.t) > 0).all()
    assert found.energy.shape == found.t.shape and found.drift["energy"] < 1e-14


def test_points_go_up_to_a_terminal_event() -> None:
    end = {"at": "q = 0", "terminal": 2}
    for points in ([1.0, 2.0, 4.0, 5.0, 9.0], [0.0, 4.712, 4.713], []):
        for accuracy in ({"step": 0.1}, {"rtol": 1e-8}):
            found = lw.solve(**OSCILLATOR, t_span=(0, 10), t_eval=points, events=[end], **accuracy)
            assert found.status == 1
            assert found.t.tolist() == [point for point in points if point < 3 * np.pi / 2]
            np.testing.assert_allclose(found.y[0], np.cos(found.t), atol=1e-5)
            np.testing.assert_allclose(found.t_events[0], [np.pi / 2, 3 * np.pi / 2], atol=1e-4)
    found = lw.solve(**OSCILLATOR, t_span=(0, 10), t_eval=[0.0], events=[end], rtol=1e-10)
    np.testing.assert_allclose(found.t_events[0], [np.pi / 2, 3 * np.pi / 2], atol=1e-9)
    assert sum(found.trials) <= 1.5 * found.trials[-1]


@pytest.mark.filterwarnings("ignore::leafwise.LeafwiseWarning")
def test_a_terminal_event_keeps_from_what_lies_behind_it() -> None:
    """x' = x² has left every bound at t = 1, and x = 4 is at t = 3/4."""
    system = {"bracket": {"x,y": "1"}, "convention": "{x,H}", "hamiltonian": "x^2*y", "x0": [1.0, 1.0]}
    found = lw.solve(**system, t_span=(0, 2), rtol=1e-6, method="implicit-midpoint", events={"at": "x = 4", "terminal": True})
    assert found.status == 1 and abs(found.t[-1] - 0.75) < 1e-5


def test_formulas_of_events() -> None:
    driven = OSCILLATOR | {"hamiltonian": "p^2/2 + w*q^2/2 + q*cos(2*t)", "parameters": {"w": 1.0}, "define": {"r": "q^2 + p^2"}}
    found = lw.solve(**driven, t_span=(0, 9), step=0.05, events=["sin(pi*t/2) = 0", "r = w/2"])
    np.testing.assert_allclose(found.t_events[0], [2, 4, 6, 8], atol=1e-12)
    np.testing.assert_allclose((found.y_events[1] ** 2).sum(1), 0.5, rtol=1e-12)
    assert found.y_events[0].shape == (4, 2) and len(found.t_events[1]) > 0
    # A start on the surface is no crossing.
    assert lw.solve(**OSCILLATOR, t_span=(0, 4), step=0.1, events="p = 0").t_events[0].shape == (1,)
    assert lw.solve(**OSCILLATOR, t_span=(0, 4), step=0.1).t_events is None
    assert lw.solve(**OSCILLATOR, t_span=(0, 4), step=0.1, events=[]).t_events == []


@pytest.mark.parametrize("step", [0.05, 0.125, 0.3])
def test_an_event_at_the_end_of_the_span_counts_once(step: float) -> None:
    """sin(πt/2) is 0 to round-off at the end itself, on either side of it."""
    driven = OSCILLATOR | {"hamiltonian": "p^2/2 + q^2/2 + q*cos(2*t)"}
    for start, end in ((0.0, 8.0), (1.0, 8.0), (8.0, 1.0), (9.0, 2.0)):
        expected = [time for time in (2.0, 4.0, 6.0, 8.0)[:: 1 if start < end else -1] if time != start]
        for last in (None, len(expected)):
            event = {"at": "sin(pi*t/2) = 0", "terminal": last}
            found = lw.solve(**driven, t_span=(start, end), step=step, events=[event, "t = 5"])
            np.testing.assert_allclose(found.t_events[0], expected, atol=1e-12)
            np.testing.assert_allclose(found.t_events[1], [5.0], atol=1e-12)
            assert found.status == (0 if last is None else 1)
            np.testing.assert_allclose(found.t[-1], expected[-1] if last or end in expected else end, atol=1e-12)
            again = pickle.loads(pickle.dumps(found))
            np.testing.assert_array_equal(again.t_events[0], found.t_events[0])
            np.testing.assert_array_equal(again(found.t[1:-1]), found(found.t[1:-1]))


def test_events_with_a_pace_lie_in_t() -> None:
    method = {"realization": "auto", "dynamics": {"name": "hamilton-jacobi", "order": 4}, "pace": "1 + q^2/2"}
    for accuracy in ({"step": 0.01}, {"rtol": 1e-8}):
        found = lw.solve(**OSCILLATOR, t_span=(0, 6), method=method, events="q = 0", **accuracy)
        np.testing.assert_allclose(found.t_events[0], [np.pi / 2, 3 * np.pi / 2], atol=1e-6)
        assert found.success and abs(found.t[-1] - 6) < 1e-12


@pytest.mark.parametrize(
    "events, error, words",
    [
        ("r = 0", lw.SceneError, "unknown name `r`"),
        ("q", lw.SceneError, "compares nothing"),
        ("q > 0", lw.SceneError, "two formulas with = between them"),
        ("ln(q - 2) = 0", lw.SceneError, "no value at the initial state"),
        ("t = 1", lw.SceneError, "t"),
        (lambda t, y: y[0], TypeError, "events are formulas"),
        ([lambda t, y: y[0]], TypeError, r"events\[0\] is a function"),
        ([1.0], TypeError, "not a formula"),
        (3, TypeError, "not a list of formulas"),
        ({"at": "q = 0", "dir": 1}, ValueError, "has no 'dir'"),
        ({"direction": 1}, ValueError, "needs the formula"),
        ({"at": "q = 0", "direction": "left"}, ValueError, "direction 'left'"),
        ({"at": "q = 0", "terminal": -1}, ValueError, "terminal -1"),
        ({"at": 3}, TypeError, "not at a formula"),
    ],
)
def test_what_is_refused(events: object, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        lw.solve(**OSCILLATOR, t_span=(0, 10), step=0.1, events=events)
