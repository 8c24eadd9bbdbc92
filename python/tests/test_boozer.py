"""Fields in Boozer coordinates."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import leafwise as lw


def stellarator() -> dict[str, Any]:
    s, theta, zeta = np.linspace(0, 1, 9), 2 * np.pi * np.arange(8) / 8, 2 * np.pi * np.arange(6) / 30
    at, of, along = np.meshgrid(s, theta, zeta, indexing="ij")
    strength = 2 - 0.3 * np.sqrt(at) * np.cos(of) + 0.2 * at * np.cos(2 * of - 5 * along)
    return {"periods": 5, "psi": 0.4, "s": s, "iota": 0.6 + 0.2 * s, "G": np.full(9, 3.2), "B": strength}


def test_arrays_become_a_scene_that_runs(tmp_path: Path) -> None:
    found = lw.import_boozer(stellarator(), tmp_path / "field", species="proton", energy=20.0, nodes=17)
    assert found.nodes == (9, 8, 6) and found.periods == 5 and not found.is_axisymmetric
    assert np.allclose(found.iota, [0.6, 0.8]) and abs(found.field_on_axis - 2) < 1e-12
    assert found.field_range[0] < 1.6 < 2.4 < found.field_range[1]
    run = found.scene.set(run__steps=20, run__record={"every": 1, "observables": ["energy", "B"]}).run()
    speed2 = 2 * 20e3 * 1.602176634e-19 / 1.67262192595e-27
    x, y, zeta, _ = run.x.T
    exact = 2 - 0.3 * x + 0.2 * ((x**2 - y**2) * np.cos(5 * zeta) + 2 * x * y * np.sin(5 * zeta))
    off = np.abs(run.observables["B"] / exact - 1)
    assert np.max(off) < 1e-4
    # H = u²/2 + μB with u and μ of the member's energy: what the table is off by at the start is in it twice at most.
    assert abs(run.observables["energy"][0] / (speed2 / 2) - 1) < 2 * off[0] + 1e-9


def test_a_dataset_and_its_file_are_the_same_field(tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    field = stellarator()
    data = {name: ("s", field[name]) for name in ("iota", "G")}
    # Axes in another order, and numbers as attributes.
    data["B"] = (("zeta", "theta", "s"), field["B"].T)
    dataset = xarray.Dataset(data, coords={"s": field["s"]}, attrs={"periods": 5, "psi": 0.4})
    lw.import_boozer(field, tmp_path / "arrays", nodes=17)
    lw.import_boozer(dataset, tmp_path / "dataset", nodes=17)
    tables = [(tmp_path / name / "modB.npy").read_bytes() for name in ("arrays", "dataset")]
    assert tables[0] == tables[1]
    try:
        dataset.to_netcdf(tmp_path / "field.nc")
    except (ImportError, ValueError):
        return
    lw.import_boozer(tmp_path / "field.nc", tmp_path / "netcdf", nodes=17)
    assert (tmp_path / "netcdf" / "modB.npy").read_bytes() == tables[0]


def test_what_is_no_field_is_refused(tmp_path: Path) -> None:
    field = stellarator()
    with pytest.raises(ValueError, match="the field has no iota"):
        lw.import_boozer({name: field[name] for name in field if name != "iota"}, tmp_path)
    with pytest.raises(lw.LeafwiseError, match="`iota` has 8 numbers"):
        lw.import_boozer({**field, "iota": field["iota"][1:]}, tmp_path)
    with pytest.raises(ValueError, match="shape"):
        lw.import_boozer({**field, "B": field["B"][0]}, tmp_path)
    with pytest.raises(lw.LeafwiseError, match="no field in Boozer coordinates"):
        (tmp_path / "field.json").write_text("{}", encoding="utf-8")
        lw.import_boozer(tmp_path / "field.json", tmp_path / "out")
    assert not (tmp_path / "scene.toml").exists()
