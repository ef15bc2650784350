"""What a tick of safety and driver costs, and how long a force takes from a reading to the motors.

The bounds are far above what is measured (`python -m mmt_drake.hw.omega.trial`), for loaded machines: a cold kernel or
a call that blocks is above them.
"""

from __future__ import annotations

import numpy as np

from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.omega.trial.cost import answer_times, tick_costs

TICK = 1e-3


def test_a_tick_of_the_whole_path_leaves_most_of_a_millisecond(omega: EmulatedOmega) -> None:
    costs = tick_costs(omega, batches=10)
    assert costs["device"] < costs["grouped"] < 0.25 * TICK
    assert costs["modular"] < 0.5 * TICK


def test_the_force_that_answers_a_reading_is_sent_within_the_same_tick(omega: EmulatedOmega) -> None:
    answered = answer_times(omega, ticks=500)
    assert (answered > 0.0).all() and omega.get("sets") >= 500
    assert np.quantile(answered, 0.9) < TICK
