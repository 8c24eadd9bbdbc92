"""Events of a solution: surfaces that it crosses."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple


class Event(NamedTuple):
    """A surface ``left = right``, the direction of its crossings, and the crossing that ends the solution, from 1 on."""

    at: str
    direction: str
    last: int | None


def events_of(given: Any) -> list[Event]:
    """One event or several, each a formula or a table ``{"at": "q = 0", "direction": "up", "terminal": True}``.

    Raises:
        TypeError, ValueError: one is none of these.
    """
    if isinstance(given, (str, Mapping)) or callable(given):
        given = [given]
    if not isinstance(given, Iterable):
        raise TypeError(f'events is {given!r}, not a list of formulas as ["q = 0"]')
    return [_event(f"events[{at}]", one) for at, one in enumerate(given)]


def _event(name: str, given: Any) -> Event:
    if isinstance(given, str):
        return Event(given, "both", None)
    if callable(given):
        raise TypeError(f'{name} is a function; events are formulas of the coordinates, as "q = 0" for SciPy\'s lambda t, y: y[0]')
    if not isinstance(given, Mapping):
        raise TypeError(f'{name} is {given!r}, not a formula as "q = 0"')
    unknown = [key for key in given if key not in ("at", "direction", "terminal")]
    if unknown or "at" not in given:
        wrong = f"has no {unknown[0]!r}" if unknown else "needs the formula"
        raise ValueError(f'{name} {wrong}: write {{"at": "q = 0", "direction": "up", "terminal": True}}')
    if not isinstance(given["at"], str):
        raise TypeError(f'{name} is at {given["at"]!r}, not at a formula as "q = 0"')
    return Event(given["at"], _direction(name, given.get("direction", "both")), _last(name, given.get("terminal", False)))


def _direction(name: str, given: Any) -> str:
    if given in ("up", "down", "both"):
        return str(given)
    if isinstance(given, (int, float)) and not isinstance(given, bool):
        return "up" if given > 0 else "down" if given < 0 else "both"
    raise ValueError(f'{name} has the direction {given!r}: "up", "down" or "both", or SciPy\'s 1, -1 and 0')


def _last(name: str, given: Any) -> int | None:
    if isinstance(given, bool):
        return 1 if given else None
    if isinstance(given, int) and given >= 1:
        return given
    if given is None or given == 0:
        return None
    raise ValueError(f"{name} is terminal {given!r}: True, or the number of the crossing that ends the solution")
