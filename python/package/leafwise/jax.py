"""Trajectories in JAX: ``lw.jax.solve`` has reverse-mode derivatives and may be batched and compiled. Needs jax.

    import leafwise.jax

    trajectory = scene.trajectory(["I1"], steps=1000, record=10)
    loss = lambda x0, values: (leafwise.jax.solve(trajectory, x0, values)[-1] ** 2).sum()
    jax.jit(jax.grad(loss, argnums=(0, 1)))(x0, values)

Numbers are stepped as doubles whatever JAX's own are: call ``jax.config.update("jax_enable_x64", True)`` to keep them.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from ._gradient import Trajectory

__all__ = ["solve"]


def solve(trajectory: Trajectory, x0: Any = None, values: Any = None) -> Any:
    """The samples, shape (n, d), from x0, shape (d,), with the parameters' values, shape (p,)."""
    kind = jnp.result_type(float)
    given = (trajectory.x0 if x0 is None else x0, trajectory.values if values is None else values)
    return _function(trajectory)(*(jnp.asarray(of, kind) for of in given))


@lru_cache(maxsize=32)
def _function(trajectory: Trajectory) -> Any:
    """The function with its derivative; made once for each trajectory, so that JAX compiles it once."""
    kind = jnp.result_type(float)
    d, p = len(trajectory.x0), len(trajectory.parameters)
    whole = trajectory._map.width
    samples = jax.ShapeDtypeStruct((trajectory.steps // trajectory.record + 1, d), kind)
    # The states that a run keeps hold more than doubles do: as bits, which no precision of JAX's rounds.
    shape = (trajectory._map.pieces((trajectory.steps, trajectory.record)), 2, whole)
    bits = jax.ShapeDtypeStruct((*shape, 2), jnp.uint32)

    def forwards(x0: Any, values: Any) -> Any:
        x, kept = trajectory._run(_doubles(x0), _doubles(values))
        return x.astype(kind), kept.view(np.uint32).reshape(*shape, 2)

    def backwards(x0: Any, values: Any, kept: Any, w: Any) -> Any:
        states = np.ascontiguousarray(kept).view(np.float64).reshape(shape)
        gradient = trajectory._pull(_doubles(x0), _doubles(values), states, _doubles(w))
        return gradient.x0.astype(kind), gradient.values.astype(kind)

    def call(function: Any, shapes: Any, *given: Any) -> Any:
        return jax.pure_callback(_batched(function), shapes, *given, vmap_method="broadcast_all")

    @jax.custom_vjp
    def samples_of(x0: Any, values: Any) -> Any:
        return call(forwards, (samples, bits), x0, values)[0]

    def with_kept(x0: Any, values: Any) -> Any:
        x, kept = call(forwards, (samples, bits), x0, values)
        return x, (x0, values, kept)

    def pulled(kept: Any, w: Any) -> Any:
        shapes = (jax.ShapeDtypeStruct((d,), kind), jax.ShapeDtypeStruct((p,), kind))
        return call(backwards, shapes, *kept, w)

    samples_of.defvjp(with_kept, pulled)
    return samples_of


def _doubles(array: Any) -> Any:
    return np.asarray(array, dtype=np.float64)


def _batched(function: Any) -> Any:
    """The function of single arguments for a batch of any shape in front of them: the first has one axis of its own."""

    def of_batches(first: Any, *others: Any) -> Any:
        first, others = np.asarray(first), tuple(np.asarray(of) for of in others)
        batch = first.shape[:-1]
        if not batch:
            return function(first, *others)
        rows = [of.reshape(-1, *of.shape[len(batch) :]) for of in (first, *others)]
        found = [function(*row) for row in zip(*rows, strict=True)]
        return tuple(np.stack(of).reshape(*batch, *of[0].shape) for of in zip(*found, strict=True))

    return of_batches
