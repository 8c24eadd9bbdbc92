"""Trajectories in PyTorch: ``lw.torch.solve`` has reverse-mode derivatives and takes batches. Needs torch.

    import leafwise.torch

    trajectory = scene.trajectory(["I1"], steps=1000, record=10)
    x0 = torch.tensor([1.0, 3.0, 3.0], dtype=torch.float64, requires_grad=True)
    (leafwise.torch.solve(trajectory, x0)[-1] ** 2).sum().backward()
    x0.grad

Numbers are stepped as doubles on the processor, whatever the tensors' own kind and device: the samples and the gradients come
back in those of x0 and values.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import torch

from ._arrays import real_numbers
from ._errors import LeafwiseError
from ._gradient import Trajectory

__all__ = ["solve"]


def solve(trajectory: Trajectory, x0: Any = None, values: Any = None) -> Any:
    """The samples, shape (n, d), from x0, shape (d,), with the parameters' values, shape (p,).

    Axes in front of these, of either or both, are a batch: their shapes are broadcast, and stand in front of (n, d).

    Raises:
        IntegrationError: a step could not be taken.
        LeafwiseError: from a second derivative, which is not known.
        TypeError, ValueError: x0 or values have another type or shape, or are not finite.
    """
    tensors = [of for of in (x0, values) if isinstance(of, torch.Tensor) and of.is_floating_point()]
    x0 = _given("x0", trajectory.x0 if x0 is None else x0, len(trajectory.x0))
    values = _given("values", trajectory.values if values is None else values, len(trajectory.parameters))
    try:
        batch = torch.broadcast_shapes(x0.shape[:-1], values.shape[:-1])
    except RuntimeError:
        shapes = f"{tuple(x0.shape[:-1])} of x0 and {tuple(values.shape[:-1])} of values"
        raise ValueError(f"the batches {shapes} do not fit each other") from None
    samples = _Samples.apply(trajectory, *(of.expand(*batch, *of.shape[-1:]) for of in (x0, values)))
    return samples.to(tensors[0]) if tensors else samples


def _given(name: str, given: Any, length: int) -> Any:
    """A tensor of real numbers whose last axis has this length."""
    if not isinstance(given, torch.Tensor):
        given = torch.as_tensor(real_numbers(name, given))
    if given.is_complex() or given.dtype == torch.bool:
        raise TypeError(f"{name} holds {given.dtype}, not real numbers")
    if given.ndim == 0 or given.shape[-1] != length:
        raise ValueError(f"{name} has the shape {tuple(given.shape)}, not ({length},), or (..., {length}) for a batch")
    return given


class _Samples(torch.autograd.Function):
    """The samples as doubles, with their derivative."""

    @staticmethod
    def forward(ctx: Any, trajectory: Trajectory, x0: Any, values: Any) -> Any:
        runs = [trajectory._run(*of) for of in zip(_rows(x0), _rows(values), strict=True)]
        ctx.trajectory, ctx.kept = trajectory, [kept for _, kept in runs]
        ctx.save_for_backward(x0, values)
        samples = trajectory.steps // trajectory.record + 1
        return _stacked([x for x, _ in runs], x0.shape[:-1], (samples, x0.shape[-1]))

    @staticmethod
    def backward(ctx: Any, w: Any) -> Any:
        return None, *_Gradient.apply(ctx.trajectory, ctx.kept, *ctx.saved_tensors, w)


class _Gradient(torch.autograd.Function):
    """The gradient of a function of the samples, a function of x0, values and w of which no derivative is known."""

    @staticmethod
    def forward(ctx: Any, trajectory: Trajectory, kept: Any, x0: Any, values: Any, w: Any) -> Any:
        rows = zip(_rows(x0), _rows(values), kept, _rows(w, axes=2), strict=True)
        found = [trajectory._pull(*of) for of in rows]
        by_state = _stacked([of.x0 for of in found], x0.shape[:-1], x0.shape[-1:])
        by_values = _stacked([of.values for of in found], values.shape[:-1], values.shape[-1:])
        return by_state.to(x0), by_values.to(values)

    @staticmethod
    def backward(ctx: Any, *_: Any) -> Any:
        raise LeafwiseError(
            "second derivatives of a trajectory are not known: take differences of gradients, or where a sum of squares is made "
            "small J'J with J from trajectory.jvp, as scene.fit does"
        )


def _rows(tensor: Any, axes: int = 1) -> Any:
    """Arrays of so many axes, one for each member of the batch in front of them."""
    array = np.asarray(tensor.detach().double().cpu())
    batch, own = array.shape[: array.ndim - axes], array.shape[array.ndim - axes :]
    return np.ascontiguousarray(array).reshape(math.prod(batch), *own)


def _stacked(rows: Any, batch: Any, own: Any) -> Any:
    """The arrays of a batch, of which there may be none, as one tensor."""
    whole = np.stack(rows) if rows else np.zeros((0, *own))
    return torch.as_tensor(whole).reshape(*batch, *own)
