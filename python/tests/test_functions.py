"""Systems of functions of Python, against the same system by formulas."""

import os
import pickle
import signal
import subprocess
import sys
import textwrap
import threading
import warnings

import numpy as np
import pytest

import leafwise as lw
from test_scenes import RIGID_BODY

METHOD = {
    "realization": "karasev-collocated",
    "dynamics": {"name": "hamilton-jacobi", "order": 2},
    "time-step": 0.1,
}
RUN = {"initial": [1.0, 3.0, 3.0], "steps": 50}


def energy(x: np.ndarray, I2: float = 1.5) -> np.ndarray:
    return x[0] ** 2 / 4 + x[1] ** 2 / (2 * I2) + x[2] ** 2 / 5


def gradient(x: np.ndarray, I2: float = 1.5) -> list[np.ndarray]:
    return [x[0] / 2, x[1] / I2, x[2] / 2.5]


def tensor(x: np.ndarray, p: np.ndarray, I2: float = 1.5) -> np.ndarray:
    return np.cross(x, p, axis=0)


def spin(x: np.ndarray, I2: float = 1.5) -> np.ndarray:
    return (x**2).sum(0)


def body(**changes: object) -> lw.System:
    own = {"hamiltonian": energy, "gradient": gradient, "tensor": tensor, "casimirs": {"spin": spin}}
    with pytest.warns(lw.LeafwiseWarning, match="hundred times faster"):
        return lw.System(variables=["x1", "x2", "x3"], **(own | changes))


def formulas(**run: object) -> lw.Scene:
    system = {
        "variables": ["x1", "x2", "x3"],
        "parameters": {"I2": 1.5},
        "bracket": {"x1,x2": "-x3", "x2,x3": "-x1", "x3,x1": "-x2"},
        "hamiltonian": "x1^2/4 + x2^2/(2*I2) + x3^2/5",
        "casimirs": {"spin": "x1^2 + x2^2 + x3^2"},
    }
    return lw.Scene(system=system, method=METHOD, run=RUN | run)


def test_the_tensor_is_that_of_the_bracket() -> None:
    """Π(x)p = x × p for {x1, x2} = −x3: checked against the matrix itself."""
    x, p = np.array([[1.0], [2.0], [3.0]]), np.array([[-0.3], [0.7], [0.2]])
    matrix = np.array([[0, -x[2, 0], x[1, 0]], [x[2, 0], 0, -x[0, 0]], [-x[1, 0], x[0, 0], 0]])
    np.testing.assert_allclose(tensor(x, p), matrix @ p, rtol=1e-15)


@pytest.mark.parametrize("method", [METHOD, {"stepper": "implicit-midpoint", "time-step": 0.1}])
def test_functions_step_as_formulas_do(method: dict[str, object]) -> None:
    scene = lw.Scene(system=body(), method=method, run=RUN)
    own = scene.run()
    by_formulas = lw.Scene(system=formulas_system(), method=method, run=RUN).run()
    # Rounding differs in each of the 50 steps.
    np.testing.assert_allclose(own.x, by_formulas.x, rtol=0, atol=50 * 1e-13)
    assert own.drift["spin"] < 1e-12
    np.testing.assert_allclose(own.energy, energy(own.x.T), rtol=1e-14)
    assert scene.variables == ["x1", "x2", "x3"] and scene.casimirs == ["spin"]


def formulas_system() -> dict[str, object]:
    return {
        "variables": ["x1", "x2", "x3"],
        "bracket": {"x1,x2": "-x3", "x2,x3": "-x1", "x3,x1": "-x2"},
        "hamiltonian": "x1^2/4 + x2^2/3 + x3^2/5",
        "casimirs": {"spin": "x1^2 + x2^2 + x3^2"},
    }


def test_solve_takes_functions() -> None:
    given = lw.solve(system=body(), x0=[1, 3, 3], t_span=(0, 2), t_eval=[1, 2], rtol=1e-7)
    exact = lw.solve(**formulas_system(), x0=[1, 3, 3], t_span=(0, 2), t_eval=[1, 2], rtol=1e-10)
    np.testing.assert_allclose(given.y, exact.y, rtol=0, atol=3e-7 * 3)
    with pytest.raises(ValueError, match="system or hamiltonian, not both"):
        lw.solve(system=body(), hamiltonian="x1", x0=[1, 3, 3], t_span=(0, 2))


def test_members_and_parameters() -> None:
    states = np.random.default_rng(1).normal([1.0, 3.0, 3.0], 0.1, (6, 3))
    values = np.linspace(1.4, 1.6, 6)
    cloud = lw.Scene(system=body(parameters={"I2": 1.5}), method=METHOD, run=RUN).ensemble(states, {"I2": values}, threads=2)
    by_formulas = formulas().ensemble(states, {"I2": values})
    np.testing.assert_allclose(cloud.x, by_formulas.x, rtol=0, atol=50 * 1e-13)


def test_a_scene_of_functions_is_pickled_by_its_functions() -> None:
    scene = lw.Scene(system=body(), method=METHOD, run=RUN)
    again = pickle.loads(pickle.dumps(scene))
    np.testing.assert_array_equal(again.run(steps=5).x, scene.set(run__steps=5).run().x)


