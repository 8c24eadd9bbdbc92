"""Poisson systems, integrated by maps that preserve the Poisson structure.

    import leafwise as lw

    scene = lw.Scene.load("scenes/rigid_body.toml")
    run = scene.run(steps=10_000, record=10)
    run.t, run.x, run.energy, run.casimirs["spin"], run.drift

Units are those of the scene. States have the shape (d,), recorded ones (samples, d).
"""

from ._commands import command, describe, list_parts as list
from ._errors import IntegrationError, LeafwiseError, LeafwiseWarning, SceneError
from ._leafwise import Integrator
from ._run import Run
from ._scene import Scene

__all__ = [
    "Integrator",
    "IntegrationError",
    "LeafwiseError",
    "LeafwiseWarning",
    "Run",
    "Scene",
    "SceneError",
    "command",
    "describe",
    "list",
]
