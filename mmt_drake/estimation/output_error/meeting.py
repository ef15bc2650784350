"""What is known of an object when the probe leaves it, and when it comes to one for the first time."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from mmt_drake.estimation.first_guess import guess
from mmt_drake.estimation.output_error.adequacy import ModelStatus
from mmt_drake.estimation.output_error.beginning import Beginning
from mmt_drake.estimation.output_error.knowledge import Knowledge
from mmt_drake.estimation.output_error.unknowns import FRICTION, LATENESS, LOG, OBJECT, UNKNOWNS, Information, unknowns
from mmt_drake.estimation.output_error.window import Window
from mmt_drake.model.held_body import NO_REPORT
from mmt_drake.model.parameters import THETA
from mmt_drake.model.scene_layout import LOOKS

_LEAST_FRICTION = 0.1  # [N]: deviation of a friction that is guessed, at least
_NORMAL = [THETA.index("normal_k"), THETA.index("normal_b")]


def put_away(known: Knowledge) -> Knowledge:
    """What is known of an object that is left; its samples must have been let go."""
    return replace(
        known,
        window=Window.empty(),
        start=Beginning.at_rest(),
        held=NO_REPORT,
        rival=None,
        fresh=0,
        interrupted=False,
        adequacy=replace(known.adequacy, doubted=0.0),
        others={},
    )


def first_guess(
    nothing: Knowledge, prior: Information, thing: int, looks: Sequence[float], others: Mapping[int, Knowledge]
) -> Knowledge:
    """Knowledge of an object that nobody has touched: a guess by its looks, with wide deviations.

    Args:
        nothing: where nothing is known but the prior.
        prior: that.
        thing: identity of the object.
        looks: of it, as `mmt_drake.estimation.first_guess.guess` takes them.
        others: what is known of others; those whose numbers the motion has told are examples.
    """
    alike = [each for each in others.values() if each.looks and each.adequacy.status != ModelStatus.UNEXCITED]
    seen = np.array([each.looks for each in alike]).reshape(-1, LOOKS)
    thetas = np.array([each.theta for each in alike]).reshape(-1, len(THETA))
    theta = np.empty(len(THETA))
    deviation = guess(np.array(looks, dtype=np.float64), seen, thetas, len(alike), theta)
    x = np.concatenate([unknowns(theta)[OBJECT], nothing.x[LATENESS]])
    spread = np.full(UNKNOWNS, np.inf)
    spread[OBJECT] = np.where(LOG[OBJECT], deviation, np.inf)
    spread[FRICTION] = max(deviation * theta[FRICTION], _LEAST_FRICTION)
    memory = Information.about(x, spread)
    covariance = prior.plus(memory).covariance()
    guessed = replace(nothing, x=x, normal=theta[_NORMAL], memory=memory, covariance=covariance)
    return replace(guessed, thing=thing, looks=tuple(looks), others=others)
