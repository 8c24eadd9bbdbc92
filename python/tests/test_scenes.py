"""Scenes and runs, against the program's own files and closed forms."""

import html
import json
import pickle
import threading
import warnings
from pathlib import Path

import numpy as np
import pytest

import leafwise as lw

SCENES = Path(__file__).parents[2] / "scenes"

RIGID_BODY = {
    "system": {
        "variables": ["x1", "x2", "x3"],
        "parameters": {"I1": 1.0, "I2": 0.75, "I3": 1.25},
        "bracket": {"x1,x2": "-x3", "x2,x3": "-x1", "x3,x1": "-x2"},
        "hamiltonian": "x1^2/(2*I1) + x2^2/(2*I2) + x3^2/(2*I3)",
        "casimirs": {"spin": "x1^2 + x2^2 + x3^2"},
    },
    "method": {
        "realization": "auto",
        "dynamics": {"name": "hamilton-jacobi", "order": 4},
        "time-step": 0.1,
    },
    "run": {"initial": np.array([1.0, 3.0, 3.0]), "steps": np.int64(200)},
}


def program(tmp_path: Path, scene: str, *sets: str) -> Path:
    """The directory that the program writes."""
    out = tmp_path / "run"
    arguments = [part for pair in sets for part in ("--set", pair)]
    code, _, err = lw._leafwise.command(["run", str(SCENES / scene), "--out", str(out), *arguments])
    assert code == 0, err
    return out


@pytest.mark.parametrize(
    "scene, sets",
    [
        ("rigid_body.toml", {"run.steps": 3000, "run.record.every": 7}),
        ("lotka_volterra_periodic.toml", {"run.steps": 2000}),
        ("heavy_top.toml", {"run.steps": 500}),
        ("kepler.toml", {}),
        ("henon_heiles.toml", {"run.steps": 5000}),
    ],
)
def test_samples_are_the_programs_to_the_bit(tmp_path: Path, scene: str, sets: dict[str, int]) -> None:
    out = program(tmp_path, scene, *(f"{key}={value}" for key, value in sets.items()))
    loaded = lw.Scene.load(SCENES / scene, set=sets)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lw.LeafwiseWarning)
        run = loaded.run()
    for file, table in [("samples.csv", run._recorded.samples), ("section.csv", run._recorded.crossings)]:
        if table is None:
            assert not (out / file).exists()
            continue
        written = np.loadtxt(out / file, delimiter=",", skiprows=1, ndmin=2)
        np.testing.assert_array_equal(table[:, : written.shape[1]], written)
    manifest = json.loads((out / "manifest.json").read_text())
    assert run.steps == manifest["steps"]
    assert run.drift == {name: float(value) for name, value in manifest["drift"].items()}


def test_a_table_is_a_scene() -> None:
    run = lw.Scene(RIGID_BODY).run()
    assert run.outcome == "done" and run.steps == 200
    assert run.t.shape == (201,) and run.x.shape == (201, 3)
    np.testing.assert_allclose(run.t, np.arange(201) * 0.1, rtol=1e-13)
    assert run.x[0].tolist() == [1.0, 3.0, 3.0]
    np.testing.assert_array_equal(run.x[-1], run.final_state)
    np.testing.assert_allclose(run.casimirs["spin"], 19.0, rtol=1e-14)
    energy = run.x[:, 0] ** 2 / 2 + run.x[:, 1] ** 2 / 1.5 + run.x[:, 2] ** 2 / 2.5
    np.testing.assert_allclose(run.energy, energy, rtol=1e-14)
    assert run.drift["energy"] == np.abs(run.energy - run.energy[0]).max()


def test_recorded_arrays_are_views_of_one_table() -> None:
    run = lw.Scene(RIGID_BODY).run()
    for array in (run.t, run.x, run.energy):
        assert np.shares_memory(array, run._recorded.samples)


def test_energy_and_casimirs_are_there_whatever_the_scene_records() -> None:
    table = RIGID_BODY | {"run": RIGID_BODY["run"] | {"record": {"observables": ["x1*x2"]}}}
    run = lw.Scene(table).run(steps=20, record=5)
    assert list(run.observables) == ["x1*x2", "energy", "spin"]
    np.testing.assert_array_equal(run.observables["x1*x2"], run.x[:, 0] * run.x[:, 1])
    assert len(run.t) == 5


def test_an_initial_state_may_be_an_array() -> None:
    states = np.arange(12.0).reshape(2, 3, 2)
    run = lw.Scene(RIGID_BODY).run(steps=1, initial=states[1, :, 1])
    assert run.x[0].tolist() == [7.0, 9.0, 11.0]


def test_steps_of_ones_own_are_the_runs() -> None:
    scene = lw.Scene(RIGID_BODY)
    run, steps = scene.run(), scene.integrator()
    target = np.empty(3)
    for state in run.x[1:100]:
        steps.step()
        steps.copy_to(target)
        np.testing.assert_array_equal(state, target)
    steps.advance(101)
    np.testing.assert_array_equal(steps.x, run.final_state)
    assert (steps.steps, steps.t) == (200, run.t[-1])
    with pytest.raises(ValueError, match="4 numbers, a state 3"):
        steps.copy_to(np.empty(4))
    frozen = np.empty(3)
    frozen.flags.writeable = False
    with pytest.raises(TypeError, match="read-only|not writeable"):
        steps.copy_to(frozen)


