"""Energy against springs, dampers and a source."""

import numpy as np
import pytest

from mmt_drake.analysis.passivity import PortEnergy, passivity
from mmt_drake.errors import BadInput
from mmt_drake.recording import AXES, Recording

TIME = np.arange(20_001) * 1e-3
OMEGA = 2 * np.pi * 0.5  # ten whole periods
AMPLITUDE = 0.02


def moving() -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) position and velocity of a sine along (1, 2, 2)/3."""
    direction = np.array([1.0, 2.0, 2.0]) / 3.0
    position = AMPLITUDE * np.sin(OMEGA * TIME)[:, None] * direction
    velocity = AMPLITUDE * OMEGA * np.cos(OMEGA * TIME)[:, None] * direction
    return position, velocity


def port_energy(time: np.ndarray, force: np.ndarray, position: np.ndarray) -> PortEnergy:
    """Of both ends of a run in which hand and probe have this force and position, (n, 3) each."""
    names = {"rendered_force": force, "master_position": position, "force": force, "position": position}
    columns = {f"{name}_{axis}": values[:, i] for name, values in names.items() for i, axis in enumerate(AXES)}
    return passivity(Recording(time, columns)).operator


def test_a_spring_gives_back_all_it_took():
    position, _ = moving()
    stiffness = 500.0
    port = port_energy(TIME, -stiffness * position, position)
    assert np.max(port.absorbed) == pytest.approx(0.5 * stiffness * AMPLITUDE**2, rel=1e-6)
    assert port.put_in == pytest.approx(20 * 0.5 * stiffness * AMPLITUDE**2, rel=1e-6)
    assert port.returned == pytest.approx(port.put_in, rel=1e-12)
    assert port.passive and port.violation < 1e-12 * port.put_in


def test_a_spring_gives_back_all_it_took_however_coarsely_it_is_sampled():
    position, _ = moving()
    coarse = position[::370]
    port = port_energy(TIME[::370], -500.0 * coarse, coarse)
    assert port.absorbed == pytest.approx(250.0 * np.sum(coarse**2, axis=1), rel=1e-9, abs=1e-15)


def test_a_damper_burns_b_times_the_mean_square_of_velocity():
    position, velocity = moving()
    damping = 60.0
    port = port_energy(TIME, -damping * velocity, position)
    assert port.net == pytest.approx(damping * (AMPLITUDE * OMEGA) ** 2 / 2 * TIME[-1], rel=1e-5)
    assert port.minimum == 0.0 and port.passive
    assert port.returned < 1e-4 * port.put_in


def test_a_negative_damper_gives_what_nobody_put_in():
    position, velocity = moving()
    port = port_energy(TIME, 60.0 * velocity, position)
    expected = 60.0 * (AMPLITUDE * OMEGA) ** 2 / 2 * TIME[-1]
    assert not port.passive
    assert port.violation == pytest.approx(expected, rel=1e-5)
    assert port.minimum_at == pytest.approx(TIME[-1], abs=1e-3)


def test_what_one_contact_gives_too_much_is_not_hidden_by_what_another_burnt():
    position, velocity = moving()
    # ten seconds of burning, a pause, four of giving: two periods of 2 s
    gain = np.where(TIME < 10.0, -60.0, np.where((TIME >= 14.0) & (TIME < 18.0), 20.0, 0.0))
    port = port_energy(TIME, gain[:, None] * velocity, position)
    power = (AMPLITUDE * OMEGA) ** 2 / 2
    assert port.passive and port.minimum == 0.0
    assert port.worst_contact == pytest.approx(-20.0 * power * 4.0, rel=1e-2)


def test_both_ports_are_read_from_their_own_columns(recording_of):
    position, velocity = moving()
    run = recording_of(
        TIME,
        rendered_force=-60.0 * velocity,
        master_position=position,
        force=-30.0 * velocity,
        position=2.0 * position,
        in_contact=np.ones_like(TIME),
    )
    found = passivity(run)
    burnt = 60.0 * (AMPLITUDE * OMEGA) ** 2 / 2 * TIME[-1]
    assert found.operator.net == pytest.approx(burnt, rel=1e-5)
    assert found.telerobot.net == pytest.approx(burnt, rel=1e-5)
    assert np.max(np.abs(found.between)) < 1e-5 * burnt
    assert found.to_json()["operator"]["violation_j"] == 0.0
    assert "passive" in found.lines()[0] and "NOT" not in found.lines()[0]


def test_a_violation_is_said_with_amount_and_time(stroke_run):
    found = passivity(stroke_run)
    assert not found.operator.passive
    assert f"{found.operator.violation:.3g} J more than was put in" in found.lines()[0]


def test_a_recording_without_the_hand_is_refused(recording_of):
    position, velocity = moving()
    run = recording_of(TIME, rendered_force=velocity, force=velocity, position=position)
    with pytest.raises(BadInput, match="'master_position_x'"):
        passivity(run)
