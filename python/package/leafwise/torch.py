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
from torch.autograd.function import once_differentiable

from ._gradient import Trajectory

__all__ = ["solve"]


def solve(trajectory: Trajectory, x0: Any = None, values: Any = None) -> Any:
    """The samples, shape (n, d), from x0, shape (d,), with the parameters' values, shape (p,).

    Axes in front of these, of either or both, are a batch: their shapes are broadcast, and stand in front of (n, d).
    """
    tensors = [of for of in (x0, values) if isinstance(of, torch.Tensor) and of.is_floating_point()]
    x0, values = (
        of if isinstance(of, torch.Tensor) else torch.as_tensor(np.array(own if of is None else of, dtype=np.float64))
        for of, own in ((x0, trajectory.x0), (values, trajectory.values))
    )
    batch = torch.broadcast_shapes(x0.shape[:-1], values.shape[:-1])
    samples = _Samples.apply(trajectory, *(of.expand(*batch, *of.shape[-1:]) for of in (x0, values)))
    return samples.to(tensors[0]) if tensors else samples


class _Samples(torch.autograd.Function):
    """The samples as doubles, with their derivative."""

    @staticmethod
    def forward(ctx: Any, trajectory: Trajectory, x0: Any, values: Any) -> Any:
        runs = [trajectory._run(*of) for of in zip(_rows(x0), _rows(values), strict=True)]
        ctx.trajectory, ctx.kept = trajectory, [kept for _, kept in runs]
        ctx.save_for_backward(x0, values)
        return _stacked([x for x, _ in runs], x0.shape[:-1])

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, w: Any) -> Any:
        x0, values = ctx.saved_tensors
        rows = zip(_rows(x0), _rows(values), ctx.kept, _rows(w, axes=2), strict=True)
        found = [ctx.trajectory._pull(*of) for of in rows]
        by_state = _stacked([of.x0 for of in found], x0.shape[:-1])
        by_values = _stacked([of.values for of in found], values.shape[:-1])
        return None, by_state.to(x0), by_values.to(values)


def _rows(tensor: Any, axes: int = 1) -> Any:
    """Arrays of so many axes, one for each member of the batch in front of them."""
    array = np.asarray(tensor.detach().double().cpu())
    batch, own = array.shape[: array.ndim - axes], array.shape[array.ndim - axes :]
    return np.ascontiguousarray(array).reshape(math.prod(batch), *own)


def _stacked(rows: Any, batch: Any) -> Any:
    return torch.as_tensor(np.stack(rows)).reshape(*batch, *rows[0].shape)
