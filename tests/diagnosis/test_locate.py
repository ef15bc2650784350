"""Where a mismatch is: a residual of known time, band and signal is found there."""

from functools import cache

import numpy as np
import pytest
from diagnosis_samples import MODEL
from residual_samples import PLAIN, leaving, plain, strokes
from trial_samples import beside

from mmt_drake.diagnosis.decide.locate import locate
from mmt_drake.diagnosis.decide.mismatch import Mismatch
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.numeric.least_squares import Minimum


@cache
def measured() -> Problem:
    return strokes()


def located(shape, noise: float = 1e-4) -> Mismatch:
    """Where a shape is said to be that the model leaves."""
    problem = leaving(measured(), shape, noise=noise)
    return locate(problem, plain(problem), [], None)


def test_a_burst_is_found_when_and_in_the_band_where_it_is():
    def burst(track):
        return 0.3 * np.sin(2 * np.pi * 5.0 * track.time) * ((track.time >= 4.0) & (track.time < 5.0))

    found = located(burst)
    assert found.intervals_s == ((4.0, 5.0),)
    assert found.band_hz is not None
    # A sine that lasts a second has 90 % of its power within 1 / 1 s of its frequency, and Welch's window blurs that.
    assert 3.5 < found.band_hz[0] < 5.0 < found.band_hz[1] < 6.5


def test_two_bursts_are_two_intervals_and_neighbouring_windows_one():
    def bursts(track):
        t = track.time
        return 0.3 * np.sin(2 * np.pi * 7.0 * t) * (((t >= 3.0) & (t < 4.5)) | ((t >= 13.0) & (t < 13.5)))

    assert located(bursts).intervals_s == ((3.0, 4.5), (13.0, 13.5))


@pytest.mark.parametrize("signal", ["sliding_velocity", "deflection", "position", "load"])
def test_what_is_a_function_of_a_signal_depends_on_that_signal_most(signal):
    def function(track):
        values = track.replay(MODEL)[1][signal]
        within = (values - values.mean()) / values.std()
        return 0.2 * np.sin(2.0 * within)

    strongest = located(function).depends_on[0]
    assert strongest.signal == signal and strongest.score > 0.8


def test_a_drift_depends_on_time_and_is_where_it_is_largest():
    strongest = located(lambda track: 0.02 * np.exp(0.3 * track.time)).depends_on[0]
    assert strongest.signal == "time" and strongest.score > 0.95
    assert strongest.where.endswith("s") and float(strongest.where.split(" < ")[0]) > 14.0


def test_noise_depends_on_nothing_and_stands_out_nowhere():
    found = located(None, noise=0.01)
    assert all(dependence.score < 0.1 for dependence in found.depends_on)
    assert found.intervals_s == ()


def test_a_residual_that_is_zero_to_the_last_bit_is_nowhere():
    found = located(None, noise=0.0)
    assert found.intervals_s == () and found.band_hz is None and found.depends_on == ()


def test_of_named_effects_each_block_has_the_share_that_its_effects_take_off_alone():
    problem = leaving(measured())

    def costing(cost: float, *names: str) -> Fitted:
        return Fitted(
            beside(*names, nominal=MODEL), Minimum(PLAIN.base(), np.array([np.sqrt(cost)]), np.zeros((1, 4)), True, 1)
        )

    refit, both = costing(100.0), costing(10.0, "coulomb_friction", "nonlinear_stiffness")
    alone = [costing(40.0, "coulomb_friction"), costing(80.0, "nonlinear_stiffness")]
    blocks = locate(problem, refit, [both, *alone], both).blocks
    assert [(b.block, b.share) for b in blocks] == [("friction", pytest.approx(0.75)), ("contact", pytest.approx(0.25))]