class Broken(Exception):
    pass


def after(calls: int, error: BaseException):
    """H that raises after so many calls."""
    count = 0

    def hamiltonian(x: np.ndarray) -> np.ndarray:
        nonlocal count
        count += 1
        if count > calls:
            raise error
        return energy(x)

    return hamiltonian


@pytest.mark.parametrize("calls", [0, 1, 7, 40])
def test_what_a_function_raises_comes_out(calls: int) -> None:
    def scene() -> lw.Scene:
        return lw.Scene(system=body(hamiltonian=after(calls, Broken("here"))), method=METHOD, run=RUN)

    with pytest.raises(Broken, match="here"):
        scene().run()
    with pytest.raises(Broken, match="here"):
        scene().ensemble(np.ones((30, 3)), threads=3)


def test_what_a_function_raises_ends_a_loop() -> None:
    def broken(x: np.ndarray) -> np.ndarray:
        if x[0].max() < 0.9:
            raise Broken
        return np.array(gradient(x))

    integrator = lw.Scene(system=body(gradient=broken), method=METHOD, run=RUN).integrator()
    with pytest.raises(Broken):
        integrator.advance(1000)
    with pytest.raises(Broken):
        for _ in range(1000):
            integrator.step()


def test_a_function_that_steps_its_own_integrator_is_told() -> None:
    own: list[lw.Integrator] = []

    def recursive(x: np.ndarray) -> np.ndarray:
        if own:
            own[0].step()
        return np.array(gradient(x))

    own_scene = lw.Scene(system=body(gradient=recursive), method=METHOD, run=RUN)
    integrator = own_scene.integrator()
    own.append(integrator)
    with pytest.raises(RuntimeError, match="is stepping"):
        integrator.step()


@pytest.mark.parametrize(
    "change, error, words",
    [
        ({"hamiltonian": lambda x: x[:, 0] ** 2}, ValueError, r"hamiltonian returned the shape \(3,\) where \(1,\)"),
        ({"gradient": lambda x: x[:2]}, ValueError, r"gradient returned the shape \(2, 1\) where \(3, 1\)"),
        ({"tensor": lambda x, p: 1j * x}, TypeError, "tensor returned complex128"),
        ({"gradient": lambda x: None}, TypeError, "gradient returned object"),
        ({"gradient": lambda x: ["a", "b", "c"]}, TypeError, "gradient returned <U1"),
        ({"casimirs": {"spin": lambda x: x}}, ValueError, "spin returned the shape"),
        ({"hamiltonian": lambda: 0.0}, TypeError, "positional argument"),
        ({"gradient": lambda x: x * np.nan}, lw.LeafwiseError, "finite"),
    ],
)
def test_a_function_that_returns_something_else(change: dict[str, object], error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        lw.Scene(system=body(**change), method=METHOD, run=RUN).run()


@pytest.mark.parametrize(
    "change, error, words",
    [
        ({"hamiltonian": "x1^2"}, TypeError, "not a function"),
        ({"parameters": {"x1": 1.0}}, ValueError, "'x1' is taken"),
        ({"casimirs": {"energy": spin}}, ValueError, "'energy' is taken"),
        ({"parameters": {"2a": 1.0}}, ValueError, "'2a' is no name"),
    ],
)
def test_what_is_no_system(change: dict[str, object], error: type[Exception], words: str) -> None:
    own = {"hamiltonian": energy, "gradient": gradient, "tensor": tensor}
    with pytest.raises(error, match=words):
        lw.System(variables=["x1", "x2", "x3"], **(own | change))


def test_commands_say_that_they_know_no_functions() -> None:
    with pytest.raises(lw.LeafwiseError, match="`check` works on scenes of formulas and plugins"):
        lw.Scene(system=body(), method=METHOD, run=RUN).check()


def test_a_part_that_needs_formulas_says_so() -> None:
    with pytest.raises(lw.SceneError, match="formulas|does not offer"):
        lw.Scene(system=body(), method={"stepper": "splitting", "time-step": 0.1}, run=RUN).run()


def test_two_threads_keep_their_own_exceptions() -> None:
    """Each run tells what was raised in it, though both share a scene."""
    turn = threading.local()

    def hamiltonian(x: np.ndarray) -> np.ndarray:
        if getattr(turn, "error", None):
            raise turn.error
        return energy(x)

    scene = lw.Scene(system=body(hamiltonian=hamiltonian), method=METHOD, run=RUN)
    ends: dict[int, object] = {}

    def work(at: int) -> None:
        turn.error = Broken(str(at)) if at % 2 else None
        try:
            ends[at] = scene.run(steps=20).outcome
        except Broken as error:
            ends[at] = str(error)

    threads = [threading.Thread(target=work, args=(at,)) for at in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert ends == {0: "done", 1: "1", 2: "done", 3: "3", 4: "done", 5: "5"}


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_within_a_function_keeps_what_was_recorded() -> None:
    program = """
    import os, signal, warnings
    warnings.simplefilter("ignore")
    import leafwise as lw
    from test_functions import METHOD, RUN, energy, gradient, tensor

    signal.signal(signal.SIGINT, signal.default_int_handler)
    calls = 0

    def own(x):
        global calls
        calls += 1
        if calls == 3000:
            os.kill(os.getpid(), signal.SIGINT)
            for _ in range(100000):
                pass
        return gradient(x)

    system = lw.System(variables=["x1", "x2", "x3"], hamiltonian=energy, gradient=own, tensor=tensor)
    run = lw.Scene(system=system, method=METHOD, run=RUN).run(steps=10**7)
    assert run.outcome == "interrupted" and len(run.t) == run.steps + 1 > 10, run
    print("kept")
    """
    told = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)],
        cwd=os.path.dirname(__file__), capture_output=True, text=True, check=False,
    )
    assert told.stdout == "kept\n", told.stderr


