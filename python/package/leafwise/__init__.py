"""Poisson systems, integrated by maps that preserve the Poisson structure.

    import leafwise as lw

    scene = lw.Scene.load("scenes/rigid_body.toml")
    run = scene.run(steps=10_000, record=10)
    run.t, run.x, run.energy, run.casimirs["spin"], run.drift
    cloud = scene.ensemble(x0=states, parameters={"I2": values})
    table = scene.sweep({"method.time-step": [0.1, 0.2], "system.parameters.I2": values}).to_pandas()
    solution = lw.solve(
        bracket={"q,p": "1"}, convention="{x,H}", hamiltonian="p^2/2 - cos(q)", x0=[0, 1], t_span=(0, 20)
    )

Units are those of the scene. States have the shape (d,), recorded ones (samples, d). ``from leafwise import *`` leaves the builtin ``list``:
parts and systems are ``lw.list()``.
"""

from . import lattice
from ._boozer import BoozerField, import_boozer
from ._commands import command, describe, list_parts as list, load_plugin
from ._comparison import Comparison
from ._ensemble import Ensemble
from ._equilibrium import Equilibrium, import_equilibrium
from ._errors import IntegrationError, LeafwiseError, LeafwiseWarning, SceneError
from ._find import Found, casimirs, find
from ._fit import Fit
from ._fmu import Fmu, write_fmu
from ._functions import System
from ._gradient import Gradient, Tangents, Trajectory, Tried
from ._leafwise import Growth, Integrator, version as _version
from ._learn import Learned, Tabulated, learn, tabulate
from ._orbit import EquilibriumPoint, Orbit, OrbitFamily, equilibrium_point, orbit, orbit_family
from ._parts import closed_form, generating_function
from ._run import Run
from ._scene import Scene
from ._solve import Solution, solve
from ._state_error import StateError
from ._sweep import Sweep

__version__ = _version()

__all__ = [
    "BoozerField",
    "Comparison",
    "Equilibrium",
    "EquilibriumPoint",
    "Fit",
    "Fmu",
    "Found",
    "Gradient",
    "Growth",
    "Ensemble",
    "Integrator",
    "IntegrationError",
    "LeafwiseError",
    "LeafwiseWarning",
    "Learned",
    "Orbit",
    "OrbitFamily",
    "Run",
    "Scene",
    "SceneError",
    "StateError",
    "Sweep",
    "Tabulated",
    "Tangents",
    "Trajectory",
    "Tried",
    "Solution",
    "System",
    "casimirs",
    "closed_form",
    "command",
    "describe",
    "equilibrium_point",
    "find",
    "generating_function",
    "import_boozer",
    "import_equilibrium",
    "lattice",
    "learn",
    "load_plugin",
    "orbit",
    "orbit_family",
    "solve",
    "tabulate",
    "write_fmu",
]
