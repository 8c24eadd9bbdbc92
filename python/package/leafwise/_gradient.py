"""Trajectories as differentiable functions."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from copy import copy
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import Array, count, in_order, names, real_numbers, reals
from ._errors import IntegrationError, LeafwiseError, LeafwiseWarning, SceneError
from ._leafwise import Growth

if TYPE_CHECKING:
    from ._scene import Scene


#: Why JAX and PyTorch are refused the derivatives of derivatives.
NO_SECOND = (
    "second derivatives of a trajectory are not available: take differences of gradients, or, to minimize a sum of squares, J'J "
    "with J from trajectory.jvp, as scene.fit does"
)


class Gradient(NamedTuple):
    """The gradient of a function of the samples."""

    x0: Array
    """By the initial state: shape (d,)."""
    values: Array
    """By the parameters: shape (p,)."""
    growth: Growth
    """How the derivatives grew on their way, and how many digits that leaves."""
    from_checkpoints: bool
    """Whether steps were taken again from checkpoints, in place of steps back."""


class Tangents(NamedTuple):
    """Samples and their tangents."""

    x: Array
    """The samples: shape (n, d)."""
    dx: Array
    """Their tangents: shape (n, d), or (n, k, d) for k directions."""
    growth: Growth
    """How they grew on their way, and how many digits that leaves."""


class Tried(NamedTuple):
    """Samples of a run that may have failed: arrays of the kind of the arguments, one entry of each for a member of a batch."""

    x: Any
    """The samples: shape (n, d); NaN behind the step that could not be taken."""
    samples: Any
    """How many there are before it."""
    is_done: Any
    """Whether all steps could be taken."""


def _enters_by_formulas(scene: Scene, name: str) -> bool:
    """Whether no values of sites are formed of a parameter."""
    try:
        scene._scene.check_varied([name], False)
    except SceneError:
        return False
    return True


class Trajectory:
    """The samples x of a scene as a function of the initial state x0 and the values of chosen parameters.

    Shapes are (n, d) of x, (d,) of x0 and (p,) of the values.

    Its derivatives are those of the steps that are taken, exact to round-off. ``vjp`` keeps 64 states of the run
    where the method is its own inverse, and as many checkpoints as the logarithm of the steps elsewhere. Derivatives that have
    lost all but six digits, as along chaotic motion, come with a warning that says how fast they grow.

    Raises:
        LeafwiseError: the scene has a pace, a condition that stops it or samples at times; a name is no parameter.
        SceneError: its bracket is not Poisson, and ``allow_non_poisson`` is not given; values of sites are formed of a parameter
            that is named.
    """

    def __init__(
        self,
        scene: Scene,
        parameters: Sequence[str] | None = None,
        *,
        steps: int | None = None,
        record: int | None = None,
        allow_non_poisson: bool = False,
    ) -> None:
        self.scene = scene
        self._allow_non_poisson = allow_non_poisson
        chosen = None if parameters is None else names("parameters", parameters)
        self._map = scene._scene.map(allow_non_poisson)
        known = scene.parameters
        chosen = [name for name in known if _enters_by_formulas(scene, name)] if chosen is None else chosen
        for name in chosen:
            if name not in known:
                told = ", ".join(known) or "none"
                raise LeafwiseError(f"the system has no parameter {name!r}; it has {told}")
            if chosen.count(name) > 1:
                raise LeafwiseError(f"the parameter {name!r} is named twice")
        scene._scene.check_varied(chosen, False)
        self.parameters = chosen
        """The names of the parameters that ``values`` holds, in their order."""
        self._all = np.array(list(known.values()), dtype=np.float64)
        self._at = [list(known).index(name) for name in chosen]
        own_steps, own_record = self._map.plan
        self.steps = own_steps if steps is None else count("steps", steps, 0)
        """The number of steps."""
        self.record = own_record if record is None else count("record", record, 1)
        """Every how many steps there is a sample."""

    @property
    def t(self) -> Array:
        """Times of the samples: shape (n,)."""
        numbers = np.arange(0, self.steps + 1, self.record, dtype=np.float64)
        times: Array = numbers * self._map.time_step
        return times

    @property
    def x0(self) -> Array:
        """The scene's initial state: shape (d,)."""
        return self._map.initial

    @property
    def values(self) -> Array:
        """The scene's values of the parameters: shape (p,)."""
        return self._all[self._at]

    @property
    def samples(self) -> int:
        """The number n of samples."""
        return self.steps // self.record + 1

    @overload
    def __call__(
        self, x0: ArrayLike | None = None, values: ArrayLike | None = None, *, throw: Literal[True] = True
    ) -> Array: ...

    @overload
    def __call__(self, x0: ArrayLike | None = None, values: ArrayLike | None = None, *, throw: Literal[False]) -> Tried: ...

    def __call__(
        self, x0: ArrayLike | None = None, values: ArrayLike | None = None, *, throw: bool = True
    ) -> Array | Tried:
        """The samples: shape (n, d), with the bits of the program's run.

        With ``throw=False`` the result is a :class:`Tried`, for optimizers that go on from there. A step that cannot be taken, and an x0
        or values that are not finite, raise nothing: samples behind that step are NaN.

        Raises:
            IntegrationError: a step could not be taken.
            MemoryError: the samples take more memory than there is.
        """
        if throw:
            return self._run(x0, values)[0]
        x, _, there = self._try(x0, values)
        return Tried(x, there, there == self.samples)

    def _try(self, x0: ArrayLike | None, values: ArrayLike | None) -> tuple[Array, Array, int]:
        """As :meth:`_run`, with the number of samples before a step that fails: behind them are NaN, and nothing is kept."""
        x = np.full((self.samples, len(self.x0)), np.nan)
        none = np.zeros((self._map.pieces((self.steps, self.record)), 2, self._map.width))
        if not self._are_finite(x0, values):
            return x, none, 0
        try:
            return *self._run(x0, values), self.samples
        except IntegrationError:
            made = self._map.reach(self._initial(x0), self._whole(values), self.steps)
            part = self._part(made // self.record + 1)
            x[: part.samples] = part._run(x0, values)[0]
            return x, none, part.samples

    def _are_finite(self, x0: ArrayLike | None, values: ArrayLike | None) -> bool:
        """Whether all numbers are finite. Other types and shapes raise an exception."""
        are_finite = True
        for name, of, columns in (("x0", x0, self.scene.variables), ("values", values, self.parameters)):
            if of is not None:
                found = real_numbers(name, in_order(name, of, columns))
                is_there = np.isfinite(found)
                reals(name, np.where(is_there, found, 0.0), len(columns))
                are_finite &= bool(is_there.all())
        return are_finite

    def _part(self, samples: int) -> Trajectory:
        """The same with the first samples alone."""
        part = copy(self)
        part.steps = self.record * (samples - 1)
        return part

    def _try_pull(self, x0: Array, values: Array, kept: Array, w: Array) -> tuple[Array, Array]:
        """As :meth:`_pull` by x0 and values, of the samples that are there; NaN where others count."""
        there = self._try(x0, values)[2] if np.isfinite(w).all() else 0
        if there == 0 or (w[there:] != 0).any():
            return np.full(len(x0), np.nan), np.full(len(values), np.nan)
        if there < self.samples:
            part = self._part(there)
            return part._pull(x0, values, part._run(x0, values)[1], w[:there])[:2]
        return self._pull(x0, values, kept, w)[:2]

    def _push(self, x0: Array, values: Array, dx0: Array, dvalues: Array) -> Array:
        """Tangents of the samples in k directions: shape (n, k, d)."""
        by_values = dvalues if self.parameters else None
        return self.jvp(dx0, by_values, x0=x0, values=values).dx

    def _try_push(self, x0: Array, values: Array, dx0: Array, dvalues: Array) -> Array:
        """As :meth:`_push`, of the samples that are there; NaN behind them."""
        dx = np.full((self.samples, len(dx0), len(x0)), np.nan)
        there = self._try(x0, values)[2] if np.isfinite(dx0).all() and np.isfinite(dvalues).all() else 0
        if there:
            dx[:there] = self._part(there)._push(x0, values, dx0, dvalues)
        return dx

    def _run(self, x0: ArrayLike | None, values: ArrayLike | None) -> tuple[Array, Array]:
        """Samples, and the states kept for the way back: shape (pieces, 2, stepped coordinates)."""
        return self._map.run(self._initial(x0), self._whole(values), (self.steps, self.record))

    def jvp(
        self,
        dx0: ArrayLike | None = None,
        dvalues: ArrayLike | None = None,
        *,
        x0: ArrayLike | None = None,
        values: ArrayLike | None = None,
    ) -> Tangents:
        """The samples, and their derivative in the direction (dx0, dvalues).

        Shapes are (d,) and (p,), or (k, d) and (k, p) for k directions at once. An argument that is left out does not change.

        Raises:
            IntegrationError: a step could not be taken.
            LeafwiseError: the method's derivatives are not known.
        """
        d, p = len(self.x0), len(self.parameters)
        given = [("dx0", dx0, d), ("dvalues", dvalues, p)]
        dims = {np.ndim(of) for _, of, _ in given if of is not None}
        if dims not in ({1}, {2}):
            raise ValueError("give dx0 or dvalues, each for one direction or both for several")
        rows = [None if of is None else reals(name, of, *[None] * (dims == {2}), n) for name, of, n in given]
        count = max(1 if of is None or of.ndim == 1 else len(of) for of in rows)
        if any(of is not None and of.size != count * n for of, (_, _, n) in zip(rows, given, strict=True)):
            raise ValueError(f"dx0 and dvalues have {count} and fewer directions")
        of_state, of_values = (
            np.zeros((count, n)) if of is None else of.reshape(count, n)
            for of, (_, _, n) in zip(rows, given, strict=True)
        )
        by_values = np.zeros((count, len(self._all) if dvalues is not None else 0))
        if dvalues is not None:
            by_values[:, self._at] = of_values
        x, dx, growth = self._map.push(
            self._initial(x0),
            self._whole(values),
            np.ascontiguousarray(of_state),
            by_values,
            (self.steps, self.record),
        )
        _warn(growth)
        return Tangents(x, dx[:, 0] if dims == {1} else dx, growth)

    def vjp(
        self, x0: ArrayLike | None = None, values: ArrayLike | None = None
    ) -> tuple[Array, Callable[[ArrayLike], Gradient]]:
        """The samples, and a function that pulls derivatives by them back to x0 and the parameters.

        It takes the derivatives w of any function of the samples and gives the gradient of that function. The samples and w have the
        shape (n, d).

        Raises:
            IntegrationError: a step could not be taken.
            LeafwiseError: from the function, where the method's derivatives are not known.
        """
        initial, whole = self._initial(x0).copy(), self._whole(values)
        x, kept = self._map.run(initial, whole, (self.steps, self.record))
        return x, lambda w: self._pull(initial, whole[self._at], kept, w)

    def _pull(self, x0: ArrayLike, values: ArrayLike, kept: Array, w: ArrayLike) -> Gradient:
        """The gradient of a function with the derivatives w, of the run that kept these states."""
        of_state, of_values, growth, again = self._map.pull(
            self._initial(x0),
            self._whole(values),
            kept,
            reals("w", w, self.samples, len(self.x0)),
            bool(self.parameters),
            (self.steps, self.record),
        )
        _warn(growth)
        chosen = of_values[self._at] if self.parameters else of_values
        return Gradient(of_state, chosen, growth, again)

    def _initial(self, x0: ArrayLike | None) -> Array:
        return self.x0 if x0 is None else reals("x0", in_order("x0", x0, self.scene.variables), len(self.x0))

    def _whole(self, values: ArrayLike | None) -> Array:
        """All parameters with these values of the chosen ones."""
        whole = self._all.copy()
        if values is not None:
            given = in_order("values", values, self.parameters)
            whole[self._at] = reals("values", given, len(self.parameters))
        return whole

    def __reduce__(self) -> tuple[object, ...]:
        return _again, (self.scene, self.parameters, self.steps, self.record, self._allow_non_poisson)

    def __repr__(self) -> str:
        names = ", ".join(["x0", *self.parameters])
        return f"<leafwise.Trajectory of {names}: {self.steps} steps, {self.samples} samples>"


def _again(scene: Scene, parameters: list[str], steps: int, record: int, allow_non_poisson: bool) -> Trajectory:
    return Trajectory(scene, parameters, steps=steps, record=record, allow_non_poisson=allow_non_poisson)


def _warn(growth: Growth) -> None:
    if growth.is_large:
        warnings.warn(str(growth), LeafwiseWarning, stacklevel=3)
