"""The foreign object as a system: the ports of the own one, and sensors that are late, filtered and coarse."""

import numpy as np
import pytest
from contract import inputs, outputs
from test_flexible_box_system import MODEL, STEP, hand, run

from mmt_drake.errors import BadInput
from mmt_drake.foreign import plant
from mmt_drake.foreign.numbers import Numbers
from mmt_drake.foreign.options import ForeignSensors
from mmt_drake.systems.flexible_box import FlexibleBox, SensorNoise
from mmt_drake.systems.foreign_box import ForeignBoxSystem

NUMBERS = Numbers(k1=30.0, Fs=0.3, Fd=0.2)
TIME, POSITION, VELOCITY = hand(1500)


def measured(noise=None, **sensors):
    """What the sensors read, and the true force (n, 3)."""
    out, _ = run(ForeignBoxSystem(NUMBERS, ForeignSensors(**sensors), noise=noise), TIME, POSITION, VELOCITY)
    return out["measurement"], out["force"]


def test_it_has_the_ports_of_the_own_one():
    own, foreign = FlexibleBox(MODEL), ForeignBoxSystem(NUMBERS)
    assert inputs(foreign) == inputs(own) and outputs(foreign) == outputs(own)
    for name in set(outputs(own)) - {"readout"}:
        assert foreign.GetOutputPort(name).size() == own.GetOutputPort(name).size()


def test_tick_by_tick_it_is_the_plant_run_in_one():
    out, _ = run(ForeignBoxSystem(NUMBERS), TIME, POSITION, VELOCITY)
    forces, body = np.empty(((len(TIME) - 1) * 100 + 1, 3)), np.empty((len(TIME), 4))
    plant.run(TIME, np.hstack([POSITION, VELOCITY]), NUMBERS.checked(plant.STEP_S), 100, forces, body)
    np.testing.assert_allclose(out["force"], forces[::100], atol=1e-9)
    np.testing.assert_allclose(out["body"], body, atol=1e-11)
    np.testing.assert_array_equal(out["measurement"], np.hstack([POSITION, VELOCITY, out["force"]]))
    np.testing.assert_array_equal(out["in_contact"][:, 0], POSITION[:, 2] < 0)


@pytest.mark.parametrize("delay", [0.0005, 0.002, 0.0173, 0.02])
def test_force_is_late_by_the_delay(delay):
    reading, force = measured(delay=delay)
    np.testing.assert_array_equal(reading[:, :6], np.hstack([POSITION, VELOCITY]))
    for i in range(3):
        expected = np.interp(TIME - delay, TIME, force[:, i])
        np.testing.assert_allclose(reading[:, 6 + i], expected, atol=1e-12)


def test_force_is_filtered_by_a_first_order_low_pass():
    reading, _ = measured(corner=40.0)
    forces, body = np.empty(((len(TIME) - 1) * 100 + 1, 3)), np.empty((len(TIME), 4))
    plant.run(TIME, np.hstack([POSITION, VELOCITY]), NUMBERS.checked(plant.STEP_S), 100, forces, body)
    step, tau = 1e-5, 1.0 / (2.0 * np.pi * 40.0)
    expected = np.empty_like(forces)  # implicit midpoint rule
    expected[0] = forces[0]
    for k in range(1, len(forces)):
        driven = 0.5 * step / tau * (forces[k] + forces[k - 1])
        expected[k] = ((1.0 - 0.5 * step / tau) * expected[k - 1] + driven) / (1.0 + 0.5 * step / tau)
    np.testing.assert_allclose(reading[:, 6:], expected[::100], atol=1e-5)


def test_readings_come_in_steps_after_noise():
    noise = SensorNoise(force=0.02, position=1e-5, seed=4)
    exact, _ = measured(noise)
    coarse, _ = measured(noise, force_resolution=0.005, position_resolution=4e-6)
    for columns, step in ((slice(0, 3), 4e-6), (slice(6, 9), 0.005)):
        ticks = coarse[:, columns] / step
        np.testing.assert_allclose(ticks, np.round(ticks), atol=1e-6)
        assert np.abs(coarse[:, columns] - exact[:, columns]).max() <= 0.5 * step * (1.0 + 1e-6)


@pytest.mark.parametrize("ticks", [1, 10])
def test_velocity_is_the_difference_of_measured_positions_over_its_window(ticks):
    reading, _ = measured(SensorNoise(position=1e-5, seed=4), velocity_window=ticks * STEP)
    expected = (reading[ticks:, :3] - reading[:-ticks, :3]) / (ticks * STEP)
    np.testing.assert_allclose(reading[ticks:, 3:6], expected, atol=1e-9)


def test_a_window_is_a_whole_number_of_ticks():
    with pytest.raises(BadInput, match=r"sensors.velocity_window: found 0.0015, expected a whole number of periods"):
        ForeignBoxSystem(NUMBERS, ForeignSensors(velocity_window=0.0015))
