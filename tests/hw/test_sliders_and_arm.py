"""A hand on sliders moves an arm on another machine with the switch of that name alone, and then slowly."""

import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context

from mmt_drake.diagrams.proof.faults.franka import SETTINGS
from mmt_drake.diagrams.proof.faults.wires import End, FaultyWire
from mmt_drake.diagrams.stations.devices import RemoteArm
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.site import Devices
from mmt_drake.diagrams.stations.two_sides import Side, build_side
from mmt_drake.hw.franka.emulator import EmulatedFranka
from mmt_drake.hw.link.link import Link
from mmt_drake.hw.link.options import OPERATOR, TELEROBOT, LinkSignal, Role
from mmt_drake.hw.safety.rate_limiter import GREATEST_SPEED, MotionRateLimiter
from mmt_drake.recording import load
from mmt_drake.viewer.viewer import Viewer

pytest.importorskip("cryptography", reason="the extra `link` is not installed")

STEP = 2e-3
SLIDER = "hand x [m]"


class Bench:
    """Both sides, stepped by the wall's clock."""

    def __init__(self, stack: ExitStack, franka: EmulatedFranka, viewer: Viewer, record: Path, allowed: bool) -> None:
        there, back = FaultyWire(time.monotonic_ns), FaultyWire(time.monotonic_ns)
        scenario = load_scenario("setup3", [f"step={STEP}", "clouds=none", "operator=!Interactive {}"])
        settings = {name: getattr(SETTINGS, name) for name in ("realtime", "table", "low", "high", "gap", "hold_after")}
        self.arm = RemoteArm(replace(scenario.telerobot_device, address=franka.address, **settings), STEP)
        stack.callback(self.arm.close)

        def open_link(role: Role, signals: Mapping[Role, LinkSignal], agreed: str) -> Link:
            end = End(there, back) if role == OPERATOR else End(back, there)
            return Link(role, signals, bytes(range(1, 33)), end, scenario=agreed)

        self.sides: dict[Role, Side] = {
            OPERATOR: build_side(scenario, OPERATOR, open_link, meshcat=viewer),
            TELEROBOT: build_side(
                scenario,
                TELEROBOT,
                open_link,
                meshcat=viewer,
                devices=Devices(arm=self.arm),
                sliders_move_hardware=allowed,
                record=record,
            ),
        }
        for side in self.sides.values():
            stack.enter_context(side)
        self.simulators = {role: Simulator(side.diagram) for role, side in self.sides.items()}
        self.began, self.tick = time.monotonic(), 0

    def go(self, seconds: float) -> Iterator[Context]:
        """Each tick's context of the telerobot's side."""
        for _ in range(round(seconds / STEP)):
            self.tick += 1
            for simulator in self.simulators.values():
                simulator.AdvanceTo(self.tick * STEP)
            time.sleep(max(0.0, self.began + self.tick * STEP - time.monotonic()))
            yield self.simulators[TELEROBOT].get_context()


@pytest.mark.parametrize("allowed", [False, True])
def test_sliders_move_an_arm_with_their_switch_alone_and_slowly(
    franka: EmulatedFranka, allowed: bool, tmp_path: Path
) -> None:
    record = tmp_path / "a.mcap"
    with ExitStack() as stack:
        viewer = stack.enter_context(Viewer(""))
        bench = Bench(stack, franka, viewer, record, allowed)
        told = bench.sides[TELEROBOT].diagram.GetSubsystemByName("link").GetOutputPort("received")
        list(bench.go(0.5))
        assert bench.sides[TELEROBOT].link.alive == allowed
        viewer.values[SLIDER] = 0.1
        if not allowed:
            first = told.Eval(told.get_system().GetMyContextFromRoot(next(bench.go(STEP)))).copy()
            last = [told.Eval(told.get_system().GetMyContextFromRoot(context)).copy() for context in bench.go(0.5)][-1]
            np.testing.assert_array_equal(last, first)
            return
        limiter = bench.sides[TELEROBOT].diagram.GetSubsystemByName("limiter")
        assert isinstance(limiter, MotionRateLimiter)
        motion = limiter.GetOutputPort("motion")
        positions = [motion.Eval(limiter.GetMyContextFromRoot(context))[0] for context in bench.go(1.0)]
        speeds = np.diff(positions) / STEP
        assert 0.9 * GREATEST_SPEED < speeds.max() <= GREATEST_SPEED * (1 + 1e-9)
    assert load(record, forces=False).constants == {"loosened.sliders_move_hardware": 1.0}


def test_a_limiter_follows_no_jump_faster_than_its_speed_and_arrives() -> None:
    limiter = MotionRateLimiter(np.zeros(3))
    simulator = Simulator(limiter)
    port = limiter.GetInputPort("commanded")
    port.FixValue(simulator.get_mutable_context(), [0.1, -0.1, 0.0, 9.0, 9.0, 9.0])
    seen = []
    for tick in range(4000):
        simulator.AdvanceTo(tick * 1e-3)
        seen.append(limiter.GetOutputPort("motion").Eval(simulator.get_context()).copy())
    positions = np.array(seen)
    assert np.abs(np.diff(positions[:, :3], axis=0)).max() <= GREATEST_SPEED * 1e-3 * (1 + 1e-9)
    assert np.abs(positions[:, 3:]).max() <= GREATEST_SPEED
    np.testing.assert_allclose(positions[-1], [0.1, -0.1, 0, 0, 0, 0], atol=1e-4)
