"""Derivatives of trajectories against each other and against differences, and parameters from noisy observations."""

import pickle
import subprocess
import sys
import warnings

import numpy as np
import pytest

import leafwise as lw
from test_scenes import RIGID_BODY, SCENES

HEAVY_TOP = {
    "system": {"library": "heavy-top"},
    "method": {
        "realization": {"name": "karasev-truncated", "order": 4},
        "dynamics": {"name": "hamilton-jacobi", "order": 4},
        "time-step": 0.05,
    },
    "run": {"initial": [0.5, 1.0, 1.5, 0.6, 0.0, 0.8], "steps": 398, "record": {"every": 2}},
}

#: I1, I3 and the height of the centre of mass, times the weight.
NAMES = ["I1", "I3", "chi3"]
TRUE = np.array([1.0, 1.25, 1.0])
NOISE = 0.05


def pendulum(**run: object) -> lw.Scene:
    system = {
        "variables": ["q", "p"],
        "parameters": {"g": 1.0, "a": 0.1},
        "bracket": {"q,p": "1"},
        "convention": "{x,H}",
        "hamiltonian": "p^2/2 - g*cos(q) + a*q*cos(t)",
    }
    return lw.Scene(
        system=system,
        method={"dynamics": {"name": "hamilton-jacobi", "order": 4}, "time-step": 0.05},
        run={"initial": [1.0, 0.3], "steps": 100, "record": {"every": 20}} | run,
    )


def body(method: dict[str, object]) -> lw.Scene:
    return lw.Scene(RIGID_BODY | {"method": method})


def top_from(*, I1: float, I3: float, chi3: float) -> lw.Scene:
    """The heavy top with other values to begin with."""
    return lw.Scene(HEAVY_TOP | {"system": {"library": "heavy-top", "parameters": {"I1": I1, "I3": I3, "chi3": chi3}}})


def noisy(seed: int) -> np.ndarray:
    """200 observations of the heavy top's states."""
    x = lw.Scene(HEAVY_TOP).trajectory([])()
    return x + NOISE * np.random.default_rng(seed).standard_normal(x.shape)


@pytest.mark.parametrize("file", ["rigid_body.toml", "heavy_top.toml", "lotka_volterra_periodic.toml", "point_vortices.toml"])
def test_samples_are_those_of_a_run_to_the_bit(file: str) -> None:
    scene = lw.Scene.load(SCENES / file)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lw.LeafwiseWarning)
        run = scene.run(steps=300, record=30)
    trajectory = scene.trajectory(steps=300, record=30)
    np.testing.assert_array_equal(trajectory(), run.x)
    np.testing.assert_allclose(trajectory.t, run.t, rtol=1e-14)


def test_tangents_and_covectors_agree() -> None:
    """w·(Dx v) = (Dxᵀ w)·v. Each of 398 steps rounds both by a few units, of random signs."""
    trajectory = lw.Scene(HEAVY_TOP).trajectory(NAMES)
    rng = np.random.default_rng(1)
    v, mu = rng.standard_normal((4, 6)), rng.standard_normal((4, 3))
    w = rng.standard_normal((200, 6))
    x, dx, growth = trajectory.jvp(v, mu)
    assert x.shape == (200, 6) and dx.shape == (200, 4, 6)
    same, pull = trajectory.vjp()
    np.testing.assert_array_equal(x, same)
    gradient = pull(w)
    assert gradient.x0.shape == (6,) and gradient.values.shape == (3,) and not gradient.from_checkpoints
    assert 10 < growth.digits < 16 and not growth.is_large and "digits of them are right" in str(growth)
    forwards = np.einsum("nd,nkd->k", w, dx)
    sizes = np.einsum("nd,nkd->k", np.abs(w), np.abs(dx))
    assert (np.abs(forwards - v @ gradient.x0 - mu @ gradient.values) < 1e-12 * sizes).all()
    one = trajectory.jvp(v[2], mu[2])
    np.testing.assert_allclose(one.dx, dx[:, 2], rtol=0, atol=1e-13 * np.abs(dx).max())


