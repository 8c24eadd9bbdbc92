"""Systems of functions of Python."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import names, number, short, table
from ._errors import LeafwiseWarning

Array = NDArray[np.float64]

#: Names that stand beside the coordinates in what is recorded.
_TAKEN = {"t", "time", "energy"}


class System:
    """A Poisson system ẋ = {H, x} = −Π(x)∇H(x), Π_ij = {x_i, x_j}, by functions of NumPy arrays.

    d is the number of coordinates, m that of the points a function is called with, a column each.

    Args:
        variables: the coordinates' names.
        hamiltonian: H(x), shape (d, m) to (m,).
        gradient: ∇H(x), (d, m) to (d, m) or a list of d rows.
        tensor: Π(x)p, (d, m) and (d, m) to (d, m) or a list of d rows.
        casimirs: functions as ``hamiltonian``, by name.
        parameters: values by name; every function takes them as keyword arguments behind x and p.

    A scene takes it as its system: ``lw.Scene(system=system, method=..., run=...)``. It is a system of numbers: each
    evaluation calls Python, and a step takes fifty to four hundred times as long as one of formulas. A warning says so.

    Raises:
        TypeError, ValueError: a function is none, or a name is no name.
    """

    def __init__(
        self,
        *,
        variables: Sequence[str],
        hamiltonian: Callable[..., Any],
        gradient: Callable[..., Any],
        tensor: Callable[..., Any],
        casimirs: Mapping[str, Callable[..., Any]] | None = None,
        parameters: Mapping[str, float] | None = None,
    ) -> None:
        self.variables = names("variables", variables)
        self._casimirs = table("casimirs", casimirs)
        self.parameters = {name: number(name, value) for name, value in table("parameters", parameters).items()}
        self._functions = {"hamiltonian": hamiltonian, "gradient": gradient, "tensor": tensor}
        for name, function in {**self._functions, **self._casimirs}.items():
            if not callable(function):
                raise TypeError(f"{name} is {short(function)}, not a function")
        if not self.variables:
            raise ValueError("a system needs variables")
        seen: set[str] = set()
        for name in [*self.variables, *self._casimirs, *self.parameters]:
            if not (isinstance(name, str) and name.isascii() and name.isidentifier()):
                raise ValueError(f"{short(name)} is no name")
            if name in _TAKEN or name in seen:
                raise ValueError(f"the name {name!r} is taken")
            seen.add(name)
        warnings.warn(
            "a system of Python functions calls them at every step: formulas of a scene are fifty to four hundred times faster",
            LeafwiseWarning,
            stacklevel=2,
        )

    @property
    def casimirs(self) -> list[str]:
        """The names of the Casimirs."""
        return list(self._casimirs)

    @property
    def _parameters(self) -> list[tuple[str, float]]:
        return list(self.parameters.items())

    def _values(self, function: str, parameters: list[float], count: int, y: Array, v: Array | None) -> Array:
        """``count`` numbers, point after point, at the points y and vectors v, of which one serves all where there is but one."""
        d = len(self.variables)
        rows = {"hamiltonian": 1, "casimirs": len(self._casimirs)}.get(function, d)
        points = count // rows
        given = [np.ascontiguousarray(np.broadcast_to(x.reshape(-1, d), (points, d)).T) for x in (y, v) if x is not None]
        named = dict(zip(self.parameters, parameters, strict=True))
        if function == "casimirs":
            found = [_reals(name, own(*given, **named), (points,)) for name, own in self._casimirs.items()]
            return np.stack(found, axis=1).reshape(-1)
        shape = (points,) if function == "hamiltonian" else (d, points)
        return np.ascontiguousarray(_reals(function, self._functions[function](*given, **named), shape).T).reshape(-1)

    def __repr__(self) -> str:
        return f"<leafwise.System of functions of {', '.join(self.variables)}>"


def _reals(name: str, found: Any, shape: tuple[int, ...]) -> Array:
    """The result of a function, as doubles of this shape; a number, or a row of them, may stand for all points."""
    if isinstance(found, (list, tuple)):
        found = np.stack([np.broadcast_to(row, shape[1:]) for row in found])
    values = np.asarray(found)
    if values.dtype.kind not in "iuf":
        raise TypeError(f"{name} returned {values.dtype}, not real numbers")
    if values.shape != shape and values.ndim:
        raise ValueError(f"{name} returned the shape {values.shape} where {shape} is needed")
    return np.broadcast_to(values.astype(np.float64), shape)
