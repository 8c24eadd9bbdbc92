"""Results of an ensemble."""

from __future__ import annotations

import html
import json
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _leafwise
from ._labelled import of_ensemble, unlike
from ._plots import axes
from ._stored import reduced

if TYPE_CHECKING:
    import matplotlib.axes
    import pandas
    import xarray

Array = NDArray[np.float64]

_OUTCOMES = np.array(["done", "stopped", "failed"])


class Losses(NamedTuple):
    """The members that the scene's condition has ended by each time t: shape (m,) each.

    ``low`` and ``high`` are the ends of Wilson's 95 % interval of the probability.
    """

    t: Array
    stopped: NDArray[np.int64]
    fraction: Array
    low: Array
    high: Array


class Crossings(NamedTuple):
    """States on the scene's section: members (m,), times (m,), recorded coordinates (m, d), observables (m,) each."""

    member: NDArray[np.int64]
    t: Array
    x: Array
    observables: dict[str, Array]


class Ensemble:
    """An ensemble: the members' last states and what became of their invariants.

    n is the number of members, d the number of coordinates; rows are in the order of the members.
    """

    def __init__(self, left: _leafwise.Ensemble) -> None:
        self._left = left
        self._ending: dict[str, Any] = json.loads(left.ending)

    def _columns(self, before: int, count: int) -> Array:
        first = int(self._left.has_times) + before
        return self._left.members[:, first : first + count]

    def _named(self, before: int, names: list[str]) -> dict[str, Array]:
        return {name: self._columns(before + at, 1)[:, 0] for at, name in enumerate(names)}

    @property
    def x(self) -> Array:
        """The members' last states: shape (n, d). A member that failed has its last good state."""
        return self._columns(len(self._left.parameters), len(self._left.variables))

    @property
    def x0(self) -> Array:
        """Their initial states: shape (n, d)."""
        left = self._left
        before = len(left.parameters) + len(left.variables) + len(left.observables)
        return self._columns(before, len(left.variables))

    @property
    def t(self) -> Array:
        """The times of the last states: shape (n,)."""
        if self._left.has_times:
            return self._left.members[:, 0]
        return np.full(len(self._left.members), self._left.time)

    @property
    def outcomes(self) -> NDArray[np.str_]:
        """``done``, ``stopped`` by the scene's condition, or ``failed``: shape (n,)."""
        found: NDArray[np.str_] = _OUTCOMES[self._left.outcomes]
        return found

    @property
    def parameters(self) -> dict[str, Array]:
        """The parameters that differ from member to member: shape (n,) each."""
        return self._named(0, self._left.parameters)

    @property
    def observables(self) -> dict[str, Array]:
        """The observables of the last states: shape (n,) each; NaN where a member failed."""
        before = len(self._left.parameters) + len(self._left.variables)
        return self._named(before, self._left.observables)

    @property
    def drift(self) -> dict[str, Array]:
        """The largest deviation of energy and Casimirs from their initial values: shape (n,) each; NaN where a member failed."""
        left = self._left
        before = len(left.parameters) + 2 * len(left.variables) + len(left.observables)
        return self._named(before, left.invariants)

    @property
    def names(self) -> list[str]:
        """The names of the coordinates."""
        return self._left.variables

    @property
    def losses(self) -> Losses | None:
        """How many members the scene's condition has ended against time; None without one."""
        if not self._left.has_times:
            return None
        rows = self._ending.get("losses", [])
        values = np.array([[row["time"], row["fraction"], *row["interval"]] for row in rows], dtype=np.float64)
        t, fraction, low, high = values.reshape(-1, 4).T
        return Losses(t, np.array([row["stopped"] for row in rows], dtype=np.int64), fraction, low, high)

    @property
    def crossings(self) -> Crossings | None:
        """The members' crossings of the scene's section, member after member; None without one."""
        table, names = self._left.crossings, self._left.observables
        if table is None:
            return None
        last = table.shape[1] - len(names)
        observables = {name: table[:, last + at] for at, name in enumerate(names)}
        return Crossings(table[:, 0].astype(np.int64), table[:, 1], table[:, 2:last], observables)

    @property
    def statistics(self) -> list[dict[str, Any]]:
        """Count, mean, variance, extremes and quantiles of every observable at each recorded time, as the program's manifest."""
        found: list[dict[str, Any]] = self._ending["statistics"]
        return found

    @property
    def failed(self) -> int:
        """How many members failed; ``statistics`` cover the others."""
        return int(self._ending["failed"])

    @property
    def failures(self) -> list[dict[str, Any]]:
        """The members that failed, the first 1000 of them: member, step, time, message, state."""
        found: list[dict[str, Any]] = self._ending["failures"]
        return found

    @property
    def outcome(self) -> str:
        """``done``, or ``interrupted``: arrays then hold the members that had ended."""
        found: str = self._ending["outcome"]
        return found

    @property
    def wall_seconds(self) -> float:
        """Seconds of integration, without building the method."""
        return float(self._ending["wall_seconds"])

    @property
    def warnings(self) -> list[str]:
        """Changes of the scene that would help, with reasons."""
        return self._left.advice

    def report(self) -> str:
        """The report as a page that needs nothing else."""
        return self._left.page

    def save_report(self, file: str | PathLike[str]) -> None:
        """Write the report to a file to open in a browser."""
        Path(file).write_text(self.report(), encoding="utf-8")

    def plot(self, x: str | None = None, y: str | None = None, *, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
        """The members' last states, one column against another, in a colour for each outcome. Needs matplotlib.

        Columns are coordinates, parameters, observables and ``t``; by default the first two coordinates.

        Raises:
            KeyError: there is no such column.
        """
        columns = {"t": self.t, **self.parameters, **dict(zip(self.names, self.x.T, strict=True)), **self.observables}
        first, second = (self.names * 2)[:2]
        asked = (x or first, y or second)
        for name in asked:
            if name not in columns:
                raise KeyError(f"{name!r} is not a column; there are {', '.join(columns)}")
        ax = axes(ax)
        for end in _OUTCOMES:
            of_end = self.outcomes == end
            if of_end.any():
                ax.plot(columns[asked[0]][of_end], columns[asked[1]][of_end], ".", label=f"{end}: {np.count_nonzero(of_end)}")
        ax.set(xlabel=asked[0], ylabel=asked[1])
        ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, frameon=False)
        return ax

    def to_xarray(self) -> xarray.Dataset:
        """Last and initial states as ``x`` and ``x0`` over members and the coordinates' names, all else over members. Needs xarray."""
        return of_ensemble(self)

    def to_pandas(self) -> pandas.DataFrame:
        """A row for each member. Needs pandas."""
        import pandas

        columns: dict[str, Any] = {"outcome": self.outcomes, "t": self.t, **self.parameters}
        columns |= dict(zip(self.names, self.x.T, strict=True))
        initial = {f"{name}_initial": x for name, x in zip(self.names, self.x0.T, strict=True)}
        drift = {f"{name}_drift": values for name, values in self.drift.items()}
        for name, values in self.observables.items():
            columns[unlike(name, {*columns, *initial, *drift})] = values
        columns |= initial | drift
        return pandas.DataFrame(columns).rename_axis("member")

    def _repr_html_(self) -> str:
        page = html.escape(self.report())
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 40em; border: 0"></iframe>'

    def __len__(self) -> int:
        return len(self._left.members)

    def __reduce__(self) -> tuple[Any, ...]:
        return reduced(self, "_left")

    def __repr__(self) -> str:
        ends = ", ".join(f"{np.count_nonzero(self.outcomes == end)} {end}" for end in _OUTCOMES)
        return f"<leafwise.Ensemble {self.outcome}: {len(self)} members, {ends}>"
