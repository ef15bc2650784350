"""What can be chosen about the recursive estimators."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from mmt_drake.errors import BadInput, check_number
from mmt_drake.estimation.output_error.options import LearningOptions


@dataclass(frozen=True, kw_only=True)
class KalmanOptions(LearningOptions):
    """Choices of the Kalman filter.

    Attributes:
        step, sample, period, prior, force_limit: see `LearningOptions`.
        force_noise: deviation of the force sensor's noise, each tick [N]; more is found out.
        body_noise: deviation of what acts on the body and is not in the model, each sample [N].
        drift: deviation of what the parameters do in a second, of their natural sizes.
        rivals: filters that run beside the one that is believed, each with something else in mind.

    Raises:
        BadInput: a value that is out of range.
    """

    force_noise: float = 0.02
    body_noise: float = 0.01
    drift: float = 1e-3
    rivals: int = 8

    SOURCE: ClassVar = "Kalman filter"

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("force_noise", "body_noise", "drift"):
            check_number(self.SOURCE, name, getattr(self, name), least=0.0, open_interval=name == "force_noise")
        if not 0 <= self.rivals <= 10:
            raise BadInput(self.SOURCE, at="rivals", found=self.rivals, expected="0 to 10")


@dataclass(frozen=True, kw_only=True)
class InstrumentalOptions(LearningOptions):
    """Choices of the refined instrumental variable.

    Attributes:
        step, sample, period, prior, force_limit: see `LearningOptions`.
        force_noise: deviation of the force sensor's noise, each tick [N]; no fit is believed to be better.
        growth: samples count to 1/e for this share of the time in contact so far: while the prefilter and the auxiliary
            model are still wrong they are forgotten soon.
        memory: time in contact for which samples count to 1/e at most [s].

    Raises:
        BadInput: a value that is out of range.
    """

    force_noise: float = 0.02
    growth: float = 1.0
    memory: float = 30.0

    SOURCE: ClassVar = "instrumental variable"

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("force_noise", "growth"):
            check_number(self.SOURCE, name, getattr(self, name), least=0.0, open_interval=True)
        self._check_time("memory", 1.0, 1e6)
