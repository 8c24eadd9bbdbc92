"""Axes to draw on, and lines over them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import matplotlib.axes


def axes(given: matplotlib.axes.Axes | None) -> matplotlib.axes.Axes:
    """These axes, or those of a new figure, which a notebook shows."""
    if given is not None:
        return given
    from matplotlib import pyplot

    return pyplot.subplots(layout="constrained")[1]


def chosen(names: Sequence[str], coordinates: Sequence[str], known: Iterable[str]) -> Sequence[str]:
    """These names, or the coordinates where there are none.

    Raises:
        KeyError: nothing of this name was recorded.
    """
    there = list(known)
    for name in names:
        if name not in there:
            raise KeyError(f"{name!r} was not recorded; there are {', '.join(there)}")
    return names or coordinates


def lines(
    ax: matplotlib.axes.Axes, t: Any, columns: Mapping[str, Any], apart: Iterable[str]
) -> matplotlib.axes.Axes:
    """Columns against time. Those ``apart`` have a second axis on the right where there are others too. The legend is next to the
    curves."""
    of_their_own = {name for name in columns if name in set(apart)}
    other = ax.twinx() if of_their_own and len(of_their_own) < len(columns) else ax
    drawn = []
    for at, (name, values) in enumerate(columns.items()):
        on, style = (other, "--") if name in of_their_own and other is not ax else (ax, "-")
        drawn += on.plot(t, values, style, label=name, color=f"C{(len(ax.lines) + at) % 10}" if other is not ax else None)
    ax.set_xlabel("t")
    if other is not ax:
        other.set_ylabel(", ".join(name for name in columns if name in of_their_own))
    legend = [*(line for line in ax.lines if line not in drawn), *drawn]
    ax.legend(handles=legend, loc="lower left", bbox_to_anchor=(0, 1), ncols=4, frameon=False)
    return ax