def test_a_loop_of_ones_own_shows_the_scenes_own_coordinates_and_the_time() -> None:
    """With t in H two coordinates more are stepped, and with a pace steps are of another time."""
    driven = lw.Scene.load(SCENES / "driven_oscillator.toml")
    kepler = lw.Scene.load(SCENES / "kepler.toml")
    for scene in (driven, driven.set(run__t0=3.0), kepler):
        paced = "until" in scene.text
        run = scene.run(**({"until": 2.0} if paced else {"steps": 40}), record=1)
        integrator = scene.integrator()
        state = np.zeros(len(scene.variables))
        assert integrator.x.shape == run.x[0].shape == state.shape
        for at in range(len(run.t) - (2 if paced else 1)):
            assert integrator.t == run.t[at]
            np.testing.assert_array_equal(integrator.x, run.x[at])
            integrator.copy_to(state)
            np.testing.assert_array_equal(state, run.x[at])
            integrator.step()
        assert integrator.steps > 10


def test_tables_of_other_libraries() -> None:
    run = lw.Scene(RIGID_BODY).run(steps=10)
    frame = run.to_pandas()
    assert list(frame.columns) == ["x1", "x2", "x3", "energy", "spin"]
    np.testing.assert_array_equal(frame.index, run.t)
    data = run.to_xarray()
    np.testing.assert_array_equal(data.x.sel(coordinate="x2"), run.x[:, 1])
    np.testing.assert_array_equal(data.energy, run.energy)


def test_figures() -> None:
    run = lw.Scene(RIGID_BODY).run(steps=10)
    ax = run.plot("x1", "x3", "energy")
    assert [line.get_label() for line in ax.lines] == ["x1", "x3"]
    # Energy has an axis of its own, and the legend names all.
    (other,) = (one for one in ax.figure.axes if one is not ax)
    np.testing.assert_array_equal(other.lines[0].get_ydata(), run.energy)
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["x1", "x3", "energy"]
    assert len(run.plot(ax=ax).lines) == 5
    assert len(run.plot("energy", "spin").lines) == 2
    with pytest.raises(KeyError, match="'x9' was not recorded; there are x1, x2, x3, energy, spin"):
        run.plot("x9", ax=ax)


def test_a_comparison_is_a_table() -> None:
    found = lw.Scene(RIGID_BODY).compare("--steps", "20", "--repeat", "0", "--budget", "1e5")
    table = found.to_pandas()
    ran = [point for point in found["points"] if "error" in point]
    assert len(table) == len(ran) > 10 and table["operations"].is_monotonic_increasing
    assert table["seconds"].isna().all() and set(table["method"]) <= {method["name"] for method in found["methods"]}
    front = table[table["poisson_front"]]
    assert front["poisson"].all() and (np.diff(front["error"]) < 0).all()
    np.testing.assert_array_equal(found.plot().lines[1].get_ydata(), front["error"])


def test_the_report_is_a_page_of_its_own(tmp_path: Path) -> None:
    run = lw.Scene(RIGID_BODY).run(steps=10)
    run.save_report(tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<svg" in page and "http://" not in page.replace("http://www.w3.org", "")
    shown = run._repr_html_()
    assert shown.startswith("<iframe") and html.escape(page) in shown and "<script" in page
    assert "10 steps" in repr(run)


def test_a_table_takes_the_place_of_a_table() -> None:
    scene = lw.Scene(RIGID_BODY).set(
        method={"stepper": {"name": "splitting"}, "time-step": 0.05},
        run__record={"every": 2, "observables": ["spin"]},
        run__initial=np.array([1.0, 2.0, 3.0]),
    )
    assert scene.method == lw.Scene(RIGID_BODY | {"method": {"stepper": "splitting", "time-step": 0.05}}).method
    run = scene.run(steps=4)
    np.testing.assert_array_equal(run.t, [0.0, 0.1, 0.2])
    np.testing.assert_array_equal(run.x[0], [1, 2, 3])
    with pytest.raises(lw.SceneError, match="`run` is a table; name one of its keys, or give a table"):
        lw.Scene(RIGID_BODY).set(run=5)


def test_scenes_can_be_pickled() -> None:
    scene = lw.Scene.load(SCENES / "rigid_body.toml", set={"run.steps": 50})
    again = pickle.loads(pickle.dumps(scene))
    np.testing.assert_array_equal(again.run().x, scene.run().x)


def test_threads_step_side_by_side() -> None:
    scene = lw.Scene(RIGID_BODY)
    alone, found = scene.run().x, [None] * 4

    def step(at: int) -> None:
        found[at] = scene.run().x

    threads = [threading.Thread(target=step, args=(at,)) for at in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for one in found:
        np.testing.assert_array_equal(one, alone)


def test_commands() -> None:
    scene = lw.Scene(RIGID_BODY)
    assert scene.variables == ["x1", "x2", "x3"]
    assert scene.casimirs == ["spin"]
    assert scene.parameters["I2"] == 0.75
    assert any("hamilton-jacobi" in line for line in scene.method)
    assert scene.check()["jacobi"]["verdict"] != "violated"
    assert any(part["name"] == "lie-poisson" for part in lw.list()["realizations"])
    assert lw.describe("hamilton-jacobi")
    with pytest.raises(lw.LeafwiseError, match="did you mean `hamilton-jacobi`"):
        lw.describe("hamilton")
