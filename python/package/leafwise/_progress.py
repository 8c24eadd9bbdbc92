"""Progress of a run, while it runs."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

#: Seconds before a bar appears that nobody asked for.
_PATIENCE = 0.5

_WIDTH = 30

Told = Callable[[int, int], object]


class _Bar:
    """A line on a terminal: the part that is done, and the time that is left."""

    def __init__(self, stream: TextIO, patience: float) -> None:
        self._stream, self._begun = stream, time.monotonic()
        self._patience, self._is_shown = patience, False

    def __call__(self, made: int, total: int) -> None:
        passed = time.monotonic() - self._begun
        if passed < self._patience or made == 0:
            return
        part = min(made / total, 1.0)
        bar = ("#" * round(_WIDTH * part)).ljust(_WIDTH)
        left = passed * (1 - part) / part
        line = f"\r[{bar}] {100 * part:3.0f} %, {made / passed:.3g} steps a second, {left:.0f} s left"
        print(line.ljust(78), end="", file=self._stream, flush=True)
        self._is_shown = True

    def end(self) -> None:
        if self._is_shown:
            print(file=self._stream, flush=True)


@contextmanager
def shown(progress: bool | Told | None) -> Iterator[Told | None]:
    """The function that hears how far a run is; a bar on standard error where True, or None on a terminal."""
    if callable(progress):
        yield progress
        return
    if not (progress or (progress is None and sys.stderr is not None and sys.stderr.isatty())):
        yield None
        return
    bar = _Bar(sys.stderr, 0.0 if progress else _PATIENCE)
    try:
        yield bar
    finally:
        bar.end()
