"""Trajectories in JAX: ``lw.jax.solve`` has forward- and reverse-mode derivatives and may be batched and compiled. Needs jax.

    import leafwise.jax

    trajectory = scene.trajectory(["I1"], steps=1000, record=10)
    loss = lambda x0, values: (leafwise.jax.solve(trajectory, x0, values)[-1] ** 2).sum()
    jax.jit(jax.grad(loss, argnums=(0, 1)))(x0, values)
    jax.jacfwd(lambda x0: leafwise.jax.solve(trajectory, x0)[-1])(x0)

Numbers are stepped as doubles whatever JAX's own are: call ``jax.config.update("jax_enable_x64", True)`` to keep them. Second
derivatives are refused.

A step that cannot be taken is an ``IntegrationError``, also under ``jax.grad`` and ``jax.vmap``. Within compiled code JAX raises a
``JaxRuntimeError`` instead. ``with leafwise.jax.errors():`` around the call, or the decorator ``@leafwise.jax.errors()`` of the
function that calls it, raises the package's error.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir

from . import _batches
from ._arrays import real_numbers
from ._errors import LeafwiseError
from ._gradient import NO_SECOND, Trajectory, Tried

__all__ = ["errors", "solve"]

#: The last exceptions that functions called by compiled code have raised.
_raised: list[BaseException] = []

#: JAX raises what comes of an exception in compiled code a little later, and other threads' may come between.
_KEPT = 16


def solve(trajectory: Trajectory, x0: Any = None, values: Any = None, *, throw: bool = True) -> Any:
    """The samples, shape (n, d), from x0, shape (d,), with the parameters' values, shape (p,).

    Axes in front of these, of either or both, are a batch: their shapes are broadcast, and stand in front of (n, d).
    With ``throw=False`` it is a :class:`Tried`: samples behind a step that cannot be taken are NaN, and so are gradients to which they
    count.

    Raises:
        IntegrationError: a step could not be taken; see :func:`errors` for compiled code.
        LeafwiseError: from a second derivative, which is not known.
        TypeError, ValueError: x0 or values have another type or shape, or are not finite.
    """
    x0 = _given("x0", trajectory.x0 if x0 is None else x0, len(trajectory.x0))
    values = _given("values", trajectory.values if values is None else values, len(trajectory.parameters))
    try:
        batch = jnp.broadcast_shapes(x0.shape[:-1], values.shape[:-1])
    except ValueError:
        raise ValueError(f"the batches {x0.shape[:-1]} of x0 and {values.shape[:-1]} of values do not match") from None
    x = _function(trajectory, throw)(*(jnp.broadcast_to(of, (*batch, of.shape[-1])) for of in (x0, values)))
    if throw:
        return x
    is_there = jnp.isfinite(x).all(-1)
    return Tried(x, is_there.sum(-1), is_there.all(-1))


@contextmanager
def errors() -> Iterator[None]:
    """Raises the error of a trajectory within compiled code instead of JAX's own.

    Raises:
        IntegrationError: a step could not be taken.
    """
    logger = logging.getLogger("jax._src.callback")
    was_quiet, logger.disabled = logger.disabled, True
    before = len(_raised) and _raised[-1]
    try:
        yield
    except jax.errors.JaxRuntimeError as error:
        if not _raised or _raised[-1] is before:
            raise
        raise _raised.pop() from error
    finally:
        logger.disabled = was_quiet


def _given(name: str, array: Any, length: int) -> Any:
    """An array of doubles, or of what JAX has for them, whose last axis has this length."""
    given = array if isinstance(array, jax.core.Tracer) else real_numbers(name, array)
    if given.dtype.kind not in "iuf" and not jnp.issubdtype(given.dtype, jnp.floating):
        raise TypeError(f"{name} holds {given.dtype}, not real numbers")
    if given.ndim == 0 or given.shape[-1] != length:
        raise ValueError(f"{name} has the shape {given.shape}, not ({length},), or (..., {length}) for a batch")
    return jnp.asarray(given, jnp.result_type(float))


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


def _call(function: Callable[..., Any], shapes: Any, *given: Any) -> Any:
    """Result of a function of NumPy's arrays, within compiled code too."""
    if any(isinstance(of, jax.core.Tracer) for of in given):
        kinds = jax.tree.map(lambda of: jax.ShapeDtypeStruct(of.shape, of.dtype), shapes)
        return jax.pure_callback(_told(function), kinds, *given)
    # Nothing is compiled here: exceptions come out as they are.
    return jax.tree.map(jnp.asarray, function(*map(np.asarray, given)))


def _told(function: Any) -> Any:
    """The function, whose exceptions :func:`errors` finds."""

    def told(*given: Any) -> Any:
        try:
            return function(*given)
        except BaseException as error:
            _raised.append(error)
            del _raised[:-_KEPT]
            raise

    return told


def _run(x0: Any, values: Any, *, trajectory: Trajectory, throw: bool) -> Any:
    def called(x0: Any, values: Any) -> Any:
        x, states = _batches.run(trajectory, throw, x0, values)
        return [x.astype(kind), states.view(np.uint32).reshape(*states.shape, 2)]

    kind = x0.dtype
    return _call(called, _shapes_of_run(x0, values, trajectory=trajectory, throw=throw), x0, values)


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
    return _call(called, shape, x0, values, dx0, dvalues)


def _shape_of_push(x0: Any, values: Any, _: Any, dx0: Any, dvalues: Any, *, trajectory: Trajectory, throw: bool) -> Any:
    batch = np.broadcast_shapes(x0.shape[:-1], values.shape[:-1], dx0.shape[:-1], dvalues.shape[:-1])
    return jax.core.ShapedArray((*batch, trajectory.samples, dx0.shape[-1]), dx0.dtype)


def _pull(x0: Any, values: Any, states: Any, w: Any, *, trajectory: Trajectory, throw: bool) -> Any:
    def called(x0: Any, values: Any, states: Any, w: Any) -> Any:
        kept = np.ascontiguousarray(states).view(np.float64).reshape(states.shape[:-1])
        found = _batches.pull(trajectory, throw, x0, values, kept, w)
        return [of.astype(w.dtype) for of in found]

    return _call(called, _shapes_of_pull(x0, values, states, w, trajectory=trajectory, throw=throw), x0, values, states, w)


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
