"""Functional mock-up units of scenes."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from ._scene import Scene


@dataclass(frozen=True)
class Fmu:
    """A functional mock-up unit, FMI 3.0 for co-simulation.

    Attributes:
        file: the unit's file.
        library: the library that is within.
        platform: where it runs: ``"x86_64-linux"``.
        token: what its description and its scene have in common.
        time_step: the time of a step: communication steps are multiples of it.
        variables: names, in the order of their numbers: the time, parameters, coordinates, energy and Casimirs.
    """

    file: Path
    library: Path
    platform: str
    token: str
    time_step: float
    variables: tuple[str, ...]


def write_fmu(scene: Scene, out: str | PathLike[str], *, library: str | PathLike[str]) -> Fmu:
    """Write a scene as a functional mock-up unit, FMI 3.0 for co-simulation, as ``leafwise fmu``.

    Args:
        scene: gives the system, the method with its step, and the initial state.
        out: the unit's file, ``name.fmu``; one that exists is left as it is.
        library: ``libleafwise_c.so``, built by ``cargo build --release -p leafwise-c``.

    Returns:
        The contents of the unit.

    Raises:
        LeafwiseError: the file exists, the library is not there, or the scene does not stand alone.
        TypeError: an argument is none.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"scene is of {type(scene).__name__}: give a leafwise.Scene")
    report: dict[str, Any] = scene.command("fmu", "--out", fspath(out), "--library", fspath(library))
    return Fmu(
        file=Path(report["file"]),
        library=Path(report["library"]),
        platform=report["platform"],
        token=report["token"],
        time_step=report["time_step"],
        variables=tuple(report["variables"]),
    )
