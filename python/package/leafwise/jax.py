"""Trajectories in JAX: ``lw.jax.solve`` has forward- and reverse-mode derivatives and may be batched and compiled. Needs jax.

    import leafwise.jax

    trajectory = scene.trajectory(["I1"], steps=1000, record=10)
    loss = lambda x0, values: (leafwise.jax.solve(trajectory, x0, values)[-1] ** 2).sum()
    jax.jit(jax.grad(loss, argnums=(0, 1)))(x0, values)
    jax.jacfwd(lambda x0: leafwise.jax.solve(trajectory, x0)[-1])(x0)

Numbers are stepped as doubles whatever JAX's own are: call ``jax.config.update("jax_enable_x64", True)`` to keep them. Second
derivatives are refused.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir

from . import _batches
from ._errors import LeafwiseError
from ._gradient import NO_SECOND, Trajectory, Tried

__all__ = ["solve"]


def solve(trajectory: Trajectory, x0: Any = None, values: Any = None, *, throw: bool = True) -> Any:
    """The samples, shape (n, d), from x0, shape (d,), with the parameters' values, shape (p,).

    With ``throw=False`` it is a :class:`Tried`: samples behind a step that cannot be taken are NaN, and so are gradients to which they
    count.
    """
    kind = jnp.result_type(float)
    given = (trajectory.x0 if x0 is None else x0, trajectory.values if values is None else values)
    x = _function(trajectory, throw)(*(jnp.asarray(of, kind) for of in given))
    if throw:
        return x
    is_there = jnp.isfinite(x).all(-1)
    return Tried(x, is_there.sum(-1), is_there.all(-1))


@lru_cache(maxsize=32)
def _function(trajectory: Trajectory, throw: bool) -> Any:
    """The function with its derivative; made once for each trajectory, so that JAX compiles it once."""
    of = {"trajectory": trajectory, "throw": throw}

    @jax.custom_jvp
    def samples_of(x0: Any, values: Any) -> Any:
        return _ran.bind(x0, values, **of)[0]

    @samples_of.defjvp
    def with_tangents(at: Any, along: Any) -> Any:
        x, states = _ran.bind(*at, **of)
        return x, _pushed.bind(*at, states, *along, **of)

    return samples_of


def _run(x0: Any, values: Any, *, trajectory: Trajectory, throw: bool) -> Any:
    def called(x0: Any, values: Any) -> Any:
        x, states = _batches.run(trajectory, throw, x0, values)
        return x.astype(kind), states.view(np.uint32).reshape(*states.shape, 2)

    kind = x0.dtype
    shapes = _shapes_of_run(x0, values, trajectory=trajectory, throw=throw)
    return jax.pure_callback(called, [jax.ShapeDtypeStruct(of.shape, of.dtype) for of in shapes], x0, values)


def _shapes_of_run(x0: Any, values: Any, *, trajectory: Trajectory, throw: bool) -> Any:
    batch = np.broadcast_shapes(x0.shape[:-1], values.shape[:-1])
    pieces, width = trajectory._map.pieces((trajectory.steps, trajectory.record)), trajectory._map.width
    # The states that a run keeps hold more than doubles do: as bits, which no precision of JAX's rounds.
    return [
        jax.core.ShapedArray((*batch, trajectory.samples, len(trajectory.x0)), x0.dtype),
        jax.core.ShapedArray((*batch, pieces, 2, width, 2), np.dtype(np.uint32)),
    ]


def _push(x0: Any, values: Any, _: Any, dx0: Any, dvalues: Any, *, trajectory: Trajectory, throw: bool) -> Any:
    def called(*given: Any) -> Any:
        return _batches.push(trajectory, throw, *given).astype(dx0.dtype)

    shape = _shape_of_push(x0, values, _, dx0, dvalues, trajectory=trajectory, throw=throw)
    return jax.pure_callback(called, jax.ShapeDtypeStruct(shape.shape, shape.dtype), x0, values, dx0, dvalues)


def _shape_of_push(x0: Any, values: Any, _: Any, dx0: Any, dvalues: Any, *, trajectory: Trajectory, throw: bool) -> Any:
    batch = np.broadcast_shapes(x0.shape[:-1], values.shape[:-1], dx0.shape[:-1], dvalues.shape[:-1])
    return jax.core.ShapedArray((*batch, trajectory.samples, dx0.shape[-1]), dx0.dtype)


def _pull(x0: Any, values: Any, states: Any, w: Any, *, trajectory: Trajectory, throw: bool) -> Any:
    def called(x0: Any, values: Any, states: Any, w: Any) -> Any:
        kept = np.ascontiguousarray(states).view(np.float64).reshape(states.shape[:-1])
        found = _batches.pull(trajectory, throw, x0, values, kept, w)
        return [of.astype(w.dtype) for of in found]

    shapes = _shapes_of_pull(x0, values, states, w, trajectory=trajectory, throw=throw)
    given = [jax.ShapeDtypeStruct(of.shape, of.dtype) for of in shapes]
    return jax.pure_callback(called, given, x0, values, states, w)


def _shapes_of_pull(x0: Any, values: Any, states: Any, w: Any, *, trajectory: Trajectory, throw: bool) -> Any:
    batch = np.broadcast_shapes(x0.shape[:-1], values.shape[:-1], w.shape[:-2])
    return [jax.core.ShapedArray((*batch, of.shape[-1]), w.dtype) for of in (x0, values)]


def _transposed(w: Any, x0: Any, values: Any, states: Any, dx0: Any, dvalues: Any, **of: Any) -> Any:
    """Gradients by the directions, which are broadcast: the batch is that of w."""
    by_state, by_values = _pulled.bind(x0, values, states, ad.instantiate_zeros(w), **of)
    own = [linear.aval.shape for linear in (dx0, dvalues) if ad.is_undefined_primal(linear)]
    assert all(shape[:-1] == w.shape[:-2] for shape in own), "directions have the whole batch"
    return (
        None,
        None,
        None,
        by_state if ad.is_undefined_primal(dx0) else None,
        by_values if ad.is_undefined_primal(dvalues) else None,
    )


def _in_batches(primitive: Any, linear: int) -> Any:
    """One more axis of the batch, in front: the last arguments have it whole, others may be of length 1 there."""

    def batched(given: Any, dims: Any, **of: Any) -> Any:
        size = next(array.shape[dim] for array, dim in zip(given, dims, strict=True) if dim is not None)

        def moved(array: Any, dim: Any, is_whole: bool) -> Any:
            if dim is not None:
                return jnp.moveaxis(array, dim, 0)
            return jnp.broadcast_to(array[None], (size if is_whole else 1, *array.shape))

        first = len(given) - linear
        found = primitive.bind(*(moved(*pair, at >= first) for at, pair in enumerate(zip(given, dims, strict=True))), **of)
        return found, [0] * len(found) if primitive.multiple_results else 0

    return batched


def _refused(*_: Any, **__: Any) -> Any:
    raise LeafwiseError(NO_SECOND)


#: The run with what it keeps for the way back; the samples' tangents, linear in the last two arguments; and the transpose of these.
_ran, _pushed, _pulled = Primitive("leafwise_ran"), Primitive("leafwise_pushed"), Primitive("leafwise_pulled")
_ran.multiple_results = _pulled.multiple_results = True
for _primitive, _called, _shape, _linear in (
    (_ran, _run, _shapes_of_run, 0),
    (_pushed, _push, _shape_of_push, 2),
    (_pulled, _pull, _shapes_of_pull, 1),
):
    _primitive.def_impl(_called)
    _primitive.def_abstract_eval(_shape)
    mlir.register_lowering(_primitive, mlir.lower_fun(_called, _primitive.multiple_results))
    batching.primitive_batchers[_primitive] = _in_batches(_primitive, _linear)
    ad.primitive_jvps[_primitive] = _refused
ad.primitive_transposes[_pushed] = _transposed
