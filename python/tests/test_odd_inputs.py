"""Whatever is given to a public function, it is taken or refused in words: no other exception, and nothing ends the process."""

import datetime
import decimal
import fractions
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import leafwise as lw
from test_inputs import OSCILLATOR, Quantity
from test_scenes import RIGID_BODY

#: Drawn for each argument of each function; the same in every run.
EXAMPLES = 40

#: So many of them no argument takes.
REFUSED = 8


class Own:
    """An object that is its own list."""

    def tolist(self) -> "Own":
        return self


class Empty:
    """An object with the name of everything and nothing in it."""

    dtype = shape = columns = iloc = dims = coords = mask = None

    def __array__(self, dtype: object = None, copy: object = None) -> np.ndarray:
        return np.zeros((2, 0))


class Raising:
    """An object that raises whatever is asked of it."""

    def __array__(self, dtype: object = None, copy: object = None) -> np.ndarray:
        raise ValueError("this object is no array")

    def __iter__(self) -> object:
        raise ValueError("this object has no items")

    def __float__(self) -> float:
        raise ValueError("this object is no number")

    def __index__(self) -> int:
        raise ValueError("this object is no whole number")


def holds_itself() -> list[object]:
    own: list[object] = [1.0]
    own.append(own)
    return own


def table_in_itself() -> dict[str, object]:
    own: dict[str, object] = {"q,p": "1"}
    own["more"] = own
    return own


class Nested(list[object]):
    """Lists within each other, which a report of a failure can show."""

    def __repr__(self) -> str:
        return "lists within each other"


def nested(depth: int) -> object:
    found: object = 1.0
    for _ in range(depth):
        found = Nested([found])
    return found


def frames() -> list[object]:
    import pandas
    import xarray

    rows = np.arange(6.0).reshape(3, 2)
    return [
        pandas.DataFrame(rows, columns=["q", "p"]),
        pandas.DataFrame(rows, columns=["p", "mass"]),
        pandas.DataFrame(rows, columns=["p", "p"]),
        pandas.DataFrame({"q": ["a", "b"], "p": [1, 2]}),
        pandas.DataFrame({"q": pandas.array([1, None], dtype="Int64"), "p": [1.0, 2.0]}),
        pandas.DataFrame(),
        pandas.Series([1.0, 2.0], index=["p", "q"]),
        pandas.Series([1.0, 2.0]),
        pandas.Series(["a", "b"], dtype="category"),
        pandas.Timestamp("2020-01-01"),
        pandas.NA,
        xarray.DataArray(rows, dims=("t", "coordinate"), coords={"coordinate": ["p", "q"]}),
        xarray.Dataset({"q": ("t", rows[:, 0])}),
    ]


DTYPES = ["?", "i1", "u8", "f2", "f4", "f8", ">f8", "g", "c16", "G", "M8[ns]", "m8[s]", "U3", "S3", "O", "V4", [("q", "f8"), ("p", "f8")]]
SHAPES = [(), (0,), (1,), (2,), (3,), (1, 2), (2, 1), (2, 2), (5, 2), (2, 2, 2), (0, 2), (2, 0)]


@st.composite
def arrays(draw: Any) -> object:
    dtype, shape = draw(st.sampled_from(DTYPES)), draw(st.sampled_from(SHAPES))
    of = np.zeros(shape, dtype)
    if of.dtype.kind in "iuf" and of.size:
        flat = of.reshape(-1)
        flat[:] = draw(st.lists(st.sampled_from([0, 1, 2, 100]), min_size=of.size, max_size=of.size))
        if of.dtype.kind == "f":
            flat[0] = draw(st.sampled_from([1.0, np.nan, np.inf, -0.0, 1e300]))
    if of.dtype.kind == "O" and of.size:
        one = np.empty(1, object)
        one[0] = draw(st.sampled_from([1.0, None, "a", [1], 2**70, Own()]))
        of.reshape(-1)[:1] = one
    kind = draw(st.sampled_from(["plain", "masked", "hidden", "turned", "fixed", "list"]))
    if kind in ("masked", "hidden"):
        return np.ma.masked_array(of, kind == "hidden")
    if kind == "turned":
        return of[::-1] if of.ndim else of.T
    if kind == "fixed":
        of.flags.writeable = False
    return of.tolist() if kind == "list" else of


