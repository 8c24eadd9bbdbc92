"""Ensembles and sweeps on other processes and machines, by anything with the interface of ``concurrent.futures``."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from . import _leafwise

Array = NDArray[np.float64]

#: Text, name, overrides and functions of a scene.
Origin = tuple[str, str, list[tuple[str, str]], Any, list[tuple[str, Any]]]

#: A shard's files by their names.
Files = dict[str, bytes]

#: Shards that a worker joins into one, at most.
WIDTH = 8


class Asked(Protocol):
    """Order of an ensemble or a sweep: everything that a worker needs beside a shard's number."""

    def shard(self, out: Path, place: tuple[int, int], threads: int | None) -> None:
        """Makes a shard in a directory."""

    def join(self, out: Path, shards: Path) -> None:
        """Joins shards that follow one another into a larger one."""


class AskedEnsemble(NamedTuple):
    """An ensemble."""

    origin: Origin
    overrides: list[tuple[str, str]]
    states: Array | None
    parameters: list[tuple[str, Array]]
    files: Path
    allow_non_poisson: bool

    def shard(self, out: Path, place: tuple[int, int], threads: int | None) -> None:
        """Steps the members of a shard into a directory."""
        scene, (states, parameters) = _leafwise.Scene(*self.origin), self._arrays()
        scene.shard(self.overrides, states, parameters, self.files, out, place, None, threads, self.allow_non_poisson)

    def join(self, out: Path, shards: Path) -> None:
        """Joins shards that follow one another into a larger one."""
        scene, (states, parameters) = _leafwise.Scene(*self.origin), self._arrays()
        scene.shard(self.overrides, states, parameters, self.files, out, (1, 1), shards, None, self.allow_non_poisson)

    def merge(self, out: Path, shards: Path) -> _leafwise.Ensemble:
        """The whole."""
        scene = _leafwise.Scene(*self.origin)
        return scene.ensemble(
            self.overrides, self.states, self.parameters, self.files, out, shards, None, self.allow_non_poisson, None
        )

    def _arrays(self) -> tuple[Array | None, list[tuple[str, Array]]]:
        # Arrays that have come with a message may begin anywhere.
        states = None if self.states is None else np.require(self.states, requirements="A")
        return states, [(name, np.require(values, requirements="A")) for name, values in self.parameters]


class AskedSweep(NamedTuple):
    """A sweep."""

    origin: Origin
    overrides: list[tuple[str, str]]
    allow_non_poisson: bool

    def shard(self, out: Path, place: tuple[int, int], threads: int | None) -> None:
        """Runs the settings of a shard into a directory."""
        scene = _leafwise.Scene(*self.origin)
        scene.sweep_shard(self.overrides, out, place, None, threads, self.allow_non_poisson)

    def join(self, out: Path, shards: Path) -> None:
        """Joins shards that follow one another into a larger one."""
        scene = _leafwise.Scene(*self.origin)
        scene.sweep_shard(self.overrides, out, (1, 1), shards, None, self.allow_non_poisson)

    def merge(self, out: Path, shards: Path) -> _leafwise.Sweep:
        """The whole."""
        scene = _leafwise.Scene(*self.origin)
        return scene.sweep(self.overrides, out, shards, None, self.allow_non_poisson, None)


def _read(folder: Path) -> Files:
    return {file.name: file.read_bytes() for file in folder.iterdir() if not file.name.startswith(".")}


def _write(parts: Sequence[Files], folder: Path) -> Path:
    for number, files in enumerate(parts):
        part = folder / f"part-{number:06}"
        part.mkdir(parents=True)
        for name, content in files.items():
            (part / name).write_bytes(content)
    return folder


def shard(asked: Asked, number: int, of: int, threads: int | None) -> Files:
    """The files of one shard: a worker's task. They depend on the order alone."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "shard"
        asked.shard(out, (number, of), threads)
        return _read(out)


def join(asked: Asked, parts: Sequence[Files]) -> Files:
    """The files of the shard that these make together: a worker's task."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "shard"
        asked.join(out, _write(parts, Path(folder) / "parts"))
        return _read(out)


def ensemble(
    asked: AskedEnsemble, executor: Any, shards: int, threads: int | None, told: Callable[[int, int], object] | None
) -> _leafwise.Ensemble:
    """An ensemble in shards on the workers of an executor."""
    with tempfile.TemporaryDirectory() as folder:
        parts = _write(joined(asked, executor, shards, threads, told), Path(folder) / "parts")
        return asked.merge(Path(folder) / "ensemble", parts)


def sweep(
    asked: AskedSweep, executor: Any, shards: int, threads: int | None, told: Callable[[int, int], object] | None
) -> _leafwise.Sweep:
    """A sweep in shards on the workers of an executor."""
    with tempfile.TemporaryDirectory() as folder:
        parts = _write(joined(asked, executor, shards, threads, told), Path(folder) / "parts")
        return asked.merge(Path(folder) / "sweep", parts)


def joined(
    asked: Asked, executor: Any, shards: int, threads: int | None, told: Callable[[int, int], object] | None
) -> list[Files]:
    """The shards, joined by the workers in groups of neighbours until a few are left.

    The tree depends on the number of shards alone; results do not depend on it. ``told`` is called with the numbers of
    finished shards and of all.
    """
    # A client of Dask makes one.
    get = getattr(executor, "get_executor", None)
    if get is None and not callable(getattr(executor, "submit", None)):
        raise TypeError(f"executor is of {type(executor).__name__}: give anything with submit, as concurrent.futures.ProcessPoolExecutor()")
    workers: Executor = get() if get else executor
    counts = [shards]
    while counts[-1] > WIDTH:
        counts.append(-(-counts[-1] // WIDTH))
    pending: dict[Future[Files], tuple[int, int]] = {
        workers.submit(shard, asked, number, shards, threads): (0, number - 1) for number in range(1, shards + 1)
    }
    done: dict[tuple[int, int], Files] = {}
    made = 0
    try:
        while pending:
            for future in wait(pending, return_when=FIRST_COMPLETED).done:
                level, at = pending.pop(future)
                done[level, at] = future.result()
                if level == 0:
                    made += 1
                    if told:
                        told(made, shards)
                group = at // WIDTH
                parts = [(level, k) for k in range(WIDTH * group, min(WIDTH * (group + 1), counts[level]))]
                if level + 1 < len(counts) and all(part in done for part in parts):
                    task = workers.submit(join, asked, [done.pop(part) for part in parts])
                    pending[task] = (level + 1, group)
    except BaseException:
        for future in pending:
            future.cancel()
        raise
    return [done[len(counts) - 1, at] for at in range(counts[-1])]
