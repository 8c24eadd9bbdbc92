"""Names that users of SciPy know: the fields of its ``OdeResult``, and its arguments."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import wraps
from os import PathLike
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from ._arrays import Array
from ._labelled import frame_of_solution, of_solution
from ._plots import axes, chosen, lines
from ._views import table

if TYPE_CHECKING:
    import matplotlib.axes
    import pandas
    import xarray

    from ._run import Run

P = ParamSpec("P")
T = TypeVar("T")

#: The fields of a solution, SciPy's first.
_FIELDS = (
    "t",
    "y",
    "sol",
    "t_events",
    "y_events",
    "nfev",
    "njev",
    "nlu",
    "status",
    "message",
    "success",
    "energy",
    "casimirs",
    "drift",
    "step",
    "trials",
    "scene",
    "run",
)

#: Arguments of ``solve_ivp`` and what stands for them here.
_ARGUMENTS = {
    "fun": "the motion is given by bracket= and hamiltonian=, or by functions as system=lw.System(...)",
    "y0": "the initial state is x0=",
    "args": "parameters are given by name: parameters={'k': 2.0}, and formulas use the names",
    "atol": "only rtol= is supported, relative to the largest coordinate",
    "max_step": "all steps have the same length, given by step=",
    "min_step": "all steps have the same length, given by step=",
    "first_step": "all steps have the same length, given by step=",
    "dense_output": "every solution is a function of the time: solution(3.75)",
    "vectorized": "formulas are compiled, and functions of lw.System take a column for each point",
    "jac": "derivatives are formed from the formulas",
    "jac_sparsity": "derivatives are formed from the formulas",
}


def by_name(function: Callable[P, T]) -> Callable[P, T]:
    """The same function with a word about arguments that it knows under other names."""

    @wraps(function)
    def named(*given: P.args, **arguments: P.kwargs) -> T:
        for name in arguments:
            if name in _ARGUMENTS:
                raise TypeError(f"{function.__name__}() has no argument {name!r}: {_ARGUMENTS[name]}")
        if given:
            raise TypeError(
                f"arguments of {function.__name__}() have names: lw.solve(bracket=..., hamiltonian=..., x0=[...], t_span=(0, 20))"
            )
        return function(*given, **arguments)

    return named


class Fields:
    """A mapping of fields, and what tables, figures and notebooks take of it."""

    t: Array
    y: Array
    energy: Array
    casimirs: dict[str, Array]
    step: float
    message: str
    run: Run

    def keys(self) -> list[str]:
        """The names of the fields."""
        return list(_FIELDS)

    def values(self) -> list[Any]:
        """Values of the fields."""
        return [self[name] for name in _FIELDS]

    def items(self) -> list[tuple[str, Any]]:
        """Names and values of the fields."""
        return [(name, self[name]) for name in _FIELDS]

    def get(self, field: str, default: Any = None) -> Any:
        """Value of a field."""
        return self[field] if field in _FIELDS else default

    def __iter__(self) -> Iterator[str]:
        return iter(_FIELDS)

    def __contains__(self, field: object) -> bool:
        return field in _FIELDS

    def __len__(self) -> int:
        return len(_FIELDS)

    def __bool__(self) -> bool:
        return True

    def __getitem__(self, field: str) -> Any:
        if field not in _FIELDS:
            raise KeyError(f"{field!r} is not a field; there are {', '.join(_FIELDS)}")
        return getattr(self, field)

    def plot(self, *names: str, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
        """Coordinates, ``energy`` and Casimirs against time, all coordinates where none are named; energy and Casimirs beside others have
        an axis of their own. Needs matplotlib.

        Raises:
            KeyError: there is nothing of this name.
        """
        own = dict(zip(self.run.names, self.y, strict=True))
        columns = {"energy": self.energy, **self.casimirs} | own
        drawn = {name: columns[name] for name in chosen(names, list(own), columns)}
        return lines(axes(ax), self.t, drawn, set(columns) - set(own))

    def to_pandas(self) -> pandas.DataFrame:
        """A column for each coordinate, the energy and each Casimir over the index t. Needs pandas."""
        return frame_of_solution(self)

    def to_xarray(self) -> xarray.Dataset:
        """The states as ``y`` over the coordinates' names and t, energy and Casimirs over t; ``attrs`` as of a run. Needs xarray."""
        return of_solution(self)

    def report(self) -> str:
        """The report of the run as a page that needs nothing else."""
        return self.run.report()

    def save_report(self, file: str | PathLike[str]) -> None:
        """Write the report to a file to open in a browser."""
        self.run.save_report(file)

    def _repr_html_(self) -> str:
        heads = ["t", *self.run.names, "energy"]
        rows = [(float(t), *map(float, x), float(e)) for t, x, e in zip(self.t, self.y.T, self.energy, strict=True)]
        return table(repr(self), heads, rows)
