"""Scenes."""

from __future__ import annotations

import sys
import tempfile
import warnings
from collections.abc import Callable, Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from . import _leafwise
from ._commands import command
from ._errors import IntegrationError, LeafwiseError, LeafwiseWarning
from ._leafwise import Integrator, text_of
from ._run import Run


class Scene:
    """A system, a method and a plan: what a scene file says.

    ``Scene({"system": ..., "method": ..., "run": ...})`` or ``Scene(system=..., method=..., run=...)``; arrays are
    lists. ``Scene.load`` reads a file, ``Scene.parse`` a text.

    Raises:
        SceneError: each problem with its place.
    """

    def __init__(self, table: Mapping[str, Any] | None = None, /, **sections: Any) -> None:
        whole = {**(table or {}), **sections}
        if not whole:
            raise TypeError("a scene needs sections: Scene(system=..., method=..., run=...)")
        self._hold(_leafwise.Scene(text_of(whole), "scene.toml", []))

    def _hold(self, scene: _leafwise.Scene) -> None:
        self._scene = scene
        self._described: tuple[list[str], list[str], list[tuple[str, float]], list[str]] | None = None

    @classmethod
    def parse(cls, text: str, name: str = "scene.toml", set: Mapping[str, Any] | None = None) -> Scene:
        """The scene of a text; ``set`` overrides values, as in ``{"method.epsilon": 0.05}``."""
        return cls._of(text, name, _overrides(set or {}))

    @classmethod
    def load(cls, file: str | PathLike[str], set: Mapping[str, Any] | None = None) -> Scene:
        """The scene of a file."""
        path = Path(file)
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            raise LeafwiseError(f"{path} is not UTF-8 text") from None
        return cls._of(text, fspath(path), _overrides(set or {}))

    @classmethod
    def _of(cls, text: str, name: str, overrides: list[tuple[str, str]]) -> Scene:
        scene = cls.__new__(cls)
        scene._hold(_leafwise.Scene(text, name, overrides))
        return scene

    def __reduce__(self) -> tuple[Any, ...]:
        return Scene._of, self._scene.origin

    def set(self, **values: Any) -> Scene:
        """The same scene with other values: ``scene.set(run__steps=100)``, two underscores for a dot."""
        pairs = {key.replace("__", "."): value for key, value in values.items()}
        return self._of(self.text, self.name, _overrides(pairs))

    @property
    def name(self) -> str:
        """The file's name."""
        return self._scene.name

    @property
    def text(self) -> str:
        """The scene as TOML."""
        return self._scene.text

    def _description(self) -> tuple[list[str], list[str], list[tuple[str, float]], list[str]]:
        if self._described is None:
            self._described = self._scene.describe()
        return self._described

    @property
    def variables(self) -> list[str]:
        """The names of the coordinates."""
        return self._description()[0]

    @property
    def casimirs(self) -> list[str]:
        """The names of the Casimirs."""
        return self._description()[1]

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters' values."""
        return dict(self._description()[2])

    @property
    def method(self) -> list[str]:
        """The method in words."""
        return self._description()[3]

    def run(
        self,
        *,
        steps: int | None = None,
        until: float | None = None,
        record: int | None = None,
        initial: Any = None,
        allow_non_poisson: bool = False,
        progress: bool | Callable[[int, int], object] = False,
    ) -> Run:
        """Step the scene, with every sample in memory: the same numbers as the program's.

        Args:
            steps: the number of steps.
            until: the time at the end, in place of steps, where the scene has a pace.
            record: every how many steps a sample is kept.
            initial: the initial state, shape (d,).
            allow_non_poisson: step a tensor that violates the Jacobi identity.
            progress: True for a line on standard error, or a function of the steps made and their number.

        Ctrl-C ends the run and returns what was recorded, with the outcome ``interrupted`` and a warning.

        Raises:
            SceneError: the scene is not valid.
            IntegrationError: a step could not be taken; its ``run`` holds what was recorded before.
        """
        given = {"run.steps": steps, "run.until": until, "run.record.every": record, "run.initial": initial}
        overrides = _overrides({key: value for key, value in given.items() if value is not None})
        told = _line if progress is True else progress or None
        recorded = self._scene.run(overrides, allow_non_poisson, told)
        if progress is True:
            print(file=sys.stderr)
        run = Run(recorded)
        for advice in run.warnings:
            warnings.warn(advice, LeafwiseWarning, stacklevel=2)
        if run.outcome == "interrupted":
            warnings.warn(run.message, LeafwiseWarning, stacklevel=2)
        if run.outcome == "failed":
            error = IntegrationError(run.message)
            error.run = run
            raise error
        return run

    def integrator(self) -> Integrator:
        """The method's steps from the initial state, for a loop of one's own."""
        return self._scene.integrator()

    def command(self, name: str, *arguments: str, accept: tuple[int, ...] = (0,)) -> Any:
        """The object of a command on this scene: ``scene.command("evaluate", "--at", ...)``."""
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / (Path(self.name).name or "scene.toml")
            file.write_text(self.text, encoding="utf-8")
            return command(name, file, *arguments, accept=accept)

    def check(self) -> dict[str, Any]:
        """Jacobi identity and Casimirs of the system, as ``leafwise check``. A check that fails is told, not raised."""
        found: dict[str, Any] = self.command("check", accept=(0, 5))
        return found

    def compare(self, *arguments: str) -> dict[str, Any]:
        """Cost against accuracy of methods on this scene, as ``leafwise compare``."""
        found: dict[str, Any] = self.command("compare", *arguments)
        return found

    def tune(self, error: float, *arguments: str) -> dict[str, Any]:
        """The cheapest method and step for an error, as ``leafwise tune --error``."""
        found: dict[str, Any] = self.command("tune", "--error", repr(float(error)), *arguments)
        return found

    def __repr__(self) -> str:
        return f"<leafwise.Scene {self.name}>"


def _overrides(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Keys and values as TOML."""
    return [(key, text_of({"value": value}).partition("=")[2].strip()) for key, value in values.items()]


def _line(made: int, total: int) -> None:
    print(f"\r{made} of {total} steps", end="", file=sys.stderr, flush=True)
