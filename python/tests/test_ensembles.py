"""Ensembles from arrays, against the program's own files and single runs."""

import threading
import warnings
from pathlib import Path

import numpy as np
import pytest

import leafwise as lw
from test_scenes import RIGID_BODY

CLOUD = np.random.default_rng(5).normal([1.0, 3.0, 3.0], 0.2, (40, 3))
INERTIA = np.linspace(0.7, 0.8, 40)

SPLITTING = RIGID_BODY | {"method": {"stepper": "splitting", "time-step": 0.05}}
EVENTS = RIGID_BODY | {
    "run": RIGID_BODY["run"] | {"stop": "x1 > 3.8", "section": {"at": "x1 = 0", "direction": "up"}}
}


def test_members_are_runs_of_their_own() -> None:
    for table in (SPLITTING, RIGID_BODY):
        scene = lw.Scene(table)
        cloud = scene.ensemble(CLOUD, {"I2": INERTIA})
        assert len(cloud) == 40 and cloud.outcome == "done"
        np.testing.assert_array_equal(cloud.x0, CLOUD)
        np.testing.assert_array_equal(cloud.parameters["I2"], INERTIA)
        # The method is chosen at the scene's own parameters.
        chosen = {"chosen-at": {"I2": 0.75}} if table is RIGID_BODY else {}
        for k in (0, 17, 39):
            own = table["system"] | {"parameters": table["system"]["parameters"] | {"I2": INERTIA[k]}}
            alone = lw.Scene(table, system=own, method=table["method"] | chosen).run(initial=CLOUD[k])
            np.testing.assert_array_equal(cloud.x[k], alone.final_state)
            assert cloud.t[k] == alone.final_time
            for name, largest in alone.drift.items():
                assert cloud.drift[name][k] == largest
            assert cloud.observables["energy"][k] == alone.energy[-1]


