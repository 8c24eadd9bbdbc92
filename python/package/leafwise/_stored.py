"""Result of the compiled part of the package, as an object that can be stored and sent to other processes."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any


class Stored(SimpleNamespace):
    """The fields of an object of the compiled part, and what its methods without arguments return."""


def stored(native: Any) -> Any:
    """The object as one that can be stored."""
    if isinstance(native, Stored):
        return native
    names = [name for name in dir(native) if not name.startswith("_")]
    fields = {name: getattr(native, name) for name in names}
    return Stored(**{name: Returned(field()) if callable(field) else field for name, field in fields.items()})


class Returned:
    """A function without arguments that returns what another has returned."""

    def __init__(self, value: Any) -> None:
        self.value = value

    def __call__(self) -> Any:
        return self.value


def reduced(self: Any, native: str) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """How an object that holds one of the compiled part under this name is stored."""
    return _again, (type(self), {**vars(self), native: stored(getattr(self, native))})


def _again(kind: type[Any], fields: dict[str, Any]) -> Any:
    found = object.__new__(kind)
    vars(found).update(fields)
    return found
