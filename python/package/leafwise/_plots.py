"""Axes to draw on."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import matplotlib.axes


def axes(given: matplotlib.axes.Axes | None) -> matplotlib.axes.Axes:
    """These axes, or those of a new figure, which a notebook shows."""
    if given is not None:
        return given
    from matplotlib import pyplot

    return pyplot.subplots(layout="constrained")[1]
