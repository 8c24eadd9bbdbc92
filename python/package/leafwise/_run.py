"""Results of a run."""

from __future__ import annotations

import html
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._labelled import attributes, beside
from ._leafwise import Recorded
from ._plots import axes, chosen, colours, lines, paths, place_of, plane_of
from ._state_error import StateError
from ._stored import reduced

if TYPE_CHECKING:
    import matplotlib.axes
    import pandas
    import xarray

Array = NDArray[np.float64]


class Run:
    """A run: recorded states and what became of the invariants.

    Arrays are views of one table; n is the number of samples, d the number of recorded coordinates.
    """

    def __init__(self, recorded: Recorded) -> None:
        self._recorded = recorded
        self._coordinates = recorded.coordinates

    @property
    def t(self) -> Array:
        """Times of the samples: shape (n,)."""
        return self._recorded.samples[:, 0]

    @property
    def x(self) -> Array:
        """States of the samples: shape (n, d)."""
        return self._recorded.samples[:, 1 : 1 + self._coordinates]

    @property
    def names(self) -> list[str]:
        """The names of the recorded coordinates."""
        return self._recorded.columns[1 : 1 + self._coordinates]

    @property
    def observables(self) -> dict[str, Array]:
        """Every recorded observable by its name, energy and Casimirs among them: shape (n,) each."""
        first, table = 1 + self._coordinates, self._recorded.samples
        return {name: table[:, first + at] for at, name in enumerate(self._recorded.columns[first:])}

    @property
    def state_error(self) -> StateError | None:
        """The estimated error of its states, where the scene has ``error = "estimate"`` and there is an estimate."""
        found = self._recorded.state_error
        return None if found is None else StateError(*found)

    @property
    def energy(self) -> Array:
        """The Hamiltonian at the samples: shape (n,)."""
        return self._invariant("energy", "Hamiltonian")

    @property
    def casimirs(self) -> dict[str, Array]:
        """The Casimirs at the samples by their names: shape (n,) each."""
        return {name: self._invariant(name, "Casimir") for name, _, _ in self._recorded.invariants[1:]}

    def _invariant(self, name: str, kind: str) -> Array:
        """An invariant at the samples, whose column is called otherwise where a coordinate has its name."""
        observables = self.observables
        column = f"{name} ({kind})"
        return observables[column if column in observables else name]

    @property
    def drift(self) -> dict[str, float]:
        """The largest deviation of energy and Casimirs from their initial values, over every step."""
        return {name: largest for name, _, largest in self._recorded.invariants}

    @property
    def windows(self) -> tuple[Array, dict[str, Array]]:
        """Over windows of steps: the time at each end, and the largest deviation of each invariant within."""
        table, names = self._recorded.windows, self._recorded.windows_columns
        return table[:, 0], {name: table[:, at + 1] for at, name in enumerate(names[1:])}

    @property
    def crossings(self) -> tuple[Array, Array] | None:
        """Times and states on the scene's section: shapes (m,) and (m, d); None without one."""
        table = self._recorded.crossings
        return None if table is None else (table[:, 0], table[:, 1 : 1 + self._coordinates])

    @property
    def final_state(self) -> Array:
        """The last state: shape (d,), all coordinates."""
        return self._recorded.final_state

    @property
    def final_time(self) -> float:
        """The last time."""
        return self._recorded.time

    @property
    def steps(self) -> int:
        """Steps made."""
        return self._recorded.steps

    @property
    def evaluations(self) -> int:
        """Evaluations of the step equations."""
        return self._recorded.evaluations

    @property
    def wall_seconds(self) -> float:
        """Seconds of integration, without building the method."""
        return self._recorded.wall_seconds

    @property
    def outcome(self) -> str:
        """``done``, ``stopped`` by the scene's condition, ``interrupted`` or ``failed``."""
        return self._recorded.outcome

    @property
    def message(self) -> str:
        """Why the run ended before its end."""
        return self._recorded.message

    @property
    def warnings(self) -> list[str]:
        """Changes of the scene that would help, with reasons."""
        return self._recorded.advice

    @property
    def motion(self) -> str | None:
        """Whether the motion is regular, chaotic with its e-folding time, or not yet known, where `megno` is recorded; None elsewhere."""
        return self._recorded.motion

    def report(self) -> str:
        """The report as a page that needs nothing else."""
        return self._recorded.page()

    def save_report(self, file: str | PathLike[str]) -> None:
        """Write the report to a file to open in a browser."""
        Path(file).write_text(self.report(), encoding="utf-8")

    def plot(self, *names: str, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
        """Coordinates and observables against time, all coordinates where none are named; energy and Casimirs beside others have an axis
        of their own on the right. Needs matplotlib.

        Raises:
            KeyError: nothing of this name was recorded.
        """
        columns, table = self._recorded.columns, self._recorded.samples
        asked = chosen(names, self.names, columns[1:])
        drawn = {name: table[:, columns.index(name)] for name in asked}
        return lines(axes(ax), self.t, drawn, self.drift)

    def field(self, name: str) -> Array:
        """A family ``q`` or a component ``s.z`` at the samples, recorded at every site: shape (n, sites), along several
        axes one dimension each.

        Raises:
            KeyError: it was not recorded at every site.
        """
        at, lengths = place_of(self.names, name)
        return self.x[:, at].reshape(-1, *lengths)

    def plot_map(
        self, name: str, t: float | None = None, *, slice: tuple[str, int] | None = None, ax: matplotlib.axes.Axes | None = None
    ) -> matplotlib.axes.Axes:
        """A field over a lattice of two or three axes in colour, at the sample nearest to t, the last where t is not given. Needs matplotlib.

        Args:
            name: a family ``q`` or a component ``s.z``; or a vector ``s``, with s.z in colour and s.x, s.y as arrows.
            t: a time.
            slice: of three axes the one that is cut, and the site, ``("k", 3)``; the middle of k where it is not given.
            ax: the axes to draw on.

        Raises:
            KeyError: the field was not recorded at every site: ``record = { states = "all" }``.
            ValueError: the lattice has one axis, or no such slice.
        """
        at = len(self.t) - 1 if t is None else int(np.argmin(np.abs(self.t - t)))
        families = {known.partition("[")[0] for known in self.names}
        is_vector = name not in families and f"{name}.z" in families
        parts = [f"{name}.{letter}" for letter in "zxy"] if is_vector else [name]
        planes = [plane_of(self.field(part)[at], slice) for part in parts]
        return colours(axes(ax), planes, parts[0], f"{name} at t = {self.t[at]:.6g}")

    def plot_paths(self, x: str = "q.x", y: str = "q.y", *, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
        """The path of every body in the plane of two families, a unit as long along both axes: a disc where it begins, a ring where it is last. Needs matplotlib.

        Raises:
            KeyError: a family was not recorded at every site.
        """
        across, up = self.field(x), self.field(y)
        return paths(axes(ax), across, up, (x, y))

    def to_pandas(self) -> pandas.DataFrame:
        """A column for each coordinate and observable over the index t. Needs pandas."""
        import pandas

        table = self._recorded.samples
        columns = self._recorded.columns
        return pandas.DataFrame(table[:, 1:], pandas.Index(self.t, name=columns[0]), columns[1:])

    def to_xarray(self) -> xarray.Dataset:
        """The states as ``x`` over t and the coordinates' names, the observables over t. Its ``attrs`` hold the method, the scene, the
        program's version and the drift of each invariant. Needs xarray.

        An observable called x, t or coordinate is ``x (observable)`` there.
        """
        import xarray

        variables: dict[str, Any] = {"x": (("t", "coordinate"), self.x)}
        variables |= beside({"x", "t", "coordinate"}, self.observables, "t", "observable")
        return xarray.Dataset(variables, {"t": self.t, "coordinate": self.names}, attributes(self._recorded))

    def _repr_html_(self) -> str:
        page = html.escape(self.report())
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 40em; border: 0"></iframe>'

    def __reduce__(self) -> tuple[Any, ...]:
        return reduced(self, "_recorded")

    def __repr__(self) -> str:
        drift = ", ".join(f"{name} {value:.1e}" for name, value in self.drift.items())
        end = f"{self.outcome}: {self.steps} steps to t = {self.final_time:g}"
        return f"<leafwise.Run {end}, {len(self.t)} samples, drift: {drift}>"
