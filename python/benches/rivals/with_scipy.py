"""The problems in SciPy."""

import numpy as np
from scipy.integrate import solve_ivp


def rigid_body():
    """User's code."""

    def slope(t, x):
        x1, x2, x3 = x
        return [
            x2 * x3 * (1 / 0.75 - 1 / 1.25),
            x3 * x1 * (1 / 1.25 - 1),
            x1 * x2 * (1 - 1 / 0.75),
        ]

    return slope, [1.0, 3.0, 3.0]


def lotka_volterra():
    """User's code."""

    def slope(t, x):
        x1, x2, x3 = x
        return [
            x1 * ((x2 + 1) / 2 - x3 + 1),
            x2 * (2 * x3 - 2 - x1),
            x3 * (x1 - x2 - 1),
        ]

    return slope, [1.0, 1.9, 0.5]


def volterra_lattice():
    """User's code."""

    def slope(t, x):
        return x * (np.roll(x, -1) - np.roll(x, 1))

    return slope, 1 + 0.1 * np.sin(2 * np.pi * np.arange(1024) / 1024)


def solve(slope, x0, time, tolerance):
    """User's code."""
    return solve_ivp(slope, (0, time), x0, method="DOP853", rtol=tolerance, atol=tolerance).y[:, -1]


METHODS = dict.fromkeys(["rigid_body", "lotka_volterra", "volterra_lattice"], {"DOP853": None})


class Solver:
    """Runs with one tolerance; a finer one is 10^(1/4) times as small."""

    SETTINGS = [10 ** (-k / 4) for k in range(8, 55)]

    def __init__(self, problem, name, method, setting):
        self.slope, self.initial = globals()[name]()
        self.time, self.setting = problem.time, setting

    def end(self):
        """The last state."""
        return solve(self.slope, self.initial, self.time, self.setting)

    def states(self):
        """Those after each step."""
        tolerances = {"rtol": self.setting, "atol": self.setting}
        return solve_ivp(self.slope, (0, self.time), self.initial, method="DOP853", **tolerances).y.T


def first(name, problem, method, setting):
    """A first result."""
    return solve(*globals()[name](), problem.time, setting)
