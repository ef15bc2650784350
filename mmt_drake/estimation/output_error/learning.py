"""What the gate, the system and the offline run ask of whoever learns from the checked samples."""

from __future__ import annotations

from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from mmt_drake.estimation.output_error.options import LearningOptions

Array = NDArray[np.float64]


class Known(Protocol):
    """What is known after some samples; never changed, so Drake need not copy it with its contexts."""

    @property
    def theta(self) -> Array:
        """What is handed over (10,), in the order of `mmt_drake.model.parameters.THETA`."""

    @property
    def deviation(self) -> Array:
        """Its standard deviations (10,)."""

    @property
    def held(self) -> Array:
        """Where friction holds the body (6,), `mmt_drake.model.held_body`; zeros from whoever does not tell."""


K = TypeVar("K", bound=Known)


class Learns(Protocol[K]):
    """Makes knowledge of samples; itself it keeps nothing."""

    @property
    def options(self) -> LearningOptions:
        """The estimator's."""

    def beginning(self) -> K:
        """Nothing but the prior."""

    def learned(self, known: K, new: Array, broken: bool = False) -> K:
        """Knowledge with new samples (k, SAMPLE_SIZE of `window`) in their order; `broken`: time broke off before."""

    def compile(self) -> None:
        """Compile what learning calls."""
