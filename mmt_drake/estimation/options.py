"""What can be chosen about the thesis's estimator."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

from mmt_drake.errors import BadInput
from mmt_drake.model.regrouping import EQUATIONS, Equations

Weighting = Literal["band", "information"]
FrictionVelocity = Literal["probe", "body"]
PositionOrigin = Literal["table", "touch"]
Differences = Literal["backward", "central"]

_CHOICES = {
    "equations": EQUATIONS,
    "weighting": get_args(Weighting),
    "friction_velocity": get_args(FrictionVelocity),
    "position_origin": get_args(PositionOrigin),
    "differences": get_args(Differences),
}


def _check(field: str, value: object, good: bool, expected: str) -> None:
    if not good:
        raise BadInput("RLS estimator", at=field, found=value, expected=expected)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


@dataclass(frozen=True)
class RlsOptions:
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

    step: float = 0.001
    filter_order: int = 6
    cutoff_hz: float = 10.0
    initial_covariance: float = 1e6
    forgetting: float = 1.0
    equations: Equations = "all"
    weighting: Weighting = "band"
    friction_velocity: FrictionVelocity = "probe"
    filter_friction: bool = True
    position_origin: PositionOrigin = "table"
    differences: Differences = "backward"
    settle: float = 0.0
    freeze_after: float | None = None
    knows_held_body = False

    def __post_init__(self) -> None:
        step, order, cutoff, p0 = self.step, self.filter_order, self.cutoff_hz, self.initial_covariance
        _check("step", step, _is_number(step) and step > 0, "a time in s above 0")
        integer = isinstance(order, int) and not isinstance(order, bool)
        _check("filter_order", order, integer and 1 <= order <= 12, "an integer, 1 to 12")
        nyquist = 0.5 / step
        _check("cutoff_hz", cutoff, _is_number(cutoff) and 0.01 <= cutoff < nyquist, f"0.01 to {nyquist:g} Hz")
        _check("initial_covariance", p0, _is_number(p0) and p0 > 0, "a number above 0")
        _check("forgetting", self.forgetting, _is_number(self.forgetting) and 0 < self.forgetting <= 1, "in (0, 1]")
        for field, legal in _CHOICES.items():
            _check(field, getattr(self, field), getattr(self, field) in legal, f"one of {', '.join(legal)}")
        if self.weighting == "information":
            _check("equations", self.equations, self.equations == "all", "all, where weighting is information")
        _check("filter_friction", self.filter_friction, isinstance(self.filter_friction, bool), "true or false")
        _check("settle", self.settle, _is_number(self.settle) and self.settle >= 0, "a time in s, 0 or more")
        if self.freeze_after is not None:
            good = _is_number(self.freeze_after) and self.freeze_after >= 0
            _check("freeze_after", self.freeze_after, good, "a time in s, 0 or more, or null")
