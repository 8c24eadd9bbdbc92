"""Leafwise beside SciPy, heyoka and diffrax: code, first results, times at equal errors, drifts.

    pip install './python[rivals]'
    python python/benches/rivals/table.py [--json FILE] [--rounds 15] [--libraries Leafwise,heyoka] [PROBLEM ...]

Each method takes the coarsest setting (of four steps an octave; of four tolerances a decade, heyoka of two) from which
on three in a row reach the error, in the maximum norm at the end; of the methods of one library, and of its settings for
smaller errors, the cheapest is shown.
The solvers of all libraries run in turn within one process, each keeping nothing but its last state; compiled code is compiled
before. A time is the shortest of the rounds: other programs of the machine only add to it. Drifts are the largest over all of a solver's own steps. A first result is a process
of its own: Python, imports, the building or compiling of the solver, and the run to 1e-4.
"""

from __future__ import annotations

import argparse
import importlib
import inspect
import json
import subprocess
import sys
import time
import warnings
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from problems import PROBLEMS, Problem

LIBRARIES = {"Leafwise": "with_leafwise", "SciPy": "with_scipy", "heyoka": "with_heyoka", "diffrax": "with_diffrax"}
ERRORS = (1e-4, 1e-8, 1e-12)
#: Runs of more seconds are looked at no further.
LONGEST = 5.0


def lines(module: Any, name: str) -> int:
    """Lines of what a user writes: imports, the problem, the solution."""
    source = inspect.getsource(module).splitlines()
    text = [line for line in source if line.startswith(("import ", "from ", "jax.config"))]
    for function in (name, "solve"):
        text += inspect.getsource(getattr(module, function)).splitlines()
    if "np." not in "\n".join(line for line in text if not line.startswith("import")):
        text = [line for line in text if line != "import numpy as np"]
    return sum(1 for line in text if line.strip() and line.strip() != '"""User\'s code."""')


def timed(solver: Any) -> tuple[float, Any]:
    begun = time.perf_counter()
    end = solver.end()
    return time.perf_counter() - begun, end


def first_result(module: str, name: str, method: str, setting: float) -> float:
    asked = f"{name!r}, problems.PROBLEMS[{name!r}], {method!r}, {setting!r}"
    line = f"import {module} as m, problems; m.first({asked})"

    def once() -> float:
        begun = time.perf_counter()
        subprocess.run([sys.executable, "-W", "ignore", "-c", line], cwd=Path(__file__).parent, check=True)
        return time.perf_counter() - begun

    return median(once() for _ in range(3))


def errors(module: Any, name: str, problem: Problem, method: Any, reference: Any) -> dict[float, Any]:
    """The setting for each error, a solver beside it."""
    found: dict[float, Any] = {}
    reached: list[tuple[Any, Any, float]] = []
    for setting in module.Solver.SETTINGS:
        try:
            solver = module.Solver(problem, name, method, setting)
            seconds, end = timed(solver)
            off = float(np.abs(end - reference).max())
        except Exception as error:  # a step too large, what the method is not for, or a tolerance below round-off
            is_finer = any(np.isfinite(off) for _, _, off in reached)
            if is_finer or len(reached) > 40 or type(error).__name__ == "SceneError":
                break
            reached.append((setting, None, np.inf))
            continue
        reached.append((setting, solver, off if np.isfinite(off) else np.inf))
        last = reached[-3:]
        for error in ERRORS:
            if error not in found and len(last) == 3 and all(off <= error for _, _, off in last):
                found[error] = last[0]
        if len(found) == len(ERRORS) or seconds > LONGEST:
            break
    return found


def drift(values: Any) -> float:
    return float(np.abs(values - values[0]).max())


