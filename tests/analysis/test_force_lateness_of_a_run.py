"""What a run's summary says of a force that is measured late."""

import numpy as np
import pytest

from mmt_drake.analysis.force_lateness import force_lateness
from mmt_drake.model.parameters import FORCE_LATENESS
from mmt_drake.recording import Recording


def recorded(*last: float) -> Recording:
    columns = {f"force_lateness_{n}": np.array([0.0, value]) for n, value in zip(FORCE_LATENESS, last, strict=True)}
    return Recording(np.array([0.0, 0.001]), columns, "a run")


@pytest.mark.parametrize(
    ("last", "says"),
    [
        ((3e-3, 1e-3, 4e-3, 2e-4, 3e-4, 1e-5), "4.00 +- 0.01 ms later than the motion, 1.0 ms of it as of a low pass"),
        ((0.05, 0.0, 0.05, 1e-5, 1e-5, 1e-5), "50 ms later than the motion or more"),
        ((0.0, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5), "not noticeably later than the motion (0.01 +- 0.01 ms)"),
    ],
)
def test_the_last_sample_of_a_run_says_how_late_the_force_was(last: tuple[float, ...], says: str) -> None:
    found = force_lateness(recorded(*last))
    assert found is not None and says in found.line()
    assert found.to_json()["sum_s"] == last[2] and found.to_json()["lag_deviation_s"] == last[4]


def test_a_recording_of_another_estimator_says_nothing_of_it() -> None:
    assert force_lateness(Recording(np.array([0.0, 0.001]), {}, "a run")) is None
