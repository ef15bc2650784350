"""The supervisor, the switch and a supervised hand as systems of Drake's."""

import contract
import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, System
from pydrake.systems.primitives import ConstantVectorSource

from mmt_drake.errors import BadInput
from mmt_drake.hw.safety.limits import SafetyLimits
from mmt_drake.hw.safety.operator_switch import OperatorSwitch
from mmt_drake.hw.safety.reasons import Reason, describe
from mmt_drake.hw.safety.supervised import supervised
from mmt_drake.hw.safety.supervisor import SafetySupervisor
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.systems.scripted_operator import ScriptedOperator

WATCHED = {"peer": 0.1, "worker": 0.5}


def supervisor() -> SafetySupervisor:
    return SafetySupervisor(watched=WATCHED)


def test_direct_feedthrough_is_declared_exactly_where_an_output_follows_an_input_at_once() -> None:
    system = supervisor()
    for i in contract.inputs(system):
        for o in contract.outputs(system):
            assert system.HasDirectFeedthrough(
                system.GetInputPort(i).get_index(), system.GetOutputPort(o).get_index()
            ), f"{i} -> {o}"


def test_a_run_changes_nothing_in_self_and_two_runs_give_the_same_bits() -> None:
    system = supervisor()
    diagram = contract.wire(system)
    before = contract.frozen(vars(system))
    first = list(contract.run(diagram, system, diagram.CreateDefaultContext(), 0, 100))
    assert list(contract.run(diagram, system, diagram.CreateDefaultContext(), 0, 100)) == first
    assert contract.frozen(vars(system)) == before


def test_a_run_compiles_nothing() -> None:
    from mmt_drake.hw.safety import kernel

    kernel.supervise._reset_overloads()
    system = supervisor()
    diagram = contract.wire(system)
    compiled = list(kernel.supervise.signatures)
    list(contract.run(diagram, system, diagram.CreateDefaultContext(), 0, 5))
    assert compiled and list(kernel.supervise.signatures) == compiled


@pytest.mark.parametrize(
    "options, place",
    [
        ({"period": 0.0}, "period"),
        ({"period": 0.006}, "ramp"),
        ({"limits": SafetyLimits(gap=0.001)}, "gap"),
        ({"watched": {"peer": -1.0}}, r"watched\.peer"),
    ],
)
def test_settings_that_cannot_be_kept_are_refused(options: dict[str, object], place: str) -> None:
    with pytest.raises(BadInput, match=place):
        SafetySupervisor(**options)  # type: ignore[arg-type]


class Hand:
    """A supervised scripted hand that is told a constant force."""

    def __init__(self) -> None:
        self.switch = OperatorSwitch(clock=lambda: self.simulator.get_context().get_time())
        hand = ScriptedOperator(scripted_motion("strokes"))
        hand.DeclareVectorInputPort("force", 3)
        self.diagram: Diagram = supervised(hand, switch=self.switch)
        builder = DiagramBuilder()
        builder.AddSystem(self.diagram)
        source = builder.AddSystem(ConstantVectorSource([0.5, 0.0, 1.0]))
        builder.Connect(source.get_output_port(), self.diagram.GetInputPort("force"))
        self.simulator = Simulator(builder.Build())
        self.simulator.Initialize()

    def go(self, seconds: float) -> np.ndarray:
        """Go on; gives the force on the hand (3)."""
        self.simulator.AdvanceTo(self.simulator.get_context().get_time() + seconds)
        hand = self.part("hand")
        return hand.GetInputPort("force").Eval(self.context(hand))

    def part(self, name: str) -> System:
        return self.diagram.GetSubsystemByName(name)

    def context(self, system: System) -> Context:
        return system.GetMyContextFromRoot(self.simulator.get_context())

    def told(self) -> str:
        status = self.diagram.GetOutputPort("status").Eval(self.context(self.diagram))
        return describe(status)


def test_a_supervised_hand_shows_its_motion_and_what_becomes_of_its_force() -> None:
    hand = Hand()
    hand.go(0.1)
    ports = map(hand.diagram.get_output_port, range(hand.diagram.num_output_ports()))
    assert [port.get_name() for port in ports] == ["motion", "status", "applied_force", "switches"]
    expected = hand.part("hand").GetOutputPort("motion").Eval(hand.context(hand.part("hand")))
    shown = hand.diagram.GetOutputPort("motion").Eval(hand.context(hand.diagram))
    np.testing.assert_array_equal(shown, expected)


def test_a_supervised_hand_is_armed_stopped_and_armed_again_by_a_person() -> None:
    hand = Hand()
    assert not hand.go(0.1).any() and hand.told() == "stopped: not armed yet; ready to arm"
    hand.switch.arm()
    hand.go(0.4)
    assert hand.go(0.3).tolist() == [0.5, 0.0, 1.0] and hand.told() == "armed"
    hand.switch.stop()
    assert not hand.go(0.020).any() and hand.told() == "stopped: emergency stop"
    hand.switch.arm()
    assert not hand.go(0.5).any(), "an emergency stop cannot be armed away"
    hand.switch.release()
    assert not hand.go(0.5).any() and hand.told() == "stopped: emergency stop; ready to arm"
    hand.switch.arm()
    assert hand.go(0.5).any()


def test_an_emergency_stop_is_zero_in_20_ms_whenever_it_comes() -> None:
    for delay in np.random.default_rng(0).uniform(0.0, 0.01, 10):
        hand = Hand()
        hand.go(0.05)
        hand.switch.arm()
        assert hand.go(0.5 + delay).any()
        hand.switch.stop()
        assert not hand.go(0.020).any()
        status = hand.diagram.GetOutputPort("status").Eval(hand.context(hand.diagram))
        assert status[1] == Reason.EMERGENCY_STOP
