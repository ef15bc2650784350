"""Samples on their way to a recursive estimator: smoothed over a short stretch, and handed on once they are final."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mmt_drake.estimation.output_error.smoothing import FilterBank, filter_bank
from mmt_drake.estimation.output_error.window import MOTION_GOOD, Window

Array = NDArray[np.float64]


def short_bank(h: float, ticks: int) -> FilterBank:
    """The widest band of the smoothing alone, 13 Hz: it looks 0.1 s ahead, the others for longer than is waited."""
    bank = filter_bank(h, ticks)
    return FilterBank(bank.filters[:1], bank.differences[:1])


@dataclass(frozen=True)
class Stream:
    """The latest samples.

    Attributes:
        window: of them, the oldest first.
        done: how many of them have been handed on.
        interrupted: whether time broke off once.
    """

    window: Window
    done: int = 0
    interrupted: bool = False

    @classmethod
    def empty(cls) -> Self:
        """No sample."""
        return cls(Window.empty())

    def broken(self) -> Self:
        """After time broke off: what was under way is lost."""
        return replace(self, window=Window.empty(), done=0, interrupted=True)

    def extended(self, new: Array, h: float, bank: FilterBank) -> Self:
        """With new samples at the end; of those handed on as many stay as the smoothing looks back to."""
        spare = self.done - 3 * bank.reach
        window, done = self.window, self.done
        if spare > bank.reach:
            window, done = window.shortened(spare), done - spare
        if len(window) == 0 and self.interrupted:
            new = new.copy()
            new[0, MOTION_GOOD] = 0.0  # as after any gap, the body has to settle
        return replace(self, window=window.extended(new, h, bank), done=done)

    def ready(self, bank: FilterBank) -> range:
        """The samples that are final now and have not been handed on."""
        return range(self.done, max(self.done, len(self.window) - bank.reach))
