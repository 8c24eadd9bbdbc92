"""Forward and reverse derivatives in JAX and PyTorch against the trajectory's own and differences, and steps that fail in optimizers."""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import leafwise as lw
from test_scenes import RIGID_BODY

X0, VALUES = np.array([1.0, 3.0, 3.0]), np.array([1.0, 0.75])
MANY = X0 + 0.1 * np.arange(4)[:, None]


@pytest.fixture
def along() -> lw.Trajectory:
    return lw.Scene(RIGID_BODY).trajectory(["I1", "I2"], steps=40, record=20)


@pytest.fixture
def failing() -> lw.Trajectory:
    """Steps of 0.3 about (1, 3, 3), and none from a state ten times as far."""
    return lw.Scene(RIGID_BODY | {"method": RIGID_BODY["method"] | {"time-step": 0.3}}).trajectory(["I1"], steps=10, record=5)


def jacobians(along: lw.Trajectory, x0: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """By the state (n, d, d) and by the parameters (n, d, p), by the core's tangents."""
    by_state = along.jvp(np.eye(3), x0=x0, values=values).dx
    by_values = along.jvp(None, np.eye(2), x0=x0, values=values).dx
    return by_state.transpose(0, 2, 1), by_values.transpose(0, 2, 1)


def close(found: Any, expected: np.ndarray) -> None:
    """40 steps round tangents and covectors by a few units each."""
    np.testing.assert_allclose(np.asarray(found), expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_tangents_are_those_of_differences(along: lw.Trajectory) -> None:
    """Of order 2, δ = 1e-5: off by (rδ)² of the third derivative and 1e-14/δ."""
    whole = np.concatenate(jacobians(along, X0, VALUES), axis=2)
    at, delta = np.concatenate([X0, VALUES]), 1e-5
    for k, direction in enumerate(np.eye(5)):
        ahead, back = (along((at + of * direction)[:3], (at + of * direction)[3:]) for of in (delta, -delta))
        np.testing.assert_allclose((ahead - back) / (2 * delta), whole[:, :, k], atol=1e-6)


class TestJax:
    jax: Any = None
    solve: Any = None

    @pytest.fixture(autouse=True)
    def _imports(self) -> None:
        self.jax = pytest.importorskip("jax")
        self.jax.config.update("jax_enable_x64", True)
        from leafwise.jax import solve

        self.solve = solve

    def test_forward_and_reverse_mode_are_the_cores(self, along: lw.Trajectory) -> None:
        jax = self.jax
        samples: Callable[..., Any] = lambda x0, values: self.solve(along, x0, values)
        expected = jacobians(along, X0, VALUES)
        for jacobian in (jax.jacfwd, jax.jacrev):
            for found in (jacobian(samples, (0, 1)), jax.jit(jacobian(samples, (0, 1)))):
                for own, exact in zip(found(X0, VALUES), expected, strict=True):
                    close(own, exact)
        np.testing.assert_array_equal(jax.jacfwd(samples)(X0, VALUES), expected[0])
        x, dx = jax.jvp(samples, (X0, VALUES), (MANY[1], VALUES))
        np.testing.assert_array_equal(x, along(X0, VALUES))
        close(dx, along.jvp(MANY[1], VALUES, x0=X0, values=VALUES).dx)
        close(jax.linearize(samples, X0, VALUES)[1](MANY[1], VALUES), dx)
        (transposed,) = jax.linear_transpose(lambda d: jax.jvp(lambda x: samples(x, VALUES), (X0,), (d,))[1], X0)(dx)
        close(transposed, along.vjp(X0, VALUES)[1](np.asarray(dx)).x0)

    def test_batches_of_every_nesting(self, along: lw.Trajectory) -> None:
        jax = self.jax
        samples: Callable[..., Any] = lambda x0, values: self.solve(along, x0, values)
        expected = np.array([jacobians(along, x0, VALUES)[0] for x0 in MANY])
        for jacobian in (jax.jacfwd, jax.jacrev):
            close(jax.vmap(jacobian(samples), (0, None))(MANY, VALUES), expected)
            close(jax.jit(jax.vmap(jacobian(samples), (1, None), 1))(MANY.T, VALUES), np.moveaxis(expected, 0, 1))
        values = np.stack([VALUES, VALUES + 0.1])
        both = jax.vmap(jax.vmap(jax.grad(lambda x0, values: samples(x0, values).sum(), (0, 1)), (0, None)), (None, 0))
        by_state, by_values = both(MANY, values)
        assert by_state.shape == (2, 4, 3) and by_values.shape == (2, 4, 2)
        close(by_values[1, 2], along.vjp(MANY[2], values[1])[1](np.ones((3, 3))).values)
        tangents = jax.vmap(lambda x0: jax.jvp(lambda x0: samples(x0, VALUES), (x0,), (X0,))[1])(MANY)
        close(tangents[3], along.jvp(X0, x0=MANY[3], values=VALUES).dx)

    def test_directions_of_one_run_are_moved_side_by_side(self, along: lw.Trajectory, monkeypatch: pytest.MonkeyPatch) -> None:
        counts = []
        push = lw.Trajectory._push
        monkeypatch.setattr(lw.Trajectory, "_push", lambda *given: counts.append(len(given[3])) or push(*given))
        self.jax.jacfwd(lambda x0: self.solve(along, x0))(X0).block_until_ready()
        assert counts == [3]

    def test_single_precision_and_transformations(self, along: lw.Trajectory) -> None:
        jax, jnp = self.jax, self.jax.numpy
        step = lambda x, _: (self.solve(along, x)[-1], None)  # noqa: E731
        thrice = lambda x: jax.lax.scan(step, x, None, length=3)[0]  # noqa: E731
        forward, back = jax.jacfwd(thrice)(X0), jax.jacrev(thrice)(X0)
        close(forward, np.asarray(back))
        close(jax.grad(jax.checkpoint(lambda x: thrice(x).sum()))(X0), np.asarray(back).sum(0))
        jax.config.update("jax_enable_x64", False)
        single = jnp.asarray(X0)
        found = jax.jacfwd(lambda x: self.solve(along, x))(single)
        assert found.dtype == jnp.float32
        np.testing.assert_allclose(found, jacobians(along, X0, along.values)[0], rtol=1e-5, atol=1e-5)

    def test_second_derivatives_are_refused(self, along: lw.Trajectory) -> None:
        jax = self.jax
        loss = lambda x0: (self.solve(along, x0) ** 2).sum()  # noqa: E731
        for second in (jax.hessian(loss), jax.jacrev(jax.grad(loss)), jax.jacfwd(jax.jacfwd(loss))):
            with pytest.raises(lw.LeafwiseError, match="second derivatives of a trajectory are not available"):
                second(X0)
        # A sum of squares has JᵀJ.
        (jacobian,) = (jax.jacfwd(lambda x0: self.solve(along, x0).reshape(-1))(X0),)
        assert np.linalg.eigvalsh(jacobian.T @ jacobian).min() > 0

    def test_a_step_that_fails_is_an_outcome(self, failing: lw.Trajectory) -> None:
        jax, jnp = self.jax, self.jax.numpy
        states = np.array([X0, 10 * X0, [np.nan, 1, 1]])
        found = jax.jit(jax.vmap(lambda x0: self.solve(failing, x0, throw=False)))(states)
        assert found.is_done.tolist() == [True, False, False]
        assert found.samples.tolist() == [failing(x0, throw=False).samples for x0 in states] == [3, 1, 0]
        np.testing.assert_array_equal(found.x[0], failing(X0))
        assert np.isnan(found.x[1, 1:]).all() and (found.x[1, 0] == 10 * X0).all() and np.isnan(found.x[2]).all()
        loss = jax.grad(lambda x0: (self.solve(failing, x0, throw=False).x ** 2).sum())
        close(loss(X0), failing.vjp(X0)[1](2 * failing(X0)).x0)
        assert np.isnan(loss(10 * X0)).all()
        # Where the samples that are not there do not count, the others' derivatives are right.
        masked = jax.grad(lambda x0: jnp.nansum(self.solve(failing, x0, throw=False).x))
        np.testing.assert_array_equal(masked(10 * X0), np.ones(3))
        tangents = jax.jvp(lambda x0: self.solve(failing, x0, throw=False).x, (10 * X0,), (X0,))[1]
        assert np.isnan(tangents[1:]).all() and (tangents[0] == X0).all()

    def test_an_optimizer_goes_on_from_a_step_that_fails(self, failing: lw.Trajectory) -> None:
        """Gauss and Newton's iteration, whose first trials go too far: x₀ is found again from the last sample."""
        jax, jnp = self.jax, self.jax.numpy
        goal = failing(X0)[-1]
        left = jax.jit(lambda x0: self.solve(failing, x0, throw=False).x[-1] - goal)
        slopes = jax.jit(jax.jacfwd(left))
        x, failed = jnp.asarray([1.3, 2.8, 3.1]), 0
        for _ in range(12):
            correction = jnp.linalg.solve(slopes(x), left(x))
            part = 64.0
            while not (left(x - part * correction) ** 2).sum() <= (left(x) ** 2).sum() and part > 1e-9:
                failed += int(jnp.isnan(left(x - part * correction)).any())
                part /= 2
            x = x - part * correction
        assert failed > 0
        np.testing.assert_allclose(x, X0, atol=1e-9)


@pytest.mark.filterwarnings("ignore:`torch.jit.script`")
class TestTorch:
    torch: Any = None
    solve: Any = None

    @pytest.fixture(autouse=True)
    def _imports(self) -> None:
        self.torch = pytest.importorskip("torch")
        from leafwise.torch import solve

        self.solve = solve

    def test_forward_and_reverse_mode_are_the_cores(self, along: lw.Trajectory) -> None:
        torch, func = self.torch, self.torch.func
        x0, values = torch.tensor(X0), torch.tensor(VALUES)
        samples: Callable[..., Any] = lambda x0, values: self.solve(along, x0, values)
        expected = jacobians(along, X0, VALUES)
        for jacobian in (func.jacfwd, func.jacrev):
            for own, exact in zip(jacobian(samples, (0, 1))(x0, values), expected, strict=True):
                close(own, exact)
        x, dx = func.jvp(samples, (x0, values), (torch.tensor(MANY[1]), values))
        np.testing.assert_array_equal(x, along(X0, VALUES))
        close(dx, along.jvp(MANY[1], VALUES, x0=X0, values=VALUES).dx)
        close(torch.autograd.functional.jacobian(samples, (x0, values))[1], expected[1])

    def test_batches(self, along: lw.Trajectory) -> None:
        torch, func = self.torch, self.torch.func
        many, values = torch.tensor(MANY), torch.tensor(VALUES)
        samples: Callable[..., Any] = lambda x0, values: self.solve(along, x0, values)
        expected = np.array([jacobians(along, x0, VALUES)[0] for x0 in MANY])
        np.testing.assert_array_equal(func.vmap(samples, (0, None))(many, values), [along(x0, VALUES) for x0 in MANY])
        for jacobian in (func.jacfwd, func.jacrev):
            close(func.vmap(jacobian(samples), (0, None))(many, values), expected)
            close(func.vmap(jacobian(samples), (1, None), 1)(many.T, values), np.moveaxis(expected, 0, 1))
        by_state, by_values = func.vmap(func.grad(lambda x0, values: samples(x0, values).sum(), (0, 1)), (0, None))(many, values)
        gradient = along.vjp(MANY[2], VALUES)[1](np.ones((3, 3)))
        close(by_state[2], gradient.x0)
        close(by_values[2], gradient.values)
        assert self.solve(along, torch.zeros((0, 3), dtype=torch.float64)).shape == (0, 3, 3)

    def test_forward_mode_passes_pytorchs_own_check(self, along: lw.Trajectory) -> None:
        torch = self.torch
        given = (torch.tensor(X0, requires_grad=True), torch.tensor(VALUES, requires_grad=True))
        check = torch.autograd.gradcheck
        assert check(lambda *at: self.solve(along, *at), given, check_forward_ad=True)

    def test_second_derivatives_are_refused(self, along: lw.Trajectory) -> None:
        torch, func = self.torch, self.torch.func
        x0 = torch.tensor(X0, requires_grad=True)
        loss: Callable[..., Any] = lambda x0: (self.solve(along, x0) ** 2).sum()

        def penalty() -> None:
            (slope,) = torch.autograd.grad(loss(x0) + (x0**2).sum(), x0, create_graph=True)
            (slope**2).sum().backward()

        seconds = [
            penalty,
            lambda: torch.autograd.functional.hessian(lambda x: loss(x) + (x**2).sum(), x0.detach()),
            lambda: func.hessian(loss)(x0.detach()),
            lambda: func.jacrev(func.jacrev(loss))(x0.detach()),
            lambda: func.jacfwd(func.jacfwd(loss))(x0.detach()),
        ]
        for second in seconds:
            with pytest.raises(lw.LeafwiseError, match="second derivatives of a trajectory are not available"):
                second()

    def test_a_step_that_fails_is_an_outcome(self, failing: lw.Trajectory) -> None:
        torch = self.torch
        x0 = torch.tensor(np.array([X0, 10 * X0, [np.nan, 1, 1]]), requires_grad=True)
        found = self.solve(failing, x0, throw=False)
        assert found.is_done.tolist() == [True, False, False] and found.samples.tolist() == [3, 1, 0]
        torch.nansum(found.x).backward()
        close(x0.grad[0], failing.vjp(X0)[1](np.ones((3, 3))).x0)
        np.testing.assert_array_equal(x0.grad[1], np.ones(3))
        (slope,) = torch.autograd.grad(self.solve(failing, x0[1], throw=False).x.sum(), x0)
        assert slope[1].isnan().all()


def test_trajectories_tell_what_failed(failing: lw.Trajectory) -> None:
    done = failing(X0, throw=False)
    assert done.is_done and done.samples == 3
    np.testing.assert_array_equal(done.x, failing(X0))
    with pytest.raises(lw.IntegrationError):
        failing(10 * X0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = failing(10 * X0, [1.0], throw=False)
    assert (found.samples, bool(found.is_done)) == (1, False) and np.isnan(found.x[1:]).all()
    # A failure behind some samples: x' = x² has left every bound at t = 1.
    system = {"variables": ["x", "y"], "bracket": {"x,y": "1"}, "convention": "{x,H}", "hamiltonian": "x^2*y"}
    scene = lw.Scene(
        system=system, method={"stepper": "implicit-midpoint", "time-step": 0.01}, run={"initial": [1.0, 1.0], "steps": 200}
    )
    found = scene.trajectory([], record=10)(throw=False)
    there = int(np.isfinite(found.x).all(1).sum())
    assert not found.is_done and found.samples == there and 9 <= there <= 12
    np.testing.assert_array_equal(found.x[:there], scene.trajectory([], steps=10 * (there - 1), record=10)())


@pytest.mark.parametrize("package", ["leafwise", "jax", "torch"])
def test_what_is_no_state_is_told_where_failures_are_outcomes(failing: lw.Trajectory, package: str) -> None:
    """Another shape or type is a mistake, and no step that fails."""
    solve: Callable[..., Any] = failing
    if package != "leafwise":
        pytest.importorskip(package)
        own = __import__(f"leafwise.{package}", fromlist=["solve"]).solve
        solve = lambda *given, **of: own(failing, *given, **of)  # noqa: E731
    for throw in (True, False):
        for wrong, error, words in (
            ([1.0, 2.0], ValueError, r"x0 has the shape \(2,\), not \(3,\)"),
            ([np.nan, 2.0], ValueError, r"x0 has the shape \(2,\), not \(3,\)" if package != "leafwise" or not throw else "x0"),
            ([1.0, 2.0, 3j], TypeError, "complex128"),
            (np.ma.masked_array(X0, [True, False, False]), ValueError, r"x0\[0\] is masked"),
        ):
            with pytest.raises(error, match=words):
                solve(wrong, throw=throw)
        with pytest.raises(ValueError, match=r"values has the shape \(2,\), not \(1,\)"):
            solve(None, [1.0, 2.0], throw=throw)
    assert int(solve([np.nan, 2.0, 3.0], throw=False).samples) == 0
    assert int(solve(X0, throw=False).samples) == 3


def test_a_batch_of_jax_in_front_has_both_modes(along: lw.Trajectory) -> None:
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    from leafwise.jax import solve

    values = VALUES + np.array([[0.0, 0.0], [0.1, 0.0]])
    samples: Callable[..., Any] = lambda x0, values: solve(along, x0, values)
    states = MANY[:, None]
    for jacobian in (jax.jacfwd, jax.jacrev):
        by_state, by_values = jacobian(samples, (0, 1))(states, values)
        assert by_state.shape == (4, 2, 3, 3, 4, 1, 3) and by_values.shape == (4, 2, 3, 3, 2, 2)
        expected = jacobians(along, MANY[3], values[1])
        close(by_state[3, 1, :, :, 3, 0], expected[0])
        close(by_values[3, 1, :, :, 1], expected[1])
        assert not by_state[3, 1, :, :, 2].any() and not by_values[3, 1, :, :, 0].any()


def test_a_batch_with_a_run_that_fails_names_its_step(failing: lw.Trajectory) -> None:
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    from leafwise.jax import errors, solve

    both = np.stack([X0, 10 * X0])
    for call in (jax.jacfwd(lambda x0: solve(failing, x0)), jax.vmap(jax.grad(lambda x0: solve(failing, x0).sum()))):
        with pytest.raises(lw.IntegrationError, match="step 0 failed"):
            call(both)
        with pytest.raises(lw.IntegrationError, match="step 0 failed"), errors():
            jax.block_until_ready(jax.jit(call)(both))
