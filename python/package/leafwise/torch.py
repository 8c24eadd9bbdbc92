"""Trajectories in PyTorch: ``lw.torch.solve`` has forward- and reverse-mode derivatives and takes batches. Needs torch.

    import leafwise.torch

    trajectory = scene.trajectory(["I1"], steps=1000, record=10)
    x0 = torch.tensor([1.0, 3.0, 3.0], dtype=torch.float64, requires_grad=True)
    (leafwise.torch.solve(trajectory, x0)[-1] ** 2).sum().backward()
    x0.grad
    torch.func.jacfwd(lambda x0: leafwise.torch.solve(trajectory, x0)[-1])(x0)

Numbers are stepped as doubles on the processor, whatever the tensors' kind and device. The samples and the gradients come
back in the kind and device of x0 and values. ``grad``, ``vmap``, ``jacrev``, ``jacfwd`` of ``torch.func`` work; second derivatives are refused.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch

from . import _batches
from ._arrays import real_numbers
from ._errors import LeafwiseError
from ._gradient import NO_SECOND, Trajectory, Tried

__all__ = ["solve"]


def solve(trajectory: Trajectory, x0: Any = None, values: Any = None, *, throw: bool = True) -> Any:
    """The samples, shape (n, d), from x0, shape (d,), with the parameters' values, shape (p,).

    Axes in front of these, of either or both, are a batch: their shapes are broadcast, and stand in front of (n, d).
    With ``throw=False`` it is a :class:`Tried`: samples behind a step that cannot be taken are NaN, and so are gradients to which they
    count.

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
        raise ValueError(f"the batches {shapes} do not match") from None
    x0, values = (of.expand(*batch, *of.shape[-1:]) for of in (x0, values))
    samples, _ = _Samples.apply(trajectory, throw, x0, values)
    x = samples.to(tensors[0]) if tensors else samples
    if throw:
        return x
    is_there = torch.isfinite(samples.detach()).all(-1)
    return Tried(x, is_there.sum(-1), is_there.all(-1))


def _given(name: str, given: Any, length: int) -> Any:
    """A tensor of real numbers whose last axis has this length."""
    if not isinstance(given, torch.Tensor):
        given = torch.as_tensor(np.array(real_numbers(name, given)))
    if given.is_complex() or given.dtype == torch.bool:
        raise TypeError(f"{name} holds {given.dtype}, not real numbers")
    if given.ndim == 0 or given.shape[-1] != length:
        raise ValueError(f"{name} has the shape {tuple(given.shape)}, not ({length},), or (..., {length}) for a batch")
    return given


class _Batched(torch.autograd.Function):
    """A function of tensors with a batch in front, whose first two arguments are none."""

    generate_vmap_rule = False

    @classmethod
    def _vmapped(cls, in_dims: Any, trajectory: Trajectory, throw: bool, *tensors: Any) -> Any:
        """Samples over one more axis of the batch."""
        rows = zip(tensors, in_dims[2:], strict=True)
        return cls.apply(trajectory, throw, *(of.unsqueeze(0) if dim is None else of.movedim(dim, 0) for of, dim in rows))


class _Samples(_Batched):
    """The samples as doubles, and what the run keeps for the way back."""

    @staticmethod
    def forward(trajectory: Trajectory, throw: bool, x0: Any, values: Any) -> Any:
        x, kept = _batches.run(trajectory, throw, _array(x0), _array(values))
        return torch.as_tensor(x), torch.as_tensor(kept)

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        ctx.trajectory, ctx.throw, x0, values = inputs
        ctx.mark_non_differentiable(output[1])
        ctx.set_materialize_grads(False)
        ctx.save_for_backward(x0, values, output[1])
        ctx.save_for_forward(x0, values)

    @staticmethod
    def backward(ctx: Any, w: Any, _: Any) -> Any:
        x0, values, kept = ctx.saved_tensors
        if w is None:
            return None, None, None, None
        by_state, by_values = _Pulled.apply(ctx.trajectory, ctx.throw, x0, values, kept, w)
        return None, None, by_state.to(x0), by_values.to(values)

    @staticmethod
    def jvp(ctx: Any, _trajectory: Any, _throw: Any, dx0: Any, dvalues: Any) -> Any:
        x0, values = ctx.saved_tensors
        given = (torch.zeros_like(of) if d is None else d for of, d in ((x0, dx0), (values, dvalues)))
        return _Pushed.apply(ctx.trajectory, ctx.throw, x0, values, *given), None

    @staticmethod
    def vmap(info: Any, in_dims: Any, trajectory: Trajectory, throw: bool, x0: Any, values: Any) -> Any:
        return _Samples._vmapped(in_dims, trajectory, throw, x0, values), (0, 0)


class _Once(_Batched):
    """A first derivative: its own are not known."""

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        pass

    @staticmethod
    def backward(ctx: Any, *_: Any) -> Any:
        raise LeafwiseError(NO_SECOND)

    @staticmethod
    def jvp(ctx: Any, *_: Any) -> Any:
        raise LeafwiseError(NO_SECOND)


class _Pulled(_Once):
    """The gradients of a function of the samples."""

    @staticmethod
    def forward(trajectory: Trajectory, throw: bool, x0: Any, values: Any, kept: Any, w: Any) -> Any:
        found = _batches.pull(trajectory, throw, *map(_array, (x0, values, kept, w)))
        return tuple(map(torch.as_tensor, found))

    @staticmethod
    def vmap(info: Any, in_dims: Any, trajectory: Trajectory, throw: bool, *tensors: Any) -> Any:
        return _Pulled._vmapped(in_dims, trajectory, throw, *tensors), (0, 0)


class _Pushed(_Once):
    """The samples' tangents."""

    @staticmethod
    def forward(trajectory: Trajectory, throw: bool, *tensors: Any) -> Any:
        return torch.as_tensor(_batches.push(trajectory, throw, *map(_array, tensors)))

    @staticmethod
    def vmap(info: Any, in_dims: Any, trajectory: Trajectory, throw: bool, *tensors: Any) -> Any:
        return _Pushed._vmapped(in_dims, trajectory, throw, *tensors), 0


def _array(tensor: Any) -> Any:
    """As doubles of NumPy."""
    return np.asarray(tensor.detach().double().cpu())
