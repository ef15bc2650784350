"""The tip under impedance control: exact motion, deflection by force over stiffness, and what its wrist reads."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from mmt_drake.errors import BadInput
from mmt_drake.estimation.probe import ProbeOptions, compensate, initial_readout, settings
from mmt_drake.systems.cartesian_impedance import Impedance
from mmt_drake.systems.compliant_tip import CompliantTipSystem, TipSettings, WristSensor
from mmt_drake.systems.flexible_box import SensorNoise

PERFECT = WristSensor((0.0, 0.0, 0.0), 0.0, SensorNoise())
TIP = TipSettings(mass=2.0, impedance=Impedance(stiffness=800.0, damping=40.0), probe_mass=0.2, sensor=PERFECT)
STILL = np.zeros(6)


def run(tip: TipSettings, commanded: np.ndarray, force: np.ndarray, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Motion and raw measurement after a while."""
    system = CompliantTipSystem(tip, np.zeros(3))
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    system.GetInputPort("commanded").FixValue(context, commanded)
    system.GetInputPort("force").FixValue(context, force)
    simulator.AdvanceTo(seconds)
    return tuple(system.GetOutputPort(name).Eval(context).copy() for name in ("motion", "raw_measurement"))  # type: ignore[return-value]


@pytest.mark.parametrize("seconds", [0.0505, 0.2005])
def test_a_step_is_answered_by_the_closed_form_of_a_damped_oscillator(seconds: float) -> None:
    motion, _ = run(TIP, np.array([0.01, 0.0, 0.0, 0.0, 0.0, 0.0]), np.zeros(3), seconds)
    t = seconds + 0.0005  # updates at 0, 1 ms ... each take the tip a period further
    decay, natural = 40.0 / (2 * 2.0), 800.0 / 2.0
    w = np.sqrt(natural - decay**2)
    expected = 0.01 * (1.0 - np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t)))
    assert motion[0] == pytest.approx(expected, rel=1e-9)
    assert motion[3] == pytest.approx(0.01 * np.exp(-decay * t) * natural / w * np.sin(w * t), rel=1e-9)


def test_a_held_force_deflects_it_by_force_over_stiffness() -> None:
    motion, read = run(TIP, STILL, np.array([0.0, -4.0, 8.0]), 3.0)
    np.testing.assert_allclose(motion, [0.0, -0.005, 0.01, 0.0, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(read[6:], [0.0, -4.0, 8.0 - 0.2 * 9.81], atol=1e-6)


def test_its_sensor_reads_offset_drift_weight_and_inertia_beside_the_force() -> None:
    sensor = WristSensor((0.4, -0.7, 1.1), 0.1, SensorNoise())
    _, read = run(replace(TIP, sensor=sensor), STILL, np.array([3.0, 0.0, 0.0]), 0.0)  # thrown from rest
    accelerated = run(replace(TIP, sensor=PERFECT), STILL, np.array([3.0, 0.0, 0.0]), 0.0)[1]
    np.testing.assert_allclose(read - accelerated, [0, 0, 0, 0, 0, 0, 0.4, -0.7, 1.1], atol=1e-12)
    motion, later = run(replace(TIP, sensor=sensor), STILL, np.zeros(3), 2.0)
    np.testing.assert_allclose(later[6:], [0.6, -0.5, 1.3 - 0.2 * 9.81], atol=1e-12)
    assert not motion.any()


def test_compensation_gives_the_force_back_while_it_moves() -> None:
    """The inverse of r = F + m (g - a) + o, on a swinging tip that meets a force from 1 s on."""
    tip = replace(TIP, sensor=WristSensor((0.4, -0.7, 1.1), 0.0, SensorNoise()))
    options = ProbeOptions(mass=0.2, weight=(0.0, 0.0, -0.2 * 9.81))
    system, fixed = CompliantTipSystem(tip, np.zeros(3)), settings(options)
    simulator, readout = Simulator(system), initial_readout(options)
    context = simulator.get_mutable_context()
    commanded, pushed = (system.GetInputPort(name) for name in ("commanded", "force"))
    wrong = []
    for tick in range(2000):
        t, w = tick * 1e-3, 2.0 * np.pi
        force = np.array([1.0, -2.0, 3.0]) * (1.0 - np.cos(w * max(0.0, t - 1.0)))
        commanded.FixValue(context, [0, 0.02 * np.sin(w * t), 0, 0, 0.02 * w * np.cos(w * t), 0])
        pushed.FixValue(context, force)
        simulator.AdvanceTo(t)
        compensate(system.GetOutputPort("raw_measurement").Eval(context), float(t > 0.99), 0.05, readout, fixed)
        late = t - options.delay
        expected = np.array([1.0, -2.0, 3.0]) * (1.0 - np.cos(w * max(0.0, late - 1.0)))
        wrong.append(np.abs(readout[6:9] - expected).max())
    assert max(wrong[1100:]) < 0.02  # N, of up to 6


def test_a_probe_heavier_than_all_and_a_tip_without_mass_are_refused() -> None:
    with pytest.raises(BadInput, match=r"tip: probe_mass: found 4\.0, expected 0 to 3 kg"):
        TipSettings(probe_mass=4.0)
    with pytest.raises(BadInput, match="tip: mass"):
        TipSettings(mass=0.0)


def test_a_command_or_force_that_is_not_finite_leaves_the_tip_where_it_is() -> None:
    for commanded, force in ((np.full(6, np.nan), np.zeros(3)), (np.ones(6), np.array([0.0, np.inf, 0.0]))):
        motion, _ = run(TIP, commanded, force, 0.01)
        np.testing.assert_array_equal(motion, np.zeros(6))
