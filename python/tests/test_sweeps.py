"""Sweeps: rows are single runs, and shards on other processes give the same bytes."""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any

import numpy as np
import pytest

import leafwise as lw
from test_scenes import RIGID_BODY

GRID: dict[str, Any] = {
    "system.parameters.I2": np.linspace(0.5, 1.5, 5),
    "method.time-step": {"logarithmic": [0.01, 0.1, 4]},
}


def test_rows_are_single_runs() -> None:
    scene = lw.Scene(RIGID_BODY)
    sweep = scene.sweep(GRID, steps=20, observables=["energy", {"late": "x1"}])
    assert len(sweep) == 20
    assert list(sweep.settings) == list(GRID)
    assert set(sweep.outcomes) == {"done"}
    assert not any(sweep.errors)
    before = scene.parameters["I2"]
    for at in (0, 7, 19):
        inertia, step = (float(sweep[name][at]) for name in GRID)
        values = {"system.parameters.I2": inertia, "method.time-step": step, "method.chosen-at": {"I2": before}}
        run = lw.Scene.parse(scene.text, set=values).run(steps=20, progress=False)
        assert sweep.observables["late"][at] == run.x[-1, 0]
        assert sweep.drift["energy"][at] == run.drift["energy"]
        assert sweep.t[at] == run.t[-1]
    assert np.all(sweep.cost["steps"] == 20)
    assert "<svg" in sweep.report()


def test_methods_as_settings_and_failures() -> None:
    settings = [{"method.stepper": "rk4"}, {"method": {"stepper": "rk4", "time-step": 0.05}}, {"method.time-step": 1e6}]
    with pytest.warns(lw.LeafwiseWarning, match="1 of 3 settings failed: see errors"):
        sweep = lw.Scene(RIGID_BODY).sweep(settings=settings, steps=5)
    assert sweep.failed == 1
    assert list(sweep.outcomes) == ["done", "done", "failed"]
    assert sweep.errors[2].startswith("step 1: ")
    assert list(sweep["method.stepper"]) == ["rk4", "", ""]
    assert list(sweep["setting"]) == [0, 1, 2]
    with pytest.raises(lw.SceneError, match="cannot be combined with"):
        lw.Scene(RIGID_BODY).sweep(settings=[{"method": {"stepper": "rk4", "time-step": 1}, "method.time-step": 2}])


def test_shards_of_workers_are_the_bytes_of_this_process() -> None:
    scene = lw.Scene(RIGID_BODY)
    own = scene.sweep(GRID, steps=20, progress=False)
    told: list[tuple[int, int]] = []
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        others = scene.sweep(
            GRID, steps=20, executor=executor, shards=19, progress=lambda *at: told.append(at)
        )
    assert own.table == others.table
    assert told == [(k, 19) for k in range(1, 20)]


def test_what_is_no_sweep_is_refused() -> None:
    scene = lw.Scene(RIGID_BODY)
    with pytest.raises(lw.SceneError, match="no \\[sweep\\] table"):
        scene.sweep()
    with pytest.raises(lw.SceneError, match="unknown parameter"):
        scene.sweep({"system.parameters.I9": [1.0]})
    with pytest.raises(ValueError, match="not both"):
        scene.sweep(GRID, settings=[{"run.steps": 1}])
    with pytest.raises(ValueError, match="executor="):
        scene.sweep(GRID, shards=2)


def test_a_frame_has_a_row_for_each_setting() -> None:
    pytest.importorskip("pandas")
    frame = lw.Scene(RIGID_BODY).sweep(GRID, steps=5).to_pandas()
    assert frame.shape[0] == 20
    assert frame["energy_drift"].max() > 0
