"""Tables, labelled arrays, figures and notebook views of results, and what Scipy's users write."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import leafwise as lw
from leafwise._labelled import beside
from test_scenes import RIGID_BODY
from test_solve import BODY, OSCILLATOR

TABLE = {"method.time-step": [0.1, 0.2], "system.parameters.I2": [0.7, 0.75, 0.8]}


def test_the_version_is_the_programs() -> None:
    code, out, _ = lw._leafwise.command(["--version"])
    assert code == 0 and lw.__version__ in out
    names: dict[str, object] = {}
    exec("from leafwise import *", names)
    assert "list" not in names and names["solve"] is lw.solve


def test_scenes_that_say_the_same_are_equal() -> None:
    scene = lw.Scene(RIGID_BODY)
    assert scene == lw.Scene(RIGID_BODY) == pickle.loads(pickle.dumps(scene)) == lw.Scene.parse(scene.text)
    assert scene != scene.set(run__steps=3) and scene != "a scene" and len({scene, lw.Scene(RIGID_BODY)}) == 1
    assert scene.set(run__steps=3) == scene.set(run__steps=4).set(run__steps=3)


def test_keys_with_hyphens_are_written_with_underscores() -> None:
    scene = lw.Scene(RIGID_BODY)
    assert scene.set(method__time_step=0.05) == scene.set(**{"method__time-step": 0.05})
    assert "time-step = 0.05" in scene.set(method__time_step=0.05).text
    chosen = scene.set(method__chosen_at={"I2": 0.75})
    assert "chosen-at" in chosen.text
    named = lw.Scene(RIGID_BODY | {"system": RIGID_BODY["system"] | {"parameters": {"I1": 1.0, "I2": 0.75, "I3": 1.25, "time_step": 2.0}}})
    assert named.set(system__parameters__time_step=3.0).parameters["time_step"] == 3.0
    with pytest.raises(lw.SceneError, match="time_stp"):
        scene.set(method__time_stp=0.05)


def test_a_method_that_tune_found_is_taken_up() -> None:
    scene = lw.Scene(RIGID_BODY).set(run__steps=20)
    best = scene.tune(1e-4)["recommended"]
    taken = scene.set(method=best["method"], run__steps=best["steps"])
    tuned = scene.tuned(1e-4)
    assert tuned == taken and isinstance(best["method"], str)
    exact = scene.set(method__time_step=0.001, run__steps=2000).run(advice=False)
    run = tuned.run(advice=False)
    assert run.final_time == pytest.approx(2.0) and np.abs(run.final_state - exact.final_state).max() < 1e-4
    assert scene.set(method='stepper = "rk4"\ntime-step = 0.1') == scene.set(method={"stepper": "rk4", "time-step": 0.1})
    with pytest.raises(ValueError, match="method: .*TOML|method: "):
        scene.set(method="stepper = rk4 = 3")


def test_labelled_arrays_say_where_they_come_from(tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    scene = lw.Scene(RIGID_BODY)
    run = scene.run(steps=10)
    found = run.to_xarray()
    assert found.attrs["scene"] == scene.set(run__steps=10).text and found.attrs["leafwise"] == lw.__version__
    assert "hamilton-jacobi" in found.attrs["method"] and found.attrs["drift_spin"] == run.drift["spin"]
    again = lw.Scene.parse(found.attrs["scene"]).run().to_xarray()
    xarray.testing.assert_identical(again, found)
    solution = lw.solve(**BODY, t_span=(2, 7), rtol=1e-8)
    labelled = solution.to_xarray()
    np.testing.assert_array_equal(labelled.y.sel(coordinate="x2"), solution.y[1])
    np.testing.assert_array_equal(labelled.t, solution.t)
    np.testing.assert_array_equal(labelled.spin, solution.casimirs["spin"])
    assert labelled.attrs["step"] == solution.step


def test_ensembles_as_labelled_arrays_and_figures(tmp_path: Path) -> None:
    pytest.importorskip("xarray")
    cloud = lw.Scene(RIGID_BODY).ensemble(x0=1 + np.arange(12.0).reshape(4, 3), parameters={"I2": [0.7, 0.8, 0.9, 1.1]})
    found = cloud.to_xarray()
    assert dict(found.sizes) == {"member": 4, "coordinate": 3}
    np.testing.assert_array_equal(found.x.sel(member=2, coordinate="x3"), cloud.x[2, 2])
    np.testing.assert_array_equal(found.x0, cloud.x0)
    np.testing.assert_array_equal(found.I2, cloud.parameters["I2"])
    np.testing.assert_array_equal(found.drift_energy, cloud.drift["energy"])
    assert (found.outcome == "done").all()
    ax = cloud.plot()
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), cloud.x[:, 1])
    assert cloud.plot("I2", "energy").get_xlabel() == "I2"
    with pytest.raises(KeyError, match="'x9' is not a column; there are t, I2, x1"):
        cloud.plot("x9")
    cloud.save_report(tmp_path / "cloud.html")
    assert (tmp_path / "cloud.html").read_text(encoding="utf-8") == cloud.report()


def test_names_that_arrays_have_already_are_told_apart() -> None:
    xarray = pytest.importorskip("xarray")
    columns = {"x": np.zeros(2), "y": np.ones(2)}
    found = xarray.Dataset({"x": (("t", "k"), np.eye(2))} | beside({"x", "t"}, columns, "t", "observable"))
    assert found.x.dims == ("t", "k") and found["x (observable)"].dims == found.y.dims == ("t",)


def test_sweeps_as_labelled_grids_and_figures(tmp_path: Path) -> None:
    pytest.importorskip("xarray")
    scene = lw.Scene(RIGID_BODY)
    sweep = scene.sweep(TABLE, observables=["x1"], steps=20)
    found = sweep.to_xarray()
    assert found.drift_energy.dims == tuple(TABLE) and found.drift_energy.shape == (2, 3)
    one = scene.set(system__parameters__I2=0.8, method__time_step=0.2).run(steps=20)
    at = {"method.time-step": 0.2, "system.parameters.I2": 0.8}
    assert found.drift_energy.sel(at) == one.drift["energy"] and found.x1.sel(at) == one.final_state[0]
    settings = [{"method.time-step": 0.1, "system.parameters.I2": 0.7}, {"method.time-step": 0.2, "system.parameters.I2": 0.8}]
    listed = scene.sweep(settings=settings, steps=20).to_xarray()
    assert listed.drift_energy.dims == ("setting",)
    np.testing.assert_array_equal(listed["method.time-step"], [0.1, 0.2])
    ax = sweep.plot("x1", "system.parameters.I2")
    assert [line.get_label() for line in ax.lines] == ["method.time-step = 0.1", "method.time-step = 0.2"]
    np.testing.assert_array_equal(ax.lines[1].get_ydata(), found.x1.sel({"method.time-step": 0.2}))
    assert sweep.plot().get_xlabel() == "method.time-step"
    with pytest.raises(KeyError, match="not a column"):
        sweep.plot("x9")
    sweep.save_report(tmp_path / "sweep.html")
    assert (tmp_path / "sweep.html").exists()


def test_a_solution_is_a_mapping_a_table_and_a_figure(tmp_path: Path) -> None:
    pytest.importorskip("pandas")
    solution = lw.solve(**BODY, t_span=(2, 7), rtol=1e-8)
    assert list(solution)[:2] == ["t", "y"] and "status" in solution and 0 not in solution
    whole = dict(solution)
    assert whole["y"] is solution.y and whole.keys() == set(solution.keys()) and solution.get("nothing", 3) == 3
    assert len(list(solution.items())) == len(solution) == len(list(solution.values())) and bool(solution)
    with pytest.raises(KeyError, match="not a field"):
        solution["x"]
    frame = solution.to_pandas()
    assert list(frame.columns) == ["x1", "x2", "x3", "energy", "spin"]
    np.testing.assert_array_equal(frame.index, solution.t)
    np.testing.assert_array_equal(frame["x2"], solution.y[1])
    ax = solution.plot("x1", "spin")
    assert [line.get_label() for line in ax.lines] == ["x1"] and len(solution.plot().lines) == 3
    assert ax.get_xlim()[0] < 2.5
    solution.save_report(tmp_path / "solution.html")
    assert (tmp_path / "solution.html").read_text(encoding="utf-8") == solution.report()
    with pytest.raises(KeyError, match="'x9' was not recorded; there are energy, spin, x1"):
        solution.plot("x9")


def test_notebook_views_are_short() -> None:
    scene = lw.Scene(RIGID_BODY)
    comparison = scene.compare("--steps", "20", "--repeat", "0", "--budget", "1e5")
    fit = scene.fit(scene.run(record=10).x, ["I1"], record=10)
    solution = lw.solve(**OSCILLATOR, t_span=(0, 10), step=0.001)
    for shown in (scene, comparison, fit, solution):
        assert len(repr(shown)) < 250 and "\n" not in repr(shown), repr(shown)
        page = shown._repr_html_()
        assert 50 < len(page) < 10_000 and page.count("<table") == page.count("</table")
    assert "I1" in fit._repr_html_() and "splitting" in comparison._repr_html_()
    assert "&#x27;" not in scene._repr_html_() or "<pre>" in scene._repr_html_()
    assert "hamiltonian" in scene._repr_html_() and str(comparison) == repr(comparison)
    # Both fronts are seen, and the methods' names.
    ax = comparison.plot()
    assert len(ax.texts) >= 1
    assert {text.get_text() for text in ax.texts} <= {method["name"] for method in comparison["methods"]}
    assert ax.lines[0].get_markersize() != ax.lines[1].get_markersize()


@pytest.mark.parametrize(
    "arguments, words",
    [
        ({"y0": [1.0, 0.0]}, "the initial state is x0="),
        ({"args": (1.0,)}, "parameters are given by name"),
        ({"atol": 1e-9}, "only rtol= is supported"),
        ({"max_step": 0.1}, "given by step="),
        ({"first_step": 0.1}, "given by step="),
        ({"dense_output": True}, "a function of the time"),
        ({"jac": None}, "formed from the formulas"),
    ],
)
def test_arguments_of_scipys_are_answered(arguments: dict[str, object], words: str) -> None:
    with pytest.raises(TypeError, match=words):
        lw.solve(**OSCILLATOR, t_span=(0, 1), **arguments)
    for given in ([lambda t, y: y, (0, 1), [1.0, 0.0]], [(0, 1), [1.0, 0.0]]):
        with pytest.raises(TypeError, match=r"arguments of solve\(\) have names"):
            lw.solve(*given)
    with pytest.raises(TypeError, match="unexpected keyword argument 'stepp'"):
        lw.solve(**OSCILLATOR, t_span=(0, 1), stepp=0.1)
