"""What Python adds to the program: ratios within one run.

    python python/benches/speed.py target/release/leafwise

The program has to be built with the same profile as the package.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path
from statistics import median

import numpy as np

import leafwise as lw

SCENE = Path(__file__).parents[2] / "scenes" / "rigid_body.toml"
ROUNDS = 9
STEPS, EVERY, MEMBERS = 1_000_000, 1000, 10_000


def program(binary: str, *arguments: str) -> float:
    """Seconds of integration that the program tells."""
    with tempfile.TemporaryDirectory() as folder:
        line = [binary, *arguments, "--out", f"{folder}/out", "--json"]
        told = subprocess.run(line, capture_output=True, text=True, check=True)
        return float(json.loads(told.stdout)["wall_seconds"])


def ratios(ours: list[float], theirs: list[float]) -> str:
    """The quartiles of the ratios of rounds."""
    low, middle, high = np.quantile(np.divide(ours, theirs), [0.25, 0.5, 0.75])
    return f"{low:.3f} {middle:.3f} {high:.3f}"


def long_run(binary: str) -> None:
    scene = lw.Scene.load(SCENE)
    ours, theirs = [], []
    sets = ["--set", f"run.steps={STEPS}", "--set", f"run.record.every={EVERY}"]
    for _ in range(ROUNDS):
        theirs.append(program(binary, "run", str(SCENE), *sets))
        ours.append(scene.run(steps=STEPS, record=EVERY, progress=False).wall_seconds)
    print(f"run of {STEPS} steps over the program's          {ratios(ours, theirs)}   (at most 1.05)")


def single_steps() -> None:
    rounds, steps = [], 200_000
    for _ in range(ROUNDS):
        loop, whole = lw.Scene.load(SCENE).integrator(), lw.Scene.load(SCENE).integrator()
        step = loop.step
        begun = time.perf_counter()
        for _ in range(steps):
            step()
        between = time.perf_counter()
        whole.advance(steps)
        rounds.append((between - begun - (time.perf_counter() - between)) / steps * 1e6)
    low, middle, high = np.quantile(rounds, [0.25, 0.5, 0.75])
    print(f"a loop over single steps, microseconds a step more  {low:.3f} {middle:.3f} {high:.3f}   (below 1.5)")


def ensemble(binary: str) -> None:
    states = np.random.default_rng(1).normal([1, 3, 3], 0.1, (MEMBERS, 3))
    scene = lw.Scene.load(SCENE, set={"run.steps": 500, "run.record.every": 500})
    ours, theirs = [], []
    with tempfile.TemporaryDirectory() as folder:
        rows = "\n".join(",".join(map(repr, row)) for row in states.tolist())
        (Path(folder) / "members.csv").write_text(f"x1,x2,x3\n{rows}\n")
        file = Path(folder) / "scene.toml"
        table = '[ensemble]\ninitial = { file = "members.csv" }\nfinal-states = "csv"\n'
        file.write_text(f"{scene.text}\n{table}")
        for _ in range(ROUNDS):
            begun = time.perf_counter()
            program(binary, "ensemble", str(file))
            between = time.perf_counter()
            scene.ensemble(states, progress=False)
            ours.append(time.perf_counter() - between)
            theirs.append(between - begun)
    print(f"{MEMBERS} members as an array over the program, whole  {ratios(ours, theirs)}   (at most 1.1)")


def importing() -> None:
    def seconds(module: str) -> float:
        line = f"import time; t = time.perf_counter(); import {module}; print(time.perf_counter() - t)"
        told = subprocess.run([sys.executable, "-c", line], capture_output=True, text=True, check=True)
        return float(told.stdout)

    rounds = [(seconds("leafwise"), seconds("numpy")) for _ in range(ROUNDS)]
    ours, numpy = (median(times) for times in zip(*rounds, strict=True))
    print(f"import leafwise {ours:.3f} s, of which NumPy {numpy:.3f} s   (below 0.2)")


def main() -> None:
    """All of it."""
    warnings.simplefilter("ignore", lw.LeafwiseWarning)
    binary = sys.argv[1]
    print("quartiles of", ROUNDS, "rounds")
    long_run(binary)
    single_steps()
    ensemble(binary)
    importing()


if __name__ == "__main__":
    main()
