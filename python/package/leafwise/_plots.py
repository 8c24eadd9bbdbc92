"""Axes to draw on; lines, maps of lattices and paths of bodies over them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import matplotlib.axes

Array = NDArray[np.float64]

#: The letters of axes.
_LETTERS = "ijk"

#: The most arrows across and up, and the most bodies with names.
_MOST_ARROWS = 20
_MOST_NAMES = 10

#: Longer planes than so many times their width have cells that are no squares.
_LONGEST = 8


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


def place_of(names: Sequence[str], family: str) -> tuple[slice, tuple[int, ...]]:
    """Where the coordinates of a family stand among recorded ones, and the lengths of its axes.

    Raises:
        KeyError: not all of them are there.
    """
    own = [at for at, name in enumerate(names) if name.startswith(f"{family}[")]
    if not own:
        known = dict.fromkeys(name.partition("[")[0] for name in names if "[" in name)
        raise KeyError(f"{family!r} was not recorded; there are {', '.join(known) or 'no families'}")
    lengths = tuple(int(index) + 1 for index in names[own[-1]][len(family) + 1 : -1].split(","))
    if len(own) != int(np.prod(lengths)) or own[-1] - own[0] + 1 != len(own):
        raise KeyError(f'{family!r} was not recorded at every site: record = {{ states = "all" }}')
    return slice(own[0], own[-1] + 1), lengths


def plane_of(field: Array, cut: tuple[str, int] | None) -> tuple[Array, str]:
    """A field of two axes, or a plane of one of three axes, and the letters of its axes.

    Raises:
        ValueError: it has one axis, or no such plane.
    """
    if field.ndim == 1:
        raise ValueError("the lattice has one axis: plot `field` over the sites")
    if field.ndim == len(_LETTERS):
        letter, at = cut or ("k", field.shape[-1] // 2)
        axis = _LETTERS.find(letter) if len(letter) == 1 else -1
        if axis < 0 or not 0 <= at < field.shape[axis]:
            raise ValueError(f"{letter} = {at} is no plane of a lattice of {' × '.join(map(str, field.shape))} sites")
        return np.take(field, [at], axis=axis).squeeze(axis), _LETTERS.replace(letter, "")
    if cut is not None:
        raise ValueError("a lattice of two axes has no slices")
    return field, _LETTERS[:2]


def colours(ax: matplotlib.axes.Axes, planes: Sequence[tuple[Array, str]], name: str, title: str) -> matplotlib.axes.Axes:
    """The first field in colour, its first axis across; two more as arrows, of some of the sites."""
    from matplotlib.ticker import MaxNLocator

    fields, letters = [field for field, _ in planes], planes[0][1]
    value, arrows = fields[0], fields[1:]
    most = float(np.sqrt(sum(part**2 for part in fields)).max()) if arrows else None
    across, up = value.shape
    ratio = min(max(across / up, 1 / _LONGEST), _LONGEST)
    # Cells stand about their sites' numbers; the aspect is the height of a cell over its width.
    image = ax.imshow(value.T, origin="lower", aspect=across / up / ratio, vmin=None if most is None else -most, vmax=most)
    for axis, sites in ((ax.xaxis, across), (ax.yaxis, up)):
        axis.set_major_locator(MaxNLocator("auto", steps=[1, 2, 5, 10], integer=True, min_n_ticks=min(sites, 3)))
    if arrows:
        every = [-(-length // _MOST_ARROWS) for length in value.shape]
        places = [np.arange(step // 2, length, step) for step, length in zip(every, value.shape)]
        x, y = np.meshgrid(*places, indexing="ij")
        # An arrow is at most as long as the nearer of two is far, across: cells are as wide as 1.
        apart = min(every[0], every[1] * across / up / ratio)
        ax.quiver(x, y, *(part[x, y] for part in arrows), pivot="middle", scale=most / apart if most else None, scale_units="x", color="w", edgecolor="k", linewidth=0.4)
    ax.figure.colorbar(image, ax=ax, label=name)
    ax.set(title=title, xlabel=letters[0], ylabel=letters[1])
    return ax


def paths(ax: matplotlib.axes.Axes, x: Array, y: Array, names: tuple[str, str]) -> matplotlib.axes.Axes:
    """A line for each column, with a disc where it begins and a ring where it is last. More columns than have names have a scale of
    colours."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    count = x.shape[1]
    scale = ScalarMappable(Normalize(0, max(count - 1, 1)), colormaps["viridis"])
    for body in range(count):
        color = f"C{body}" if count <= _MOST_NAMES else scale.cmap(body / max(count - 1, 1))
        ax.plot(x[:, body], y[:, body], linewidth=1, color=color, label=f"{body}")
        ax.plot(x[:1, body], y[:1, body], "o", color=color, markersize=4)
        ax.plot(x[-1:, body], y[-1:, body], "o", color=color, markerfacecolor="w", markersize=5)
    ax.set(xlabel=names[0], ylabel=names[1], aspect="equal")
    if count <= _MOST_NAMES:
        ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=5, frameon=False)
    else:
        ax.figure.colorbar(scale, ax=ax, label="body")
    return ax
