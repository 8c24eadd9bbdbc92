"""Arrays, frames and numbers of every kind: what is given is what is taken, or it is refused in words."""

import collections
import os
import subprocess
import sys
import textwrap
from types import MappingProxyType

import numpy as np
import pytest

import leafwise as lw
from test_scenes import RIGID_BODY

OSCILLATOR = {
    "system": {
        "variables": ["q", "p"],
        "bracket": {"q,p": "1"},
        "convention": "{x,H}",
        "hamiltonian": "p^2/2 + k*q^2/2",
        "parameters": {"k": 1.0},
    },
    "method": {"realization": "auto", "dynamics": {"name": "hamilton-jacobi", "order": 4}, "time-step": 0.05},
    "run": {"initial": [1.0, 0.0], "steps": 100, "record": {"every": 5}},
}


def noisy(scene: lw.Scene, sigma: float = 0.01) -> np.ndarray:
    x = scene.run().x
    return x + sigma * np.random.default_rng(0).normal(size=x.shape)


def test_what_is_masked_was_not_observed() -> None:
    scene = lw.Scene(OSCILLATOR)
    data = noisy(scene)
    hidden = np.zeros_like(data, bool)
    hidden[7, 0] = hidden[3, 1] = True
    data[hidden] = 99.0
    gaps = scene.fit(np.where(hidden, np.nan, data), ["k"])
    assert abs(gaps.values["k"] - 1) < 5 * gaps.errors["k"]
    for masked in (np.ma.masked_array(data, hidden), list(np.ma.masked_array(data, hidden))):
        assert repr(scene.fit(masked, ["k"])) == repr(gaps)
    assert scene.fit(np.ma.masked_array(data, False), ["k"]).chi2 > 100 * gaps.chi2


def test_elsewhere_masks_are_refused() -> None:
    scene, state = lw.Scene(OSCILLATOR), np.ma.masked_array([1.0, 99.0], [False, True])
    along = scene.trajectory(["k"])
    for name, call in {
        "x0": lambda: scene.ensemble(np.ma.stack([state, state])),
        "k": lambda: scene.ensemble(parameters={"k": state}),
        "run.initial": lambda: scene.run(initial=state),
        "run.initial ": lambda: scene.set(run__initial=state),
        "x0 ": lambda: along(state),
        "values": lambda: along(values=np.ma.masked_array([1.0], [True])),
        "w": lambda: along.vjp()[1](np.ma.masked_array(along(), True)),
        "sigma": lambda: scene.fit(along(), ["k"], sigma=state),
        "t_eval": lambda: lw.solve(**OSCILLATOR["system"], x0=[1, 0], t_span=(0, 2), t_eval=state),
    }.items():
        with pytest.raises(ValueError, match=rf"^{name.strip()}\[.*\] is masked"):
            call()
    # Where nothing is hidden there is nothing to refuse.
    assert scene.run(initial=np.ma.masked_array([1.0, 0.0], False)).x[0].tolist() == [1.0, 0.0]


def test_names_of_columns_are_those_of_coordinates() -> None:
    import pandas
    import xarray

    scene = lw.Scene(OSCILLATOR)
    data = noisy(scene)
    frame = pandas.DataFrame(data, columns=["q", "p"])
    record = np.zeros(len(data), [("p", float), ("q", float)])
    record["q"], record["p"] = data.T
    labelled = xarray.DataArray(data[:, ::-1], dims=("t", "coordinate"), coords={"coordinate": ["p", "q"]})
    found = repr(scene.fit(data, ["k"]))
    for same in (frame, frame[["p", "q"]], labelled, record, frame.rename(columns={"q": "a", "p": "b"}), pandas.DataFrame(data)):
        assert repr(scene.fit(same, ["k"])) == found
    assert repr(scene.fit(frame[["p"]], ["k"])) == repr(scene.fit(data[:, 1:], ["k"], observed=["p"]))
    assert repr(scene.fit(frame[["p", "q"]], ["k"], observed=["q", "p"])) == found
    body = lw.Scene(RIGID_BODY)
    states = np.random.default_rng(1).normal([1.0, 3.0, 3.0], 0.1, (5, 3))
    cloud = pandas.DataFrame(states, columns=["x1", "x2", "x3"])
    expected = body.ensemble(states, steps=3)
    np.testing.assert_array_equal(body.ensemble(cloud[["x3", "x1", "x2"]], steps=3).x, expected.x)
    np.testing.assert_array_equal(body.trajectory([])(cloud[["x3", "x1", "x2"]].iloc[0]), body.trajectory([])(states[0]))
    for initial in (cloud[["x3", "x1", "x2"]].iloc[0], dict(zip(["x3", "x1", "x2"], states[0, [2, 0, 1]], strict=True))):
        np.testing.assert_array_equal(body.run(initial=initial, steps=1).x[0], states[0])
    one = lw.solve(**RIGID_BODY["system"], x0=cloud[["x3", "x1", "x2"]].iloc[0], t_span=(0, 1), step=0.1)
    np.testing.assert_array_equal(one.y[:, 0], states[0])
    with pytest.raises(ValueError, match="x0 has the columns x1, x2, mass, and the coordinates are x1, x2, x3"):
        body.ensemble(cloud.rename(columns={"x3": "mass"}))


