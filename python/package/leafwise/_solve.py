"""Initial value problems, with the result of ``scipy.integrate.solve_ivp``."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import count, in_order, labels, names, number, real_numbers, reals, table
from ._errors import IntegrationError, LeafwiseWarning
from ._events import Event, events_of
from ._functions import System
from ._refine import FIRST, refined
from ._run import Run
from ._scene import Scene, _overrides
from ._scipy import Fields, by_name

Array = NDArray[np.float64]

#: The method where none is given.
_METHOD: dict[str, Any] = {"realization": "auto", "dynamics": {"name": "hamilton-jacobi", "order": 4}}

#: The same for functions of Python, of which no formula is known.
_METHOD_OF_NUMBERS: dict[str, Any] = {
    "realization": "karasev-collocated",
    "dynamics": {"name": "hamilton-jacobi", "order": 2},
    "composition": "suzuki-4",
}


class Solution(Fields):
    """A solution: the fields of SciPy's ``OdeResult``, also by ``solution["t"]``; d coordinates, m points.

    Called with times, shape () or (k,) within the span, it gives the method's own states there, shape (d,) or (d, k). It keeps about a
    thousand states along the span. A state between is the end of steps from the nearest of these, or from the last one computed.
    """

    #: Times of the points: shape (m,).
    t: Array
    #: States: shape (d, m).
    y: Array
    #: The energy at the points: shape (m,).
    energy: Array
    #: The Casimirs at the points, by name: shape (m,) each.
    casimirs: dict[str, Array]
    #: The largest deviation of energy and Casimirs from their initial values, over every step.
    drift: dict[str, float]
    #: Evaluations of the step equations, those of trial runs included.
    nfev: int
    #: 0 at the end of the span, 1 where an event ended it, -1 where a step failed, the accuracy was not met or Ctrl-C ended it.
    status: int
    #: Meaning of the status.
    message: str
    #: The step.
    step: float
    #: The scene that was run.
    scene: Scene
    #: The run; its own times count from the beginning of the span.
    run: Run

    #: The times of each event's crossings, shape (k,), and the states there, shape (k, d); None without events.
    t_events: list[Array] | None = None
    y_events: list[Array] | None = None
    #: The steps of the runs that were made: those of ``rtol``, the last one's the solution's.
    trials: list[int]
    #: Nothing else is counted.
    njev = 0
    nlu = 0

    def __init__(
        self,
        scene: Scene,
        run: Run,
        span: tuple[float, float],
        points: Array | None,
        step: float,
        has_events: bool = False,
    ) -> None:
        self.scene, self.run, self.step, self._span = scene, run, step, span
        self._points = points
        kept = slice(None)
        times = run.t + span[0]
        if points is not None:
            # Samples are the first state, the points behind it, and the last state where that is none of them.
            if run.outcome != "done":
                # Behind them is the state before the step that failed.
                forward = math.copysign(1.0, step)
                reached = run.final_time * forward * (1 + 1e-14)
                points = points[(points - span[0]) * forward <= reached]
            first = int(len(points) == 0 or points[0] != span[0])
            kept = slice(first, first + len(points))
            times[kept] = points
        elif run.outcome == "done":
            times[-1] = span[1]
        recorded = run._recorded
        if has_events:
            self.t_events = [found + span[0] for found, _ in recorded.events]
            self.y_events = [states for _, states in recorded.events]
        if run.outcome == "stopped":
            self._span = (span[0], span[0] + run.final_time)
        self.t, self.y, self.energy = times[kept], run.x[kept].T, run.energy[kept]
        self.casimirs = {name: values[kept] for name, values in run.casimirs.items()}
        self.drift = run.drift
        self.nfev = run.evaluations
        self.status = {"done": 0, "stopped": 1}.get(run.outcome, -1)
        self.message = run.message or "the end of the span was reached"
        if run.outcome == "stopped":
            self.message = f"the event {run.message} ended it at t = {self._span[1]:.6g}"
        self.trials = [run.steps]

    @property
    def is_interrupted(self) -> bool:
        """Whether Ctrl-C ended it."""
        return self.run.outcome == "interrupted"

    @property
    def success(self) -> bool:
        """Whether the end of the span was reached, to the accuracy of ``rtol``."""
        return self.status >= 0

    @property
    def sol(self) -> Solution:
        """The solution as a function, as SciPy's ``dense_output``."""
        return self

    def __call__(self, t: ArrayLike) -> Array:
        times = real_numbers("t", t)
        points, order = np.unique(reals("t", times.reshape(-1), None), return_inverse=True)
        if self._span[1] < self._span[0]:
            points, order = points[::-1], len(points) - 1 - order
        points = _points(points, self._span)
        states = self.scene._states() if len(self.run.names) == len(self.scene.variables) else None
        if states is not None:
            own = states.at(points - self._span[0])[order].T
            return own.reshape(len(own), *times.shape)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", LeafwiseWarning)
            run = _at(self.scene, points, self._span).run()
        found = Solution(self.scene, run, self._span, points, self.step).y[:, order]
        return found.reshape(len(found), *times.shape)

    def __repr__(self) -> str:
        drift = ", ".join(f"{name} {value:.1e}" for name, value in self.drift.items())
        return f"<leafwise.Solution {self.message}: {self.y.shape[1]} points, step {self.step:g}, drift: {drift}>"


