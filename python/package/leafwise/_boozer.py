"""Fields of stellarators in Boozer coordinates as scenes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike, fspath
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

import numpy as np

from ._arrays import count, number, reals
from ._booz_xform import field_of, is_booz_xform
from ._commands import command
from ._scene import Scene

#: Profiles over the surfaces.
_PROFILES = ("s", "iota", "G", "I")


@dataclass(frozen=True)
class BoozerField:
    """A field in Boozer coordinates, and the scene of guiding centres in it.

    Attributes:
        scene: the scene, of the file that was written.
        nodes: the surfaces, and the nodes of theta and zeta on each.
        periods: the field periods.
        field_on_axis: the field strength on the axis, in T.
        field_range: the least and the largest field strength, in T.
        iota: the rotational transform on the axis and at the edge.
        is_axisymmetric: whether the field strength is the same at every zeta.
        warnings: nodes that were left out, and where the tables leave the numbers of the surfaces.
    """

    scene: Scene = field(repr=False)
    nodes: tuple[int, int, int]
    periods: int
    field_on_axis: float
    field_range: tuple[float, float]
    iota: tuple[float, float]
    is_axisymmetric: bool
    warnings: tuple[str, ...]


def import_boozer(
    source: str | PathLike[str] | Mapping[str, Any],
    out: str | PathLike[str],
    *,
    species: Literal["proton", "deuteron", "triton", "alpha", "electron"] = "deuteron",
    energy: float = 10.0,
    pitch: float = 0.5,
    surface: float = 0.5,
    members: int = 0,
    seed: int = 1,
    nodes: int = 65,
    degree: int = 5,
) -> BoozerField:
    """Write a scene of guiding centres in a field in Boozer coordinates.

    Args:
        source: the field: a mapping, a dataset of xarray, or the path of a file in JSON or NetCDF, which needs xarray or SciPy. Its
            entries are ``periods`` and ``psi``, the toroidal flux at the edge over 2 pi in Wb/rad. On the surfaces they are ``s``,
            ``iota``, ``G`` and ``I`` in T m. ``B`` in T is over surfaces, theta and zeta. ``I`` is 0 where it is left out. Or its
            entries have the names of booz_xform, ``bmnc_b``, ``ixm_b``, …, as those of a file ``boozmn_*.nc``.
        out: the new directory of ``scene.toml`` and its tables.
        species: the particles.
        energy: their kinetic energy, in keV.
        pitch: the speed along the field as a part of the speed, from -1 to 1, of the single particle of a run.
        surface: s where they start, between 0, the axis, and 1, the edge.
        members: particles of an ensemble, uniform on the surface and in the pitch; 0 for none.
        seed: the seed of their draws.
        nodes: nodes of the table of B across the disk, along x and along y, 16 to 513.
        degree: the degree of the splines, 2 to 9.

    Returns:
        The scene, and what is known of the field.

    Raises:
        LeafwiseError: numbers that are no field, an option out of range, and a directory that holds a scene.
        TypeError, ValueError: an argument is none.
    """
    options: dict[str, Any] = {
        "species": fspath(species),
        "energy": repr(number("energy", energy)),
        "pitch": repr(number("pitch", pitch)),
        "surface": repr(number("surface", surface)),
        "members": str(count("members", members, 0)),
        "seed": str(count("seed", seed, 0)),
        "nodes": str(count("nodes", nodes, 16)),
        "degree": str(count("degree", degree, 2)),
    }
    arguments = [f"--{name}={value}" for name, value in options.items()]
    with TemporaryDirectory() as folder:
        told: dict[str, Any] = command("import", "--out", fspath(out), *arguments, _file(source, Path(folder)))
    return BoozerField(
        scene=Scene.load(told["scene"]),
        nodes=tuple(told["nodes"]),
        periods=told["periods"],
        field_on_axis=told["field_on_axis"],
        field_range=tuple(told["field"]),
        iota=tuple(told["iota"]),
        is_axisymmetric=told["is_axisymmetric"],
        warnings=tuple(told["warnings"]),
    )


def _file(source: Any, folder: Path) -> str:
    """The JSON file of a field, written into a folder unless it is one."""
    if not isinstance(source, Mapping):
        path = fspath(source)
        if not str(path).endswith((".nc", ".nc4", ".cdf")):
            return str(path)
        return _written(_dataset(str(path)), folder)
    return _written(source, folder)


def _dataset(path: str) -> Mapping[Any, Any]:
    """The variables of a NetCDF file, by xarray, or by SciPy, which reads the third version of the format."""
    try:
        import xarray
    except ImportError:
        try:
            from scipy.io import netcdf_file
        except ImportError:
            raise ImportError(f"{path} is NetCDF: reading it needs xarray with netCDF4, or SciPy") from None
        with netcdf_file(path, "r", mmap=False) as file:
            return {name: np.array(variable.data) for name, variable in file.variables.items()}
    with xarray.open_dataset(path, decode_times=False) as dataset:
        loaded: Mapping[Any, Any] = dataset.load()
        return loaded


def _written(source: Mapping[Any, Any], folder: Path) -> str:
    if is_booz_xform(source):
        source = field_of(source)
    attributes: Mapping[str, Any] = getattr(source, "attrs", {})
    missing = [name for name in ("periods", "psi", "s", "iota", "G", "B") if name not in source and name not in attributes]
    if missing:
        raise ValueError(f"the field has no {', '.join(missing)}: it has periods, psi, s, iota, G, I and B")
    strength: Any = source["B"]
    if {"s", "theta", "zeta"} == set(getattr(strength, "dims", ())):
        strength = strength.transpose("s", "theta", "zeta")
    single = {name: source[name] if name in source else attributes[name] for name in ("periods", "psi")}
    single = {name: value.item() if hasattr(value, "item") else value for name, value in single.items()}
    profiles = {name: reals(name, source[name], None).tolist() for name in _PROFILES if name in source}
    np.save(folder / "B.npy", reals("B", strength, None, None, None))
    told = {"periods": count("periods", single["periods"], 1), "psi": number("psi", single["psi"]), **profiles, "B": "B.npy"}
    file = folder / "field.json"
    file.write_text(json.dumps(told), encoding="utf-8")
    return str(file)
