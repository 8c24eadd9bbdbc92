"""Parameters from noisy observations."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import Array, count, in_order, labels, reals, with_gaps
from ._arrays import names as list_of_names
from ._bounded import bounds_of, corrections, priors_of
from ._errors import IntegrationError, LeafwiseError, LeafwiseWarning
from ._gradient import Trajectory
from ._times import AtTimes, times_of
from ._views import table

if TYPE_CHECKING:
    from ._scene import Scene

#: A correction smaller than this part of the uncertainties ends the iteration.
_SMALL = 1e-3
#: The same for parts of the data.
_NEAR = 1.0
#: First the first eighth of the data is fitted, then the first quarter, …: over a short time phases turn by little, and the sum of
#: squares has one minimum.
_PARTS = (8, 4, 2)
#: Standard deviations of the sum of squares that noise does not make.
_UNLIKELY = 10
#: A correction smaller than this part of the values ends it too, where there is no noise.
_ROUNDING = 1e-13
#: How often a correction is halved that makes the sum of squares no smaller.
_HALVINGS = 30
#: Columns of the Jacobian are told apart down to this part of the largest singular value.
_RANK = 1e-9


@dataclass(frozen=True)
class Fit:
    """A fit: the least sum of squares, with the uncertainties that the noise leaves."""

    scene: Scene
    """The scene with the values found."""
    names: list[str]
    """Fitted quantities: parameters, then initial coordinates as ``q(0)`` with ``initial=True``."""
    values: dict[str, float]
    """The values found, by name."""
    errors: dict[str, float]
    """Their standard deviations, by name; NaN for one that lies on its bound."""
    covariance: Array
    """Their covariance, in the order of ``names``: shape (k, k)."""
    residuals: Array
    """(data - model)/sigma: shape (n, m); 0 where the data is NaN."""
    chi2: float
    """The sum of their squares, with those of priors: about ``freedom`` where sigma is right."""
    freedom: int
    """Data and priors less values fitted."""
    iterations: int
    """Linear problems solved."""
    is_converged: bool
    """Whether the last correction was a small part of the uncertainties."""
    at_bounds: list[str] = field(default_factory=list)
    """Quantities on one of their bounds."""

    def _repr_html_(self) -> str:
        rows = [(name, self.values[name], f"{self.errors[name]:.2g}") for name in self.names]
        title = f"chi2 {self.chi2:.4g} of {self.freedom}, {self.iterations} iterations"
        return table(title, ["", "value", "standard deviation"], rows)

    def __repr__(self) -> str:
        errors = {name: "at its bound" if name in self.at_bounds else f"± {self.errors[name]:.1g}" for name in self.names}
        found = ", ".join(f"{name} = {self.values[name]:.6g} {errors[name]}" for name in self.names)
        return f"<leafwise.Fit {found}; chi2 {self.chi2:.4g} of {self.freedom}, {self.iterations} iterations>"


def fit(
    scene: Scene,
    data: ArrayLike,
    parameters: Sequence[str],
    *,
    sigma: ArrayLike | None,
    observed: Sequence[str] | None,
    record: int | None,
    initial: bool,
    iterations: int,
    times: ArrayLike | None = None,
    bounds: Mapping[str, object] | None = None,
    priors: Mapping[str, object] | None = None,
) -> Fit:
    """See :meth:`Scene.fit`."""
    names = labels(data)
    if observed is None and names and all(name in scene.variables for name in names):
        # A frame says itself what it is of.
        observed = names
    columns = _columns(scene, observed)
    given = with_gaps("data", in_order("data", data, [scene.variables[at] for at in columns]))
    if given.ndim != 2 or given.shape[1] != len(columns) or len(given) < 2:
        raise ValueError(
            f"data has the shape {given.shape}, not (n, {len(columns)}) with a row for each of n > 1 samples, the first at t = 0"
        )
    iterations = count("iterations", iterations, 0)
    is_there = ~np.isnan(given)
    if np.isinf(given).any():
        raise ValueError("data is infinite somewhere; write NaN for what was not observed")
    weight = _weight(sigma, given.shape) * is_there
    along = Trajectory(scene, parameters, record=record)
    scene._scene.check_varied(along.parameters, not initial)
    model: Trajectory | AtTimes
    if times is None:
        model = Trajectory(scene, parameters, record=along.record, steps=along.record * (len(given) - 1))
    elif record is not None:
        raise ValueError("give times or record, not both")
    else:
        model = AtTimes(along, times_of(reals("times", times, len(given)), along._map.time_step))
    names = [*model.parameters, *(f"{name}(0)" for name in scene.variables if initial)]
    if not names:
        raise ValueError("nothing to fit: name parameters, or give initial=True")
    chosen, freedom = len(model.parameters), int(is_there.sum()) - len(names)

    # Where a run fails at the values that fewer data gave, it may not at those from which they came.
    begins = [np.concatenate([model.values, model.x0 if initial else []])]
    if priors and sigma is None:
        raise ValueError("priors are weighed against the data: give sigma too")
    known = _Known(*priors_of(priors, names), *bounds_of(bounds, names, begins[0]))
    freedom += int(np.count_nonzero(known.weights))
    if freedom < 0:
        raise ValueError(f"{int(is_there.sum())} numbers do not determine {len(names)} values")
    whole = _Problem(model, np.where(is_there, given, 0.0), weight, columns, initial, known)
    made = 0
    for part in _PARTS:
        first = whole.first(-(-len(given) // part))
        if first.numbers <= len(names):
            continue
        try:
            near = _descend_from(first, begins, _NEAR, iterations - made, names)
        except LeafwiseError:
            # So few of the data do not determine all of it.
            continue
        begins.append(near.at)
        made += near.iterations
    found = _descend_from(whole, begins, _SMALL, iterations - made, names)
    at, made = found.at, made + found.iterations
    scale = 1.0 if sigma is not None else found.chi2 / max(freedom, 1)
    if not found.is_converged:
        told = f"the sum of squares is {found.chi2:.3g} of {whole.numbers} numbers"
        message = f"no fit after {made} iterations: {told}, and the last correction was {found.size:.1e} standard deviations"
        warnings.warn(f"{message}; start nearer to the solution, or with fewer samples", LeafwiseWarning, stacklevel=3)
    elif sigma is not None and found.chi2 > freedom + _UNLIKELY * (2 * max(freedom, 1)) ** 0.5:
        message = f"the sum of squares is {found.chi2:.3g}, where noise of sigma makes {freedom}: the fit may be at another minimum, or the model may not fit"
        warnings.warn(f"{message}, or a sigma that is too small; start nearer to the solution", LeafwiseWarning, stacklevel=3)
    covariance = found.inverse * scale
    covariance[~found.free] = covariance[:, ~found.free] = np.nan
    changed: dict[str, object] = {
        f"system__parameters__{name}": float(value) for name, value in zip(model.parameters, at[:chosen], strict=True)
    }
    if initial:
        changed["run__initial"] = at[chosen:]
    return Fit(
        scene=scene.set(**changed),
        names=names,
        values=dict(zip(names, at.tolist(), strict=True)),
        errors=dict(zip(names, np.sqrt(np.diag(covariance)).tolist(), strict=True)),
        covariance=covariance,
        residuals=found.left,
        chi2=found.chi2,
        freedom=freedom,
        iterations=made,
        is_converged=found.is_converged,
        at_bounds=[name for name, is_free in zip(names, found.free, strict=True) if not is_free],
    )


class _Known(NamedTuple):
    """Prior knowledge of the values, beside the data."""

    means: Array
    weights: Array
    """One over standard deviations, 0 where nothing is known."""
    low: Array
    high: Array


@dataclass(frozen=True)
class _Problem:
    """Data beside a trajectory."""

    model: Trajectory | AtTimes
    known: Array
    weight: Array
    columns: list[int]
    initial: bool
    beside: _Known

    @property
    def numbers(self) -> int:
        """How many data and priors there are."""
        return int(np.count_nonzero(self.weight) + np.count_nonzero(self.beside.weights))

    def first(self, rows: int) -> _Problem:
        """The same with the first rows of the data alone."""
        model = self.model._part(rows)
        return _Problem(model, self.known[:rows], self.weight[:rows], self.columns, self.initial, self.beside)

    def priors(self, at: Array) -> Array:
        """The residuals of the priors."""
        off: Array = (self.beside.means - at) * self.beside.weights
        return off

    def chi2(self, at: Array) -> float:
        """The sum of squares."""
        return float((self.left(at) ** 2).sum() + (self.priors(at) ** 2).sum())

    def left(self, at: Array) -> Array:
        """The residuals."""
        count = len(self.model.parameters)
        return self._left(self.model(at[count:] if self.initial else None, at[:count]))

    def linear(self, at: Array) -> tuple[Array, Array]:
        """The residuals, and how the model changes with what is fitted."""
        count, whole = len(self.model.parameters), np.eye(len(at))
        dx0 = whole[:, count:] if self.initial else None
        dvalues = whole[:, :count] if count else None
        x, dx, _ = self.model.jvp(dx0, dvalues, x0=at[count:] if self.initial else None, values=at[:count])
        slopes = dx[:, :, self.columns] * self.weight[:, None, :]
        return self._left(x), slopes.transpose(0, 2, 1).reshape(-1, len(at))

    def _left(self, x: Array) -> Array:
        left: Array = (self.known - x[:, self.columns]) * self.weight
        return left


class _Found(NamedTuple):
    """Where an iteration ended."""

    at: Array
    left: Array
    chi2: float
    inverse: Array
    free: NDArray[np.bool_]
    """Which of the values lie on no bound."""
    size: float
    """The last correction in standard deviations."""
    iterations: int
    is_converged: bool


def _descend(problem: _Problem, at: Array, small: float, most: int, names: list[str]) -> _Found:
    """Gauss and Newton's iteration until corrections are as small as this part of the uncertainties."""
    made = 0
    while True:
        left, slopes = problem.linear(at)
        whole = left.ravel()
        if problem.beside.weights.any():
            whole = np.concatenate([whole, problem.priors(at)])
            slopes = np.concatenate([slopes, np.diag(problem.beside.weights)])
        correction, inverse, free = _within(slopes, whole, names, problem.beside.low - at, problem.beside.high - at)
        chi2 = float((whole**2).sum())
        # Uncertainties by the noise that the residuals show.
        scale = chi2 / max(problem.numbers - len(names), 1)
        size = float(np.linalg.norm(slopes @ correction)) / max(scale, np.finfo(float).tiny) ** 0.5
        is_rounding = bool((np.abs(correction) <= _ROUNDING * np.abs(at)).all())
        is_converged = size <= small or is_rounding
        if is_converged or made >= most:
            return _Found(at, left, chi2, inverse, free, size, made, is_converged)
        shorter = _shorter(at, correction, chi2, problem.chi2)
        if shorter is None:
            # No correction however short makes the sum smaller: round-off, where the correction is one.
            return _Found(at, left, chi2, inverse, free, size, made, size <= 1.0)
        at, made = shorter, made + 1


