"""Numbers of a report have their unit, and no digits that mean nothing."""

import pytest

from mmt_drake.diagnosis.tell.result import Fit, HeldoutNrmse
from mmt_drake.diagnosis.tell.wording import bounded, rms_words, share_words

NONE = HeldoutNrmse(None, None, None)


@pytest.mark.parametrize(
    ("nrmse", "unit", "told"),
    [
        (0.25, "N", "0.5 N"),
        (0.0172, "N", "0.0344 N"),
        (0.00247, "m", "4.94 mm"),
        (1.005e-5, "m", "20.1 µm"),
        (1e-12, "rad", "0.002 nrad"),
        (0.001, "N m", "2 mN m"),
        (0.001, "deg", "0.002 deg"),
        (0.0, "N", "0 N"),
    ],
)
def test_an_error_is_told_in_its_unit_to_three_digits(nrmse: float, unit: str, told: str) -> None:
    assert rms_words(Fit((), (), None, NONE, spread=2.0, unit=unit), nrmse) == told


def test_an_error_whose_spread_nobody_knows_is_told_as_a_part_of_it() -> None:
    assert rms_words(Fit((), (), None, NONE), 0.12345) == "0.123 of the measured spread"


@pytest.mark.parametrize(
    ("value", "interval", "told"),
    [
        (612.34, (608.0, 616.5), ("612", "608 to 616")),
        (0.39996, (0.3983, 0.4016), ("0.4", "0.398 to 0.402")),
        (500.04, (500.01, 500.07), ("500.04", "500.01 to 500.07")),
        (1.23456, None, ("1.23", None)),
    ],
)
def test_a_number_has_as_many_digits_as_its_interval_knows(value, interval, told) -> None:
    assert bounded(value, interval) == told


def test_shares_are_told_in_whole_percent() -> None:
    assert [share_words(share) for share in (0.0, 0.0004, 0.0136, 0.5549, 1.0)] == [
        "0 %",
        "under 1 %",
        "1 %",
        "55 %",
        "100 %",
    ]
