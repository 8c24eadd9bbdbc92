"""Results as labelled arrays of xarray, and as columns of pandas."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ._leafwise import version

if TYPE_CHECKING:
    import pandas
    import xarray

    from ._ensemble import Ensemble
    from ._leafwise import Recorded
    from ._scipy import Fields
    from ._sweep import Sweep


def attributes(recorded: Recorded) -> dict[str, Any]:
    """Where a run's numbers come from: its method, its scene, the program, and what became of the invariants."""
    drift = {f"drift_{name}": largest for name, _, largest in recorded.invariants}
    return {"method": "\n".join(recorded.method), "scene": recorded.scene, "leafwise": version(), **drift}


def unlike(name: str, taken: Collection[str], kind: str = "observable") -> str:
    """The name of a column, with its kind behind it where the name is taken."""
    while name in taken:
        name += f" ({kind})"
    return name


def beside(taken: Iterable[str], columns: Mapping[str, Any], dims: Any, kind: str) -> dict[str, Any]:
    """Variables for columns; a name that is taken has its kind behind it."""
    found: dict[str, Any] = {}
    for name, values in columns.items():
        found[unlike(name, {*taken, *found}, kind)] = (dims, values)
    return found


def of_solution(solution: Fields) -> xarray.Dataset:
    """See :meth:`Solution.to_xarray`."""
    import xarray

    variables: dict[str, Any] = {"y": (("coordinate", "t"), solution.y)}
    variables |= beside(
        {"y", "t", "coordinate"}, {"energy": solution.energy, **solution.casimirs}, "t", "invariant"
    )
    coordinates = {"t": solution.t, "coordinate": solution.run.names}
    found = xarray.Dataset(variables, coordinates, attributes(solution.run._recorded))
    return found.assign_attrs(step=solution.step, message=solution.message)


def frame_of_solution(solution: Fields) -> pandas.DataFrame:
    """See :meth:`Solution.to_pandas`."""
    import pandas

    columns = dict(zip(solution.run.names, solution.y, strict=True))
    columns |= {name: values for name, values in {"energy": solution.energy, **solution.casimirs}.items() if name not in columns}
    return pandas.DataFrame(columns, pandas.Index(solution.t, name="t"))


def of_ensemble(ensemble: Ensemble) -> xarray.Dataset:
    """See :meth:`Ensemble.to_xarray`."""
    import xarray

    states = ("member", "coordinate")
    variables: dict[str, Any] = {
        "x": (states, ensemble.x),
        "x0": (states, ensemble.x0),
        "t": ("member", ensemble.t),
        "outcome": ("member", ensemble.outcomes),
    }
    taken = {*variables, "member", "coordinate"}
    variables |= beside(taken, ensemble.parameters, "member", "parameter")
    variables |= beside({*variables, *taken}, ensemble.observables, "member", "observable")
    variables |= {f"drift_{name}": ("member", values) for name, values in ensemble.drift.items()}
    coordinates = {"member": np.arange(len(ensemble)), "coordinate": ensemble.names}
    return xarray.Dataset(variables, coordinates, {"leafwise": version(), "outcome": ensemble.outcome})


def of_sweep(sweep: Sweep) -> xarray.Dataset:
    """See :meth:`Sweep.to_xarray`."""
    import xarray

    settings = sweep.settings
    grid = _grid(settings, len(sweep))
    dims: Any = list(grid) if grid else "setting"
    shape = [len(values) for values in grid.values()] if grid else [len(sweep)]
    measured: dict[str, Any] = {"outcome": sweep.outcomes, "error": np.array(sweep.errors, dtype=np.str_), "t": sweep.t}
    taken = {*measured, *settings}
    variables = {name: (dims, values.reshape(shape)) for name, values in measured.items()}
    for columns, kind in ((sweep.observables, "observable"), (sweep.cost, "cost")):
        shaped = {name: values.reshape(shape) for name, values in columns.items()}
        variables |= beside({*variables, *taken}, shaped, dims, kind)
    variables |= {f"drift_{name}": (dims, values.reshape(shape)) for name, values in sweep.drift.items()}
    coordinates = grid or {name: ("setting", values) for name, values in settings.items()}
    return xarray.Dataset(variables, coordinates, {"leafwise": version(), "outcome": sweep.outcome})


def _grid(settings: Mapping[str, Any], count: int) -> dict[str, Any]:
    """The values of each key where settings are all combinations of them, the last key's first; else none."""
    values: dict[str, Any] = {}
    for name, column in settings.items():
        _, first = np.unique(column, return_index=True)
        values[name] = column[np.sort(first)]
    if not values or math.prod(map(len, values.values())) != count:
        return {}
    whole = np.meshgrid(*values.values(), indexing="ij")
    is_grid = all(np.array_equal(all_.reshape(-1), column) for all_, column in zip(whole, settings.values(), strict=True))
    return values if is_grid else {}
