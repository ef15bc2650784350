"""Set-up 4 with the emulated device in hand: fingers on its trigger lift the sponge and feel its weight."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from test_station_on_omega import Session

from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.recording import load

SCALE = 2.0  # the sponge is beyond the device's own workspace
ABOVE, WITHIN, LIFTED = 0.0, -0.032, 0.02
"""Of the device: the tip then is at 0.02 m, 24 mm below the top of the sponge, and 80 mm above where it stood."""
WEIGHT = 0.15 * 9.81


@pytest.fixture
def session(omega: EmulatedOmega, tmp_path: Path) -> Iterator[Session]:
    omega.set(target_x=-0.13 / SCALE, target_z=ABOVE, soft_start=0.3, hand_stiffness=1500.0, hand_damping=40.0)
    changes = ["operator_device.device=0", f"operator_device.scale={SCALE}", "operator_device.force_scale=0.5"]
    session = Session(omega, load_scenario("setup4", changes), tmp_path / "out.mcap")
    with session.station:
        yield session


def go_to(session: Session, height: float, ticks: int) -> None:
    """The hand goes there as evenly as a hand does."""
    start = session.omega.get("target_z")
    for part in np.linspace(0.0, 1.0, ticks // 10):
        session.omega.set(target_z=start + (3.0 - 2.0 * part) * part**2 * (height - start))
        session.go(10)


@pytest.mark.parametrize("early", [False, True], ids=["closed within it", "closed before it came down"])
def test_fingers_on_the_trigger_lift_the_sponge_and_feel_what_it_weighs(
    session: Session, tmp_path: Path, early: bool
) -> None:
    session.omega.set(squeeze=5.0 * early)
    session.go(1000)
    go_to(session, WITHIN, 600)
    session.go(1400)
    session.omega.set(squeeze=5.0)
    session.go(1200)
    go_to(session, LIFTED, 1500)
    session.go(1500)
    session.station.__exit__(None, None, None)
    columns = load(tmp_path / "out.mcap").columns
    last = slice(-500, None)
    assert np.all(columns["grip_holds"][last] == 1.0) and np.all(columns["carries"][last] == 1.0)
    assert np.mean(columns["true_force_z"][last]) == pytest.approx(-WEIGHT, rel=0.05)
    assert np.mean(columns["rendered_force_z"][last]) == pytest.approx(-WEIGHT, rel=0.1)
    assert np.any(columns["scene_1_state"] == 9.0), "the scene says that it is carried"
    device = session.station.scenario.operator_device
    assert 0.5 * WEIGHT * 0.9 < session.omega.get("greatest_force") <= device.limits.force
