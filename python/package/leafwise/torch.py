"""Trajectories in PyTorch: ``lw.torch.solve`` has reverse-mode derivatives. Needs torch.

    import leafwise.torch

    trajectory = scene.trajectory(["I1"], steps=1000, record=10)
    x = leafwise.torch.solve(trajectory, x0, values)
    (x[-1] ** 2).sum().backward()

Numbers are stepped as doubles; samples and gradients have the type of the tensor that they belong to.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch

from ._gradient import Trajectory

__all__ = ["solve"]


def solve(trajectory: Trajectory, x0: Any = None, values: Any = None) -> Any:
    """The samples, shape (n, d), from x0, shape (d,), with the parameters' values, shape (p,)."""
    given = (trajectory.x0 if x0 is None else x0, trajectory.values if values is None else values)
    return _Solve.apply(trajectory, *(torch.as_tensor(of) for of in given))


class _Solve(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, trajectory: Trajectory, x0: Any, values: Any) -> Any:
        x, end = trajectory._run(_doubles(x0), _doubles(values))
        ctx.trajectory, ctx.end = trajectory, end
        ctx.save_for_backward(x0, values)
        return torch.from_numpy(x).to(x0)

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, w: Any) -> Any:
        x0, values = ctx.saved_tensors
        gradient = ctx.trajectory._pull(_doubles(x0), _doubles(values), ctx.end, _doubles(w))
        return None, torch.from_numpy(gradient.x0).to(x0), torch.from_numpy(gradient.values).to(values)


def _doubles(tensor: Any) -> Any:
    return tensor.detach().cpu().numpy().astype(np.float64)