class Quantity:
    """Numbers with a unit, as astropy, pint and unyt have them."""

    def __init__(self, value: object, unit: str) -> None:
        self.value, self._unit = np.asarray(value), unit

    @property
    def unit(self) -> str:
        return self._unit

    def to(self, unit: str) -> "Quantity":
        return Quantity(self.value, unit)

    def __array__(self, dtype: object = None, copy: object = None) -> np.ndarray:
        return self.value

    def tolist(self) -> object:
        return self.value.tolist()


def test_units_are_refused() -> None:
    scene, long = lw.Scene(OSCILLATOR), Quantity([1.0, 2.0], "km")
    for call in (
        lambda: scene.run(initial=long),
        lambda: scene.set(system__parameters__k=Quantity(1.0, "N/m")),
        lambda: scene.ensemble([long, long]),
        lambda: scene.fit(Quantity(noisy(scene), "m"), ["k"]),
        lambda: lw.solve(**OSCILLATOR["system"], x0=long, t_span=(0, 1)),
        lambda: lw.solve(**OSCILLATOR["system"], x0=[1, 0], t_span=(Quantity(0.0, "s"), Quantity(1.0, "s"))),
    ):
        with pytest.raises(TypeError, match="has units, and numbers of a scene have none"):
            call()


@pytest.mark.parametrize("library", ["astropy.units", "pint"])
def test_units_of_libraries_are_refused(library: str) -> None:
    module = pytest.importorskip(library)
    length = module.km if library != "pint" else module.UnitRegistry().km
    for state in (np.array([1.0, 2.0]) * length, [1.0 * length, 2.0 * length]):
        with pytest.raises(TypeError, match="has units"):
            lw.Scene(OSCILLATOR).run(initial=state)
        with pytest.raises(TypeError, match="has units"):
            lw.solve(**OSCILLATOR["system"], x0=state, t_span=(0, 1))


@pytest.mark.parametrize(
    "value, words",
    [
        (np.array(["2020-01-01", "2020-01-02"], "M8[ns]"), r"run.initial: .* not datetime64\[ns\]"),
        (np.array([1, 2], "m8[s]"), r"not timedelta64\[s\]"),
        (np.array([1.0, 2j]), "not complex128"),
        (np.array([1, 0], np.clongdouble), "not complex|not clongdouble"),
        (np.array([b"a", b"b"]), r"not \|S1"),
        (b"12", "not bytes"),
        ({1.0, 2.0}, "not set"),
        ([1.0, None], r"run.initial\[1\]: .* not NoneType"),
        (object(), "not object"),
        ({1: 2.0}, "keys are strings, not 1"),
    ],
)
def test_what_is_no_number_is_refused(value: object, words: str) -> None:
    with pytest.raises(TypeError, match=words):
        lw.Scene(OSCILLATOR).run(initial=value)


@pytest.mark.skipif(np.dtype(np.longdouble).itemsize == 8, reason="a long double is a double here")
def test_long_doubles_are_refused_where_they_would_be_rounded() -> None:
    scene, long = lw.Scene(OSCILLATOR), np.longdouble(1)
    for call in (
        lambda: scene.run(initial=np.array([1, 0], np.longdouble)),
        lambda: scene.set(system__parameters__k=long),
        lambda: scene.sweep({"system.parameters.k": np.array([1, 2], np.longdouble)}),
        lambda: lw.solve(**(OSCILLATOR["system"] | {"parameters": {"k": long}}), x0=[1, 0], t_span=(0, 1)),
    ):
        with pytest.raises(TypeError, match=r"round it by astype\(float\)"):
            call()


def test_what_holds_itself_is_refused() -> None:
    class Own:
        def tolist(self) -> "Own":
            return self

    class Wrapped:
        def __init__(self, of: object) -> None:
            self.of = of

        def tolist(self) -> object:
            return self.of

    own: list[object] = [1.0]
    own.append(own)
    deep: object = 1.0
    for _ in range(100_000):
        deep = [deep]
    table: dict[str, object] = dict(OSCILLATOR)
    table["run"] = OSCILLATOR["run"] | {"more": table}
    scene = lw.Scene(OSCILLATOR)
    for value in (own, deep, Own(), Wrapped(Own()), [Own(), 1.0]):
        with pytest.raises(TypeError):
            scene.run(initial=value)
        with pytest.raises((TypeError, ValueError)):
            scene.ensemble(x0=value)
        with pytest.raises((TypeError, ValueError)):
            lw.solve(**OSCILLATOR["system"], x0=value, t_span=(0, 1))
    with pytest.raises(TypeError, match="within each other more than 32 times, or one holds itself"):
        lw.Scene(table)


