"""The estimator as a system is the estimator over a recording, one step later."""

import numpy as np
import pytest
from estimated_contact import wired
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, EventStatus

from mmt_drake.errors import BadInput
from mmt_drake.estimation.offline import estimate
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.systems.rls_estimator import RlsEstimator

OUTPUTS = {"theta": 10, "regrouped": 7, "stable": 1, "estimated_force": 3, "filtered_force": 3}


def slide(ticks: int, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Measurement (ticks, 9) of some motion and a force that a box might answer with, and contact with a gap."""
    t = np.arange(ticks) * step
    waves = [(0.02, 0.5, 0.0), (0.01, 1.7, 1.0), (0.003, 3.6, 2.0)]
    x = sum(a * np.sin(2 * np.pi * f * t + p) for a, f, p in waves)
    v = sum(a * 2 * np.pi * f * np.cos(2 * np.pi * f * t + p) for a, f, p in waves)
    F = -30.0 * v + np.random.default_rng(0).normal(0, 0.02, ticks)
    z, v_z = -0.005 + 0.002 * np.sin(5 * t), 0.01 * np.cos(5 * t)
    data = np.column_stack([x, -0.5 * x, z, v, -0.5 * v, v_z, F, -0.5 * F, -500 * z - 60 * v_z])
    return data, ((t < 0.4 * t[-1]) | (t > 0.6 * t[-1])).astype(float)


@pytest.mark.parametrize(
    "options", [RlsOptions(), RlsOptions(step=0.002, equations="without_d", position_origin="touch", settle=0.05)]
)
def test_every_output_is_the_offline_estimate_of_the_samples_before_bit_for_bit(options: RlsOptions) -> None:
    data, contact = slide(1200, options.step)
    diagram, estimator = wired(RlsEstimator(options), data, contact, options.step)
    simulator = Simulator(diagram)
    seen: dict[str, list[np.ndarray]] = {name: [] for name in OUTPUTS}

    def look(root: Context) -> EventStatus:
        own = estimator.GetMyContextFromRoot(root)
        for name, values in seen.items():
            values.append(estimator.GetOutputPort(name).Eval(own).copy())
        return EventStatus.DidNothing()

    simulator.set_monitor(look)
    simulator.AdvanceTo(1198.5 * options.step)
    trace = estimate(data, contact, options)
    for name, size in OUTPUTS.items():
        expected = getattr(trace, name).reshape(len(data), size)
        got = np.array(seen[name])
        assert got.shape[1] == size
        last = got[-1]  # after the update of tick 1198
        np.testing.assert_array_equal(last, expected[1198])
        np.testing.assert_array_equal(np.unique(got, axis=0), np.unique(np.vstack([got[:1], expected[:1199]]), axis=0))
    assert trace.stable[-1] == 1.0 or np.isfinite(trace.theta[-1, 6:]).all()


def test_before_the_first_sample_theta_is_unknown_and_unstable() -> None:
    data, contact = slide(10, 1e-3)
    diagram, estimator = wired(RlsEstimator(RlsOptions()), data, contact, 1e-3)
    own = estimator.GetMyContextFromRoot(diagram.CreateDefaultContext())
    assert np.isnan(estimator.GetOutputPort("theta").Eval(own)).all()
    for name in ("regrouped", "stable", "estimated_force", "filtered_force"):
        assert not estimator.GetOutputPort(name).Eval(own).any()


@pytest.mark.parametrize("port", ["measurement", "in_contact"])
def test_a_value_that_is_not_finite_stops_the_run_with_the_time_and_the_place(port: str) -> None:
    data, contact = slide(100, 1e-3)
    (data if port == "measurement" else contact)[40] = np.nan
    diagram, _ = wired(RlsEstimator(RlsOptions()), data, contact, 1e-3)
    with pytest.raises(BadInput, match=r"estimator .*t = 0\.04 s.*NaN"):
        Simulator(diagram).AdvanceTo(0.09)
