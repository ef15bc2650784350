"""Options of the output-error estimator."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Annotated, ClassVar, Final

import numpy as np

from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.estimation.output_error.lateness import LONGEST_S
from mmt_drake.model.message_layout import MESSAGE_SIZE
from mmt_drake.model.parameters import InPlane
from mmt_drake.model_message import UNKNOWN_THETA, ModelMessage, ToldEffect
from mmt_drake.numeric.arrays import Array
from mmt_drake.quantities import Checked, Damping, Level, Mass, Quantity, Stiffness


@dataclass(frozen=True)
class Prior(Checked):
    """What is believed of an object before it is touched, and kept of what the motion does not excite.

    A soft, light thing that lies loose on the table and does not slide by itself. Once the normal axis is known, its
    stiffness and damping take the place of k2 and b2: the object is one material.

    Attributes:
        m: [kg].
        k1, k2: [N/m].
        b1, b2: [N s/m].
        Fc: [N].
        normal_k, normal_b: [N/m], [N s/m].

    Raises:
        BadInput: a value that is negative or not finite, or 0 where the object would have no mass or no surface.
    """

    m: Mass = 0.5
    k1: Stiffness = 0.0
    k2: Annotated[float, Quantity("N/m", positive=True)] = 300.0
    b1: Damping = 15.0
    b2: Annotated[float, Quantity("N s/m", positive=True)] = 15.0
    Fc: Level = 0.5
    normal_k: Annotated[float, Quantity("N/m", positive=True)] = 300.0
    normal_b: Damping = 15.0

    CALLED: ClassVar = "prior of the estimator"


@dataclass(frozen=True, kw_only=True)
class OutputErrorOptions(Checked):
    """Choices of the estimator.

    Attributes:
        step: sample time [s].
        sample: what is learned from are means over about this time [s]: as many whole steps as come nearest, one at
            least.
        period: about the time between fits [s]: as many samples as come nearest, one at least. What a fit finds is
            handed over one period later. The last sample that it sees is some 25 ms old: for so long samples are
            watched before they count.
        prior: what is believed beforehand.
        force_limit: at which the force sensor saturates [N]; null where unknown. A force that stands still while the
            probe moves is taken for saturated or frozen either way.
        window: how much is fitted at once [s]; of what is older its information is kept.
        memory: time in which that information fades to 1/e [s].
        in_plane: whether friction is one vector, F = -Fc v/|v|, or that of each axis, as in the thesis.
        surface: standard deviation of the height at which contact is said to begin [m]; 0 takes it as exact. null: in a
            station that of its `touch`, else 0.
        effects: laws that the object is known to have beside the numbers that are sought, as those of a renderer
            (`mmt_drake.model_message`).

    Raises:
        BadInput: a value that is out of range; an effect that is unknown, not to be felt or has values that it does
            not allow; a law of the load beside one along the normal.
    """

    step: Annotated[float, Quantity("s", 1e-5, 0.05)] = 0.001
    sample: Annotated[float, Quantity("s", 1e-4, 0.05)] = 0.005
    period: Annotated[float, Quantity("s", 1e-3, 1.0)] = 0.05
    prior: Prior = field(default_factory=Prior)
    force_limit: Annotated[float | None, Quantity("N", positive=True)] = None
    window: Annotated[float, Quantity("s", 2.0, 300.0)] = 30.0
    memory: Annotated[float, Quantity("s", 1.0, 1e6)] = 120.0
    in_plane: InPlane = "vector"
    surface: Annotated[float | None, Quantity("m", 0.0, 0.01)] = None
    effects: tuple[ToldEffect, ...] = ()
    tells: ClassVar = ("held_body", "model_status", "model", "thing")

    CALLED: ClassVar = "output-error estimator"

    def __post_init__(self) -> None:
        super().__post_init__()
        _ = self.model
        check_side_by_side(self.effects, self.CALLED)

    @property
    def model(self) -> Array:
        """(MESSAGE_SIZE,) the effects as a message tells them; zeros without any."""
        return ModelMessage(UNKNOWN_THETA, effects=self.effects).vector() if self.effects else np.zeros(MESSAGE_SIZE)

    @property
    def ticks(self) -> int:
        """Steps in a sample of the fit."""
        return max(1, round(self.sample / self.step))

    @property
    def interval(self) -> float:
        """Time between the samples of the fit [s]."""
        return self.ticks * self.step

    @property
    def samples_per_fit(self) -> int:
        """Samples between fits."""
        return max(1, round(self.period / self.interval))

    @property
    def latency(self) -> float:
        """Time between fits, after which each is handed over [s]."""
        return self.samples_per_fit * self.interval


def check_told(message: ModelMessage, source: str) -> None:
    """Refuse a message that cannot be taken up: `check_side_by_side`, or a force that lags more than any fit believes.

    Raises:
        BadInput: as it says.
    """
    check_side_by_side(message.effects, source)
    if message.sensor.tau > LONGEST_S:
        raise BadInput(source, at="force_lag", found=message.sensor.tau, expected=f"{LONGEST_S:g} s at most")


_OF_LOAD: Final = "load_dependent_friction"


def check_side_by_side(effects: Iterable[ToldEffect], source: str) -> None:
    """Refuse laws that a fit cannot have side by side.

    Raises:
        BadInput: a law of the load beside one along the normal.
    """
    known = [LIBRARY[told.name] for told in effects]
    if any(effect.axis for effect in known) and any(effect.name == _OF_LOAD for effect in known):
        expected = "no law along the normal beside it: the load of a fit is that of a spring and a damper"
        raise BadInput(source, at="effects", found=_OF_LOAD, expected=expected)
