"""Estimated error of a run's states."""

from typing import NamedTuple


class StateError(NamedTuple):
    """Estimate of the error of a run's states, by a pass with half the step: maximum norms over the coordinates."""

    #: The largest over the steps.
    largest: float
    #: The time where that is.
    time: float
    #: That of the last state.
    at_end: float
    #: Whether the passes part by a tenth of the way that the states go: the error is large, and its size is not known.
    is_large: bool
