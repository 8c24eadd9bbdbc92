"""Trajectories in JAX: ``lw.jax.solve`` has reverse-mode derivatives and may be batched and compiled. Needs jax.

    import leafwise.jax

    trajectory = scene.trajectory(["I1"], steps=1000, record=10)
    loss = lambda x0, values: (leafwise.jax.solve(trajectory, x0, values)[-1] ** 2).sum()
    jax.jit(jax.grad(loss, argnums=(0, 1)))(x0, values)

Numbers are stepped as doubles whatever JAX's own are: call ``jax.config.update("jax_enable_x64", True)`` to keep them.

A step that cannot be taken is an ``IntegrationError``, also under ``jax.grad``. Within compiled code and ``jax.vmap`` JAX raises a
``JaxRuntimeError`` of its own in its place: ``with leafwise.jax.errors():`` around the call, or as the decorator
``@leafwise.jax.errors()`` of the function that calls it, raises the package's.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from ._arrays import real_numbers
from ._gradient import Trajectory

__all__ = ["errors", "solve"]

#: The last exceptions that functions called by compiled code have raised.
_raised: list[BaseException] = []

#: JAX raises what comes of an exception in compiled code a little later, and other threads' may come between.
_KEPT = 16


def solve(trajectory: Trajectory, x0: Any = None, values: Any = None) -> Any:
    """The samples, shape (n, d), from x0, shape (d,), with the parameters' values, shape (p,).

    Axes in front of these, of either or both, are a batch: their shapes are broadcast, and stand in front of (n, d).

    Raises:
        IntegrationError: a step could not be taken; see :func:`errors` for compiled code.
        TypeError, ValueError: x0 or values have another type or shape, or are not finite.
    """
    x0 = _given("x0", trajectory.x0 if x0 is None else x0, len(trajectory.x0))
    values = _given("values", trajectory.values if values is None else values, len(trajectory.parameters))
    try:
        batch = jnp.broadcast_shapes(x0.shape[:-1], values.shape[:-1])
    except ValueError:
        raise ValueError(f"the batches {x0.shape[:-1]} of x0 and {values.shape[:-1]} of values do not fit each other") from None
    function = _function(trajectory)
    if batch:
        function = jnp.vectorize(function, signature="(d),(p)->(n,d)")
    if isinstance(x0, jax.core.Tracer) or isinstance(values, jax.core.Tracer):
        return function(x0, values)
    with errors():
        return jax.block_until_ready(function(x0, values))


@contextmanager
def errors() -> Iterator[None]:
    """Raises what a trajectory raised within compiled code in the place of JAX's own error.

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
        if not any(isinstance(of, jax.core.Tracer) for of in given):
            # Nothing is compiled here: exceptions come out as they are.
            return tuple(jnp.asarray(of) for of in function(*(np.asarray(of) for of in given)))
        return jax.pure_callback(_told(_batched(function)), shapes, *given, vmap_method="broadcast_all")

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


def _batched(function: Any) -> Any:
    """The function of single arguments for a batch of any shape in front of them: the first has one axis of its own."""

    def of_batches(first: Any, *others: Any) -> Any:
        first, others = np.asarray(first), tuple(np.asarray(of) for of in others)
        batch = first.shape[:-1]
        if not batch:
            return function(first, *others)
        rows = [of.reshape(math.prod(batch), *of.shape[len(batch) :]) for of in (first, *others)]
        found = [function(*row) for row in zip(*rows, strict=True)]
        return tuple(np.stack(of).reshape(*batch, *of[0].shape) for of in zip(*found, strict=True))

    return of_batches
