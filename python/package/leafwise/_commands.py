"""The program's commands and their JSON."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from os import PathLike, fspath
from typing import Any

from ._errors import LeafwiseError, SceneError
from ._leafwise import command as _command, load_plugin as _load_plugin, start_again_by

if sys.executable:
    # What tries a plugin is a process of its own.
    start_again_by(sys.executable, ["-m", "leafwise"])

#: The exit code of a scene that is not valid.
_INVALID_SCENE = 3


def command(*arguments: str | PathLike[str], accept: Sequence[int] = (0,)) -> Any:
    """The object that a command of the program prints with ``--json``.

    ``command("verify", "scene.toml")`` is ``leafwise verify scene.toml --json``.

    Raises:
        SceneError: the scene is not valid.
        LeafwiseError: any other exit code that is not in ``accept``.
    """
    code, out, err = _command([*(fspath(argument) for argument in arguments), "--json"])
    if code not in accept:
        raise (SceneError if code == _INVALID_SCENE else LeafwiseError)(err.strip().removeprefix("error: "))
    return json.loads(out)


def list_parts() -> dict[str, Any]:
    """All parts and systems, as ``leafwise list``."""
    found: dict[str, Any] = command("list")
    return found


def describe(part: str) -> dict[str, Any]:
    """A part or system with its parameters, as ``leafwise describe``."""
    found: dict[str, Any] = command("describe", part)
    return found


def load_plugin(path: str | PathLike[str]) -> None:
    """Load the parts of a plugin, a library's path or a name in the search path; every scene and command after it knows them.

    A library runs in this process, after it was tried in a separate one. A scene may also name it: ``plugins = ["path"]``.

    Raises:
        LeafwiseError: it is refused, with the reason.
    """
    _load_plugin(fspath(path))
