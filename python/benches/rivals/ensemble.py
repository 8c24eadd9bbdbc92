"""Many rigid bodies in Leafwise and in heyoka's batch mode: members a second on all threads at equal errors.

    python python/benches/rivals/ensemble.py [--members 10000] [--rounds 5] [--threads 2]

Members are initial states about (1, 3, 3) to T = 200. An error is the largest over 64 members, in the maximum norm at the end,
from heyoka's at its finest tolerance. Each method takes the coarsest step (of four an octave; of two tolerances a decade) from which on
three in a row reach it. All run in turn within one process; a time is the shortest of the rounds.
"""

from __future__ import annotations

import argparse
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import heyoka as hy
import numpy as np
import with_heyoka
import with_leafwise
from table import ERRORS

TIME = 200.0
MEASURED = 64
COMPOSITIONS = ("blanes-moan-6", "kahan-li-6", "kahan-li-8", "suzuki-umeno-8", "sofroniou-spaletta-10")
LIFTS = with_leafwise.lifts("clebsch")
BATCHES = (8, 16)


class Leafwise:
    """One method at one number of steps."""

    SETTINGS = tuple(round(40 * 2 ** (k / 4)) for k in range(30))

    def __init__(self, method: dict[str, Any], steps: int, threads: int) -> None:
        self.scene = with_leafwise.rigid_body(method).set(**{"method.time-step": TIME / steps})
        self.steps, self.threads = steps, threads

    def run(self, states: Any) -> Any:
        steps = self.steps
        return np.asarray(self.scene.ensemble(x0=states, steps=steps, record=steps, threads=self.threads).x)


class Heyoka:
    """One size of batches at one tolerance, a share of the members for each thread."""

    SETTINGS = tuple(10 ** (-k / 2) for k in range(6, 30))

    def __init__(self, batch: int, tolerance: float, threads: int) -> None:
        slope, _ = with_heyoka.rigid_body()
        first = hy.taylor_adaptive_batch(slope, np.zeros((3, batch)) + 1.0, tol=tolerance)
        self.steppers = [first, *(first.__deepcopy__({}) for _ in range(threads - 1))]
        self.batch = batch

    def share(self, stepper: Any, states: Any, ends: Any) -> None:
        for first in range(0, len(states), self.batch):
            own = states[first : first + self.batch]
            stepper.state[:, : len(own)] = own.T
            stepper.set_time(0.0)
            stepper.propagate_until(TIME)
            ends[first : first + self.batch] = stepper.state[:, : len(own)].T

    def run(self, states: Any) -> Any:
        ends = np.empty_like(states)
        size = -(-len(states) // (len(self.steppers) * self.batch)) * self.batch
        with ThreadPoolExecutor(len(self.steppers)) as pool:
            parts = [slice(k * size, (k + 1) * size) for k in range(len(self.steppers))]
            jobs = [
                pool.submit(self.share, stepper, states[own], ends[own])
                for stepper, own in zip(self.steppers, parts, strict=True)
            ]
            for job in jobs:
                job.result()
        return ends


def settings(make: Any, kind: Any, states: Any, reference: Any) -> dict[float, Any]:
    """The coarsest for each error."""
    found: dict[float, Any] = {}
    reached: list[tuple[Any, Any, float]] = []
    for setting in kind.SETTINGS:
        solver = make(setting)
        try:
            off = float(np.abs(solver.run(states) - reference).max())
        except Exception:  # a step too large
            off = np.inf
        reached.append((setting, solver, off if np.isfinite(off) else np.inf))
        for error in ERRORS[:2]:
            last = reached[-3:]
            if error not in found and len(last) == 3 and all(off <= error for _, _, off in last):
                found[error] = last[0]
        if len(found) == 2:
            break
    return found


def main() -> None:
    """All of it."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--members", type=int, default=10_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    states = np.array([1.0, 3.0, 3.0]) + np.random.default_rng(1).uniform(-0.1, 0.1, (options.members, 3))
    few = np.ascontiguousarray(states[:MEASURED])
    reference = Heyoka(8, 1e-16, 1).run(few)
    candidates: dict[tuple[str, str, float], Any] = {}
    methods = {f"splitting, {name}": {"stepper": "splitting", "composition": name, "time-step": 0.1} for name in COMPOSITIONS}
    for name, method in (methods | LIFTS).items():
        found = settings(lambda steps, own=method: Leafwise(own, steps, options.threads), Leafwise, few, reference)
        candidates |= {("Leafwise", name, error): own for error, own in found.items()}
    for batch in BATCHES:
        found = settings(lambda tolerance, own=batch: Heyoka(own, tolerance, options.threads), Heyoka, few, reference)
        candidates |= {("heyoka", f"batches of {batch}", error): own for error, own in found.items()}
    times: dict[Any, float] = dict.fromkeys(candidates, np.inf)
    for _ in range(options.rounds):
        for key, (_, solver, _) in candidates.items():
            begun = time.perf_counter()
            solver.run(states)
            times[key] = min(times[key], time.perf_counter() - begun)
    print("| error | | setting | members a second | time over heyoka's best |\n|---|---|---:|---:|---:|")
    for error in ERRORS[:2]:
        own = sorted((key for key in times if key[2] == error), key=lambda key: times[key])
        best = min(times[key] for key in own if key[0] == "heyoka")
        for key in own:
            second = options.members / times[key]
            print(f"| {error:g} | {key[0]}, {key[1]} | {candidates[key][0]:g} | {second:,.0f} | {times[key] / best:.2f} |")


if __name__ == "__main__":
    main()