@by_name
def solve(
    *,
    x0: ArrayLike,
    t_span: tuple[float, float],
    t_eval: ArrayLike | None = None,
    system: System | None = None,
    bracket: Mapping[str, Any] | str | None = None,
    hamiltonian: str | None = None,
    variables: Iterable[str] | None = None,
    parameters: Mapping[str, float] | None = None,
    casimirs: Mapping[str, str] | None = None,
    define: Mapping[str, str] | None = None,
    convention: str | None = None,
    library: str | None = None,
    method: Mapping[str, Any] | str | None = None,
    step: float | None = None,
    rtol: float | None = None,
    max_steps: int = 10_000_000,
    events: Any = None,
) -> Solution:
    """Solve ẋ = {H, x} from x0 over a span of time; the result has the fields of ``scipy.integrate.solve_ivp``.

        lw.solve(bracket={"q,p": "1"}, convention="{x,H}", hamiltonian="p^2/2 - cos(q)", x0=[0, 1], t_span=(0, 20))

    With ``convention="{x,H}"`` it is ẋ = {x, H}, which is q' = ∂H/∂p for {q, p} = 1. Without it ẋ = {H, x}, the other sign.

    Args:
        x0: the initial state, shape (d,).
        t_span: the first and the last time; the second may be the smaller one. ``t`` in a formula is that time, whatever the span
            begins at.
        t_eval: times of the points, shape (m,), on the way of the span; all steps where not given.
        bracket: the Poisson tensor as in scenes, ``{"q,p": "1"}``; ``hamiltonian``, ``parameters``, ``casimirs``, ``define``,
            ``convention`` and ``library`` are those of a scene's ``[system]``.
        system: functions of Python, in place of formulas.
        parameters: their values by name. A library's system and functions have defaults: give only other values.
        variables: the coordinates' names; where not given, those of the bracket's pairs in the order in which they come.
        method: a scene's ``[method]`` without its step, or the name of a stepper. By default it is Hamilton-Jacobi of order 4; for
            functions, five stages of Hamilton-Jacobi of order 2 over Karasev's realization by collocation. Points are in t with
            a ``pace`` too, whose steps are of another time.
        step: the longest step: the span has a whole number of steps. With a pace, the step of its time.
        rtol: in place of a step: the result errs at all points by at most ``rtol`` times the largest coordinate. Runs with fewer
            steps, less than half as many together, and the method's order give the number of steps. Where errors do not fall by
            that order, the last two runs agree within ``rtol``. 1e-6 where neither is given.
        max_steps: where that search ends.
        events: surfaces whose crossings are ``t_events`` and ``y_events``: formulas as ``"q = 0"``, or tables
            ``{"at": "q = 0", "direction": "up", "terminal": True}``. The direction is that in which left - right goes, "up", "down"
            or "both". ``terminal`` ends the solution there; a number n, at the n-th crossing. A crossing is the end of a
            shorter step of the method, on the surface to round-off. Several within one step are all found. A solution that begins
            on the surface does not cross it there.

    Raises:
        SceneError: the system is not valid.
        MemoryError: the points take more memory than there is: give ``t_eval``.
        TypeError, ValueError: an argument is not.
    """
    span = _span(t_span)
    start, end = span
    if step is not None and rtol is not None:
        raise ValueError("give step or rtol, not both")
    if step is not None and number("step", step) == 0:
        raise ValueError(f"step is {step}, not a length")
    if rtol is not None and not 0 < number("rtol", rtol) < 1:
        raise ValueError(f"rtol is {rtol}: a number between 0 and 1 is needed")
    max_steps = count("max_steps", max_steps, 1)
    if not (bracket is None or isinstance(bracket, (str, Mapping))):
        kind = type(bracket).__name__
        raise TypeError(f"bracket is of {kind}: give the brackets of pairs of coordinates, {{'q,p': '1'}}, or a name")
    if not (method is None or isinstance(method, (str, Mapping))):
        raise TypeError(f"method is of {type(method).__name__}: give a scene's table of a method, or the name of a stepper")
    points = None if t_eval is None else _points(reals("t_eval", t_eval, None), span)
    given = {
        "library": library,
        "variables": None if variables is None else names("variables", variables),
        "bracket": bracket if isinstance(bracket, str) or bracket is None else table("bracket", bracket),
        "hamiltonian": hamiltonian,
        "parameters": None if parameters is None else table("parameters", parameters),
        "casimirs": None if casimirs is None else table("casimirs", casimirs),
        "define": None if define is None else table("define", define),
        "convention": convention,
    }
    formulas = {key: value for key, value in given.items() if value is not None}
    if system is not None:
        if not isinstance(system, System):
            raise TypeError(f"system is of {type(system).__name__}, not a leafwise.System: tables of scenes go into leafwise.Scene")
        others = [key for key in formulas if key != "parameters"]
        if others:
            raise ValueError(f"give system or {others[0]}, not both")
    if system is None and "variables" not in formulas and isinstance(bracket, Mapping) and all("," in pair for pair in formulas["bracket"]):
        paired = (name.strip() for pair in bracket for name in pair.split(","))
        formulas["variables"] = list(dict.fromkeys(paired))
    usual = _METHOD if system is None else _METHOD_OF_NUMBERS
    how = {"stepper": method} if isinstance(method, str) else dict(usual if method is None else method)

    looked_for = [] if events is None else events_of(events)

    has_pace = how.get("pace") is not None
    plan: dict[str, Any] = {"initial": reals("x0", x0, None)}
    if start != 0:
        plan["t0"] = start
    if has_pace:
        plan["until"] = end - start

    def composed(steps: int) -> Scene:
        scene = Scene(
            {
                "system": formulas if system is None else system,
                "method": how | {"time-step": (end - start) / steps},
                "run": plan if has_pace else plan | {"steps": steps},
            }
        )
        return scene if system is None or not formulas else scene.set(system__parameters=formulas["parameters"])

    if labels(x0) is not None:
        plan["initial"] = reals("x0", in_order("x0", x0, composed(1).variables), None)

    def solution_of(scene: Scene, steps: int, points: Array | None, advice: bool = True) -> Solution:
        try:
            run = _run(scene, points, span, looked_for, advice)
        except IntegrationError as failure:
            if failure.run is None:
                raise
            run = failure.run
        return Solution(scene, run, span, points, (end - start) / steps, events is not None)

    if step is not None:
        # A quotient that is whole but for its rounding is whole.
        quotient = abs(end - start) / abs(step) * (1 - 4e-16)
        if quotient > 2.0**62:
            raise ValueError(f"step is {step}, of which t_span {_shown(t_span)} has more than can be counted")
        steps = max(1, math.ceil(quotient))
        return solution_of(composed(steps), steps, points)
    # Its method is that of all runs.
    first = composed(FIRST)

    def attempt(steps: int, points: Array | None) -> Solution:
        length = {} if has_pace else {"run__steps": steps}
        # The first run is never the result.
        return solution_of(first.set(method__time_step=(end - start) / steps, **length), steps, points, steps > FIRST)

    wanted = 1e-6 if rtol is None else rtol
    if has_pace and points is None:
        # Steps of different lengths end at different times: two runs are compared at given ones.
        compared = np.linspace(start, end, FIRST + 1)
        found = _refined(first, lambda steps: attempt(steps, compared), wanted, max_steps)
        if not found.success:
            return found
        whole = attempt(round((end - start) / found.step), None)
        whole.nfev += found.nfev
        whole.trials = [*found.trials, *whole.trials]
        return whole
    return _refined(first, lambda steps: attempt(steps, points), wanted, max_steps)


