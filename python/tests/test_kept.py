"""A scene keeps its method: how often it is composed, and the same bits as where it is composed for each run."""

import pickle
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest

import leafwise as lw
from leafwise._leafwise import compositions
from test_scenes import RIGID_BODY, SCENES


@contextmanager
def composing(times: int) -> Iterator[None]:
    before = compositions()
    yield
    assert compositions() - before == times


OTHERS: dict[str, Callable[[lw.Scene], lw.Scene]] = {
    "initial state": lambda scene: scene.set(run__initial=[2.0, 1.0, -1.0]),
    "steps": lambda scene: scene.set(run__steps=37),
    "a step": lambda scene: scene.set(method__time_step=0.037),
    "samples": lambda scene: scene.set(run__record__every=7),
    "times": lambda scene: scene.set(run__record__times=[0.0, 0.33, 4.001]),
    "all": lambda scene: scene.set(run__initial=[0.1, 0.2, 3.0], run__steps=11, method__time_step=-0.2).set(run__steps=12),
}


@pytest.mark.parametrize("other", OTHERS)
def test_values_leave_the_method_as_it_is(other: str) -> None:
    scene = lw.Scene(RIGID_BODY)
    scene.run(steps=1)
    changed = OTHERS[other](scene)
    with composing(0):
        run = changed.run()
        again = changed.integrator()
        samples = None if other == "times" else changed.trajectory()()
    with composing(1):
        anew = lw.Scene.parse(changed.text)
        expected = anew.run()
    np.testing.assert_array_equal(run.t, expected.t)
    np.testing.assert_array_equal(run.x, expected.x)
    assert run.drift == expected.drift and run.warnings == expected.warnings
    again.advance(run.steps)
    np.testing.assert_array_equal(again.x, run.final_state)
    if samples is not None:
        # A run also keeps its last state.
        np.testing.assert_array_equal(samples, run.x[: len(samples)])
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(changed)).run().x, run.x)


def test_calls_compose_once() -> None:
    scene = lw.Scene(RIGID_BODY)
    with composing(1):
        scene.run()
        for state in np.eye(3) + 1.0:
            scene.run(initial=state, steps=20, record=3)
            scene.integrator(initial=state).advance(3)
        scene.trajectory(["I1"])([1, 2, 3], [1.1])
        assert scene.variables and scene.parameters["I1"] == 1.0
        lw.Scene.parse(scene.text)
    with composing(1):
        # Parameters may choose another method.
        scene.set(system__parameters__I1=1.1).run()
    with composing(1):
        scene.set(method={"stepper": "splitting", "time-step": 0.1}).run()


def test_parameters_are_those_of_a_member() -> None:
    scene = lw.Scene(RIGID_BODY)
    members = scene.ensemble(parameters={"I2": [0.7, 0.8], "I3": [1.3, 1.2]})
    scene.run(steps=0)
    with composing(0):
        for member, (two, three) in enumerate([(0.7, 1.3), (0.8, 1.2)]):
            run = scene.run(parameters={"I2": two, "I3": three})
            np.testing.assert_array_equal(run.final_state, members.x[member])
            steps = scene.integrator(parameters={"I2": two, "I3": three})
            steps.advance(run.steps)
            np.testing.assert_array_equal(steps.x, members.x[member])
    with pytest.raises(lw.SceneError, match="J"):
        scene.run(parameters={"J": 1.0})
    with pytest.raises(ValueError, match="I1 is nan|not a finite number"):
        scene.run(parameters={"I1": np.nan})


@pytest.mark.parametrize("file", ["driven_pendulum.toml", "lotka_volterra_periodic.toml", "kepler.toml", "toda.toml", "spin_chain.toml"])
def test_scenes_of_all_kinds_step_to_the_same_bits(file: str) -> None:
    scene = lw.Scene.load(SCENES / file)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lw.LeafwiseWarning)
        is_paced = "until" in scene.text
        changed = scene.set(run__record__every=5) if is_paced else scene.set(run__steps=40)
        scene._scene.describe()
        np.testing.assert_array_equal(changed.run().x, lw.Scene.parse(changed.text, name=changed.name).run().x)


def test_times_that_a_run_does_not_come_to_are_refused_with_a_kept_method_too() -> None:
    scene = lw.Scene(RIGID_BODY)
    scene.run(steps=1)
    with pytest.raises(lw.SceneError, match="the run ends at t = 20.0, before t = 21"):
        scene.set(run__record__times=[21.0]).run()
    assert scene.run(until=3.0).t[-1] == 3.0
    with pytest.warns(lw.LeafwiseWarning, match="`until` = 3.05 is not a whole number of steps of 0.1"):
        assert scene.run(until=3.05).t[-1] == pytest.approx(3.05, rel=1e-15)
    with pytest.raises(lw.SceneError, match="3, one for each variable"):
        scene.run(initial=[1.0])
