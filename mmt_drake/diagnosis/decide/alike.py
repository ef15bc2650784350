"""Numbers of a delivered model that this recording does not tell from another law."""

from typing import Final

from mmt_drake.analysis.wording import significant
from mmt_drake.diagnosis.checks.finding import Finding
from mmt_drake.diagnosis.fit.comparison import RULED_OUT
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import attempt

_PLAY: Final = LIBRARY["gear_play"]
_FRICTION: Final = "coulomb_friction"
_STEPS = 6
_PART = 0.5  # of the friction that is tried as play, and of the play tried that has to stay


def play_or_friction(problem: Problem, delivered: Fitted) -> list[Finding]:
    """That a transmission's dry friction may be play in part: half of it is tried as play, and explains as well.

    Where the output does not coast across the gap, play and friction draw loops of one shape, of width gap and 2 Fc/k.
    Nothing where the recording tells them apart, and where there is no friction or no transmission.

    Args:
        problem: what was fitted.
        delivered: the fit whose numbers are told.
    """
    hypothesis, k = delivered.hypothesis, delivered.model.value("k2")
    if not hypothesis.admits(_PLAY):
        return []
    structure, effects = dict(delivered.structure_values), {n: dict(v) for n, v in delivered.effect_values.items()}
    holder = effects[_FRICTION] if _FRICTION in hypothesis.key else structure
    level = holder.get("Fc", 0.0)
    if level <= 0.0 or k <= 0.0:
        return []
    holder["Fc"] = (1.0 - _PART) * level
    begun = 2.0 * _PART * level / k
    wider = hypothesis.adding(_PLAY)
    start = wider.vector(structure, {**effects, _PLAY.name: {"gap": begun}}, delivered.skew)
    both = attempt(problem.fit, wider, start, steps=_STEPS)
    if both is None or both.cost > delivered.cost + RULED_OUT:
        return []
    gap = both.effect_values[_PLAY.name]["gap"]
    if gap < _PART * begun:
        return []
    unit = hypothesis.nominal.unit
    text = (
        f"So slow a motion does not tell play from dry friction: a play of {significant(gap, 2)} {unit('m')} with as "
        f"much less friction explains it as well. So Fc = {significant(level, 3)} {unit('N')} may be either."
    )
    return [Finding("play_or_friction", "warn", text, {"gap": gap, "Fc": level})]