def _refined(first: Scene, attempt: Callable[[int], Solution], rtol: float, max_steps: int) -> Solution:
    """The solution that errs by at most rtol."""
    tried: list[Solution] = []

    def counted(steps: int) -> Solution:
        tried.append(attempt(steps))
        return tried[-1]

    with warnings.catch_warnings():
        # Of the step that is found alone.
        warnings.simplefilter("ignore", LeafwiseWarning)
        fine, found = refined(counted, _difference, first._scene.order(), rtol, max_steps)
    if not found.is_met and fine.success:
        fine.status = -1
        fine.message = f"with {found.steps[-1]} steps two runs still differ by {found.difference:.1e}: rtol {rtol:g} is not met"
    for advice in fine.run.warnings:
        warnings.warn(advice, LeafwiseWarning, stacklevel=4)
    fine.nfev = sum(one.nfev for one in tried)
    fine.trials = [one.run.steps for one in tried]
    return fine


def _difference(fine: Solution, coarse: Solution) -> float:
    """The largest difference at points that both have, and of the ends where there are events or no points, in parts of the largest
    coordinate."""
    if fine.status != coarse.status:
        return math.inf
    is_all, is_stopped = fine._points is None, fine.status == 1
    y, other = fine.y, coarse.y
    if is_all:
        # The last of both is an event where one ended them.
        last = -1 if is_stopped else None
        y, other = y[:, :last:round(coarse.step / fine.step)], other[:, :last]
    both = min(y.shape[1], other.shape[1])
    off = np.abs(y[:, :both] - other[:, :both]).max(initial=0.0)
    size = np.abs(y).max(initial=0.0)
    if fine.t_events is not None or both == 0:
        ends = fine.run.final_state, coarse.run.final_state
        off, size = max(off, np.abs(ends[0] - ends[1]).max()), max(size, np.abs(ends[0]).max())
        start, end = fine._span
        off = max(off, size * abs(end - coarse._span[1]) / abs(end - start))
    return float(off / size) if size > 0 else float(off)