def test_an_array_is_the_programs_file(tmp_path: Path) -> None:
    """The same members by a file of the program: every table to the byte, whatever the threads."""
    rows = "\n".join(",".join(map(repr, [*x, i])) for x, i in zip(CLOUD.tolist(), INERTIA.tolist(), strict=True))
    (tmp_path / "members.csv").write_text(f"x1,x2,x3,I2\n{rows}\n")
    table = EVENTS | {"ensemble": {"initial": {"file": "members.csv"}, "final-states": "csv"}}
    file = tmp_path / "scene.toml"
    file.write_text(lw.Scene(table).text)
    code, _, err = lw._leafwise.command(["ensemble", str(file), "--out", str(tmp_path / "out")])
    assert code == 0, err
    own = np.genfromtxt(tmp_path / "out/final_states.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    section = np.loadtxt(tmp_path / "out/section.csv", delimiter=",", skiprows=1, ndmin=2)
    losses = np.loadtxt(tmp_path / "out/losses.csv", delimiter=",", skiprows=1, ndmin=2)
    found = [lw.Scene(EVENTS).ensemble(CLOUD, {"I2": INERTIA}, threads=threads) for threads in (1, 3)]
    found.append(lw.Scene.load(file).ensemble())
    for cloud in found:
        assert cloud.outcomes.tolist() == own["outcome"].tolist()
        assert {"done", "stopped"} == set(cloud.outcomes)
        np.testing.assert_array_equal(cloud.t, own["t"])
        np.testing.assert_array_equal(cloud.x, np.stack([own[name] for name in cloud.names], 1))
        np.testing.assert_array_equal(cloud.drift["spin"], own["spin_drift"])
        assert cloud.crossings is not None and cloud.losses is not None
        np.testing.assert_array_equal(cloud.crossings.member, section[:, 0])
        np.testing.assert_array_equal(cloud.crossings.t, section[:, 1])
        np.testing.assert_array_equal(cloud.crossings.x, section[:, 2:5])
        np.testing.assert_array_equal(cloud.crossings.observables["energy"], section[:, 5])
        np.testing.assert_array_equal(cloud.losses.t, losses[:, 0])
        np.testing.assert_array_equal(cloud.losses.stopped, losses[:, 1])
        np.testing.assert_array_equal(np.stack(cloud.losses[2:], 1), losses[:, 3:])


def test_one_of_states_and_parameters_is_enough() -> None:
    scene = lw.Scene(SPLITTING)
    states = scene.ensemble(CLOUD, steps=20, record=5, quantiles=[0.5])
    assert states.parameters == {} and states.losses is None and states.crossings is None
    np.testing.assert_array_equal(states.t, np.full(40, 1.0))
    assert [row["time"] for row in states.statistics] == [0.0, 0.25, 0.5, 0.75, 1.0]
    energies = [x @ (x / [2, 1.5, 2.5]) for x in CLOUD]
    np.testing.assert_allclose(states.statistics[0]["energy"]["mean"], np.mean(energies), rtol=1e-14)
    values = scene.ensemble(parameters={"I1": INERTIA, "I3": INERTIA + 1}, steps=20)
    np.testing.assert_array_equal(values.x0, np.tile([1.0, 3.0, 3.0], (40, 1)))
    assert list(values.parameters) == ["I1", "I3"]
    frame = values.to_pandas()
    np.testing.assert_array_equal(frame["x2"], values.x[:, 1])
    assert "<svg" in values.report() and values._repr_html_().startswith("<iframe")
    assert "40 members, 40 done" in repr(values)
    with pytest.raises(lw.SceneError, match="give x0, parameters or both"):
        scene.ensemble()


def test_arrays_of_every_kind_are_read_and_none_is_written() -> None:
    scene = lw.Scene(SPLITTING)
    wide = np.zeros((40, 6))
    wide[:, ::2] = CLOUD
    frozen = CLOUD.copy()
    frozen.flags.writeable = False
    expected = scene.ensemble(CLOUD, steps=5).x
    for states in (wide[:, ::2], np.asfortranarray(CLOUD), frozen, CLOUD.tolist(), CLOUD.astype(">f8")):
        np.testing.assert_array_equal(scene.ensemble(states, steps=5).x, expected)
    np.testing.assert_array_equal(wide[:, ::2], CLOUD)
    whole = scene.ensemble(np.array([[1, 3, 3]]), {"I2": np.array([1], dtype=np.int8)}, steps=5)
    halves = scene.ensemble(np.float32([[1, 3, 3]]), {"I2": [1.0]}, steps=5)
    np.testing.assert_array_equal(whole.x, halves.x)


@pytest.mark.parametrize(
    "states, parameters, error, words",
    [
        (CLOUD[0], {}, ValueError, r"x0 has the shape \(3,\), not \(n, 3\)"),
        (CLOUD[:, :2], {}, ValueError, r"x0 has the shape \(40, 2\), not \(n, 3\)"),
        (CLOUD[:0], {}, ValueError, "no members"),
        (np.where(np.arange(120).reshape(40, 3) == 7, np.nan, CLOUD), {}, ValueError, r"x0\[2, 1\] is nan"),
        (CLOUD + 0j, {}, TypeError, "complex128, not real numbers"),
        (CLOUD.astype(object), {}, TypeError, "object, not real numbers"),
        (CLOUD > 1, {}, TypeError, "bool, not real numbers"),
        (CLOUD, {"I2": INERTIA[:-1]}, ValueError, "I2 has 39 values for 40 members"),
        (CLOUD, {"I2": INERTIA.reshape(40, 1)}, ValueError, r"I2 has the shape \(40, 1\), not \(n,\)"),
        (CLOUD, {"I2": INERTIA * np.inf}, ValueError, r"I2\[0\] is inf"),
        (CLOUD, {"I4": INERTIA}, lw.SceneError, "`I4` is not a parameter of the system"),
    ],
)
def test_members_that_are_refused(
    states: np.ndarray, parameters: dict[str, np.ndarray], error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        lw.Scene(SPLITTING).ensemble(states, parameters)


def test_a_member_that_fails_ends_no_other() -> None:
    scene = lw.Scene(RIGID_BODY)
    states = CLOUD.copy()
    states[3] *= 1e3
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", lw.LeafwiseWarning)
        cloud = scene.ensemble(states, steps=10)
    message = f"1 of {len(CLOUD)} members failed; statistics cover the others: see failures"
    assert cloud.failed == 1 and message in [str(one.message) for one in told]
    assert cloud.outcomes[3] == "failed" and np.count_nonzero(cloud.outcomes == "failed") == 1
    assert cloud.failures[0]["member"] == 3 and cloud.failures[0]["message"]
    assert np.isnan(cloud.drift["energy"][3]) and np.isfinite(cloud.x).all()


def test_what_a_function_raises_ends_an_ensemble_in_any_thread() -> None:
    class Enough(Exception):
        pass

    def stop(made: int, total: int) -> None:
        raise Enough

    raised: list[BaseException] = []

    def step() -> None:
        try:
            lw.Scene(RIGID_BODY).ensemble(np.tile(CLOUD, (20, 1)), steps=200_000, progress=stop)
        except Enough as error:
            raised.append(error)

    thread = threading.Thread(target=step)
    thread.start()
    thread.join()
    assert len(raised) == 1


def test_the_scenes_own_ensemble() -> None:
    table = SPLITTING | {"ensemble": {"members": 12, "seed": 3, "initial": {"leaf": 0.1}}}
    scene = lw.Scene(table)
    cloud = scene.ensemble()
    assert len(cloud) == 12
    np.testing.assert_allclose((cloud.x0**2).sum(1), 19.0, rtol=1e-14)
    # Members in memory are all, whatever number the table has.
    assert len(scene.ensemble(CLOUD)) == 40
