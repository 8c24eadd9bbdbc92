"""Tables of scenes by arrays."""

import pickle
from pathlib import Path
from typing import Any

import leafwise as lw
import numpy as np
import pytest

TEXT = """
[system]
variables   = ["q", "p"]
bracket     = { "q,p" = 1 }
convention  = "{x,H}"
hamiltonian = "p^2/2 + V(q)"
tables      = { V = { axes = { q = [-2, 2] } } }
[method]
realization = "auto"
dynamics    = { name = "hamilton-jacobi", order = 4 }
time-step   = 0.05
[run]
initial = [1, 0.5]
steps   = 40
"""

NODES = np.linspace(-2, 2, 17)
V = NODES**2 / 2 + 0.1 * np.cos(3 * NODES)


def by_array(**more: Any) -> lw.Scene:
    return lw.Scene.parse(TEXT, tables={"V": V}, **more)


def test_an_array_is_the_table_of_its_file(tmp_path: Path) -> None:
    np.save(tmp_path / "v.npy", V)
    file = tmp_path / "scene.toml"
    file.write_text(TEXT.replace("axes", 'file = "v.npy", axes'))
    expected = lw.Scene.load(file).run().x
    assert np.array_equal(by_array().run().x, expected)
    assert np.array_equal(lw.Scene.parse(TEXT, tables={"V": list(V)}).run().x, expected)
    # In the place of the file's numbers.
    assert not np.array_equal(lw.Scene.load(file, tables={"V": 2 * V}).run().x, expected)
    section = {
        "variables": ["q", "p"],
        "bracket": {"q,p": 1},
        "convention": "{x,H}",
        "hamiltonian": "p^2/2 + V(q)",
        "tables": {"V": {"values": V, "axes": {"q": [-2, 2]}}},
    }
    method = {"dynamics": {"name": "hamilton-jacobi", "order": 4}, "time-step": 0.05}
    scene = lw.Scene(system=section, method=method, run={"initial": [1, 0.5], "steps": 40})
    assert np.array_equal(scene.run().x, expected)


def test_arrays_of_two_axes_in_any_order_of_memory() -> None:
    x, y = np.meshgrid(NODES, np.linspace(-3, 3, 15), indexing="ij")
    text = TEXT.replace("V(q)", "V(q, p)").replace("q = [-2, 2]", "q = [-2, 2], p = [-3, 3]")
    values = x**2 / 2 + 0.1 * np.cos(y)
    runs = [lw.Scene.parse(text, tables={"V": array}).run().x for array in (values, np.asfortranarray(values))]
    assert np.array_equal(*runs)


def test_scenes_keep_their_arrays() -> None:
    scene = by_array()
    expected = scene.run().x
    again = pickle.loads(pickle.dumps(scene))
    assert again == scene and hash(again) == hash(scene)
    assert scene != lw.Scene.parse(TEXT, tables={"V": V + 1})
    assert np.array_equal(again.run().x, expected)
    assert np.array_equal(scene.set(run__steps=20).run().x, expected[:21])
    other = scene.set(method={"stepper": "rk4", "time-step": 0.05}).run()
    assert np.allclose(other.x, expected, atol=1e-5)


def test_gradients_go_through_tables() -> None:
    trajectory = by_array().trajectory()
    x0 = np.array([1.0, 0.5])
    for step in 1e-5 * np.eye(2):
        ends = [by_array(set={"run.initial": list(x0 + sign * step)}).run().x[-1] for sign in (1, -1)]
        # Differences of the second order, and their rounding.
        _, tangent, _ = trajectory.jvp(step / 1e-5, x0=x0)
        assert np.allclose(tangent[-1], (ends[0] - ends[1]) / 2e-5, atol=1e-8)


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ({}, "the table `V` has no numbers"),
        ({"W": V}, "the scene has the tables V"),
        ({"V": V[:4]}, "takes 6 at least"),
        ({"V": np.where(V > 2, np.nan, V)}, "is NaN"),
        ({"V": V.reshape(1, -1)}, "have the shape"),
    ],
)
def test_wrong_arrays_are_refused(tables: Any, said: str) -> None:
    with pytest.raises(lw.LeafwiseError, match=said):
        lw.Scene.parse(TEXT, tables=tables).run()


def test_arrays_of_no_numbers_are_refused() -> None:
    with pytest.raises(TypeError, match="not real numbers"):
        lw.Scene.parse(TEXT, tables={"V": V.astype(complex)})
