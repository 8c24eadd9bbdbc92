"""Fits to observations at times of their own, within bounds, and with what was known before."""

import numpy as np
import pytest

import leafwise as lw
from leafwise._times import AtTimes
from test_gradients import HEAVY_TOP, NAMES, NOISE, TRUE, pendulum, top_from


def falling(a: float, initial: tuple[float, float] = (2.0, 1.0)) -> lw.Scene:
    """H = p²/2 + a q: q(t) = q₀ + p₀ t − a t²/2, linear in all three, and exact by a splitting."""
    return lw.Scene(
        system={
            "variables": ["q", "p"],
            "parameters": {"a": a},
            "bracket": {"q,p": "1"},
            "convention": "{x,H}",
            "hamiltonian": "p^2/2 + a*q",
        },
        method={"stepper": "splitting", "time-step": 0.1},
        run={"initial": list(initial), "steps": 50},
    )


TIMES = np.sort(np.concatenate([np.random.default_rng(8).uniform(0, 5, 20), [0.0, 0.3, 0.3, 5.0]]))


@pytest.mark.parametrize("step", [0.05, -0.05])
def test_states_at_times_are_those_of_a_run(step: float) -> None:
    for scene in (pendulum(), lw.Scene(HEAVY_TOP)):
        scene = scene.set(method__time_step=step)
        times = np.unique(np.sign(step) * TIMES)[:: int(np.sign(step))]
        run = scene.set(run__steps=100, run__record__times=times).run(advice=False)
        there = [int(np.argmin(np.abs(run.t - time))) for time in times]
        # Each piece between two times rounds anew.
        found = AtTimes(scene.trajectory(), times)()
        np.testing.assert_allclose(found, run.x[there], rtol=0, atol=1e-12)


def test_tangents_at_times_are_those_of_differences() -> None:
    """Of order 2, δ = 1e-5: off by (rδ)² of the third derivative, r < 10, and 1e-13/δ."""
    along = pendulum().trajectory()
    model = AtTimes(along, TIMES)
    at, delta = np.concatenate([along.x0, along.values]), 1e-5
    whole = np.eye(4)
    moved = model.jvp(whole[:, :2], whole[:, 2:])
    np.testing.assert_allclose(moved.x, model(), atol=1e-13)
    for k, direction in enumerate(whole):
        ahead, back = (model((at + of * direction)[:2], (at + of * direction)[2:]) for of in (delta, -delta))
        np.testing.assert_allclose((ahead - back) / (2 * delta), moved.dx[:, k], atol=1e-7)


def test_a_fit_takes_times_of_its_own() -> None:
    times = np.sort(np.random.default_rng(5).uniform(0, 19.9, 200))
    scene = lw.Scene(HEAVY_TOP)
    states = AtTimes(scene.trajectory(), times)()
    data = states + NOISE * np.random.default_rng(6).standard_normal(states.shape)
    fit = top_from(I1=1.3, I3=1.4, chi3=1.2).fit(data, NAMES, sigma=NOISE, times=times)
    assert fit.is_converged and fit.freedom == 1197 and abs(fit.chi2 - 1197) < 5 * 49
    for name, true in zip(NAMES, TRUE, strict=True):
        assert abs(fit.values[name] - true) < 4 * fit.errors[name], fit
    # On the steps it is the fit to samples.
    grid = scene.trajectory().t
    samples = scene.trajectory()() + NOISE * np.random.default_rng(7).standard_normal((200, 6))
    at_steps, at_times = (scene.fit(samples, NAMES, sigma=NOISE, **how) for how in ({}, {"times": grid}))
    for name in NAMES:
        assert abs(at_steps.values[name] - at_times.values[name]) < 1e-6 * at_steps.errors[name]
    np.testing.assert_allclose(at_times.covariance, at_steps.covariance, rtol=1e-6)


