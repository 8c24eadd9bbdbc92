"""The problems in diffrax."""

import diffrax
import jax
import jax.numpy as jnp
import numpy as np

jax.config.update("jax_enable_x64", True)


def rigid_body():
    """User's code."""

    def slope(t, x, _):
        x1, x2, x3 = x
        return jnp.stack(
            [
                x2 * x3 * (1 / 0.75 - 1 / 1.25),
                x3 * x1 * (1 / 1.25 - 1),
                x1 * x2 * (1 - 1 / 0.75),
            ]
        )

    return slope, jnp.array([1.0, 3.0, 3.0])


def lotka_volterra():
    """User's code."""

    def slope(t, x, _):
        x1, x2, x3 = x
        return jnp.stack(
            [
                x1 * ((x2 + 1) / 2 - x3 + 1),
                x2 * (2 * x3 - 2 - x1),
                x3 * (x1 - x2 - 1),
            ]
        )

    return slope, jnp.array([1.0, 1.9, 0.5])


def volterra_lattice():
    """User's code."""

    def slope(t, x, _):
        return x * (jnp.roll(x, -1) - jnp.roll(x, 1))

    return slope, 1 + 0.1 * jnp.sin(2 * jnp.pi * jnp.arange(1024) / 1024)


def solve(slope, x0, time, method, tolerance):
    """User's code."""
    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(slope),
        method,
        t0=0.0,
        t1=time,
        dt0=None,
        y0=x0,
        stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
        max_steps=1_000_000,
    )
    return solution.ys[-1]


METHODS = dict.fromkeys(
    ["rigid_body", "lotka_volterra", "volterra_lattice"], {"Tsit5": diffrax.Tsit5(), "Dopri8": diffrax.Dopri8()}
)


class Solver:
    """Runs with one tolerance; a finer one is 10^(1/4) times as small. It is no constant of the compiled code."""

    SETTINGS = [10 ** (-k / 4) for k in range(8, 55)]
    compiled: dict = {}

    def __init__(self, problem, name, method, setting):
        self.slope, self.initial = globals()[name]()
        self.method, self.time, self.setting = method, problem.time, setting
        key = (name, type(method))
        if key not in self.compiled:
            self.compiled[key] = jax.jit(lambda x0, tolerance: solve(self.slope, x0, problem.time, method, tolerance))
        self.run = self.compiled[key]

    def end(self):
        """The last state."""
        return np.asarray(self.run(self.initial, self.setting).block_until_ready())

    def states(self):
        """Those after each step."""
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(self.slope),
            self.method,
            t0=0.0,
            t1=self.time,
            dt0=None,
            y0=self.initial,
            stepsize_controller=diffrax.PIDController(rtol=self.setting, atol=self.setting),
            saveat=diffrax.SaveAt(t0=True, steps=True),
            max_steps=min(1_000_000, 50_000_000 // len(self.initial)),
        )
        return np.asarray(solution.ys)[: int(solution.stats["num_accepted_steps"]) + 1]


def first(name, problem, method, setting):
    """A first result."""
    return np.asarray(solve(*globals()[name](), problem.time, METHODS[name][method], setting))