PLAIN = st.sampled_from(
    [None, True, 0, 1, -1, 3, 2**31, 2**63 - 1, 2**63, -(2**63) - 1, 10**30, 10**400, 0.5, -1.0, 3.0, 5e-324, 1e300, float("nan")]
    + [float("inf"), 1j, "", "q", "qp", "energy", "1 +", "x" * 1000, "\0", "\ud800", "∂", b"q", bytearray(b"12"), object(), ...]
    + [decimal.Decimal("1.5"), fractions.Fraction(1, 3), datetime.datetime(2020, 1, 1), datetime.timedelta(1), Path("none"), lw, int]
    + [len, lambda *_: 1 / 0, {1.0, 2.0}, frozenset("qp"), range(2), range(10**6), (), [], {}, memoryview(b"12"), slice(2), Own(), Empty()]
    + [Raising(), Quantity([1.0, 2.0], "km"), [Quantity(1.0, "km")] * 2, holds_itself(), table_in_itself(), nested(40), nested(50_000)]
    + [{"q": 1.0, "p": 0.0}, {"p": 0}, {1: 2}, {"k": [1.0]}, {"k": None}, {"name": "auto"}, [["q", "p"]], ["k"], ["q", 1], [{"k": 1}]]
    + frames()
)
ODD = st.one_of(PLAIN, arrays(), st.lists(PLAIN, min_size=1, max_size=3), st.dictionaries(st.sampled_from(["k", "q", "run.steps"]), PLAIN, max_size=2))

SCENE = lw.Scene(OSCILLATOR | {"run": OSCILLATOR["run"] | {"steps": 10}})
TRAJECTORY = SCENE.trajectory(["k"])
RUN = SCENE.run()
PULL = TRAJECTORY.vjp()[1]
SOLUTION = lw.solve(**OSCILLATOR["system"], x0=[1.0, 0.0], t_span=(0, 1), step=0.1)
SYSTEM = {
    "variables": ["q", "p"],
    "hamiltonian": lambda x: (x**2).sum(0) / 2,
    "gradient": lambda x: x,
    "tensor": lambda x, p: [p[1], -p[0]],
}


def solved(**given: Any) -> object:
    return lw.solve(**({"x0": [1.0, 0.0], "t_span": (0.0, 1.0)} | OSCILLATOR["system"] | given))


def of_jax(*given: Any) -> object:
    pytest.importorskip("jax")
    import leafwise.jax

    return leafwise.jax.solve(TRAJECTORY, *given)


def of_torch(*given: Any) -> object:
    pytest.importorskip("torch")
    import leafwise.torch

    return leafwise.torch.solve(TRAJECTORY, *given)


def stepped(x: Any) -> object:
    lw.Scene(system=lw.System(**SYSTEM | x), method={"stepper": "implicit-midpoint", "time-step": 0.1}, run=SCENE_RUN).run()
    return None


#: States of a trajectory.
LEARNED = np.stack([np.cos(np.arange(12.0) / 9), -np.sin(np.arange(12.0) / 9)], axis=1)

SCENE_RUN = {"initial": [1.0, 0.5], "steps": 3}