@pytest.mark.parametrize("scene", [pendulum(), body(RIGID_BODY["method"]), body({"stepper": "splitting", "time-step": 0.1})])
def test_gradients_are_those_of_differences(scene: lw.Scene) -> None:
    """Differences of order 4: where phases turn by r ≤ 80 for a change by one, off by (rδ)⁴/30 = 2e-9 of the derivative, and by
    1e-13/δ = 5e-10 for what the runs round."""
    trajectory = scene.trajectory(steps=100, record=20)
    w = np.random.default_rng(2).standard_normal(trajectory().shape)
    gradient = trajectory.vjp()[1](w)
    d, delta = len(trajectory.x0), 2e-4
    at = np.concatenate([trajectory.x0, trajectory.values])

    def value(point: np.ndarray) -> float:
        return float((w * trajectory(point[:d], point[d:])).sum())

    def slope(direction: np.ndarray) -> float:
        one, two = ((value(at + of * direction) - value(at - of * direction)) / (2 * of) for of in (delta, 2 * delta))
        return (4 * one - two) / 3

    expected = [slope(direction) for direction in np.eye(len(at))]
    found = np.concatenate([gradient.x0, gradient.values])
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-8 * np.abs(expected).max())


def test_methods_that_are_no_inverse_of_themselves_take_checkpoints() -> None:
    scene = body({"stepper": "rk4", "time-step": 0.05})
    trajectory = scene.trajectory([], steps=200, record=200)
    x, pull = trajectory.vjp()
    gradient = pull([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    dx = trajectory.jvp(np.eye(3)).dx
    assert gradient.from_checkpoints
    np.testing.assert_allclose(gradient.x0, dx[-1, :, 0], rtol=0, atol=1e-12 * np.abs(dx).max())


def test_functions_of_python_have_no_derivatives_and_raise_their_own() -> None:
    with pytest.warns(lw.LeafwiseWarning, match="hundred times faster"):
        system = lw.System(
            variables=["q", "p"],
            hamiltonian=lambda x: x[1] ** 2 / 2 - np.cos(x[0]),
            gradient=lambda x: [1 / 0 if np.any(x[0] > 2) else np.sin(x[0]), x[1]],
            tensor=lambda x, p: np.array([p[1], -p[0]]),
        )
    method = {"realization": "karasev-collocated", "dynamics": {"name": "hamilton-jacobi", "order": 2}, "time-step": 0.1}
    scene = lw.Scene(system=system, method=method, run={"initial": [0.5, 0.1], "steps": 20})
    trajectory = scene.trajectory(record=20)
    np.testing.assert_array_equal(trajectory(), scene.run(record=20).x)
    with pytest.raises(lw.LeafwiseError, match="offers no exact derivative of its steps; take"):
        trajectory.jvp(np.eye(2))
    with pytest.raises(ZeroDivisionError):
        trajectory([3.0, 0.0])


def test_numbers_have_no_derivatives_by_parameters() -> None:
    scene = body(RIGID_BODY["method"] | {"realization": "karasev-collocated"})
    assert scene.trajectory([], steps=2).vjp()[1](np.ones((3, 3))).values.shape == (0,)
    _, pull = scene.trajectory(["I1"], steps=2).vjp()
    with pytest.raises(lw.LeafwiseError, match="derivatives by the parameters are not known; take"):
        pull(np.ones((3, 3)))
    with pytest.raises(lw.LeafwiseError, match="derivatives by the parameters are not known; take"):
        scene.fit(scene.run(steps=10).x, ["I1"])


def test_a_chaotic_trajectory_says_how_fast_gradients_grow() -> None:
    system = {
        "variables": ["q1", "q2", "p1", "p2"],
        "bracket": {"q1,p1": "1", "q2,p2": "1"},
        "convention": "{x,H}",
        "hamiltonian": "(p1^2 + p2^2 + q1^2 + q2^2)/2 + q1^2*q2 - q2^3/3",
    }
    scene = lw.Scene(
        system=system,
        method={"stepper": "splitting", "time-step": 0.05},
        run={"initial": [0.0, -0.1, 0.5677, 0.0], "steps": 10_000},
    )
    _, pull = scene.trajectory(record=10_000).vjp()
    with pytest.warns(lw.LeafwiseWarning, match="no digit of them is right"):
        gradient = pull(np.ones((2, 4)))
    assert gradient.growth.is_large and 0.05 < gradient.growth.rate < 0.3


def test_the_heavy_top_s_inertia_is_found_from_noisy_observations() -> None:
    fit = top_from(I1=1.1, I3=1.15, chi3=0.9).fit(noisy(0), NAMES, sigma=NOISE)
    assert fit.is_converged and fit.iterations < 50
    for name, true in zip(NAMES, TRUE, strict=True):
        assert abs(fit.values[name] - true) < 4 * fit.errors[name], fit
    # χ² of 1197 degrees of freedom has the standard deviation √2394 = 49.
    assert fit.freedom == 1197 and abs(fit.chi2 - 1197) < 5 * 49
    assert fit.scene.parameters["I3"] == fit.values["I3"] and "I3 = " in repr(fit)


@pytest.mark.parametrize("start", [(2.0, 2.0, 2.0), (0.7, 0.8, 0.6), (1.5, 1.5, 1.5)])
def test_a_fit_begins_far_away(start: tuple[float, float, float]) -> None:
    fit = top_from(I1=start[0], I3=start[1], chi3=start[2]).fit(noisy(0), NAMES, sigma=NOISE)
    assert fit.is_converged and fit.iterations < 50
    assert all(abs(fit.values[n] - true) < 4 * fit.errors[n] for n, true in zip(NAMES, TRUE, strict=True)), fit


def test_uncertainties_cover_the_truth_as_often_as_they_say() -> None:
    """Over 100 seeds: each parameter within one standard deviation in 68 ± 4.7 cases, and Σ δᵀC⁻¹δ as χ² of 300, ± √600."""
    inside, total = np.zeros(3), 0.0
    for seed in range(100):
        fit = lw.Scene(HEAVY_TOP).fit(noisy(seed), NAMES, sigma=NOISE)
        off = np.array([fit.values[name] for name in NAMES]) - TRUE
        inside += np.abs(off) < np.sqrt(np.diag(fit.covariance))
        total += off @ np.linalg.solve(fit.covariance, off)
        assert fit.is_converged and fit.iterations < 50
    assert (np.abs(inside - 68.3) < 4 * 4.7).all(), inside
    assert abs(total - 300) < 4 * 24.5, total


def test_a_fit_takes_what_is_there() -> None:
    """Some coordinates, with gaps, an unknown noise, and an unknown initial state."""
    data = noisy(3)
    observed = ["m1", "gamma3"]
    some = data[:, [0, 5]]
    some[20:60, 1] = np.nan
    fit = top_from(I1=1.05, I3=1.2, chi3=0.95).fit(some, NAMES, observed=observed)
    assert fit.is_converged and fit.freedom == 400 - 40 - 3
    assert abs(np.sqrt(fit.chi2 / fit.freedom) / NOISE - 1) < 0.2
    assert all(abs(fit.values[n] - true) < 4 * fit.errors[n] for n, true in zip(NAMES, TRUE, strict=True)), fit
    assert (fit.residuals[20:60, 1] == 0).all()
    both = lw.Scene(HEAVY_TOP).fit(data, ["I3"], sigma=[NOISE] * 6, initial=True)
    truth = [1.25, *HEAVY_TOP["run"]["initial"]]
    assert both.names == ["I3", "m1(0)", "m2(0)", "m3(0)", "gamma1(0)", "gamma2(0)", "gamma3(0)"]
    assert all(abs(both.values[n] - true) < 4 * both.errors[n] for n, true in zip(both.names, truth, strict=True)), both
    exact = top_from(I1=1.05, I3=1.2, chi3=0.95).fit(lw.Scene(HEAVY_TOP).trajectory()(), NAMES)
    np.testing.assert_allclose(list(exact.values.values()), TRUE, rtol=1e-12)


def test_residuals_that_noise_does_not_explain_are_told() -> None:
    with pytest.warns(lw.LeafwiseWarning, match="sum of squares is 1.14e.05, where noise of sigma makes 1197"):
        lw.Scene(HEAVY_TOP).fit(noisy(0), NAMES, sigma=NOISE / 10)
    with pytest.warns(lw.LeafwiseWarning, match="no fit after 1 iterations"):
        fit = top_from(I1=1.5, I3=1.5, chi3=1.5).fit(noisy(0), NAMES, sigma=NOISE, iterations=1)
    assert not fit.is_converged and fit.iterations == 1


def test_a_fit_that_the_data_do_not_determine_says_so() -> None:
    scene = lw.Scene(
        system={
            "variables": ["q", "p"],
            "parameters": {"a": 1.0, "b": 1.0, "c": 1.0},
            "bracket": {"q,p": "1"},
            "convention": "{x,H}",
            "hamiltonian": "p^2/2 + a*b*q^2/2 + c",
        },
        method={"dynamics": {"name": "hamilton-jacobi", "order": 4}, "time-step": 0.1},
        run={"initial": [1.0, 0.0], "steps": 100},
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lw.LeafwiseWarning)
        data = scene.run().x
    with pytest.raises(lw.LeafwiseError, match="do not distinguish a and b"):
        scene.fit(data, ["a", "b"])
    with pytest.raises(lw.LeafwiseError, match="do not depend on c"):
        scene.fit(data, ["a", "c"])


def test_what_is_wrong_is_told() -> None:
    scene = lw.Scene(RIGID_BODY)
    trajectory = scene.trajectory(["I1"], steps=20, record=10)
    with pytest.raises(lw.LeafwiseError, match="no parameter 'J'; it has I1, I2, I3"):
        scene.trajectory(["J"])
    with pytest.raises(lw.LeafwiseError, match="named twice"):
        scene.trajectory(["I1", "I1"])
    with pytest.raises(ValueError, match="record is 0"):
        scene.trajectory(record=0)
    with pytest.raises(TypeError, match="steps is 2.5"):
        scene.trajectory(steps=2.5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"x0 has the shape \(2,\), not \(3,\)"):
        trajectory([1.0, 2.0])
    with pytest.raises(ValueError, match="not a finite number"):
        trajectory(values=[np.nan])
    with pytest.raises(TypeError, match="complex"):
        trajectory([1j, 2, 3])
    with pytest.raises(ValueError, match=r"w has the shape \(3,\), not \(3, 3\)"):
        trajectory.vjp()[1](np.ones(3))
    with pytest.raises(ValueError, match="give dx0 or dvalues"):
        trajectory.jvp()
    with pytest.raises(ValueError, match="directions"):
        trajectory.jvp(np.ones((2, 3)), np.ones((3, 1)))
    with pytest.raises(lw.IntegrationError, match="step 0 failed"):
        body(RIGID_BODY["method"] | {"time-step": 50.0}).trajectory()()
    for run, words in [({"stop": "q > 10"}, "stops"), ({"record": {"times": [0.5]}}, "samples at times")]:
        with pytest.raises(lw.LeafwiseError, match=words):
            pendulum(**run).trajectory()
    data = trajectory()
    for wrong in [data[:, :2], data[0], data[:1]]:
        with pytest.raises(ValueError, match="data has the shape"):
            scene.fit(wrong, ["I1"], record=10)
    with pytest.raises(ValueError, match="sigma must be positive"):
        scene.fit(data, ["I1"], record=10, sigma=0.0)
    with pytest.raises(ValueError, match="nothing to fit"):
        scene.fit(data, [], record=10)
    with pytest.raises(lw.LeafwiseError, match="no coordinate 'x9'"):
        scene.fit(data, ["I1"], observed=["x9"])


def test_arrays_of_any_kind_and_pickles() -> None:
    trajectory = lw.Scene(RIGID_BODY).trajectory(["I1", "I3"], steps=20, record=10)
    expected = trajectory([1, 3, 3], [1.0, 1.25])
    strided = np.arange(12.0).reshape(4, 3)[::2]
    strided[0] = [1.0, 3.0, 3.0]
    frozen = np.array([1.0, 3.0, 3.0])
    frozen.flags.writeable = False
    for x0 in (strided[0], frozen, frozen.astype(np.float32), (1, 3, 3)):
        np.testing.assert_array_equal(trajectory(x0), expected)
    weights = np.asfortranarray(np.ones((3, 3)))
    again = pickle.loads(pickle.dumps(trajectory))
    np.testing.assert_array_equal(again.vjp()[1](weights).x0, trajectory.vjp()[1](np.ones((3, 3))).x0)


def test_an_interruption_ends_a_gradient() -> None:
    program = """
import os, signal, threading
import leafwise as lw
from test_scenes import RIGID_BODY
signal.signal(signal.SIGINT, signal.default_int_handler)
threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
try:
    lw.Scene(RIGID_BODY).trajectory(steps=10**11, record=10**11)()
except KeyboardInterrupt:
    print("interrupted")
"""
    told = subprocess.run(
        [sys.executable, "-c", program], cwd=SCENES.parent / "python/tests", capture_output=True, text=True, check=False
    )
    assert told.stdout == "interrupted\n", told.stderr


def test_jax_differentiates_batches_and_compiles() -> None:
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    from leafwise.jax import solve

    trajectory = lw.Scene(RIGID_BODY).trajectory(["I1", "I2"], steps=100, record=50)
    x0, values = np.array([1.0, 3.0, 3.0]), np.array([1.0, 0.75])
    w = np.random.default_rng(4).standard_normal((3, 3))

    def loss(x0, values):  # type: ignore[no-untyped-def]
        return (w * solve(trajectory, x0, values)).sum()

    gradient = trajectory.vjp()[1](w)
    np.testing.assert_array_equal(solve(trajectory), trajectory())
    for differentiate in (jax.grad(loss, argnums=(0, 1)), jax.jit(jax.grad(loss, argnums=(0, 1)))):
        by_state, by_values = differentiate(x0, values)
        np.testing.assert_array_equal(by_state, gradient.x0)
        np.testing.assert_array_equal(by_values, gradient.values)
    many = x0 + 0.1 * np.arange(5)[:, None]
    of_many = jax.jit(jax.vmap(lambda x0: solve(trajectory, x0, values)))(many)
    np.testing.assert_array_equal(of_many, [trajectory(x0, values) for x0 in many])
    by_state, by_values = jax.vmap(jax.grad(loss, argnums=(0, 1)), (0, None))(many, values)
    pulled = [trajectory.vjp(x0, values)[1](w) for x0 in many]
    np.testing.assert_array_equal(by_state, [gradient.x0 for gradient in pulled])
    np.testing.assert_array_equal(by_values, [gradient.values for gradient in pulled])


BLOWS_UP = {
    "system": {"variables": ["x", "y"], "bracket": {"x,y": "1"}, "convention": "{x,H}", "hamiltonian": "x^2*y"},
    "method": {"realization": "auto", "dynamics": {"name": "hamilton-jacobi", "order": 4}, "time-step": 0.1},
    "run": {"initial": [1.0, 1.0], "steps": 200},
}


def test_what_fails_within_jax_is_an_error_of_the_package(capfd: pytest.CaptureFixture[str]) -> None:
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    import leafwise.jax

    # x' = x² has left every bound at t = 1/x0.
    trajectory = lw.Scene(BLOWS_UP).trajectory([])
    solve, errors = leafwise.jax.solve, leafwise.jax.errors
    ones = jax.numpy.ones(2)

    def loss(x0: object) -> object:
        return (solve(trajectory, x0)[..., -1, :] ** 2).sum()

    def within(function: object) -> object:
        with errors():
            return jax.block_until_ready(function(ones))

    for call in (
        lambda: solve(trajectory, ones),
        lambda: solve(trajectory, jax.numpy.ones((3, 2))),
        lambda: jax.grad(loss)(ones),
        lambda: within(jax.jit(loss)),
        lambda: within(jax.jit(jax.grad(loss))),
        lambda: within(lambda x0: jax.vmap(loss)(jax.numpy.stack([x0, x0]))),
        lambda: errors()(jax.jit(loss))(ones),
    ):
        with pytest.raises(lw.IntegrationError, match="step 10 failed: .*reduce the time step"):
            call()
    assert "Traceback" not in capfd.readouterr().err
    for wrong, error, words in (
        (jax.numpy.ones(3), ValueError, r"x0 has the shape \(3,\), not \(2,\), or \(\.\.\., 2\) for a batch"),
        (1.0, ValueError, r"x0 has the shape \(\)"),
        (np.array([1.0, 1j]), TypeError, "x0 holds complex128"),
        (["a", "b"], TypeError, "x0 holds <U1"),
    ):
        with pytest.raises(error, match=words):
            solve(trajectory, wrong)
        if not isinstance(wrong, list):
            with pytest.raises(error, match=words):
                jax.jit(loss)(wrong)
    with pytest.raises(ValueError, match=r"x0\[1\] is nan"):
        solve(trajectory, jax.numpy.array([1.0, np.nan]))
    # Other errors of compiled code pass.
    with pytest.raises(ZeroDivisionError), errors():
        raise ZeroDivisionError


def test_batches_of_jax_are_their_members() -> None:
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    from leafwise.jax import solve

    trajectory = lw.Scene(RIGID_BODY).trajectory(["I1"], steps=20, record=10)
    states = np.random.default_rng(3).normal([1.0, 3.0, 3.0], 0.1, (2, 4, 3))
    values = np.array([[1.0], [1.1], [0.9], [1.2]])
    found = solve(trajectory, states, values)
    assert found.shape == (2, 4, 3, 3)
    for at in np.ndindex(2, 4):
        np.testing.assert_array_equal(found[at], trajectory(states[at], values[at[1]]))
    assert solve(trajectory, np.zeros((0, 3))).shape == (0, 3, 3)
    by_states = jax.grad(lambda x0: solve(trajectory, x0, values)[..., -1, 0].sum())(jax.numpy.asarray(states))
    w = np.zeros((3, 3))
    w[-1, 0] = 1
    np.testing.assert_allclose(by_states[1, 2], trajectory.vjp(states[1, 2], values[2])[1](w).x0, rtol=1e-12)


def test_a_fit_goes_on_from_values_at_which_every_step_can_be_taken() -> None:
    """The first eighth of noisy data may stray to values whose longer runs fail: of these data each did."""

    def pendulum(g: float, d: float, x0: list[float]) -> lw.Scene:
        return lw.Scene(
            system={
                "variables": ["q", "p"],
                "bracket": {"q,p": "1"},
                "convention": "{x,H}",
                "hamiltonian": "p^2/2 - g*cos(q) + d*q^4/4",
                "parameters": {"g": g, "d": d},
            },
            method={"realization": "auto", "dynamics": {"name": "hamilton-jacobi", "order": 4}, "time-step": 0.05},
            run={"initial": x0, "steps": 400, "record": {"every": 4}},
        )

    true, start = pendulum(1.0, 0.3, [1.2, 0.0]).run().x, pendulum(1.5, 0.1, [1.0, 0.2])
    assert start.run().outcome == "done"
    raised = 0
    for sigma, columns, seeds in ((0.3, ["q", "p"], range(40)), (0.05, ["q"], range(40))):
        for seed in seeds:
            data = (true + np.random.default_rng(seed).normal(size=true.shape) * sigma)[:, : len(columns)]
            fit = start.fit(data, ["g", "d"], sigma=sigma, observed=columns, initial=True)
            # Five deviations of the sum of squares, √(2·freedom) each.
            assert fit.is_converged and fit.chi2 < fit.freedom + 5 * (2 * fit.freedom) ** 0.5
            first = data[: -(-len(data) // 8)]
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                alone = start.fit(first, ["g", "d"], sigma=sigma, observed=columns, initial=True)
                try:
                    alone.scene.run()
                except lw.IntegrationError:
                    raised += 1
    assert raised > 0, "no case of the kind was drawn"


def test_a_fit_that_ends_elsewhere_tells_its_sum_of_squares() -> None:
    scene = lw.Scene(RIGID_BODY).set(run__steps=400)
    data = scene.run().x
    with pytest.warns(lw.LeafwiseWarning, match="the sum of squares is .* of 1203 numbers, and the last correction was"):
        scene.set(system__parameters__I1=1.4).fit(data, ["I1"], sigma=1e-3, iterations=1)
