"""What a run's summary says of a surface that is elsewhere than the cloud shows it."""

import numpy as np
import pytest

from mmt_drake.analysis.surface_raised import surface_raised
from mmt_drake.recording import Recording


def recorded(height: float, deviation: float) -> Recording:
    columns = {"surface_raised_height": [0.0, height], "surface_raised_deviation": [1e-3, deviation]}
    return Recording(np.array([0.0, 0.001]), {name: np.array(values) for name, values in columns.items()}, "a run")


@pytest.mark.parametrize(
    ("height", "deviation", "says"),
    [
        (1.2e-3, 2e-5, "it is 1.20 +- 0.02 mm above where the cloud shows it, and it was corrected"),
        (-3e-4, 2e-5, "it is 0.30 +- 0.02 mm below where"),
        (5e-5, 2e-5, "it is 0.05 +- 0.02 mm above where"),  # it was moved, however little
        (0.0, 2.2e-4, "where the cloud shows it, as far as touches tell (+- 0.22 mm)"),
        (0.0, 1e-3, "no touch told its height"),
        (0.0, 3.15e-3, "no touch told its height"),  # they have told less than was believed before
    ],
)
def test_the_last_sample_says_where_touches_found_the_surface(height: float, deviation: float, says: str) -> None:
    found = surface_raised(recorded(height, deviation))
    assert found is not None and says in found.line()
    assert found.to_json() == {"height_m": height, "deviation_m": deviation}


def test_without_its_columns_nothing_is_said() -> None:
    assert surface_raised(Recording(np.array([0.0, 0.001]), {}, "a run")) is None