def measure(name: str, rounds: int, libraries: list[str]) -> list[dict[str, Any]]:
    problem = PROBLEMS[name]
    modules = {library: importlib.import_module(LIBRARIES[library]) for library in libraries}
    modules = {library: module for library, module in modules.items() if name in module.METHODS}
    heyoka = importlib.import_module(LIBRARIES["heyoka"])
    reference = np.asarray(heyoka.reference(name, problem), dtype=np.float64)
    rows, candidates = [], {}
    for library, module in modules.items():
        for method, own in module.METHODS[name].items():
            for error, (setting, solver, off) in errors(module, name, problem, own, reference).items():
                candidates[library, method, error] = (setting, solver, off)
        rows.append({"library": library, "lines": lines(module, name)})
    times: dict[Any, list[float]] = {key: [] for key in candidates}
    keys = list(candidates)
    for turn in range(rounds):
        for key in keys if turn % 2 == 0 else reversed(keys):
            times[key].append(timed(candidates[key][1])[0])
    for row in rows:
        for error in ERRORS:
            own = [key for key in keys if key[0] == row["library"] and key[2] <= error]
            row[f"{error:g}"] = None
            if own:
                best = min(own, key=lambda key: min(times[key]))
                setting, solver, off = candidates[best]
                states = solver.states()
                if error == ERRORS[0]:
                    row["first"] = first_result(LIBRARIES[row["library"]], name, best[1], setting)
                row[f"{error:g}"] = {
                    "method": best[1],
                    "setting": setting,
                    "error": off,
                    "seconds": min(times[best]),
                    "quartiles": [float(of) for of in np.quantile(times[best], [0.25, 0.75])],
                    "energy": drift(problem.energy(states)),
                    "casimir": drift(problem.casimir(states)),
                    "of_all": {f"{key[1]}, {key[2]:g}": min(times[key]) for key in own},
                }
    return rows


def shown(name: str, rows: list[dict[str, Any]]) -> str:
    """Markdown."""
    head = ["", "lines", "first result, s", *(f"1e{round(np.log10(error))}: ms | energy | Casimir" for error in ERRORS)]
    text = [f"**{PROBLEMS[name].title}**", "", "| " + " | ".join(head) + " |", "|---" + "|---:" * (len(head) - 1) + "|"]
    for row in rows:
        cells = [row["library"], str(row["lines"]), f"{row['first']:.2f}" if "first" in row else ""]
        for error in ERRORS:
            found = row[f"{error:g}"]
            if found is None:
                cells += ["not reached", "", ""]
                continue
            cells += [
                f"{found['seconds'] * 1e3:.3g} ({found['method']})",
                f"{found['energy']:.0e}",
                f"{found['casimir']:.0e}",
            ]
        text.append("| " + " | ".join(cells) + " |")
    return "\n".join(text)


def ratios(found: dict[str, list[dict[str, Any]]]) -> str:
    """Markdown: Leafwise's time over heyoka's, and Leafwise's."""
    text = ["| Leafwise over heyoka | " + " | ".join(f"1e{round(np.log10(error))}" for error in ERRORS) + " |", "|---|---:|---:|---:|"]
    for name, rows in found.items():
        of_library = {row["library"]: row for row in rows}
        cells = [PROBLEMS[name].title]
        for error in ERRORS:
            own, other = (of_library[library][f"{error:g}"] for library in ("Leafwise", "heyoka"))
            ratio = f"{own['seconds'] / other['seconds']:.2f}" if own and other else "not reached"
            cells.append(f"{ratio} ({own['seconds'] * 1e6:.0f} µs, {own['method']})" if own else ratio)
        text.append("| " + " | ".join(cells) + " |")
    return "\n".join(text)


def main() -> None:
    """All of it, or the problems named."""
    parser = argparse.ArgumentParser()
    parser.add_argument("problems", nargs="*", choices=[[], *PROBLEMS], default=[])
    parser.add_argument("--json", type=Path)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--libraries", type=lambda names: names.split(","), default=list(LIBRARIES))
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    found = {}
    for name in asked.problems or PROBLEMS:
        found[name] = measure(name, asked.rounds, asked.libraries)
        print(shown(name, found[name]), end="\n\n", flush=True)
    if {"Leafwise", "heyoka"} <= set(asked.libraries):
        print(ratios(found))
    if asked.json:
        asked.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
