"""Exceptions and warnings."""

from ._leafwise import IntegrationError, LeafwiseError, SceneError

__all__ = ["IntegrationError", "LeafwiseError", "LeafwiseWarning", "SceneError"]


class LeafwiseWarning(UserWarning):
    """What a run wants changed in its scene."""
