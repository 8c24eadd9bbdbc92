"""Files of booz_xform, ``boozmn_*.nc``, as fields in Boozer coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: The least number of nodes of an angle.
_FEWEST = 5


def is_booz_xform(source: Mapping[Any, Any]) -> bool:
    """Whether a dataset has the names of booz_xform."""
    return "bmnc_b" in source


def field_of(source: Mapping[Any, Any]) -> dict[str, Any]:
    """The field of such a dataset by the names of ``import_boozer``.

    booz_xform tells B = sum bmnc cos(m theta - n zeta) + bmns sin(m theta - n zeta) on surfaces of the half mesh, number j of which
    has s = (j - 3/2)/(ns - 1). It takes its angles from VMEC, whose theta turns such that (s, theta, zeta) is left-handed. There
    B = grad psi x grad theta + iota grad zeta x grad psi holds with psi = -phi/(2 pi). The coefficients are summed at so many nodes
    that the harmonics are those of the file.

    Raises:
        ValueError: names that are missing, and arrays of other shapes.
    """
    needed = ("nfp_b", "ns_b", "jlist", "ixm_b", "ixn_b", "iota_b", "bvco_b", "buco_b", "phi_b", "bmnc_b")
    missing = [name for name in needed if name not in source]
    if missing:
        raise ValueError(f"the file of booz_xform has no {', '.join(missing)}")

    def array(name: str) -> NDArray[np.float64]:
        return np.asarray(source[name], dtype=np.float64)

    periods, meshes = (round(float(array(name))) for name in ("nfp_b", "ns_b"))
    surfaces, m, n = (np.rint(array(name)).astype(int) for name in ("jlist", "ixm_b", "ixn_b"))
    if periods < 1 or np.any(n % max(periods, 1)):
        raise ValueError(f"the file of booz_xform has nfp_b = {periods} and modes n in ixn_b that are no multiples of it")
    n = n // periods
    profiles = {name: array(key) for name, key in (("iota", "iota_b"), ("G", "bvco_b"), ("I", "buco_b"))}
    for name, profile in profiles.items():
        if profile.shape != (meshes,):
            raise ValueError(f"the file of booz_xform has {name} of the shape {profile.shape} where ns_b = {meshes}")
    if np.any(surfaces < 2) or np.any(surfaces > meshes):
        raise ValueError(f"the file of booz_xform has surfaces outside of 2 to ns_b = {meshes} in jlist")
    order = np.argsort(surfaces)
    surfaces = surfaces[order]

    most_m, most_n = int(np.max(np.abs(m), initial=0)), int(np.max(np.abs(n), initial=0))
    along_theta = max(2 * most_m + 1, _FEWEST)
    along_zeta = 1 if most_n == 0 else max(2 * most_n + 1, _FEWEST)
    theta = 2 * np.pi * np.outer(np.arange(along_theta), np.arange(-most_m, most_m + 1)) / along_theta
    zeta = 2 * np.pi * np.outer(np.arange(along_zeta), np.arange(-most_n, most_n + 1)) / along_zeta

    def summed(name: str, along: tuple[Any, Any]) -> NDArray[np.float64]:
        values = array(name)
        if values.shape != (surfaces.size, m.size):
            raise ValueError(f"the file of booz_xform has {name} of the shape {values.shape}, not {(surfaces.size, m.size)}")
        modes = np.zeros((surfaces.size, 2 * most_m + 1, 2 * most_n + 1))
        for own, at_m, at_n in zip(values[order].T, m + most_m, n + most_n):
            modes[:, int(at_m), int(at_n)] += own
        by_theta, by_zeta = along[0](theta), along[1](zeta)
        total: NDArray[np.float64] = np.einsum("kmn,jm,ln->kjl", modes, by_theta, by_zeta, optimize=True)
        return total

    # cos(a - b) = cos a cos b + sin a sin b, and sin(a - b) = sin a cos b - cos a sin b.
    strength = summed("bmnc_b", (np.cos, np.cos)) + summed("bmnc_b", (np.sin, np.sin))
    if "bmns_b" in source and np.size(source["bmns_b"]):
        strength += summed("bmns_b", (np.sin, np.cos)) - summed("bmns_b", (np.cos, np.sin))
    return {
        "periods": periods,
        "psi": -float(array("phi_b")[-1]) / (2 * np.pi),
        "s": (surfaces - 1.5) / (meshes - 1),
        **{name: profile[surfaces - 1] for name, profile in profiles.items()},
        "B": strength,
    }