def test_what_is_linear_is_the_normal_equations() -> None:
    """Values, covariances and priors in closed form."""
    sigma = 0.03
    design = np.stack([-(TIMES**2) / 2, np.ones_like(TIMES), TIMES], axis=1)
    data = design @ [0.8, 2.1, 0.9] + sigma * np.random.default_rng(2).standard_normal(len(TIMES))
    names = ["a", "q(0)", "p(0)"]
    free = falling(1.0).fit(data[:, None], ["a"], sigma=sigma, observed=["q"], initial=True, times=TIMES)
    covariance = np.linalg.inv(design.T @ design) * sigma**2
    expected = covariance @ design.T @ data / sigma**2
    np.testing.assert_allclose([free.values[name] for name in names], expected, rtol=1e-9)
    np.testing.assert_allclose(free.covariance, covariance, rtol=1e-8)
    priors = {"a": (0.79, 0.01), "p(0)": (1.0, 0.2)}
    known = falling(1.0).fit(data[:, None], ["a"], sigma=sigma, observed=["q"], initial=True, times=TIMES, priors=priors)
    precision = np.linalg.inv(covariance) + np.diag([1 / 0.01**2, 0, 1 / 0.2**2])
    posterior = np.linalg.inv(precision)
    mean = posterior @ (design.T @ data / sigma**2 + [0.79 / 0.01**2, 0, 1.0 / 0.2**2])
    np.testing.assert_allclose([known.values[name] for name in names], mean, rtol=1e-9)
    np.testing.assert_allclose(known.covariance, posterior, rtol=1e-8)
    assert known.freedom == free.freedom + 2
    # A prior may stand for data.
    one = falling(1.0).fit([[2.0], [np.nan]], [], sigma=sigma, observed=["q"], initial=True, times=[0, 1], priors={"p(0)": (3.0, 0.5)})
    np.testing.assert_allclose([one.values["p(0)"], one.errors["p(0)"]], [3.0, 0.5], rtol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_bounds_are_kept_and_the_rest_is_the_least_there(seed: int) -> None:
    """Against SciPy's least squares within the same bounds, which the linear model has one minimum in."""
    from scipy.optimize import lsq_linear

    rng = np.random.default_rng(seed)
    design = np.stack([-(TIMES**2) / 2, np.ones_like(TIMES), TIMES], axis=1)
    data = design @ [0.8, 2.1, 0.9] + 0.3 * rng.standard_normal(len(TIMES))
    low, high = np.array([0.9, 1.9, -np.inf]), np.array([np.inf, 2.2, 0.95])
    bounds = {"a": (0.9, None), "q(0)": (1.9, 2.2), "p(0)": (None, 0.95)}
    names = ["a", "q(0)", "p(0)"]
    fit = falling(1.2, (2.0, 0.5)).fit(
        data[:, None], ["a"], sigma=0.3, observed=["q"], initial=True, times=TIMES, bounds=bounds
    )
    exact = lsq_linear(design, data, (low, high), tol=1e-14)
    found = np.array([fit.values[name] for name in names])
    np.testing.assert_allclose(found, exact.x, rtol=1e-6)
    is_held = (found == low) | (found == high)
    assert fit.at_bounds == [name for name, held in zip(names, is_held, strict=True) if held]
    assert is_held.any() and fit.is_converged
    for name, held in zip(names, is_held, strict=True):
        assert np.isnan(fit.errors[name]) == held
    own = np.linalg.inv((design.T @ design)[np.ix_(~is_held, ~is_held)]) * 0.3**2
    np.testing.assert_allclose(fit.covariance[np.ix_(~is_held, ~is_held)], own, rtol=1e-6)
    assert "at its bound" in repr(fit)
    # Bounds that hold nothing change nothing.
    wide = {name: (-50, 50) for name in names}
    free, within = (
        falling(1.2).fit(data[:, None], ["a"], sigma=0.3, observed=["q"], initial=True, times=TIMES, bounds=of)
        for of in (None, wide)
    )
    np.testing.assert_allclose([free.values[name] for name in names], [within.values[name] for name in names], rtol=1e-9)
    np.testing.assert_allclose(free.covariance, within.covariance, rtol=1e-9)


def test_a_bound_keeps_a_parameter_where_the_motion_is_defined() -> None:
    """Of a pendulum's weight, which noise alone would draw below zero."""
    scene = pendulum().set(system__parameters__a=0.0)
    true = scene.set(system__parameters__g=0.001).trajectory([], steps=100, record=5)()
    data = true + 0.05 * np.random.default_rng(0).standard_normal(true.shape)
    fit = scene.fit(data, ["g"], sigma=0.05, record=5, bounds={"g": (0, None)})
    assert 0 <= fit.values["g"] < 0.02


def test_what_is_wrong_is_told() -> None:
    scene, data = falling(1.0), np.ones((3, 2))
    good = {"sigma": 0.1, "times": [0.0, 0.5, 0.7]}
    for changed, words in [
        ({"times": [0.0, 0.5]}, r"times has the shape \(2,\), not \(3,\)"),
        ({"times": [0.0, 0.7, 0.5]}, r"times\[2\] is 0.5, before times\[1\]: sort"),
        ({"times": [-0.1, 0.7, 0.8]}, r"times\[0\] is -0.1: the run begins at t = 0"),
        ({"times": [0.0, np.nan, 0.8]}, "not a finite number"),
        ({"record": 2}, "times or record, not both"),
        ({"bounds": {"b": (0, 1)}}, "bounds name 'b', which is not fitted; the fitted ones are a"),
        ({"bounds": {"a": (1, 0)}}, "the first is the smaller one"),
        ({"bounds": {"a": (2, 3)}}, "a begins at 1, outside of its bounds"),
        ({"priors": {"b": (0, 1)}}, "priors name 'b'"),
        ({"priors": {"a": (0, 0)}}, "which must be positive"),
        ({"priors": {"a": (0, 1)}, "sigma": None}, "give sigma too"),
        ({"bounds": {"a": (np.nan, 3)}}, "not a finite number"),
    ]:
        with pytest.raises(ValueError, match=words):
            scene.fit(data, ["a"], **(good | changed))
    for changed in ({"bounds": {"a": 3}}, {"priors": {"a": 3}}):
        with pytest.raises(TypeError, match="pair|mean"):
            scene.fit(data, ["a"], **(good | changed))


def test_frames_and_masks_are_taken_beside_times_bounds_and_priors() -> None:
    pandas = pytest.importorskip("pandas")
    scene = falling(1.3)
    t = TIMES
    data = np.stack([2 + t - t**2 / 2, 1 - t], axis=1) + 0.01 * np.random.default_rng(3).standard_normal((len(t), 2))
    hidden = np.zeros(data.shape, bool)
    hidden[3, 0] = hidden[7] = True
    given = {"sigma": 0.01, "initial": True, "bounds": {"a": (0, 2.0), "q(0)": (None, 3)}, "priors": {"a": (1.0, 0.1)}}
    found = scene.fit(np.where(hidden, np.nan, data), ["a"], times=t, **given)
    assert found.is_converged and abs(found.values["a"] - 1) < 5 * found.errors["a"]
    frame = pandas.DataFrame(data, columns=["q", "p"])[["p", "q"]].mask(hidden[:, ::-1])
    for same in (np.ma.masked_array(data, hidden), frame):
        assert repr(scene.fit(same, ["a"], times=pandas.Series(t), **given)) == repr(found)
    for name, wrong in (("bounds", [(0, 1)]), ("priors", 3.0)):
        with pytest.raises(TypeError, match=f"{name} is .*, not a table"):
            scene.fit(data, ["a"], times=t, **given | {name: wrong})
