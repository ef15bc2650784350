"""What a run says of clouds that did not come."""

import numpy as np
import pytest

from mmt_drake.analysis.clouds_missed import clouds_missed
from mmt_drake.recording import Recording

TIME = np.arange(0.0, 2.0, 1e-3)


def run(fault: np.ndarray) -> Recording:
    columns = {"camera_fault": 1.0 * fault, "camera_age": np.where(fault > 1.0, 0.4, 0.05)}
    return Recording(TIME, columns, "a run")


def test_time_without_a_cloud_is_told_and_the_wait_for_the_first_is_none() -> None:
    fault = np.where(TIME < 0.1, 1.0, np.where((TIME > 1.0) & (TIME < 1.5), 2.0, 0.0))
    found = clouds_missed(run(fault))
    assert found is not None and found.seconds == pytest.approx(0.499, abs=2e-3) and found.oldest == 0.4
    assert found.line() == "camera: NO CLOUD that counts for 0.50 s in all; the oldest was 0.40 s old"
    assert found.to_json() == {"without_cloud_s": found.seconds, "oldest_s": 0.4}


def test_a_camera_that_never_saw_anything_is_told_for_the_whole_run() -> None:
    found = clouds_missed(run(np.ones(len(TIME))))
    assert found is not None and found.seconds == pytest.approx(2.0)


def test_nothing_is_told_where_clouds_came_or_there_is_no_camera() -> None:
    assert clouds_missed(run(np.where(TIME < 0.1, 1.0, 0.0))) is None
    assert clouds_missed(Recording(TIME, {"position_x": TIME}, "a run")) is None
