"""How deep a name holds beside what else there is: rules for a law, a family or a block that all explanations share."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Literal, Protocol

from mmt_drake.effects.effect import Effect

Depth = Literal["law", "family", "block"]
"""How deep a name holds, deepest first."""

MOST_NAMELESS = 0.1
"""A law is sure only if what nobody has named is no more than this part of it: what has no name may itself be a law
that is not in the library, of which the one found draws the most."""

MOST_BESIDE_A_FAMILY = 0.5
"""A family is sure only if it is no more than this part of it: what is left may be the better half of another one."""

SLIGHT = 0.03
"""An effect that takes less than this part of what another one of its block takes is no surer than the block, and that
one no surer than its family."""

MINUTE = 0.01
"""An effect that takes less than this part of what another one takes, of whatever block, is not sure at all."""


_TIMING = "timing"
_SMOOTH = "smooth_coulomb_friction"
"""Friction that is a curve over the speed, and never holds: dampers level off like it."""


class Placed(Protocol):
    """What has a name at every depth, and an axis."""

    @property
    def name(self) -> str:
        """Of the law."""

    @property
    def family(self) -> str:
        """Of laws that are mostly alike."""

    @property
    def block(self) -> str:
        """In which it acts."""

    @property
    def axis(self) -> str:
        """Along which."""


AT: dict[Depth, Callable[[Placed], tuple[str, str]]] = {
    "law": lambda effect: (effect.name, effect.axis),
    "family": lambda effect: (effect.family, effect.axis),
    "block": lambda effect: (effect.block, effect.axis),
}
"""What two effects have in common that are the same at a depth."""


def beside_the_nameless(
    depth: Depth | None, share: float, nameless: float, may_be_all: bool, shared: float = 0.0
) -> Depth | None:
    """How deep a name holds beside what nobody has named.

    Args:
        depth: that all explanations share.
        share: of the effect in the budget.
        nameless: of what nobody has named.
        may_be_all: whether a law that nobody has named may be all of the effect: the interval of its number reaches
            the value at which it does nothing, or a free curve over what it depends on says clearly more.
        shared: what the effect and the parameters take together, in the budget.
    """
    if depth is not None and nameless > MOST_BESIDE_A_FAMILY * (share + shared):
        return "block"
    return "family" if depth == "law" and (may_be_all or nameless > MOST_NAMELESS * share) else depth


def is_kin(one: Placed, other: Placed) -> bool:
    """Whether two effects are different laws of one family, in one place."""
    return AT["family"](one) == AT["family"](other) and one.name != other.name


def beside_its_kin(depth: Depth | None, effect: Placed, others: Iterable[Placed]) -> Depth | None:
    """How deep a name holds beside the other effects of its set.

    Two laws of one family on one place are as likely a third one that is not in the library, which the two make up.

    Args:
        depth: that all explanations share.
        effect: that is named.
        others: the set, with it or without.
    """
    return "family" if depth == "law" and any(is_kin(other, effect) for other in others) else depth


def beside_another_curve(
    depth: Depth | None, effect: Placed, effects: Iterable[Placed], bent: frozenset[str]
) -> Depth | None:
    """How deep a name holds where an effect of its set depends on a signal in another way than its law says.

    A lag is nearly a delay, and what it is beside that a spring and a damper draw: beside a delay that is none no other
    name is sure. And a curve over the speed that is another one, or needs kin to be drawn, is of no family.

    Args:
        depth: that all explanations share.
        effect: that is named.
        effects: the set.
        bent: names of those of it that are another curve, or as it seems no delay.
    """
    effects = list(effects)
    if effect.family != _TIMING and any(one.family == _TIMING and one.name in bent for one in effects):
        return None
    smooth = [one for one in effects if one.name == _SMOOTH]
    of_none = any(one.name in bent or any(is_kin(one, other) for other in effects) for one in smooth)
    is_near = any(one is effect or is_kin(one, effect) for one in smooth)
    return "block" if depth is not None and of_none and is_near else depth


def beside_its_block(depths: Mapping[Placed, Depth | None]) -> dict[str, Depth | None]:
    """Name -> how deep it holds beside others of its block of which no more than that is sure: no law is then.

    Args:
        depths: of each effect of a set.
    """
    block = AT["block"]
    vague = {block(effect) for effect, depth in depths.items() if depth == "block"}
    return {
        effect.name: "family" if depth == "law" and block(effect) in vague else depth
        for effect, depth in depths.items()
    }


def beside_another_size(depth: Depth | None, effect: Effect, shares: Mapping[Effect, float]) -> Depth | None:
    """How deep a name holds beside a much greater effect, or a much slighter one of its block.

    What a law that is not quite right leaves of its own effect, another one draws in part: of the slight one only the
    block is sure then, and of the great one no more than the family. Where bodies stick by chance even the right law
    leaves a hundredth, which any effect may draw.

    Args:
        depth: that all explanations share.
        effect: that is named.
        shares: of each effect of its set in the budget.
    """
    block, own = AT["block"], shares[effect]
    beside = [share for other, share in shares.items() if other != effect and block(other) == block(effect)]
    if any(own < MINUTE * share for share in shares.values()):
        return None
    if depth is not None and any(own < SLIGHT * share for share in beside):
        return "block"
    return "family" if depth == "law" and any(share < SLIGHT * own for share in beside) else depth


def beside_the_untried(depth: Depth | None, effect: Placed, others: Iterable[Placed]) -> Depth | None:
    """How deep a name holds beside effects that there was no time to try in its place.

    What was not tried is not ruled out. A law is then no surer than its family, and a family no surer than its block.

    Args:
        depth: that all explanations which were tried share.
        effect: that is named.
        others: those that were not tried in its place.
    """
    family, block = (AT[deep] for deep in ("family", "block"))
    near = [other for other in others if block(other) == block(effect)]
    if depth is None or not near:
        return depth
    kin = all(family(other) == family(effect) for other in near)
    return "family" if kin and depth != "block" else "block"
