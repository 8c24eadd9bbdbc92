"""Ensembles on other processes and machines, by anything with the interface of ``concurrent.futures``."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from concurrent.futures import Executor, Future, as_completed
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _leafwise

Array = NDArray[np.float64]

#: Text, name, overrides and functions of a scene.
Origin = tuple[str, str, list[tuple[str, str]], Any]


class Asked(NamedTuple):
    """What an ensemble is asked for; everything that a worker needs beside a shard's number."""

    origin: Origin
    overrides: list[tuple[str, str]]
    states: Array | None
    parameters: list[tuple[str, Array]]
    files: Path
    allow_non_poisson: bool


def shard(asked: Asked, number: int, of: int, threads: int | None) -> dict[str, bytes]:
    """The files of one shard, which depend on what is asked for alone: a worker's task."""
    scene = _leafwise.Scene(*asked.origin)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "shard"
        scene.shard(
            asked.overrides, asked.states, asked.parameters, asked.files, out, (number, of), threads, asked.allow_non_poisson
        )
        return {file.name: file.read_bytes() for file in out.iterdir() if not file.name.startswith(".")}


def ensemble(
    asked: Asked,
    executor: Any,
    shards: int,
    threads: int | None,
    told: Callable[[int, int], object] | None,
) -> _leafwise.Ensemble:
    """The shards of an ensemble on the workers of an executor, merged here."""
    # A client of Dask makes one.
    get = getattr(executor, "get_executor", None)
    workers: Executor = get() if get else executor
    with tempfile.TemporaryDirectory() as folder:
        parts = Path(folder) / "shards"
        pending: dict[Future[dict[str, bytes]], int] = {
            workers.submit(shard, asked, number, shards, threads): number for number in range(1, shards + 1)
        }
        try:
            for count, done in enumerate(as_completed(pending), 1):
                part = parts / f"shard-{pending[done]}"
                part.mkdir(parents=True)
                for name, content in done.result().items():
                    (part / name).write_bytes(content)
                if told:
                    told(count, shards)
        except BaseException:
            for future in pending:
                future.cancel()
            raise
        return _leafwise.Scene(*asked.origin).merge(
            asked.overrides, asked.states, asked.parameters, asked.files, Path(folder) / "ensemble", parts, asked.allow_non_poisson
        )
