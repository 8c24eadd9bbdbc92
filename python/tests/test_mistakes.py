"""What is wrong is an exception with the program's words, and nothing that was computed is lost."""

import os
import subprocess
import sys
import textwrap

import numpy as np
import pytest

import leafwise as lw
from test_scenes import RIGID_BODY


def changed(section: str, **values: object) -> dict[str, object]:
    return RIGID_BODY | {section: RIGID_BODY[section] | values}


@pytest.mark.parametrize(
    "table, words",
    [
        (changed("method", **{"time-stepp": 0.1}), r"time-stepp"),
        (changed("run", initial=[1.0, 2.0]), r"3"),
        (changed("run", initial=np.ones((2, 3))), r"initial"),
        (changed("run", initial=[1.0, float("nan"), 2.0]), r"nan"),
        (changed("system", hamiltonian="x1^2 + x4"), r"x4"),
        ({"system": {}}, r"variables"),
    ],
)
def test_a_scene_that_is_not_valid_says_where(table: dict[str, object], words: str) -> None:
    with pytest.raises(lw.SceneError, match=words) as error:
        lw.Scene(table).run()
    assert "scene.toml:" in str(error.value)


def test_what_no_scene_holds() -> None:
    with pytest.raises(TypeError, match=r"run.initial\[1\]: .* not complex"):
        lw.Scene(changed("run", initial=[1.0, 2j, 3.0]))
    with pytest.raises(TypeError, match="system.parameters: keys are strings"):
        lw.Scene(changed("system", parameters={1: 2.0}))
    with pytest.raises(TypeError, match="needs sections"):
        lw.Scene()
    with pytest.raises(FileNotFoundError):
        lw.Scene.load("there_is_none.toml")


def test_a_tensor_that_is_not_poisson_is_refused() -> None:
    bracket = RIGID_BODY["system"]["bracket"] | {"x1,x2": "-x3 - x1^2"}
    scene = lw.Scene(changed("system", bracket=bracket, casimirs={}))
    assert scene.check()["jacobi"]["verdict"] == "violated"
    with pytest.raises(lw.SceneError, match="Jacobi"):
        scene.run()


def test_a_step_that_fails_keeps_what_was_recorded() -> None:
    scene = lw.Scene(changed("method", **{"time-step": 50.0}))
    with pytest.raises(lw.IntegrationError, match="step 1 failed at t = 0") as error:
        scene.run()
    assert error.value.run.outcome == "failed"
    assert error.value.run.x.tolist() == [[1.0, 3.0, 3.0]]


def test_a_warning_is_a_warning() -> None:
    unused = RIGID_BODY["system"]["parameters"] | {"I4": 2.0}
    with pytest.warns(lw.LeafwiseWarning, match="I4"):
        lw.Scene(changed("system", parameters=unused)).run(steps=1)


def test_what_a_function_raises_ends_the_run() -> None:
    class Enough(Exception):
        pass

    def stop(made: int, total: int) -> None:
        assert 0 < made < total
        raise Enough

    with pytest.raises(Enough):
        lw.Scene(RIGID_BODY).run(steps=10**12, record=10**11, progress=stop)


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_an_interruption_keeps_what_was_recorded() -> None:
    program = """
    import os, signal, warnings
    import leafwise as lw
    from test_scenes import RIGID_BODY

    # A process in the background may have been started to ignore it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    calls = 0

    def interrupt(made, total):
        global calls
        calls += 1
        assert calls < 100, "the run goes on"
        os.kill(os.getpid(), signal.SIGINT)

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run = lw.Scene(RIGID_BODY).run(steps=10**9, record=1000, progress=interrupt)
    assert run.outcome == "interrupted", run
    assert len(run.t) == run.steps // 1000 + 1
    assert "interrupted after" in str(caught[-1].message)
    print("kept")
    """
    told = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)],
        cwd=os.path.dirname(__file__),
        capture_output=True,
        text=True,
        check=False,
    )
    assert told.stdout == "kept\n", told.stderr


# JAX, where a test before took it, warns that its threads are not in the child, which takes none.
@pytest.mark.filterwarnings("ignore:os.fork")
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_child_process_steps_too() -> None:
    scene = lw.Scene(RIGID_BODY)
    states = np.random.default_rng(1).normal([1.0, 3.0, 3.0], 0.1, (20, 3))
    # The parent's threads, which step its members, are not in the child.
    expected, members = scene.run().final_state, scene.ensemble(states, progress=False).x
    child = os.fork()
    if child == 0:
        same = np.array_equal(scene.run().final_state, expected)
        same = same and np.array_equal(scene.ensemble(states, progress=False).x, members)
        os._exit(0 if same else 1)
    _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == 0


def test_the_program_is_there() -> None:
    told = subprocess.run(
        [sys.executable, "-m", "leafwise", "--version"], capture_output=True, text=True, check=False
    )
    assert told.returncode == 0 and told.stdout.startswith("leafwise ")
    told = subprocess.run(
        [sys.executable, "-m", "leafwise", "run"], capture_output=True, text=True, check=False
    )
    assert told.returncode == 2 and "SCENE" in told.stderr
