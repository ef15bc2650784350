"""How the force was zeroed is told from the recording: for how long, and why it was not."""

from dataclasses import replace

import numpy as np
import pytest

from mmt_drake.analysis.zeroing import zeroing
from mmt_drake.estimation.probe import Zero
from mmt_drake.recording import Recording


def recording(*states: Zero) -> Recording:
    """100 ticks of 2 ms in each state, in contact where it is held."""
    codes = np.repeat(np.array(states, float), 100)
    columns = {"probe_zero": codes, "detected_contact": (codes == Zero.HELD).astype(float)}
    return Recording(np.arange(len(codes)) * 2e-3, columns)


def test_time_in_each_state_is_told_with_the_reason() -> None:
    told = zeroing(recording(Zero.RENEWED, Zero.HELD, Zero.RENEWED, Zero.DEPARTED))
    assert told is not None
    assert told.to_json() == pytest.approx(
        {"renewed_s": 0.4, "lost_s": 0.0, "restless_s": 0.0, "departed_s": 0.2, "contact_before_s": 0.0}
    )
    assert "renewed for 0.40 s; held for 0.20 s (free, but far from the last zero" in told.line()
    assert "steady" not in told.line() and "contact before" not in told.line()


def test_a_zero_that_was_never_taken_is_told() -> None:
    told = zeroing(recording(Zero.HELD, Zero.LOST))
    assert told is not None and "NEVER taken; the sensor's offset is in the forces of 0.20 s" in told.line()
    late = zeroing(recording(Zero.HELD, Zero.RENEWED, Zero.HELD))
    assert late is not None and late.before == pytest.approx(0.2) and "NEVER" not in late.line()


def test_without_a_probe_there_is_nothing_to_tell() -> None:
    assert zeroing(replace(recording(Zero.HELD), columns={})) is None
