"""The problems in Leafwise."""

import leafwise as lw
import numpy as np
import problems
from problems import BODIES, SPECIES


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


def heavy_top(method):
    """User's code."""
    return lw.Scene(
        system={
            "variables": ["m1", "m2", "m3", "g1", "g2", "g3"],
            "bracket": {
                **{"m1,m2": "m3", "m2,m3": "m1", "m3,m1": "m2"},
                **{"m1,g2": "g3", "m2,g3": "g1", "m3,g1": "g2"},
                **{"g1,m2": "g3", "g2,m3": "g1", "g3,m1": "g2"},
            },
            "hamiltonian": "m1^2/2 + m2^2/1.5 + m3^2/2.5 + 0.3*g1 + g3",
        },
        method=method,
        run={"initial": [0.5, 1.0, 1.5, 0.6, 0.0, 0.8], "steps": 1},
    )


def coupled_bodies(method):
    """User's code."""
    n = range(BODIES)
    return lw.Scene(
        system={
            "variables": [f"m{i}{c}" for i in n for c in "xyz"],
            "bracket": {f"m{i}{a},m{i}{b}": f"-m{i}{c}" for i in n for a, b, c in ("xyz", "yzx", "zxy")},
            "hamiltonian": " + ".join(
                f"m{i}x^2/2 + m{i}y^2/1.5 + m{i}z^2/2.5 + 0.1*m{i}x*m{(i + 1) % BODIES}x" for i in n
            ),
        },
        method=method,
        run={"initial": list(problems.bodies()), "steps": 1},
    )


def food_web(method):
    """User's code."""
    a, c = problems.food_web()
    n = range(SPECIES)
    return lw.Scene(
        system={
            "variables": [f"x{i}" for i in n],
            "bracket": {f"x{i},x{j}": f"({a[i, j]})*x{i}*x{j}" for i in n for j in n if i < j},
            "hamiltonian": " + ".join(f"x{i} - {c[i]}*ln(x{i})" for i in n),
        },
        method=method,
        run={"initial": list(1 + 0.3 * np.sin(2.1 * np.arange(SPECIES) + 0.4)), "steps": 1},
    )


def henon_heiles(method):
    """User's code."""
    return lw.Scene(
        system={
            "variables": ["q1", "q2", "p1", "p2"],
            "bracket": {"q1,p1": "1", "q2,p2": "1"},
            "convention": "{x,H}",
            "hamiltonian": "(p1^2 + p2^2)/2 + (q1^2 + q2^2)/2 + q1^2*q2 - q2^3/3",
        },
        method=method,
        run={"initial": [0.0, 0.1, 0.3872983346207417, 0.1], "steps": 1},
    )


def magnetic(method):
    """User's code."""
    return lw.Scene(
        system={"library": "magnetic"},
        method=method,
        run={"initial": [1.0, 0.5, -0.5, 0.3, 0.2, 0.4], "steps": 1},
    )


def kepler(method):
    """User's code."""
    return lw.Scene(
        system={"library": "kepler"},
        method=method | {"pace": "(q1^2 + q2^2)^0.75"},
        run={"initial": [0.1, 0.0, 0.0, 4.358898943540674], "until": 20.0, "record": {"interval": 20.0}},
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


def lifts(realization):
    """Gauss methods in coordinates with a constant tensor."""
    return {
        f"{realization}, Gauss {stages}": {
            "realization": realization,
            "dynamics": {"name": "collective", "stages": stages},
            "time-step": 0.1,
        }
        for stages in (4, 8, 16)
    }


GAUSS = {f"gauss {stages}": {"stepper": {"name": "gauss", "stages": stages}, "time-step": 0.1} for stages in (4, 8)}

METHODS = {
    "rigid_body": HAMILTON_JACOBI | SPLITTINGS | lifts("clebsch"),
    "lotka_volterra": HAMILTON_JACOBI | SPLITTINGS | lifts("logarithms"),
    "heavy_top": SPLITTINGS | lifts("clebsch"),
    "coupled_bodies": SPLITTINGS | lifts("clebsch"),
    "food_web": {"splitting, blanes-moan-4": SPLITTINGS["splitting, blanes-moan-4"]} | lifts("logarithms"),
    "henon_heiles": HAMILTON_JACOBI | SPLITTINGS | GAUSS,
    "magnetic": SPLITTINGS
    | {
        name: method | {"realization": {"name": "karasev-truncated", "order": 3}}
        for name, method in HAMILTON_JACOBI.items()
    },
    "kepler": HAMILTON_JACOBI | GAUSS,
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

    SETTINGS = sorted({round(3 * 2 ** (k / 4)) for k in range(67)})

    def __init__(self, problem, name, method, setting):
        self.scene = globals()[name](method).set(**{"method.time-step": problem.time / setting})
        self.setting = setting
        # Steps of a pace are not counted before.
        self.is_paced = name == "kepler"
        if self.is_paced:
            self.trajectory = lambda: self.scene.run(advice=False).x
        else:
            self.trajectory = self.scene.trajectory([], steps=setting, record=setting)

    def end(self):
        """The last state."""
        return self.trajectory()[-1]

    def states(self):
        """Those after each step; of a pace, at 1000 times."""
        if self.is_paced:
            return self.scene.set(**{"run.record.interval": 0.02}).run(advice=False).x
        return np.asarray(self.scene.trajectory([], steps=self.setting, record=1)())


def first(name, problem, method, setting):
    """A first result."""
    scene = globals()[name](METHODS[name][method])
    if name == "kepler":
        return Solver(problem, name, METHODS[name][method], setting).end()
    return solve(scene, problem.time, setting)