def _run(scene: Scene, points: Array | None, span: tuple[float, float], events: Sequence[Event], advice: bool) -> Run:
    overrides = {} if points is None else {"run.record.times": points - span[0]}
    return scene._run(_overrides(overrides), [], events, advice, False, None)


def _span(t_span: Any) -> tuple[float, float]:
    """The first and the last time.

    Raises:
        TypeError, ValueError: they are none.
    """
    ends = real_numbers("t_span", t_span)
    if ends.shape != (2,):
        raise ValueError(f"t_span is two times, the first and the last, not {_shown(t_span)}: points between them are t_eval")
    start, end = ends.tolist()
    if not (math.isfinite(start) and math.isfinite(end) and start != end):
        raise ValueError(f"t_span is {_shown(t_span)}: two different finite times are needed")
    return start, end


def _shown(values: Any) -> str:
    told = repr(values)
    return told if len(told) <= 60 else f"{told[:57]}..."


def _points(points: Array, span: tuple[float, float]) -> Array:
    """Points that go the way of the span.

    Raises:
        ValueError: they do not.
    """
    forward = math.copysign(1.0, span[1] - span[0])
    if ((points - span[0]) * forward < 0).any() or ((points - span[1]) * forward > 0).any():
        raise ValueError(f"t_eval leaves t_span {span}")
    if not (np.diff(points) * forward > 0).all():
        raise ValueError("t_eval goes another way than t_span, or has a time twice")
    return points


def _at(scene: Scene, points: Array, span: tuple[float, float]) -> Scene:
    """The scene with its samples at points."""
    return scene.set(run__record__times=points - span[0])