def _descend_from(problem: _Problem, begins: list[Array], small: float, most: int, names: list[str]) -> _Found:
    """The iteration from the last of these values at which every step can be taken.

    Raises:
        IntegrationError: a step cannot be taken at the first ones, the scene's own.
        LeafwiseError: the data do not determine all values.
    """
    for begin in reversed(begins[1:]):
        try:
            return _descend(problem, begin, small, most, names)
        except IntegrationError:
            continue
    return _descend(problem, begins[0], small, most, names)


def _columns(scene: Scene, observed: Sequence[str] | None) -> list[int]:
    """Which coordinates the data are of."""
    known = scene.variables
    observed = None if observed is None else list_of_names("observed", observed)
    for name in observed or []:
        if name not in known:
            raise LeafwiseError(f"the system has no coordinate {name!r}; it has {', '.join(known)}")
    return [known.index(name) for name in (known if observed is None else observed)]


def _weight(sigma: ArrayLike | None, shape: tuple[int, ...]) -> Array:
    """1/sigma for each number of the data."""
    if sigma is None:
        return np.ones(shape)
    ndim = np.ndim(sigma)
    given = reals("sigma", sigma, *shape[2 - ndim :]) if ndim <= 2 else reals("sigma", sigma, *shape)
    if (given <= 0).any():
        raise ValueError("sigma must be positive")
    return np.broadcast_to(1.0 / given, shape).copy()