def test_numbers_and_tables_of_other_kinds_are_taken() -> None:
    scene = lw.Scene(OSCILLATOR)
    expected = scene.run(steps=3).final_state
    for state in ((1, 0), np.array([1, 0], np.int8), np.array([1, 0], np.float16), np.array([1.0, 0.0], object), range(1, -1, -1)):
        np.testing.assert_array_equal(scene.run(initial=state, steps=3.0).final_state, expected)
    for table in (MappingProxyType(OSCILLATOR), collections.OrderedDict(OSCILLATOR), collections.UserDict(OSCILLATOR)):
        np.testing.assert_array_equal(lw.Scene(table).run(steps=np.int8(3)).final_state, expected)
    assert scene.set(system__parameters__k=np.array(2.0)).parameters == {"k": 2.0}


@pytest.mark.parametrize(
    "arguments, error, words",
    [
        ({"threads": 0}, ValueError, "threads is 0, less than 1"),
        ({"threads": -1}, ValueError, "threads is -1, less than 1"),
        ({"threads": 1.5}, TypeError, "threads is 1.5, not a whole number"),
        ({"threads": True}, TypeError, "threads is True, not a whole number"),
        ({"steps": 10**30}, ValueError, "steps is about 1e30, and at most 9223372036854775807"),
        ({"steps": -1}, ValueError, "steps is -1, less than 0"),
        ({"record": 0}, ValueError, "record is 0, less than 1"),
        ({"steps": "3"}, TypeError, "steps is '3', not a whole number"),
        ({"quantiles": ["a"]}, TypeError, "quantiles holds <U1"),
        ({"parameters": ["k"]}, TypeError, "parameters is of list, not a table"),
        ({"parameters": {"k": [1.0, "a"]}}, TypeError, "k holds <U"),
    ],
)
def test_arguments_are_named_in_what_is_said_of_them(
    arguments: dict[str, object], error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        lw.Scene(OSCILLATOR).ensemble(**({"x0": np.ones((2, 2))} | arguments))
    if "threads" in arguments:
        with pytest.raises(error, match=words):
            lw.Scene(OSCILLATOR).sweep({"method.time-step": [0.1]}, **arguments)
    if "steps" in arguments:
        for call in (lw.Scene(OSCILLATOR).run, lw.Scene(OSCILLATOR).trajectory, lambda steps: lw.Scene(OSCILLATOR).integrator().advance(steps)):
            with pytest.raises(error, match=words):
                call(**arguments)


def test_a_name_is_no_list_of_its_letters() -> None:
    scene = lw.Scene(OSCILLATOR)
    for call in (
        lambda: scene.trajectory("k"),
        lambda: scene.fit(noisy(scene), "k"),
        lambda: scene.fit(noisy(scene), ["k"], observed="qp"),
        lambda: scene.sweep({"method.time-step": [0.1]}, observables="energy"),
    ):
        with pytest.raises(TypeError, match=r"not a list: give \["):
            call()


def test_more_threads_than_there_are_take_turns() -> None:
    scene = lw.Scene(OSCILLATOR)
    expected = scene.ensemble(np.ones((3, 2)), threads=1).x
    np.testing.assert_array_equal(scene.ensemble(np.ones((3, 2)), threads=10**12).x, expected)


@pytest.mark.skipif(sys.platform != "linux", reason="a limit of Linux")
def test_the_want_of_memory_is_an_exception() -> None:
    program = """
    import resource
    import warnings
    import numpy as np
    import leafwise as lw
    from test_inputs import OSCILLATOR

    warnings.simplefilter("ignore")
    scene = lw.Scene(OSCILLATOR)
    # A pace: the number of steps is not known before.
    paced = lw.Scene(OSCILLATOR | {
        "method": {"realization": "auto", "dynamics": "hamilton-jacobi", "pace": "1 + q^2", "time-step": 1e-4},
        "run": {"initial": [1.0, 0.0], "until": 1e6, "record": {"observables": [f"q + {k}" for k in range(30)]}},
    })
    body = scene.run(steps=10).final_state
    pages = int(open("/proc/self/statm").read().split()[0])
    most = pages * resource.getpagesize() + (256 << 20)
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    for name, call in {
        "run": lambda: scene.run(steps=10**12, record=1),
        "solve": lambda: lw.solve(**OSCILLATOR["system"], x0=[1, 0], t_span=(0, 1), step=1e-12, max_steps=10**13),
        "trajectory": lambda: scene.trajectory(["k"], steps=10**12, record=1)(),
        "tangents": lambda: scene.trajectory(["k"], steps=10**7, record=1).jvp(np.ones((1000, 2))),
        "paced": paced.run,
    }.items():
        try:
            call()
        except MemoryError as error:
            told = str(error)
            assert "record" in told and "numbers each" in told, told
            if name == "paced":
                assert len(error.run.t) > 10**4 and error.run.outcome == "failed"
        else:
            raise AssertionError(name)
    assert np.array_equal(scene.run(steps=10).final_state, body)
    print("lives")
    """
    told = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)],
        cwd=os.path.dirname(__file__),
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
    )
    assert told.stdout == "lives\n", told.stderr


