"""What the summary of a run says of a carried object."""

import numpy as np
import pytest

from mmt_drake.analysis.carried import carried_object, nothing_lifted
from mmt_drake.model.grasped_box import HOLDS, LOST
from mmt_drake.recording import Recording

STEP, LATE = 1e-3, 0.1


def carried(centre: float = 0.05) -> Recording:
    """Off the table from 1 to 3 s beside the plant, a tenth of a second earlier beside the operator; 2 % too heavy."""
    time = np.arange(0.0, 4.0, STEP)
    flies, copy = (time >= 1.0) & (time < 3.0), (time >= 1.0 - LATE) & (time < 3.0 - LATE)
    still = np.zeros(len(time))
    columns = {f"position_{axis}": still for axis in "xyz"} | {"body_height": 0.05 * flies, "carries": 1.0 * copy}
    swing = 0.3 * np.sin(8.0 * time)
    columns |= {"true_force_x": swing * flies, "true_force_y": still, "true_force_z": -3.0 * flies}
    felt = 0.3 * np.sin(8.0 * (time + LATE)) * 0.9
    columns |= {"rendered_force_x": felt * copy, "rendered_force_y": still, "rendered_force_z": -3.06 * copy}
    told = 1.0 * (time > 1.5)
    columns |= {"carried_m": 0.3 * told, "carried_centre": centre * told, "carried_swing": 0.05 * told}
    deviations = {"m": 0.001, "centre": 0.002, "swing": 0.01}
    return Recording(time, columns | {f"carried_deviation_{k}": v * told for k, v in deviations.items()}, "a run")


def test_errors_are_those_of_the_time_in_the_air_a_delay_apart() -> None:
    found = carried_object(carried(), LATE)
    assert found is not None
    assert found.seconds == pytest.approx(2.0, abs=2e-3)
    assert found.across == pytest.approx(0.1, rel=1e-3)
    assert found.force == pytest.approx(np.sqrt((0.06**2 + 0.03**2 / 2) / (3.0**2 + 0.3**2 / 2)), rel=1e-3)
    assert (found.m, found.centre, found.centre_deviation) == (0.3, 0.05, 0.002)
    assert "300 +- 1 g, centre 50.0 +- 2.0 mm" in found.line() and "10 % along x and y" in found.line()
    assert found.to_json()["mass_kg"] == 0.3


def test_a_centre_that_was_not_told_is_none_and_nothing_carried_is_no_figure() -> None:
    untold = carried_object(carried(centre=0.0), LATE)
    assert untold is not None and untold.centre is None and "centre not told" in untold.line()
    recording = carried()
    recording.columns["carries"][:] = 0.0
    assert carried_object(recording, LATE) is None
    assert carried_object(Recording(np.array([0.0, 0.001]), {}, "a run"), LATE) is None


def test_what_slips_out_of_the_grip_is_told_whether_or_not_it_was_lifted() -> None:
    lifted = carried()
    lost = np.where(np.arange(len(lifted.time)) > len(lifted.time) // 2, LOST, HOLDS)
    found = carried_object(Recording(lifted.time, {**lifted.columns, "grip_holds": lost}, "a run"), LATE)
    assert found is not None and found.slipped == 1 and found.line().endswith("SLIPPED out of the grip once")
    columns = {"grip": np.full(4, 10.0), "body_height": np.zeros(4), "grip_holds": np.array([HOLDS, LOST, HOLDS, LOST])}
    stays = nothing_lifted(Recording(1e-3 * np.arange(4), columns, "a run"))
    assert stays is not None and stays.line().endswith("SLIPPED out of the grip 2 times")


def test_a_grip_that_closed_and_lifted_nothing_is_told() -> None:
    recording = carried()
    for name in ("carries", "body_height"):
        recording.columns[name][:] = 0.0
    grip = 10.0 * ((recording.time < 0.5) | ((recording.time > 1.0) & (recording.time < 2.0)))
    found = nothing_lifted(Recording(recording.time, {**recording.columns, "grip": grip}, "a run"))
    assert found is not None and found.closed == 2 and "closed 2 times and lifted nothing" in found.line()
    assert found.to_json() == {"closed": 2, "slipped": 0}
    assert nothing_lifted(Recording(recording.time, {**carried().columns, "grip": grip}, "a run")) is None
    assert nothing_lifted(Recording(recording.time, {**recording.columns, "grip": 0.0 * grip}, "a run")) is None


def test_where_nothing_acts_along_x_and_y_no_share_of_it_is_told() -> None:
    recording = carried()
    recording.columns["true_force_x"][:] = 0.0
    found = carried_object(recording, LATE)
    assert found is not None and found.across is None and "along x and y" not in found.line()
    assert found.to_json()["force_error_across"] is None
