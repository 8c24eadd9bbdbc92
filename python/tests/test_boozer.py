"""Fields in Boozer coordinates."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import leafwise as lw
from leafwise._booz_xform import field_of


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


def boozmn(asymmetric: bool = False) -> dict[str, Any]:
    """The variables of a file of booz_xform: three field periods, of 12 surfaces of the half mesh the even ones."""
    meshes, periods = 13, 3
    jlist = np.arange(2, 14, 2)
    half = (np.arange(1, 14) - 1.5) / 12
    s = half[jlist - 1]
    ixm, ixn = np.array([0, 1, 2, 1]), np.array([0, 0, 3, -3])
    bmnc = np.stack([2 + 0.1 * s, -0.3 * np.sqrt(s), 0.2 * s, 0.05 * np.sqrt(s)], axis=1)
    variables = {
        "nfp_b": np.int32(periods),
        "ns_b": np.int32(meshes),
        "jlist": jlist,
        "ixm_b": ixm,
        "ixn_b": ixn,
        "iota_b": np.where(half < 0, 0.0, 0.4 + 0.1 * half),
        "bvco_b": np.where(half < 0, 0.0, 3.2 + 0.0 * half),
        "buco_b": np.where(half < 0, 0.0, 0.05 * half),
        "phi_b": 0.4 * 2 * np.pi * np.linspace(0, 1, meshes),
        "bmnc_b": bmnc,
    }
    if asymmetric:
        variables["bmns_b"] = 0.1 * bmnc[:, ::-1] * (ixm > 0)
    return variables


@pytest.mark.parametrize("asymmetric", [False, True])
def test_files_of_booz_xform_are_sums_of_their_modes(asymmetric: bool, tmp_path: Path) -> None:
    source = boozmn(asymmetric)
    found = field_of(source)
    assert found["periods"] == 3 and found["B"].shape == (6, 5, 5)
    assert np.allclose(found["s"], [1 / 24, 5 / 24, 9 / 24, 13 / 24, 17 / 24, 21 / 24], rtol=1e-15)
    assert np.allclose(found["iota"], 0.4 + 0.1 * found["s"]) and np.allclose(found["I"], 0.05 * found["s"])
    # Left-handed angles: the flux has the other sign.
    assert found["psi"] == pytest.approx(-0.4, rel=1e-15)
    for j in range(5):
        for l in range(5):
            angle = source["ixm_b"] * 2 * np.pi * j / 5 - source["ixn_b"] * 2 * np.pi * l / 15
            exact = source["bmnc_b"] @ np.cos(angle) + (source["bmns_b"] @ np.sin(angle) if asymmetric else 0)
            assert np.allclose(found["B"][:, j, l], exact, rtol=0, atol=1e-14)
    run = lw.import_boozer(source, tmp_path / "booz", nodes=17, energy=5.0)
    assert run.periods == 3 and run.nodes == (6, 5, 5) and run.warnings == ()
    assert run.scene.set(run__steps=10).run().outcome == "done"


def test_a_file_of_booz_xform_is_its_variables(tmp_path: Path) -> None:
    io = pytest.importorskip("scipy.io")
    source = boozmn()
    with io.netcdf_file(tmp_path / "boozmn_test.nc", "w") as file:
        for name, values in source.items():
            values = np.asarray(values)
            axes = [f"{name}_{axis}" for axis in range(values.ndim)]
            for axis, length in zip(axes, values.shape):
                file.createDimension(axis, length)
            kind = "d" if values.dtype.kind == "f" else "i"
            variable = file.createVariable(name, kind, axes)
            variable[...] = values
    lw.import_boozer(source, tmp_path / "arrays", nodes=17)
    lw.import_boozer(tmp_path / "boozmn_test.nc", tmp_path / "file", nodes=17)
    tables = [(tmp_path / name / "modB.npy").read_bytes() for name in ("arrays", "file")]
    assert tables[0] == tables[1]


def test_odd_files_of_booz_xform_are_refused(tmp_path: Path) -> None:
    for spoil, message in [
        ({"bmnc_b": np.zeros((6, 3))}, r"bmnc_b of the shape \(6, 3\), not \(6, 4\)"),
        ({"jlist": np.arange(1, 7)}, "surfaces outside of 2 to ns_b = 13"),
        ({"iota_b": np.zeros(5)}, r"iota of the shape \(5,\) where ns_b = 13"),
        ({"ixn_b": np.array([0, 1, 3, -3])}, "no multiples of it"),
    ]:
        with pytest.raises(ValueError, match=message):
            lw.import_boozer({**boozmn(), **spoil}, tmp_path)
    source = boozmn()
    del source["phi_b"], source["jlist"]
    with pytest.raises(ValueError, match="no jlist, phi_b"):
        lw.import_boozer(source, tmp_path)


def test_what_is_left_out_is_told(tmp_path: Path) -> None:
    field = stellarator()
    closed = np.concatenate([field["B"], field["B"][:, :1]], axis=1)
    found = lw.import_boozer({**field, "B": closed}, tmp_path / "field", nodes=17)
    assert found.nodes == (9, 8, 6)
    assert len(found.warnings) == 1 and "the last node of theta" in found.warnings[0]


def test_what_is_no_field_is_refused(tmp_path: Path) -> None:
    field = stellarator()
    with pytest.raises(ValueError, match="the field has no iota"):
        lw.import_boozer({name: field[name] for name in field if name != "iota"}, tmp_path)
    with pytest.raises(lw.LeafwiseError, match="`iota` has 8 numbers"):
        lw.import_boozer({**field, "iota": field["iota"][1:]}, tmp_path)
    with pytest.raises(ValueError, match="shape"):
        lw.import_boozer({**field, "B": field["B"][0]}, tmp_path)
    with pytest.raises(lw.LeafwiseError, match="`B` is missing|`periods` is missing|missing of a field in Boozer coordinates"):
        (tmp_path / "field.json").write_text("{}", encoding="utf-8")
        lw.import_boozer(tmp_path / "field.json", tmp_path / "out")
    assert not (tmp_path / "scene.toml").exists()
