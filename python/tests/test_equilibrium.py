"""Equilibria of tokamaks."""

from pathlib import Path

import numpy as np
import pytest

import leafwise as lw

SOLOVEV = Path(__file__).parents[2] / "scenes" / "tokamak" / "solovev.geqdsk"


def test_an_equilibrium_becomes_a_scene(tmp_path: Path) -> None:
    found = lw.import_equilibrium(SOLOVEV, tmp_path / "shot", energy=20.0, members=5)
    assert found.nodes == (33, 33) and found.has_edge
    assert np.allclose(found.axis, [1.6, 0], atol=1e-8)
    assert np.allclose(found.field_on_axis, [0, 0, 2], atol=1e-8)
    q = found.safety_factors[0]["q"]
    assert q is not None and abs(q - 1.2) < 1e-6
    run = found.scene.set(run__steps=300).run()
    momentum = run.observables["momentum"]
    assert np.ptp(momentum) < 1e-12 * abs(momentum[0])
    # u^2/2 + mu B is the kinetic energy over the mass.
    speed2 = 2 * 20e3 * 1.602176634e-19 / 3.3435837768e-27
    assert abs(run.observables["energy"][0] / (speed2 / 2) - 1) < 1e-12
    with pytest.raises(lw.LeafwiseError, match="exists and is left as it is"):
        lw.import_equilibrium(SOLOVEV, tmp_path / "shot")


def test_options_out_of_range_are_refused(tmp_path: Path) -> None:
    with pytest.raises(lw.LeafwiseError, match="not relativistic"):
        lw.import_equilibrium(SOLOVEV, tmp_path, species="electron", energy=100)
    with pytest.raises(lw.LeafwiseError, match="two whole numbers"):
        lw.import_equilibrium(__file__, tmp_path)
    with pytest.raises(ValueError, match="members"):
        lw.import_equilibrium(SOLOVEV, tmp_path, members=-1)
    assert not list(tmp_path.iterdir())