FUNCTIONS: dict[str, Callable[[Any], object]] = {
    "Scene(x)": lambda x: lw.Scene(x).run(),
    "Scene(system=x)": lambda x: lw.Scene(OSCILLATOR, system=x).run(),
    "Scene(method=x)": lambda x: lw.Scene(OSCILLATOR, method=x).run(),
    "Scene(run=x)": lambda x: lw.Scene(OSCILLATOR, run=x).run(),
    "Scene(plugins=x)": lambda x: lw.Scene(OSCILLATOR, plugins=x).run(),
    "Scene(hamiltonian=x)": lambda x: lw.Scene(OSCILLATOR, system=OSCILLATOR["system"] | {"hamiltonian": x}).run(),
    "Scene.parse(x)": lambda x: lw.Scene.parse(x),
    "Scene.parse(set=x)": lambda x: lw.Scene.parse(SCENE.text, set=x),
    "Scene.load(x)": lambda x: lw.Scene.load(x),
    "set(parameter)": lambda x: SCENE.set(system__parameters__k=x).run(),
    "set(initial)": lambda x: SCENE.set(run__initial=x).run(),
    "set(method)": lambda x: SCENE.set(method=x).run(),
    "set(record)": lambda x: SCENE.set(run__record=x).run(),
    "run(steps)": lambda x: SCENE.run(steps=x),
    "run(until)": lambda x: SCENE.run(until=x),
    "run(record)": lambda x: SCENE.run(record=x),
    "run(initial)": lambda x: SCENE.run(initial=x),
    "run(allow)": lambda x: SCENE.run(allow_non_poisson=x),
    "ensemble(x0)": lambda x: SCENE.ensemble(x),
    "ensemble(parameters)": lambda x: SCENE.ensemble(parameters=x),
    "ensemble(k)": lambda x: SCENE.ensemble(parameters={"k": x}),
    "ensemble(steps)": lambda x: SCENE.ensemble([[1.0, 0.0]], steps=x, record=2**60) if not _is_long(x) else None,
    "ensemble(record)": lambda x: SCENE.ensemble([[1.0, 0.0]], record=x),
    "ensemble(quantiles)": lambda x: SCENE.ensemble([[1.0, 0.0]], quantiles=x),
    "ensemble(threads)": lambda x: SCENE.ensemble([[1.0, 0.0]], threads=x),
    "ensemble(executor)": lambda x: SCENE.ensemble([[1.0, 0.0]], executor=x),
    "ensemble(shards)": lambda x: SCENE.ensemble([[1.0, 0.0]], shards=x),
    "sweep(grid)": lambda x: SCENE.sweep(x),
    "sweep(values)": lambda x: SCENE.sweep({"system.parameters.k": x}),
    "sweep(settings)": lambda x: SCENE.sweep(settings=x),
    "sweep(observables)": lambda x: SCENE.sweep({"system.parameters.k": [1.0]}, observables=x),
    "sweep(threads)": lambda x: SCENE.sweep({"system.parameters.k": [1.0]}, threads=x),
    "sweep(executor)": lambda x: SCENE.sweep({"system.parameters.k": [1.0]}, executor=x),
    "learn(pairs)": lambda x: lw.learn(x, SCENE),
    "learn(scene)": lambda x: lw.learn(np.zeros((3, 2)), x),
    "learn(basis)": lambda x: lw.learn(LEARNED, SCENE, x),
    "learn(degree)": lambda x: lw.learn(LEARNED, SCENE, degree=x),
    "learn(time_step)": lambda x: lw.learn(LEARNED, SCENE, degree=1, time_step=x),
    "learn(ridge)": lambda x: lw.learn(LEARNED, SCENE, degree=1, ridge=x),
    "learn(weights)": lambda x: lw.learn(LEARNED, SCENE, degree=1, weights=x),
    "learn(noisy)": lambda x: lw.learn(LEARNED, SCENE, degree=1, noisy=x),
    "find(equations)": lambda x: lw.find(x),
    "tabulate(scene)": lambda x: lw.tabulate(x, 2),
    "tabulate(steps)": lambda x: lw.tabulate(SCENE, x, degree=1) if not _is_long(x) else None,
    "tabulate(box)": lambda x: lw.tabulate(SCENE, 2, x, degree=1),
    "tabulate(states)": lambda x: lw.tabulate(SCENE, 2, states=x, degree=1),
    "orbit(scene)": lambda x: lw.orbit(x),
    "orbit(period)": lambda x: lw.orbit(SCENE, x, steps=20),
    "orbit(steps)": lambda x: lw.orbit(SCENE, 6.2, steps=x) if not _is_long(x) else None,
    "orbit_family(scene)": lambda x: lw.orbit_family(x, "energy", 1.0),
    "orbit_family(along)": lambda x: lw.orbit_family(SCENE, x, 0.5, 6.2, steps=20, orbits=2),
    "orbit_family(to)": lambda x: lw.orbit_family(SCENE, "energy", x, 6.2, steps=20, orbits=2),
    "orbit_family(orbits)": lambda x: lw.orbit_family(SCENE, "k", 1.5, 6.2, steps=20, orbits=x) if not _is_long(x) else None,
    "equilibrium_point(scene)": lambda x: lw.equilibrium_point(x),
    "casimirs(scene)": lambda x: lw.casimirs(x),
    "import_boozer(source)": lambda x: lw.import_boozer(x, "nowhere"),
    "import_boozer(surface)": lambda x: lw.import_boozer(__file__, "nowhere", surface=x),
    "import_equilibrium(file)": lambda x: lw.import_equilibrium(x, "nowhere"),
    "import_equilibrium(energy)": lambda x: lw.import_equilibrium(__file__, "nowhere", energy=x),
    "write_fmu(scene)": lambda x: lw.write_fmu(x, "nowhere.fmu", library=__file__),
    "write_fmu(library)": lambda x: lw.write_fmu(SCENE, "nowhere.fmu", library=x),
    "find(parameters)": lambda x: lw.find({"q": "p", "p": "-k*q"}, parameters=x),
    "state_error": lambda x: SCENE.state_error(steps=x) if not _is_long(x) else None,
    "integrator.advance": lambda x: SCENE.integrator().advance(x) if not _is_long(x) else None,
    "integrator.copy_to": lambda x: SCENE.integrator().copy_to(x),
    "trajectory(parameters)": lambda x: SCENE.trajectory(x),
    "trajectory(steps)": lambda x: SCENE.trajectory(["k"], steps=x)(),
    "trajectory(record)": lambda x: SCENE.trajectory(["k"], record=x)(),
    "x(x0)": lambda x: TRAJECTORY(x),
    "x(values)": lambda x: TRAJECTORY(values=x),
    "jvp(dx0)": lambda x: TRAJECTORY.jvp(x),
    "jvp(dvalues)": lambda x: TRAJECTORY.jvp(None, x),
    "jvp(x0)": lambda x: TRAJECTORY.jvp([1.0, 0.0], x0=x),
    "vjp(x0)": lambda x: TRAJECTORY.vjp(x),
    "pull(w)": lambda x: PULL(x),
    "fit(data)": lambda x: SCENE.fit(x, ["k"]),
    "fit(parameters)": lambda x: SCENE.fit(RUN.x, x),
    "fit(sigma)": lambda x: SCENE.fit(RUN.x, ["k"], sigma=x),
    "fit(observed)": lambda x: SCENE.fit(RUN.x, ["k"], observed=x),
    "fit(record)": lambda x: SCENE.fit(RUN.x, ["k"], record=x),
    "fit(iterations)": lambda x: SCENE.fit(RUN.x, ["k"], iterations=x),
    "command(x)": lambda x: lw.command(x),
    "command(check, x)": lambda x: SCENE.command("check", x),
    "describe": lambda x: lw.describe(x),
    "load_plugin": lambda x: lw.load_plugin(x),
    "closed_form(alpha)": lambda x: lw.Scene(OSCILLATOR, method=METHOD | {"realization": lw.closed_form(x)}).run(),
    "closed_form(order)": lambda x: lw.Scene(OSCILLATOR, method=METHOD | {"realization": lw.closed_form(ALPHA, order=x)}).run(),
    "generating_function(S)": lambda x: lw.Scene(OSCILLATOR, method=METHOD | {"dynamics": lw.generating_function(x)}).run(),
    "System(variables)": lambda x: stepped({"variables": x}),
    "System(hamiltonian)": lambda x: stepped({"hamiltonian": x}),
    "System(hamiltonian returns)": lambda x: stepped({"hamiltonian": lambda _: x}),
    "System(gradient returns)": lambda x: stepped({"gradient": lambda _: x}),
    "System(tensor returns)": lambda x: stepped({"tensor": lambda _, p: x}),
    "System(casimirs)": lambda x: stepped({"casimirs": x}),
    "System(parameters)": lambda x: stepped({"parameters": x}),
    "solution(t)": lambda x: SOLUTION(x),
    "jax.solve(x0)": lambda x: of_jax(x),
    "jax.solve(values)": lambda x: of_jax(None, x),
    "torch.solve(x0)": lambda x: of_torch(x),
    "torch.solve(values)": lambda x: of_torch(None, x),
} | {
    f"solve({name})": (lambda x, name=name: solved(**{name: x}))
    for name in ("x0", "t_span", "t_eval", "system", "bracket", "hamiltonian", "variables", "parameters", "casimirs", "define", "convention")
    + ("library", "method", "step", "rtol", "max_steps")
}
METHOD = OSCILLATOR["method"]
ALPHA = ["q - epsilon*p_p/2", "p + epsilon*p_q/2"]