@pytest.mark.parametrize(
    "change, words",
    [
        ({"gradient": lambda x: [x[0], x[1] / 1.5, x[2] / 2.5]}, r"`gradient` is not that of `hamiltonian`: by x1 it is 1\.000000, and differences of `hamiltonian` give 0\.500000"),
        ({"gradient": lambda x: [x[0] / 2, x[1] / 1.5, x[2] / 2.5 + 1e-4]}, "by x3 it is 1.200100"),
        ({"hamiltonian": lambda x: energy(x) + x[0] * x[1] ** 2}, "by x1 it is 0.5"),
        ({"tensor": lambda x, p: x * p}, "`tensor` is not antisymmetric"),
        ({"tensor": lambda x, p: np.cross(x, p, axis=0) + 1e-4 * p}, "`tensor` is not antisymmetric"),
        ({"tensor": lambda x, p: np.cross(x, p, axis=0) * np.abs(p).sum(0)}, r"`tensor` is not linear in p"),
        ({"tensor": lambda x, p: np.cross(x, p, axis=0) + x[[1, 2, 0]]}, r"`tensor` is not linear in p"),
        ({"tensor": lambda x, p: np.cross(x * [[1.0], [2.0], [3.0]] + x[::-1] ** 2, p, axis=0), "casimirs": {}}, "Jacobi identity fails"),
        ({"casimirs": {"c": lambda x: x[0]}}, "`c` is not a Casimir"),
    ],
)
def test_functions_that_are_those_of_no_poisson_system_are_refused(change: dict[str, object], words: str) -> None:
    scene = lw.Scene(system=body(**change), method=METHOD, run=RUN)
    for call in (scene.run, scene.integrator, scene.trajectory, lambda: scene.ensemble(np.ones((2, 3)))):
        with pytest.raises(lw.SceneError, match=words):
            call()
    with pytest.raises(lw.SceneError, match=words):
        lw.solve(system=body(**change), x0=[1, 3, 3], t_span=(0, 1), step=0.1)


def test_functions_of_single_precision_and_of_a_small_domain_are_let_pass() -> None:
    def single(x: np.ndarray) -> np.ndarray:
        return np.array(gradient(x)).astype(np.float32).astype(np.float64)

    def within(x: np.ndarray) -> np.ndarray:
        if x.max() > 3.1:
            raise ValueError("no energy here")
        return energy(x)

    for change in ({"gradient": single}, {"hamiltonian": within}, {"hamiltonian": lambda x: energy(x) + 1e6}):
        run = lw.Scene(system=body(**change), method=METHOD, run=RUN).run(steps=0)
        assert run.outcome == "done"


def test_parameters_of_functions_are_set_and_swept() -> None:
    system = body(parameters={"I2": 1.5})
    scene = lw.Scene(system=system, method=METHOD, run=RUN)
    inertia = [1.4, 1.5, 1.6]
    single = [formulas().set(system__parameters__I2=value).run().final_state for value in inertia]
    for value, expected in zip(inertia, single, strict=True):
        other = scene.set(system__parameters__I2=value)
        assert other.parameters == {"I2": value} and scene.parameters == {"I2": 1.5}
        np.testing.assert_allclose(other.run().final_state, expected, rtol=1e-12)
        assert pickle.loads(pickle.dumps(other)).parameters == {"I2": value}
        solved = lw.solve(system=system, parameters={"I2": value}, x0=[1, 3, 3], t_span=(0, 5), step=0.1, method=METHOD)
        np.testing.assert_allclose(solved.y[:, -1], expected, rtol=1e-12)
    table = scene.sweep({"system.parameters.I2": inertia}, observables=["x1", "x2", "x3"])
    np.testing.assert_allclose(np.stack(list(table.observables.values()), 1), single, rtol=1e-12)
    np.testing.assert_allclose(scene.ensemble(parameters={"I2": inertia}).x, single, rtol=1e-12)
    with pytest.raises(lw.SceneError, match="unknown parameter of this system `I9`(.|\n)*I2"):
        scene.set(system__parameters__I9=1.0)
    with pytest.raises(lw.SceneError, match="I2(.|\n)*a number"):
        scene.set(system__parameters__I2="long")
