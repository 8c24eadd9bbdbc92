"""Trajectories in PyTorch, against their own derivatives."""

import numpy as np
import pytest

import leafwise as lw
from test_scenes import RIGID_BODY

torch = pytest.importorskip("torch")

METHODS = [RIGID_BODY["method"], {"stepper": "splitting", "time-step": 0.1}, {"stepper": "rk4", "time-step": 0.05}]


def trajectory(method: dict[str, object], parameters: list[str]) -> lw.Trajectory:
    return lw.Scene(RIGID_BODY | {"method": method}).trajectory(parameters, steps=40, record=20)


@pytest.mark.parametrize("method", METHODS)
def test_gradients_pass_pytorchs_own_check(method: dict[str, object]) -> None:
    """Central differences of δ = 1e-6: off by (rδ)² and u/δ, far below the 1e-6 of each entry that is asked."""
    from leafwise.torch import solve

    names = [] if "rk4" in str(method) else ["I1", "I3"]
    along = trajectory(method, names)
    x0 = torch.tensor([1.0, 3.0, 3.0], dtype=torch.float64, requires_grad=True)
    values = torch.tensor(along.values, requires_grad=bool(names))
    assert torch.autograd.gradcheck(lambda x0, values: solve(along, x0, values), (x0, values), atol=1e-6, rtol=1e-6)


def test_batches_are_their_members() -> None:
    from leafwise.torch import solve

    along = trajectory(RIGID_BODY["method"], ["I1", "I2"])
    rng = np.random.default_rng(5)
    states, w = 1 + rng.random((2, 3, 3)), rng.standard_normal((2, 3, 3, 3))
    values = np.array([[1.0, 0.75], [1.1, 0.8], [0.9, 0.7]])
    x0, of = torch.tensor(states, requires_grad=True), torch.tensor(values, requires_grad=True)
    x = solve(along, x0, of)
    assert x.shape == (2, 3, 3, 3) and x.dtype == torch.float64
    (x * torch.tensor(w)).sum().backward()
    by_values = np.zeros((3, 2))
    for at in np.ndindex(2, 3):
        samples, pull = along.vjp(states[at], values[at[1]])
        np.testing.assert_array_equal(x[at].detach(), samples)
        gradient = pull(w[at])
        np.testing.assert_array_equal(x0.grad[at], gradient.x0)
        by_values[at[1]] += gradient.values
    np.testing.assert_allclose(of.grad, by_values, rtol=1e-14)


def test_kinds_and_what_is_not_given() -> None:
    from leafwise.torch import solve

    along = trajectory(RIGID_BODY["method"], [])
    np.testing.assert_array_equal(solve(along), along())
    np.testing.assert_array_equal(solve(along, [1, 3, 3]), along())
    single = torch.tensor([1.0, 3.0, 3.0], requires_grad=True)
    x = solve(along, single)
    assert x.dtype == torch.float32
    x[-1, 0].backward()
    assert single.grad.dtype == torch.float32
    w = np.zeros((3, 3))
    w[-1, 0] = 1
    np.testing.assert_allclose(single.grad, along.vjp()[1](w).x0, rtol=1e-6)
    reversed_ = torch.arange(6, dtype=torch.float64).reshape(3, 2).T[1]
    np.testing.assert_array_equal(solve(along, reversed_), along([1.0, 3.0, 5.0]))


def test_what_is_wrong_is_told() -> None:
    from leafwise.torch import solve

    along = trajectory(RIGID_BODY["method"], ["I1"])
    with pytest.raises(ValueError, match=r"x0 has the shape \(2,\), not \(3,\)"):
        solve(along, torch.ones(2, dtype=torch.float64))
    with pytest.raises(ValueError, match="not a finite number"):
        solve(along, None, torch.tensor([float("nan")], dtype=torch.float64))
    with pytest.raises(ValueError, match=r"x0 has the shape \(\), not \(3,\)"):
        solve(along, torch.tensor(1.0))
    with pytest.raises(TypeError, match="complex"):
        solve(along, torch.tensor([1.0, 3.0, 3j]))
    with pytest.raises(ValueError, match=r"batches \(2,\) of x0 and \(3,\) of values do not match"):
        solve(along, torch.ones(2, 3), torch.ones(3, 1))


def test_a_batch_may_be_empty() -> None:
    from leafwise.torch import solve

    along = trajectory(RIGID_BODY["method"], ["I1"])
    x0 = torch.zeros((0, 3), dtype=torch.float64, requires_grad=True)
    x = solve(along, x0)
    assert x.shape == (0, 3, 3)
    x.sum().backward()
    assert x0.grad.shape == (0, 3)


def test_second_derivatives_are_refused_and_never_zero() -> None:
    from leafwise.torch import solve

    along = trajectory(RIGID_BODY["method"], [])
    x0 = torch.tensor([1.0, 3.0, 3.0], dtype=torch.float64)

    def loss(x: object) -> object:
        return (solve(along, x)[-1, 0] ** 2).sum()

    def penalty(function: object) -> None:
        x = x0.clone().requires_grad_()
        (g,) = torch.autograd.grad(function(x), x, create_graph=True)
        (g**2).sum().backward()

    functional = torch.autograd.functional
    for second in (
        lambda: functional.hessian(loss, x0),
        lambda: functional.hessian(lambda x: loss(x) + (x**2).sum(), x0),
        lambda: functional.hvp(loss, x0, torch.ones_like(x0)),
        lambda: functional.vhp(loss, x0, torch.ones_like(x0)),
        lambda: penalty(loss),
        lambda: penalty(lambda x: loss(x) + (x**2).sum()),
        lambda: torch.autograd.gradgradcheck(loss, x0.clone().requires_grad_()),
    ):
        with pytest.raises(lw.LeafwiseError, match="second derivatives of a trajectory are not available"):
            second()
    # A graph that is not differentiated again is of no harm.
    x = x0.clone().requires_grad_()
    (kept,) = torch.autograd.grad(loss(x), x, create_graph=True)
    (plain,) = torch.autograd.grad(loss(x), x)
    np.testing.assert_array_equal(kept.detach(), plain)
