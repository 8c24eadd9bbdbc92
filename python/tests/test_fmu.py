"""Functional mock-up units."""

import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest

import leafwise as lw


def body() -> lw.Scene:
    return lw.Scene(
        system={"library": "rigid-body"},
        method={"realization": "auto", "dynamics": {"name": "hamilton-jacobi", "order": 4}, "time-step": 0.05},
        run={"initial": [1.0, 3.0, 3.0], "steps": 100},
    )


def test_a_unit_holds_the_scene_its_variables_and_the_library(tmp_path: Path) -> None:
    library = tmp_path / "libleafwise_c.so"
    library.write_bytes(b"any bytes")
    unit = lw.write_fmu(body(), tmp_path / "body.fmu", library=library)
    with zipfile.ZipFile(unit.file) as archive:
        assert archive.testzip() is None
        names = archive.namelist()
        described = ElementTree.fromstring(archive.read("modelDescription.xml"))
        assert archive.read(next(name for name in names if name.startswith("binaries/"))) == b"any bytes"
        assert "rigid-body" in archive.read("resources/scene.toml").decode()
    assert described.get("fmiVersion") == "3.0" and described.get("instantiationToken") == unit.token
    own = [variable.get("name") for variable in described.iter("Float64")]
    assert tuple(own) == unit.variables and own[0] == "time" and "energy" in own
    step = described.find("CoSimulation")
    assert step is not None and float(step.get("fixedInternalStepSize", "nan")) == unit.time_step == 0.05


def test_what_is_no_unit_is_told(tmp_path: Path) -> None:
    with pytest.raises(lw.LeafwiseError, match="libleafwise_c"):
        lw.write_fmu(body(), tmp_path / "body.fmu", library=tmp_path / "libleafwise_c.so")
    with pytest.raises(TypeError, match="Scene"):
        lw.write_fmu("body", tmp_path / "body.fmu", library="any")  # type: ignore[arg-type]
