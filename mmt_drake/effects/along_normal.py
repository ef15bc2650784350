"""A law of the contact along the surface, made one along the surface normal.

There the deflection d is the depth, -z; what the law reads of spring and damper is the normal axis', and nothing moves
but the probe.
"""

from dataclasses import replace
from typing import Final

from mmt_drake.effects.effect import Effect, Ranges, Values

_THERE: Final = {"k2": "normal_k", "b2": "normal_b", "m": "normal_m"}
_SEEN: Final = {"deflection": "depth", "deflection_rate": "depth_rate", "sliding_velocity": "depth_rate"}


def along_normal(effect: Effect) -> Effect:
    """The effect `normal_NAME` with the law of another one, of a contact; fits begin by the scales of its presses."""

    def engages(values: Values, ranges: Ranges) -> bool:
        seen = {name: ranges[own] for name, own in _SEEN.items() if own in ranges}
        used = {name: ranges[own] for name, own in _THERE.items() if own in ranges}
        return effect.engages(values, {**ranges, **seen, **used})

    return replace(
        effect,
        name=f"normal_{effect.name}",
        axis="z",
        twin_of=effect.name,
        equation=f"along the surface normal: {effect.equation}",
        uses=tuple(_THERE[symbol] for symbol in effect.uses),
        needs=tuple(_THERE[symbol] for symbol in effect.needs),
        holds=tuple(f"normal_{name}" for name in effect.holds if name == "nonlinear_stiffness"),
        equal_to=(),
        equal_one_way=(),
        equal_massless=(),
        near_equal={},
        elsewhere={},
        stiffness=lambda values: 0.0,
        damping=lambda values: 0.0,
        engages=engages,
        starts=lambda scales: effect.starts(scales.normal or scales),
    )
