"""Ensembles on the workers of other engines, to the bits of this process."""

import os
import signal
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

import leafwise as lw
from test_ensembles import CLOUD, EVENTS, INERTIA
from test_scenes import RIGID_BODY

MANY = np.random.default_rng(7).normal([1.0, 3.0, 3.0], 0.2, (300, 3))


def is_same(one: lw.Ensemble, other: lw.Ensemble) -> None:
    np.testing.assert_array_equal(one.x, other.x)
    np.testing.assert_array_equal(one.outcomes, other.outcomes)
    assert one.statistics == other.statistics
    assert (one.crossings is None) == (other.crossings is None)
    if one.crossings is not None and other.crossings is not None:
        np.testing.assert_array_equal(one.crossings.x, other.crossings.x)
    for name, largest in one.drift.items():
        np.testing.assert_array_equal(largest, other.drift[name])


def test_processes_step_shards_to_the_same_bits() -> None:
    told: list[tuple[int, int]] = []
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        for table in (RIGID_BODY, EVENTS):
            scene = lw.Scene(table)
            own = scene.ensemble(MANY, quantiles=[0.1, 0.5])
            others = scene.ensemble(
                MANY, quantiles=[0.1, 0.5], executor=executor, shards=7, progress=lambda *at: told.append(at)
            )
            is_same(own, others)
        drawn = lw.Scene(RIGID_BODY | {"ensemble": {"members": 200, "seed": 3, "initial": {"ball": 0.1}}})
        is_same(drawn.ensemble(), drawn.ensemble(executor=executor, shards=3))
    assert told[:7] == [(k, 7) for k in range(1, 8)]


def test_workers_join_shards_of_shards_to_the_same_bits() -> None:
    """20 shards are joined twice over: groups of 8 by workers, what is left here. More shards than leaves have no members."""
    scene = lw.Scene(RIGID_BODY)
    many = np.concatenate([MANY] * 5)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        is_same(scene.ensemble(many, steps=20), scene.ensemble(many, steps=20, executor=executor, shards=70))


def test_what_a_worker_raises_comes_out() -> None:
    scene = lw.Scene(RIGID_BODY)
    with pytest.raises(ValueError, match="executor="):
        scene.ensemble(CLOUD, shards=2)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:
        with pytest.raises(ValueError, match="shards is 0, less than 1"):
            scene.ensemble(CLOUD, executor=executor, shards=0)
        with pytest.raises(lw.SceneError):
            scene.ensemble(CLOUD, {"I9": INERTIA}, executor=executor, shards=2)


@pytest.mark.filterwarnings("ignore")
def test_dask_loses_a_worker_and_ends_with_the_same_bits(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    scene = lw.Scene(RIGID_BODY)
    steps = 20_000
    own = scene.ensemble(MANY, steps=steps)
    lost: list[int] = []
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, local_directory=str(tmp_path)
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        workers = list(client.run(os.getpid).values())

        def lose_one(done: int, _: int) -> None:
            if done == 1:
                os.kill(workers[0], signal.SIGKILL)
                lost.append(workers[0])

        others = scene.ensemble(MANY, steps=steps, executor=client, shards=5, progress=lose_one)
    assert lost
    is_same(own, others)
