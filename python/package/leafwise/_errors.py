"""Exceptions and warnings."""

from ._leafwise import IntegrationError, LeafwiseError, SceneError

#: Of a run that failed: what it left. None where no run did.
IntegrationError.run = None

__all__ = ["IntegrationError", "LeafwiseError", "LeafwiseWarning", "SceneError"]


class LeafwiseWarning(UserWarning):
    """Advice to change a scene, and failures of some members or settings."""
