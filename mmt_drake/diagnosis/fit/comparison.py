"""How fits of one problem compare: when one rules another out, and when one has run into a bound."""

from __future__ import annotations

from mmt_drake.diagnosis.fit.problem import Fitted

RULED_OUT = 12.0
"""A rival is ruled out if it is worse by this much in -2 ln(likelihood), each free number counting ln(samples)."""


def at_bound(fitted: Fitted) -> str | None:
    """The structural parameter that a fit has driven to its bound, 0 apart; None if it has driven none."""
    for place, value in zip(fitted.hypothesis.places(), fitted.x, strict=True):
        if not place.effect and place.symbol in fitted.hypothesis.free:
            room = 0.01 * place.scale
            if (place.low > 0.0 and value - place.low < 0.25 * room) or place.high - value < room:
                return place.symbol
    return None
