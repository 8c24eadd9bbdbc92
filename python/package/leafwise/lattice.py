"""Spins of a lattice as arrays: structure factors, correlations, and files that other programs read.

    from leafwise import lattice

    s = lattice.vectors(np.load("runs/hot/states.npy"), (64, 64))     # (samples, 3, 64, 64)
    S = lattice.structure_factor(s)                                   # (3, 64, 64), a row for each component
    omega, S = lattice.dynamic_structure_factor(s, dt=0.5)            # (samples,), (samples, 3, 64, 64)
    C = lattice.correlation(s)                                        # (64, 64), C[0, 0] = <|s|^2>
    lattice.write_xyz("hot.xyz", s)                                   # OVITO, ASE
    lattice.write_ovf("last.ovf", s[-1])                              # OOMMF, mumax3, Spirit
    lattice.write_vti("last.vti", s[-1])                              # ParaView

Axes are those of the scene, all of them periodic for what is transformed. Wave numbers q of an axis are
``lattice.wave_numbers(length)``, in radians a site, frequencies in radians a unit of time.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

__all__ = [
    "correlation",
    "dynamic_structure_factor",
    "structure_factor",
    "vectors",
    "wave_numbers",
    "write_ovf",
    "write_vti",
    "write_xyz",
]

_MOST_AXES = 3


def vectors(x: ArrayLike, lengths: Sequence[int], components: int = 3, first: int = 0) -> Array:
    """States (..., d) as vectors (..., components, *lengths).

    A family of vectors stands component after component, the last axis fastest. ``first`` is the place of its first
    coordinate where other families stand before it, all of the same lattice.
    """
    states = np.asarray(x, dtype=float)
    sites = int(np.prod(lengths))
    count = components * sites
    if states.ndim == 0 or states.shape[-1] < first + count:
        found = states.shape[-1] if states.ndim else 1
        raise ValueError(
            f"{components} components on {tuple(lengths)} sites are {count} coordinates from {first} on, and a state has {found}"
        )
    if first % sites or states.shape[-1] % sites:
        raise ValueError(
            f"families on {tuple(lengths)} sites have {sites} coordinates a component: a state of {states.shape[-1]}, from {first} on, "
            "is of another lattice"
        )
    return states[..., first : first + count].reshape(*states.shape[:-1], components, *lengths)


def wave_numbers(length: int) -> Array:
    """The wave numbers q of an axis in the order of the factors, from -pi to pi: (length,)."""
    return np.asarray(2 * np.pi * np.fft.fftfreq(length), dtype=np.float64)


def structure_factor(s: ArrayLike) -> Array:
    """S_c(q) = <|sum_r s_c(r) exp(-i q r)|^2>/N, the mean over samples (samples, components, *lengths).

    Returns (components, *lengths); its mean over q is <s_c^2>.
    """
    samples = _samples(s)
    axes = _axes(samples)
    transformed = np.fft.fftn(samples, axes=axes)
    return np.asarray((np.abs(transformed) ** 2).mean(axis=0) / _sites(samples), dtype=np.float64)


def dynamic_structure_factor(s: ArrayLike, dt: float, window: bool = True) -> tuple[Array, Array]:
    """Frequencies omega and S_c(q, omega) = |sum_{r,t} w(t) s_c(r, t) exp(-i (q r - omega t))|^2/(N sum_t w(t)^2) of samples at distances ``dt``.

    ``s`` and S have the shape (samples, components, *lengths), the frequencies (samples,), in the order of ``numpy.fft``.
    w is Hann's window, or 1 without ``window``. A wave cos(k r - w t) has its peaks at
    (k, w) and (-k, -w). The mean over omega is the structure factor of the samples, weighted by w^2.
    """
    samples = _samples(s)
    count = samples.shape[0]
    if count < 2:
        raise ValueError("frequencies need two samples or more")
    if not dt > 0:
        raise ValueError(f"the time between samples must be positive, found {dt!r}")
    weights = np.sin(np.pi * (np.arange(count) + 0.5) / count) ** 2 if window else np.ones(count)
    weighted = samples * weights.reshape(-1, *[1] * (samples.ndim - 1))
    in_space = np.fft.fftn(weighted, axes=_axes(samples))
    transformed = np.fft.ifft(in_space, axis=0) * count
    power = np.abs(transformed) ** 2 / (_sites(samples) * (weights**2).sum())
    omega = np.asarray(2 * np.pi * np.fft.fftfreq(count, dt), dtype=np.float64)
    return omega, np.asarray(power, dtype=np.float64)


def correlation(s: ArrayLike) -> Array:
    """C(r) = <s(x) . s(x + r)>, the mean over sites x and samples: (*lengths)."""
    total = structure_factor(s).sum(axis=0)
    return np.fft.ifftn(total).real


def write_xyz(
    path: str | PathLike[str], s: ArrayLike, times: Iterable[float] | None = None, species: str = "Fe", periodic: bool = True
) -> None:
    """Write samples (samples, components, *lengths) as extended XYZ, a frame each: an atom a site at its place, its vector as ``spin``.

    ``periodic`` is what the frames say of all their axes.
    """
    samples = _samples(s)
    frames = list(times) if times is not None else [None] * len(samples)
    if len(frames) != len(samples):
        raise ValueError(f"{len(frames)} times for {len(samples)} states")
    lengths = _lengths(samples)
    places = np.indices(lengths).reshape(_MOST_AXES, -1).T
    cell = " ".join(str(float(length)) if row == column else "0.0" for row, length in enumerate(lengths) for column in range(3))
    components = samples.shape[1]
    pbc = " ".join(["T" if periodic else "F"] * _MOST_AXES)
    with open(path, "w", encoding="ascii") as file:
        for sample, time in zip(samples, frames):
            at = "" if time is None else f" Time={float(time)!r}"
            file.write(f"{places.shape[0]}\n")
            file.write(f'Lattice="{cell}" Properties=species:S:1:pos:R:3:spin:R:{components} pbc="{pbc}"{at}\n')
            for place, vector in zip(places, sample.reshape(components, -1).T):
                numbers = " ".join(repr(float(number)) for number in (*place, *vector))
                file.write(f"{species} {numbers}\n")


def write_ovf(path: str | PathLike[str], s: ArrayLike, cell: float = 1e-9, title: str = "m") -> None:
    """Write one state (components, *lengths) as OVF 2.0, binary doubles; ``cell`` is the distance of sites in metres. Axis 0 is x."""
    state = _one(s)
    components, (nx, ny, nz) = state.shape[0], _lengths(state[None])
    units = " ".join(["1"] * components)
    labels = " ".join([f"{title}_{name}" for name in "xyz"[:components]])
    header = [
        "# OOMMF OVF 2.0",
        "# Segment count: 1",
        "# Begin: Segment",
        "# Begin: Header",
        f"# Title: {title}",
        "# meshtype: rectangular",
        "# meshunit: m",
        *(f"# {axis}min: 0" for axis in "xyz"),
        *(f"# {axis}max: {count * cell!r}" for axis, count in zip("xyz", (nx, ny, nz))),
        f"# valuedim: {components}",
        f"# valuelabels: {labels}",
        f"# valueunits: {units}",
        *(f"# {axis}base: {cell / 2!r}" for axis in "xyz"),
        *(f"# {axis}nodes: {count}" for axis, count in zip("xyz", (nx, ny, nz))),
        *(f"# {axis}stepsize: {cell!r}" for axis in "xyz"),
        "# End: Header",
        "# Begin: Data Binary 8",
    ]
    with open(path, "wb") as file:
        file.write(("\n".join(header) + "\n").encode("ascii"))
        file.write(np.array([123456789012345.0], dtype="<f8").tobytes())
        file.write(_x_fastest(state).astype("<f8").tobytes())
        file.write(b"\n# End: Data Binary 8\n# End: Segment\n")


def write_vti(path: str | PathLike[str], s: ArrayLike, title: str = "spin") -> None:
    """Write one state (components, *lengths) as VTK image data, in text. Axis 0 is x; two components get a third one that is 0."""
    state = _one(s)
    if state.shape[0] == 2:
        state = np.concatenate([state, np.zeros_like(state[:1])])
    components, lengths = state.shape[0], _lengths(state[None])
    kind = "Vectors" if components == _MOST_AXES else "Scalars"
    extent = " ".join(f"0 {length - 1}" for length in lengths)
    rows = "\n".join(" ".join(repr(float(number)) for number in row) for row in _x_fastest(state))
    with open(path, "w", encoding="ascii") as file:
        file.write(
            '<?xml version="1.0"?>\n<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian">\n'
            f'<ImageData WholeExtent="{extent}" Origin="0 0 0" Spacing="1 1 1">\n<Piece Extent="{extent}">\n'
            f'<PointData {kind}="{title}">\n'
            f'<DataArray type="Float64" Name="{title}" NumberOfComponents="{components}" format="ascii">\n{rows}\n'
            "</DataArray>\n</PointData>\n</Piece>\n</ImageData>\n</VTKFile>\n"
        )


def _samples(s: ArrayLike) -> Array:
    """Checked to be (samples, components, *lengths), with components of a vector."""
    array = np.asarray(s, dtype=float)
    if not 3 <= array.ndim <= 2 + _MOST_AXES or array.shape[1] > _MOST_AXES:
        raise ValueError(f"samples have the shape (samples, components, *lengths) with at most {_MOST_AXES} components, found {array.shape}; of one state take s[None]")
    return array


def _one(s: ArrayLike) -> Array:
    """Checked to be (components, *lengths)."""
    array = np.asarray(s, dtype=float)
    if not 2 <= array.ndim <= 1 + _MOST_AXES or array.shape[0] > _MOST_AXES:
        raise ValueError(f"one state has the shape (components, *lengths), found {array.shape}; of samples take s[-1]")
    return array


def _axes(samples: Array) -> tuple[int, ...]:
    return tuple(range(2, samples.ndim))


def _sites(samples: Array) -> int:
    return int(np.prod(samples.shape[2:]))


def _lengths(samples: Array) -> tuple[int, int, int]:
    """The lengths of three axes, 1 for a missing one."""
    own = samples.shape[2:]
    nx, ny, nz = (*own, 1, 1)[:_MOST_AXES]
    return nx, ny, nz


def _x_fastest(state: Array) -> Array:
    """Rows of components, the first axis fastest."""
    components, lengths = state.shape[0], _lengths(state[None])
    return state.reshape(components, *lengths).transpose(3, 2, 1, 0).reshape(-1, components)
