"""Runs, tangents and gradients of many initial states and values at once: axes in front of the last are a batch, and are broadcast."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from ._arrays import Array
from ._gradient import Trajectory


def run(trajectory: Trajectory, throw: bool, x0: Any, values: Any) -> tuple[Array, Array]:
    """Samples (…, n, d), and what is kept for the way back (…, pieces, 2, stepped coordinates)."""
    batch, rows = _rows((x0, 1), (values, 1))
    found = [trajectory._run(*row) if throw else trajectory._try(*row)[:2] for row in rows]
    if not found:
        n, pieces = trajectory.samples, trajectory._map.pieces((trajectory.steps, trajectory.record))
        return np.zeros((*batch, n, len(trajectory.x0))), np.zeros((*batch, pieces, 2, trajectory._map.width))
    return _stacked([x for x, _ in found], batch), _stacked([kept for _, kept in found], batch)


def pull(trajectory: Trajectory, throw: bool, x0: Any, values: Any, kept: Any, w: Any) -> tuple[Array, Array]:
    """The gradients of functions with the derivatives w (…, n, d): by the initial state (…, d) and by the parameters (…, p)."""
    batch, rows = _rows((x0, 1), (values, 1), (kept, 3), (w, 2))
    found = [trajectory._pull(*row)[:2] if throw else trajectory._try_pull(*row) for row in rows]
    if not found:
        return np.zeros((*batch, len(trajectory.x0))), np.zeros((*batch, len(trajectory.parameters)))
    return _stacked([by_state for by_state, _ in found], batch), _stacked([by_values for _, by_values in found], batch)


def push(trajectory: Trajectory, throw: bool, x0: Any, values: Any, dx0: Any, dvalues: Any) -> Array:
    """How the samples change in the directions (dx0, dvalues): (…, n, d). Directions of one run are moved side by side."""
    own = np.broadcast_shapes(np.shape(x0)[:-1], np.shape(values)[:-1])
    batch, rows = _rows((x0, 1), (values, 1), (dx0, 1), (dvalues, 1))
    pushed = trajectory._push if throw else trajectory._try_push
    if math.prod(batch) and math.prod(own) == 1:
        whole = [np.array(of) for of in zip(*rows, strict=True)]
        dx = pushed(whole[0][0], whole[1][0], whole[2], whole[3])
        return np.moveaxis(dx, 1, 0).reshape(*batch, *dx[:, 0].shape)
    found = [pushed(row[0], row[1], row[2][None], row[3][None])[:, 0] for row in rows]
    if not found:
        return np.zeros((*batch, trajectory.samples, len(trajectory.x0)))
    return _stacked(found, batch)


def _rows(*given: tuple[Any, int]) -> tuple[tuple[int, ...], Iterator[tuple[Array, ...]]]:
    """The shape of the batch axes in front of arrays, and the arrays of each member. Each array comes with the number of its last axes
    that are no batch."""
    arrays = [(np.asarray(of, dtype=np.float64), axes) for of, axes in given]
    batch = np.broadcast_shapes(*(of.shape[: of.ndim - axes] for of, axes in arrays))
    rows = [
        np.broadcast_to(of, (*batch, *of.shape[of.ndim - axes :])).reshape(math.prod(batch), *of.shape[of.ndim - axes :])
        for of, axes in arrays
    ]
    return batch, zip(*(map(np.ascontiguousarray, of) for of in rows), strict=True)


def _stacked(rows: list[Array], batch: tuple[int, ...]) -> Array:
    return np.stack(rows).reshape(*batch, *rows[0].shape)
