"""Exceptions and warnings."""

from ._leafwise import IntegrationError, LeafwiseError, SceneError

#: Of a run that failed: what it left. None where no run did.
IntegrationError.run = None

__all__ = ["IntegrationError", "LeafwiseError", "LeafwiseWarning", "SceneError"]


class LeafwiseWarning(UserWarning):
    """What a run wants changed in its scene."""