def test_no_variable_of_a_dataset_is_lost() -> None:
    polar = {
        "system": {
            "variables": ["r", "phi", "pr", "L"],
            "bracket": {"r,pr": "1", "phi,L": "1"},
            "convention": "{x,H}",
            "define": {"x": "r*cos(phi)", "coordinate": "r*sin(phi)", "t": "r"},
            "hamiltonian": "pr^2/2 + L^2/(2*r^2) - 1/r",
        },
        "method": {"stepper": "splitting", "time-step": 0.01},
        "run": {"initial": [1.0, 0.0, 0.0, 1.1], "steps": 10, "record": {"observables": ["energy", "x", "coordinate", "t"]}},
    }
    run = lw.Scene(polar).run()
    data = run.to_xarray()
    np.testing.assert_array_equal(data["x"], run.x)
    for name in ("x", "coordinate"):
        np.testing.assert_array_equal(data[f"{name} (observable)"], run.observables[name])
    assert len(data.data_vars) == 1 + len(run.observables)
    np.testing.assert_array_equal(data["t"], run.t)
    polar["ensemble"] = {"members": 3, "record": {"observables": ["energy", "t", "x"]}}
    cloud = lw.Scene(polar).ensemble(run.x)
    frame = cloud.to_pandas()
    # The outcome, the time, coordinates, observables, initial coordinates, drifts of the energy.
    assert frame.shape[1] == len(set(frame.columns)) == 2 + 4 + 3 + 4 + 1
    np.testing.assert_array_equal(frame["t"], cloud.t)
    np.testing.assert_array_equal(frame["t (observable)"], cloud.observables["t"])


def test_problems_are_told_in_words_of_python() -> None:
    scene = lw.Scene(OSCILLATOR)
    for call in (lambda: scene.run(initial=[1.0]), lambda: scene.set(run__stepz=3), lambda: scene.set(method__stepper="rk5").run()):
        with pytest.raises(lw.SceneError) as error:
            call()
        assert "--" not in str(error.value).replace("-->", "")
    bracket = RIGID_BODY["system"]["bracket"] | {"x1,x2": "-x3 - x1^2"}
    odd = lw.Scene(RIGID_BODY | {"system": RIGID_BODY["system"] | {"bracket": bracket, "casimirs": {}}})
    for call in (odd.run, odd.integrator, odd.trajectory, lambda: odd.fit(np.ones((3, 3)), ["I1"])):
        with pytest.raises(lw.SceneError, match=r"Jacobi(.|\n)*pass allow_non_poisson=True"):
            call()
    # As is advised.
    odd = odd.set(**{"method.time-step": 0.001})
    assert odd.run(steps=1, allow_non_poisson=True).outcome == "done"
    odd.integrator(allow_non_poisson=True).step()
    assert odd.trajectory([], allow_non_poisson=True, steps=1)().shape == (2, 3)
    with pytest.raises(lw.SceneError, match="give x0, parameters or both"):
        scene.ensemble()


def test_nothing_names_a_folder_that_is_gone() -> None:
    scene = lw.Scene(OSCILLATOR)
    pages = [scene.ensemble(np.ones((2, 2))).report(), scene.sweep({"method.time-step": [0.1, 0.2]}).report()]
    assert not any("/tmp" in page or "Temp" in page or ">Data<" in page for page in pages)
    assert scene.tune(1e-4)["scene"] == "scene.toml"


def test_an_invariant_may_have_a_coordinates_name() -> None:
    scene = lw.Scene(
        system={
            "variables": ["energy", "y", "z"],
            "bracket": {"energy,y": "1"},
            "convention": "{x,H}",
            "hamiltonian": "energy^2 + y^2*z",
            "casimirs": {"z": "z^2"},
        },
        method={"stepper": "splitting", "time-step": 0.1},
        run={"initial": [1, 2, 3], "steps": 3},
    )
    run = scene.run()
    np.testing.assert_array_equal(run.casimirs["z"], np.full(4, 9.0))
    np.testing.assert_allclose(run.energy, run.x[:, 0] ** 2 + run.x[:, 1] ** 2 * 3, rtol=1e-14)