#: Arguments of which nearly everything is a value.
TOLERANT = {"run(allow)": 0, "ensemble(executor)": 5, "System(hamiltonian returns)": 5}


def _is_long(x: Any) -> bool:
    """Steps that would be taken, and not in a test."""
    return isinstance(x, (int, np.integer)) and x > 10**6


@pytest.mark.parametrize("name", FUNCTIONS)
def test_it_is_taken_or_refused_in_words(name: str) -> None:
    function, counts = FUNCTIONS[name], Counter[str]()

    @settings(
        max_examples=EXAMPLES,
        derandomize=True,
        database=None,
        deadline=None,
        phases=(Phase.generate, Phase.shrink),
        suppress_health_check=list(HealthCheck),
    )
    @given(ODD)
    def draws(x: Any) -> None:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                function(x)
        except (lw.LeafwiseError, TypeError, ValueError, MemoryError) as error:
            assert len(str(error)) > 8, f"{type(error).__name__} without words"
            counts["refused"] += 1
        except OSError:
            assert name == "Scene.load(x)"
            counts["refused"] += 1
        except ZeroDivisionError:
            # What a function that was given has raised itself.
            assert "(" in name
            counts["taken"] += 1
        else:
            counts["taken"] += 1

    draws()
    assert counts.total() >= EXAMPLES // 2
    assert counts["refused"] >= TOLERANT.get(name, REFUSED), counts


def test_every_public_function_is_drawn_for() -> None:
    drawn = " ".join(FUNCTIONS)
    methods = [name for name in vars(lw.Scene) if not name.startswith("_") and callable(getattr(lw.Scene, name))]
    # Without arguments, or with those of the command.
    others = {"Scene": {"check", "verify", "compare", "tune", "tuned"}}
    for name in methods:
        assert name in drawn or name in others["Scene"], name
    functions = [name for name in lw.__all__ if callable(getattr(lw, name)) and not isinstance(getattr(lw, name), type)]
    for name in functions:
        assert name in drawn or name == "list", name
    assert RIGID_BODY