def _within(
    slopes: Array, left: Array, names: list[str], low: Array, high: Array
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """The correction within bounds, (slopesᵀ slopes)⁻¹ of the values that lie on none of them, and which these are."""

    def solve(some: Array, rest: Array, columns: list[int]) -> Array:
        return _solve(some, rest, [names[at] for at in columns])[0]

    if np.isinf(low).all() and np.isinf(high).all():
        return *_solve(slopes, left, names), np.ones(len(names), dtype=bool)
    correction, free = corrections(slopes, left, low, high, solve)
    inverse = np.zeros((len(names), len(names)))
    if free.any():
        own = _solve(slopes[:, free], left, [name for name, is_free in zip(names, free, strict=True) if is_free])[1]
        inverse[np.ix_(free, free)] = own
    return correction, inverse, free


def _solve(slopes: Array, left: Array, names: list[str]) -> tuple[Array, Array]:
    """The correction with the least ‖left − slopes·correction‖, and (slopesᵀ slopes)⁻¹."""
    scales = np.linalg.norm(slopes, axis=0)
    for name, scale in zip(names, scales, strict=True):
        if scale == 0.0:
            raise LeafwiseError(f"the data do not depend on {name}: fit it from others, or leave it out")
    u, sizes, vt = np.linalg.svd(slopes / scales, full_matrices=False)
    if sizes[-1] <= _RANK * sizes[0]:
        mixed = [name for name, part in zip(names, vt[-1], strict=True) if abs(part) > 0.1]
        raise LeafwiseError(
            f"the data do not distinguish {' and '.join(mixed)}: fix one of them, or observe more coordinates or a longer time"
        )
    correction = (vt.T @ ((u.T @ left) / sizes)) / scales
    half = vt.T / sizes / scales[:, None]
    return correction, half @ half.T


def _shorter(at: Array, correction: Array, chi2: float, sum_of: Callable[[Array], float]) -> Array | None:
    """The first of at + correction, at + correction/2, … with a smaller sum of squares."""
    for halving in range(_HALVINGS):
        trial = at + correction * 0.5**halving
        try:
            found = sum_of(trial)
        except IntegrationError:
            continue
        if found < chi2:
            return trial
    return None
