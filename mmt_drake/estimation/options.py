"""Options of the thesis's estimator."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import InPlane
from mmt_drake.model.regrouping import Equations
from mmt_drake.quantities import Checked, Delay, Quantity, Time

Weighting = Literal["band", "information"]
FrictionVelocity = Literal["probe", "body"]
PositionOrigin = Literal["table", "touch"]
Differences = Literal["backward", "central"]


@dataclass(frozen=True)
class RlsOptions(Checked):
    """Choices of the estimator. The defaults are the thesis's, where it says.

    Attributes:
        step: sample time [s].
        filter_order, cutoff_hz: the Butterworth low-pass on every signal [-, Hz]; the thesis, G.1: 6 and 10 Hz.
        initial_covariance: P before the first sample is this times the identity; theta starts at 0.
        forgetting: lambda in (0, 1]; 1 is eq. 4-5.
        equations: what the back-solve uses of eq. 30, an entry of `mmt_drake.model.regrouping.EQUATIONS`.
        weighting: how 'all' weighs the six equations: `band` by their share in the force at 1 Hz, `information` by the
            inverse of P.
        friction_velocity: whose sign the friction regressor takes: `probe` (the thesis) or `body`: v + (F + k2 d)/b2
            with the parameters estimated so far, and the probe's until there are any.
        filter_friction: whether that sign goes through the filter too, to have the phase of the other regressors.
        position_origin: zero of eq. 7's x: the table frame's (`table`, the thesis) or the probe's position at touch
            (`touch`), where the contact spring starts. Both are the same without a ground spring (d = 0).
        differences: how velocity and force are differentiated: `backward` (the thesis, appendix D.2), each difference
            half a sample late, or `central`, all signals taken one sample ago.
        settle: time after each touch during which nothing is learned [s]. The filters still hold samples from before
            the touch, which no model of the contact explains; the thesis learns from them all the same (0).
        freeze_after: contact time, summed over all touches, after which nothing is learned [s] (the thesis, figures 11
            and 31: 5 s); None: never.

    Raises:
        BadInput: a value that is out of range, or two that contradict each other.
    """

    step: Time = 0.001
    filter_order: Annotated[int, Quantity("", 1, 12, whole=True)] = 6
    cutoff_hz: Annotated[float, Quantity("Hz", 0.01)] = 10.0
    initial_covariance: Annotated[float, Quantity("", positive=True)] = 1e6
    forgetting: Annotated[float, Quantity("", 0.0, 1.0, positive=True)] = 1.0
    equations: Equations = "all"
    weighting: Weighting = "band"
    friction_velocity: FrictionVelocity = "probe"
    filter_friction: bool = True
    position_origin: PositionOrigin = "table"
    differences: Differences = "backward"
    settle: Delay = 0.0
    freeze_after: Annotated[float | None, Quantity("s")] = None
    tells: ClassVar[tuple[str, ...]] = ()
    in_plane: ClassVar[InPlane] = "per_axis"
    CALLED: ClassVar = "RLS estimator"

    def __post_init__(self) -> None:
        super().__post_init__()
        nyquist = 0.5 / self.step
        if not self.cutoff_hz < nyquist:
            raise BadInput(self.CALLED, at="cutoff_hz", found=self.cutoff_hz, expected=f"0.01 to {nyquist:g} Hz")
        if self.weighting == "information" and self.equations != "all":
            expected = "all, where weighting is information"
            raise BadInput(self.CALLED, at="equations", found=self.equations, expected=expected)
