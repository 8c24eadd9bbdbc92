"""Results of a sweep."""

from __future__ import annotations

import csv
import html
import io
import json
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _leafwise
from ._labelled import of_sweep
from ._plots import axes
from ._stored import reduced

if TYPE_CHECKING:
    import matplotlib.axes
    import pandas
    import xarray

Array = NDArray[np.float64]


class Sweep:
    """A table with a row for each of n settings, in their order: the program's ``sweep.csv``.

    ``sweep["energy_drift"]`` is a column by its heading: numbers where all cells are, words otherwise.
    """

    def __init__(self, left: _leafwise.Sweep) -> None:
        self._left = left
        self._ending: dict[str, Any] = json.loads(left.ending)
        head, *rows = csv.reader(io.StringIO(left.table))
        cells = zip(*rows, strict=True) if rows else ([] for _ in head)
        self._cells = dict(zip(head, cells, strict=True))

    def _named(self, kind: str) -> list[str]:
        names: list[str] = self._ending["columns"][kind]
        return names

    def _numbers(self, name: str) -> Array:
        return np.array([float(cell) if cell else np.nan for cell in self._cells[name]], dtype=np.float64)

    @property
    def columns(self) -> list[str]:
        """The headings of the table."""
        return list(self._cells)

    @property
    def settings(self) -> dict[str, NDArray[Any]]:
        """The values of the swept keys: shape (n,) each, numbers where all are."""
        return {name: self[name] for name in self._named("settings")}

    @property
    def outcomes(self) -> NDArray[np.str_]:
        """``done``, ``stopped`` by the scene's condition, or ``failed``: shape (n,)."""
        return np.array(self._cells["outcome"], dtype=np.str_)

    @property
    def errors(self) -> list[str]:
        """Why runs have failed; empty where they have not: n texts."""
        return list(self._cells["error"])

    @property
    def failed(self) -> int:
        """How many runs have failed."""
        return int(self._ending["failed"])

    @property
    def t(self) -> Array:
        """The times of the last states: shape (n,)."""
        return self._numbers("t")

    @property
    def drift(self) -> dict[str, Array]:
        """The largest deviation of energy and Casimirs from their initial values, over all steps: shape (n,) each."""
        return {name.removesuffix("_drift"): self._numbers(name) for name in self._named("drifts")}

    @property
    def observables(self) -> dict[str, Array]:
        """The observables of the last states: shape (n,) each."""
        return {name: self._numbers(name) for name in self._named("observables")}

    @property
    def cost(self) -> dict[str, Array]:
        """Counts of ``steps``, ``evaluations`` and ``operations``: shape (n,) each, the same on every machine."""
        return {name: self._numbers(name) for name in self._named("cost")}

    @property
    def outcome(self) -> str:
        """``done``, or ``interrupted``: the table then holds the settings that had ended."""
        found: str = self._ending["outcome"]
        return found

    @property
    def wall_seconds(self) -> float:
        """Seconds of all runs, without building their methods."""
        return float(self._ending["wall_seconds"])

    @property
    def table(self) -> str:
        """The table as CSV."""
        return self._left.table

    def report(self) -> str:
        """The report as a page that needs nothing else."""
        return self._left.page

    def save_report(self, file: str | PathLike[str]) -> None:
        """Write the report to a file to open in a browser."""
        Path(file).write_text(self.report(), encoding="utf-8")

    def plot(self, y: str | None = None, x: str | None = None, *, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
        """A column against a swept key, with a line for each combination of the others. Needs matplotlib.

        By default it is the first drift against the first key.

        Raises:
            KeyError: there is no such column.
        """
        keys = self._named("settings")
        asked = (x or keys[0], y or self._named("drifts")[0])
        for name in asked:
            if name not in self._cells:
                raise KeyError(f"{name!r} is not a column; there are {', '.join(self._cells)}")
        others = [key for key in keys if key != asked[0]]
        groups: dict[tuple[str, ...], list[int]] = {}
        for at in range(len(self)):
            groups.setdefault(tuple(self._cells[key][at] for key in others), []).append(at)
        ax = axes(ax)
        across, up = self[asked[0]], self._numbers(asked[1])
        for values, rows in groups.items():
            label = ", ".join(f"{key} = {value}" for key, value in zip(others, values, strict=True))
            order = sorted(rows, key=lambda at: across[at])
            ax.plot(across[order], up[order], "o-", label=label or None)
        ax.set(xlabel=asked[0], ylabel=asked[1])
        if others:
            ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, frameon=False)
        return ax

    def to_xarray(self) -> xarray.Dataset:
        """All columns over the swept keys, where settings are all combinations of their values; else over settings. Needs xarray."""
        return of_sweep(self)

    def to_pandas(self) -> pandas.DataFrame:
        """A row for each setting. Needs pandas."""
        import pandas

        frame = pandas.DataFrame({name: self[name] for name in self.columns})
        return frame.set_index("setting")

    def __getitem__(self, name: str) -> NDArray[Any]:
        if all(cell.isdecimal() for cell in self._cells[name]):
            return np.array([int(cell) for cell in self._cells[name]], dtype=np.int64)
        try:
            return self._numbers(name)
        except ValueError:
            return np.array(self._cells[name])

    def _repr_html_(self) -> str:
        page = html.escape(self.report())
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 40em; border: 0"></iframe>'

    def __len__(self) -> int:
        return len(self._cells["setting"])

    def __reduce__(self) -> tuple[Any, ...]:
        return reduced(self, "_left")

    def __repr__(self) -> str:
        return f"<leafwise.Sweep {self.outcome}: {len(self)} settings, {self.failed} failed>"
