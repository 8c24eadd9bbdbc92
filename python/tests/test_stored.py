"""What a scene leaves can be stored, copied and sent to other processes."""

import copy
import pickle
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any

import numpy as np
import pytest

import leafwise as lw
from test_scenes import RIGID_BODY

EVENTS = RIGID_BODY | {"run": RIGID_BODY["run"] | {"section": {"at": "x1 = 0"}, "stop": "x2 > 3.2"}}
CLOUD = np.random.default_rng(2).normal([1.0, 3.0, 3.0], 0.1, (20, 3))
FAILING = RIGID_BODY | {"method": RIGID_BODY["method"] | {"time-step": 50.0}}


def run() -> lw.Run:
    return lw.Scene(EVENTS).run()


def solution() -> lw.Solution:
    return lw.solve(**RIGID_BODY["system"], x0=[1, 3, 3], t_span=(1, 5), t_eval=[1, 2, 4.5], rtol=1e-7)


def ensemble() -> lw.Ensemble:
    return lw.Scene(EVENTS).ensemble(CLOUD, {"I2": np.linspace(0.7, 0.8, 20)})


def sweep() -> lw.Sweep:
    return lw.Scene(RIGID_BODY).sweep({"method.time-step": [0.1, 50.0]})


def tangents() -> lw.Tangents:
    return lw.Scene(RIGID_BODY).trajectory(["I1"]).jvp(np.eye(3))


def gradient() -> lw.Gradient:
    x, pull = lw.Scene(RIGID_BODY).trajectory(["I1"]).vjp()
    return pull(np.ones_like(x))


def fit() -> lw.Fit:
    scene = lw.Scene(RIGID_BODY)
    return scene.fit(scene.run().x, ["I1"])


def failure() -> lw.IntegrationError:
    with pytest.raises(lw.IntegrationError) as error:
        lw.Scene(FAILING).run()
    return error.value


def seen(of: Any, within: int = 3) -> Any:
    """Everything that users see of an object, as numbers and words."""
    if isinstance(of, np.ndarray):
        return (of.shape, of.dtype.str, of.tobytes())
    if isinstance(of, dict):
        return {name: seen(value, within) for name, value in of.items()}
    if isinstance(of, (list, tuple)) and not hasattr(of, "_fields"):
        return [seen(value, within) for value in of]
    if type(of).__module__.split(".")[0] != "leafwise" or within == 0:
        return repr(of)
    names = [name for name in dir(of) if not name.startswith("_") and name not in ("sol", "count", "index", "with_traceback", "add_note")]
    fields = {name: getattr(of, name) for name in names}
    found = {name: seen(value, within - 1) for name, value in fields.items() if not callable(value)}
    return found | ({"report": of.report()} if hasattr(of, "report") else {})


MAKERS: list[Callable[[], Any]] = [run, solution, ensemble, sweep, tangents, gradient, fit, failure]


@pytest.mark.parametrize("make", MAKERS)
def test_copies_show_the_same(make: Callable[[], Any]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lw.LeafwiseWarning)
        of = make()
    expected = seen(of)
    assert len(expected) >= 2
    for again in (
        *(pickle.loads(pickle.dumps(of, protocol)) for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1)),
        pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(of)))),
        copy.copy(of),
        copy.deepcopy(of),
    ):
        assert type(again) is type(of) and seen(again) == expected
        assert str(again) == str(of)
    if isinstance(of, lw.Solution):
        np.testing.assert_array_equal(pickle.loads(pickle.dumps(of))(2.5), of(2.5))


def work(name: str) -> Any:
    warnings.simplefilter("ignore")
    return globals()[name]()


def fails(_: int) -> None:
    lw.Scene(FAILING).run()


def test_workers_return_and_raise_them() -> None:
    names = [make.__name__ for make in (run, solution, ensemble, sweep, tangents, gradient)]
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:
        for name, found in zip(names, executor.map(work, names), strict=True):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                mine = work(name)
            if name in ("tangents", "gradient"):
                assert seen(found) == seen(mine)
            else:
                assert type(found) is type(mine)
                np.testing.assert_array_equal(found["y"] if name == "solution" else found.t, mine["y"] if name == "solution" else mine.t)
        with pytest.raises(lw.IntegrationError, match="step 1 failed at t = 0") as error:
            executor.submit(fails, 0).result()
        assert error.value.run is not None and error.value.run.x.tolist() == [[1.0, 3.0, 3.0]]


def test_an_error_without_a_run_has_none() -> None:
    assert lw.IntegrationError("x").run is None
    with pytest.raises(lw.IntegrationError) as error:
        lw.Scene(FAILING).integrator().step()
    assert error.value.run is None
