"""The problems in heyoka."""

import heyoka as hy
import numpy as np
import problems
from problems import BODIES, SPECIES


def rigid_body():
    """User's code."""
    x1, x2, x3 = hy.make_vars("x1", "x2", "x3")
    slope = [
        (x1, x2 * x3 * (1 / 0.75 - 1 / 1.25)),
        (x2, x3 * x1 * (1 / 1.25 - 1)),
        (x3, x1 * x2 * (1 - 1 / 0.75)),
    ]
    return slope, [1.0, 3.0, 3.0]


def lotka_volterra():
    """User's code."""
    x1, x2, x3 = hy.make_vars("x1", "x2", "x3")
    slope = [
        (x1, x1 * ((x2 + 1.0) / 2.0 - x3 + 1.0)),
        (x2, x2 * (2.0 * x3 - 2.0 - x1)),
        (x3, x3 * (x1 - x2 - 1.0)),
    ]
    return slope, [1.0, 1.9, 0.5]


def heavy_top():
    """User's code."""
    m1, m2, m3, g1, g2, g3 = hy.make_vars("m1", "m2", "m3", "g1", "g2", "g3")
    w1, w2, w3 = m1, m2 / 0.75, m3 / 1.25
    slope = [
        (m1, m2 * w3 - m3 * w2 + g2),
        (m2, m3 * w1 - m1 * w3 + 0.3 * g3 - g1),
        (m3, m1 * w2 - m2 * w1 - 0.3 * g2),
        (g1, g2 * w3 - g3 * w2),
        (g2, g3 * w1 - g1 * w3),
        (g3, g1 * w2 - g2 * w1),
    ]
    return slope, [0.5, 1.0, 1.5, 0.6, 0.0, 0.8]


def coupled_bodies():
    """User's code."""
    n = BODIES
    m = [hy.make_vars(f"m{i}x", f"m{i}y", f"m{i}z") for i in range(n)]
    slope = []
    for i, (x, y, z) in enumerate(m):
        w1, w2, w3 = x + 0.1 * (m[i - 1][0] + m[(i + 1) % n][0]), y / 0.75, z / 1.25
        slope += [(x, w2 * z - w3 * y), (y, w3 * x - w1 * z), (z, w1 * y - w2 * x)]
    return slope, problems.bodies()


def food_web():
    """User's code."""
    a, c = problems.food_web()
    x = hy.make_vars(*[f"x{i}" for i in range(SPECIES)])
    return [
        (x[i], x[i] * hy.sum([a[j, i] * (x[j] - c[j]) for j in range(SPECIES) if j != i])) for i in range(SPECIES)
    ], 1 + 0.3 * np.sin(2.1 * np.arange(SPECIES) + 0.4)


def henon_heiles():
    """User's code."""
    q1, q2, p1, p2 = hy.make_vars("q1", "q2", "p1", "p2")
    slope = [(q1, p1), (q2, p2), (p1, -q1 - 2 * q1 * q2), (p2, -q2 - q1 * q1 + q2 * q2)]
    return slope, [0.0, 0.1, 0.3872983346207417, 0.1]


def magnetic():
    """User's code."""
    x, y, z, p1, p2, p3 = hy.make_vars("x", "y", "z", "p1", "p2", "p3")
    b1, b2, b3 = y, -z, x * x
    slope = [
        (x, p1),
        (y, p2),
        (z, p3),
        (p1, p3 * b2 - p2 * b3 - x),
        (p2, p1 * b3 - p3 * b1 - y),
        (p3, p2 * b1 - p1 * b2 - z),
    ]
    return slope, [1.0, 0.5, -0.5, 0.3, 0.2, 0.4]


def kepler():
    """User's code."""
    q1, q2, p1, p2 = hy.make_vars("q1", "q2", "p1", "p2")
    cube = (q1 * q1 + q2 * q2) ** -1.5
    slope = [(q1, p1), (q2, p2), (p1, -q1 * cube), (p2, -q2 * cube)]
    return slope, [0.1, 0.0, 0.0, 4.358898943540674]


def volterra_lattice():
    """User's code."""
    x = hy.make_vars(*[f"x{i}" for i in range(1024)])
    slope = [(x[i], x[i] * (x[(i + 1) % 1024] - x[i - 1])) for i in range(1024)]
    return slope, 1 + 0.1 * np.sin(2 * np.pi * np.arange(1024) / 1024)


def solve(slope, x0, time, tolerance):
    """User's code."""
    taylor = hy.taylor_adaptive(slope, x0, tol=tolerance, compact_mode=len(x0) > 200)
    taylor.propagate_until(time)
    return taylor.state


METHODS = dict.fromkeys(problems.PROBLEMS, {"Taylor": None})


class Solver:
    """Runs with one tolerance; a finer one is 10^(1/2) times as small, since each is compiled."""

    SETTINGS = [10 ** (-k / 2) for k in range(4, 32)]

    def __init__(self, problem, name, method, setting, kind=float):
        slope, initial = globals()[name]()
        self.initial, self.begin, self.time = np.array(initial, dtype=kind), kind(0), kind(problem.time)
        self.taylor = hy.taylor_adaptive(
            slope, list(self.initial), tol=kind(setting), compact_mode=len(self.initial) > 200, fp_type=kind
        )

    def end(self):
        """The last state."""
        self.taylor.time = self.begin
        self.taylor.state[:] = self.initial
        self.taylor.propagate_until(self.time)
        return self.taylor.state.copy()

    def states(self):
        """Those after each step."""
        found = [self.initial]
        self.taylor.time = self.begin
        self.taylor.state[:] = self.initial
        self.taylor.propagate_until(self.time, callback=lambda taylor: found.append(taylor.state.copy()) or True)
        return np.array(found)


def first(name, problem, method, setting):
    """A first result."""
    return solve(*globals()[name](), problem.time, setting)


def reference(name, problem):
    """The last state to the digits of a double, by a Taylor method in numbers of 64 binary digits."""
    return Solver(problem, name, None, 1e-19, np.longdouble).end()
