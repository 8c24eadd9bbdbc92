"""Equilibria of tokamaks as scenes."""

from __future__ import annotations

from dataclasses import dataclass, field
from os import PathLike, fspath
from typing import Any, Literal

from ._arrays import count, number
from ._commands import command
from ._scene import Scene


@dataclass(frozen=True)
class Equilibrium:
    """A tokamak's field, and the scene of guiding centres in it.

    Attributes:
        scene: the scene, of the file that was written.
        title: the title of the g-file.
        nodes: the nodes along R and Z.
        axis: R and Z of the magnetic axis, in m.
        field_on_axis: B_R, B_Z and B_phi there, in T.
        safety_factors: for four surfaces the normalized flux ``s``, the safety factor ``q`` of the field, and that ``in_file``.
        has_edge: whether the edge, s = 1, is closed inside the grid.
        warnings: where the tables do not follow the file, and an edge that is not closed.
    """

    scene: Scene = field(repr=False)
    title: str
    nodes: tuple[int, int]
    axis: tuple[float, float]
    field_on_axis: tuple[float, float, float]
    safety_factors: list[dict[str, float | None]]
    has_edge: bool
    warnings: tuple[str, ...]


def import_equilibrium(
    file: str | PathLike[str],
    out: str | PathLike[str],
    *,
    species: Literal["proton", "deuteron", "triton", "alpha", "electron"] = "deuteron",
    energy: float = 10.0,
    pitch: float = 0.5,
    surface: float = 0.5,
    members: int = 0,
    seed: int = 1,
    degree: int = 5,
) -> Equilibrium:
    """Write a scene of guiding centres in a tokamak's equilibrium, from a g-file of EFIT.

    Args:
        file: the g-file, with psi(R, Z) in Wb/rad and F = R B_phi in T m.
        out: the new directory of ``scene.toml`` and its tables.
        species: the particles.
        energy: their kinetic energy, in keV.
        pitch: the speed along the field as a part of the speed, from -1 to 1, of the single particle of a run.
        surface: the normalized flux of the surface where they start, between 0, the axis, and 1, the edge.
        members: particles of an ensemble, uniform on the surface and in the pitch; 0 for none.
        seed: the seed of their draws.
        degree: the degree of the splines, 2 to 9.

    Returns:
        The scene, and what is known of the field.

    Raises:
        LeafwiseError: a file that is no g-file, an option out of range, and a directory that holds a scene.
        TypeError, ValueError: an argument is none.
    """
    options: dict[str, Any] = {
        "species": fspath(species),
        "energy": repr(number("energy", energy)),
        "pitch": repr(number("pitch", pitch)),
        "surface": repr(number("surface", surface)),
        "members": str(count("members", members, 0)),
        "seed": str(count("seed", seed, 0)),
        "degree": str(count("degree", degree, 2)),
    }
    told: dict[str, Any] = command(
        "import", "--out", fspath(out), *(f"--{name}={value}" for name, value in options.items()), fspath(file)
    )
    return Equilibrium(
        scene=Scene.load(told["scene"]),
        title=told["title"],
        nodes=tuple(told["nodes"]),
        axis=tuple(told["axis"]),
        field_on_axis=tuple(told["field_on_axis"]),
        safety_factors=told["safety_factors"],
        has_edge=told["has_edge"],
        warnings=tuple(told["warnings"]),
    )
