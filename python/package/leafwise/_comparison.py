"""Cost against accuracy of methods."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ._plots import axes
from ._views import table

if TYPE_CHECKING:
    import matplotlib.axes
    import pandas


class Comparison(dict[str, Any]):
    """The object that ``leafwise compare`` prints: ``methods``, ``points``, ``refused``, and the ``reference`` that errors are against."""

    def to_pandas(self) -> pandas.DataFrame:
        """A row for each method and step that ran, the cheapest first. Needs pandas.

        Columns are

        - ``method``, ``steps``, ``time_step``, and ``tolerance`` of steppers that choose their steps;
        - ``operations``, of floating-point numbers, ``evaluations`` of the step equations, ``seconds``, the median;
        - ``error``, the largest distance from the reference, ``relative_error``, ``end_error``;
        - ``energy_drift``, ``casimir_drift``, ``tensor_defect``, and ``poisson``: the map keeps the structure;
        - ``front``: nothing is both cheaper and more accurate; ``poisson_front``: no Poisson map is.
        """
        import pandas

        rows = []
        for point in self._ran:
            row = {name: value for name, value in point.items() if name not in _NESTED}
            timed = point["wall_seconds"]
            row["seconds"] = None if timed is None else timed["median"]
            row["front"], row["poisson_front"] = point["front"]["all"], point["front"]["poisson"]
            rows.append(row)
        frame = pandas.DataFrame(rows, columns=_COLUMNS)
        return frame.sort_values("operations", ignore_index=True, kind="stable")

    def plot(self, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
        """Error against operations: the front of all methods, and that of Poisson maps, with the methods' names. Needs matplotlib."""
        ax = axes(ax)
        named: set[tuple[str, float]] = set()
        for front, label, style in (("all", "any method", "o-"), ("poisson", "Poisson maps", "D--")):
            points = sorted((p["operations"], p["error"], p["method"]) for p in self._ran if p["front"][front])
            across, up, methods = ([point[part] for point in points] for part in range(3))
            # Both are seen where they are the same.
            ax.loglog(across, up, style, markersize=4 if front == "all" else 9, markerfacecolor="none", label=label)
            for at, (method, before) in enumerate(zip(methods, [None, *methods], strict=False)):
                if method != before and (method, across[at]) not in named:
                    named.add((method, across[at]))
                    ax.annotate(method, (across[at], up[at]), (5, 5), textcoords="offset points", fontsize="small")
        ax.set(xlabel="operations", ylabel="largest error", title=f"t = {self['time']:g}")
        ax.legend()
        return ax

    def _repr_html_(self) -> str:
        best = sorted((p for p in self._ran if p["front"]["all"] or p["front"]["poisson"]), key=lambda p: float(p["operations"]))
        heads = ["method", "time step", "operations", "error", "Poisson"]
        rows = [
            (p["method"], p.get("time_step"), p["operations"], float(p["error"]), "yes" if p["poisson"] else "no") for p in best
        ]
        return table(f"{self}: nothing is both cheaper and more accurate than these", heads, rows)

    def __repr__(self) -> str:
        return f"<leafwise.Comparison of {len(self['methods'])} methods to t = {self['time']:g}: {len(self._ran)} runs>"

    __str__ = __repr__

    @property
    def _ran(self) -> list[dict[str, Any]]:
        return [point for point in self["points"] if point.get("error") is not None]


_NESTED = {"wall_seconds", "front", "failure", "over_budget", "at_floor"}
_COLUMNS = [
    "method",
    "steps",
    "time_step",
    "tolerance",
    "operations",
    "evaluations",
    "seconds",
    "error",
    "relative_error",
    "end_error",
    "energy_drift",
    "casimir_drift",
    "tensor_defect",
    "poisson",
    "front",
    "poisson_front",
]
