"""The problems in Leafwise."""

import leafwise as lw
import numpy as np


def rigid_body(method):
    """User's code."""
    return lw.Scene(
        system={
            "variables": ["x1", "x2", "x3"],
            "bracket": {"x1,x2": "-x3", "x2,x3": "-x1", "x3,x1": "-x2"},
            "hamiltonian": "x1^2/2 + x2^2/1.5 + x3^2/2.5",
        },
        method=method,
        run={"initial": [1.0, 3.0, 3.0], "steps": 1},
    )


def lotka_volterra(method):
    """User's code."""
    return lw.Scene(
        system={
            "variables": ["x1", "x2", "x3"],
            "bracket": {"x1,x2": "-x1*x2/2", "x1,x3": "x1*x3/2", "x2,x3": "-x2*x3"},
            "hamiltonian": "2*x1 + x2 + 2*x3 + ln(x2) - 2*ln(x3)",
        },
        method=method,
        run={"initial": [1.0, 1.9, 0.5], "steps": 1},
    )


def volterra_lattice(method):
    """User's code."""
    return lw.Scene(
        system={
            "families": {"x": 1024},
            "bracket": {"x[i],x[i+1]": "x[i]*x[i+1]"},
            "boundary": "periodic",
            "convention": "{x,H}",
            "hamiltonian": "sum(i, x[i])",
        },
        method=method,
        run={"initial": {"x[i]": "1 + 0.1*sin(2*pi*i/N)"}, "steps": 1},
    )


def solve(scene, time, steps):
    """User's code."""
    trajectory = scene.set(**{"method.time-step": time / steps}).trajectory([], steps=steps, record=steps)
    return trajectory()[-1]


#: Methods, by what they are called in a table.
HAMILTON_JACOBI = {
    f"Hamilton–Jacobi {order}": {"dynamics": {"name": "hamilton-jacobi", "order": order}, "time-step": 0.1}
    for order in (4, 6, 8)
}
SPLITTINGS = {
    f"splitting, {name}": {"stepper": "splitting", "composition": name, "time-step": 0.1}
    for name in ("blanes-moan-4", "blanes-moan-6", "sofroniou-spaletta-10")
}
METHODS = {
    "rigid_body": HAMILTON_JACOBI | SPLITTINGS,
    "lotka_volterra": HAMILTON_JACOBI | SPLITTINGS,
    "volterra_lattice": {
        "Hamilton–Jacobi 2": {
            "realization": {"name": "karasev-truncated", "order": 2},
            "dynamics": {"name": "hamilton-jacobi", "order": 2},
            "time-step": 0.1,
        },
        **SPLITTINGS,
    },
}


class Solver:
    """Runs with one method at one number of steps; a finer setting has 2^(1/4) times as many."""

    SETTINGS = [round(50 * 2 ** (k / 4)) for k in range(50)]

    def __init__(self, problem, name, method, setting):
        self.scene = globals()[name](method).set(**{"method.time-step": problem.time / setting})
        self.trajectory = self.scene.trajectory([], steps=setting, record=setting)
        self.setting = setting

    def end(self):
        """The last state."""
        return self.trajectory()[-1]

    def states(self):
        """Those after each step."""
        return np.asarray(self.scene.trajectory([], steps=self.setting, record=1)())


def first(name, problem, method, setting):
    """A first result."""
    return solve(globals()[name](METHODS[name][method]), problem.time, setting)
