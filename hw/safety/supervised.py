"""Any hand, simulated or real, behind a supervisor; both look the same from outside."""

from collections.abc import Mapping
from types import MappingProxyType

from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import Demultiplexer

from mmt_drake.hw.safety.kernel import PORT_SIZES
from mmt_drake.hw.safety.limits import SafetyLimits
from mmt_drake.hw.safety.operator_switch import OperatorSwitch
from mmt_drake.hw.safety.supervisor import SafetySupervisor


def supervised(
    hand: LeafSystem,
    limits: SafetyLimits | None = None,
    *,
    period: float = 1e-3,
    watched: Mapping[str, float] = MappingProxyType({}),
    switch: LeafSystem | None = None,
) -> Diagram:
    """A hand that only ever gets what a supervisor lets through.

    Its ports are those of a hand, `force` and `motion`, with `status` (6, of `SafetySupervisor`), `applied_force` (3,
    what the hand gets [N]), `switches` (2, of the switch) and, if anything is watched, `ages`; of a hand with a trigger
    `grip` (1) [N], whose spring goes with the gain on the force. The parts are `hand`,
    `safety` and `switch`.

    Args:
        hand: an operator; a driver tells about itself on a port `device` (3), and one whose velocity is its own
            what the device reports on `reported_motion` (6), which the supervisor then sees.
        limits: of the supervisor.
        period: of its updates [s].
        watched: what must stay fresh, as `SafetySupervisor` takes it.
        switch: arms and stops; by default an `OperatorSwitch`, which also has a device's motors turned on again.

    Raises:
        BadInput: as `SafetySupervisor`.
    """
    driver = hand.HasOutputPort("device")
    builder = DiagramBuilder()
    builder.AddNamedSystem("hand", hand)
    safety = SafetySupervisor(limits, period=period, device=driver, watched=watched)
    builder.AddNamedSystem("safety", safety)
    if switch is None:
        switch = OperatorSwitch(on_arm=getattr(hand, "request_forces", None))
    builder.AddNamedSystem("switch", switch)

    builder.ExportInput(safety.GetInputPort("command"), "force")
    if watched:
        builder.ExportInput(safety.GetInputPort("ages"), "ages")
    motion = hand.GetOutputPort("motion")
    reported = hand.GetOutputPort("reported_motion") if hand.HasOutputPort("reported_motion") else motion
    builder.Connect(reported, safety.GetInputPort("motion"))
    if driver:
        builder.Connect(hand.GetOutputPort("device"), safety.GetInputPort("device"))
    builder.Connect(switch.GetOutputPort("switches"), safety.GetInputPort("switches"))
    # The readout, taken apart by a system of Drake's, costs one evaluation for everything (see `KernelSystem`).
    readout = safety.GetOutputPort("readout")
    sizes = PORT_SIZES.values()
    parts = builder.AddSystem(Demultiplexer([*sizes, readout.size() - sum(sizes)]))
    builder.Connect(readout, parts.get_input_port())
    builder.Connect(parts.get_output_port(0), hand.GetInputPort("force"))
    if hand.HasInputPort("gain"):  # of a spring that the hand makes itself
        status = builder.AddSystem(Demultiplexer([4, 1, 1]))
        builder.Connect(parts.get_output_port(1), status.get_input_port())
        builder.Connect(status.get_output_port(1), hand.GetInputPort("gain"))
    if hand.HasOutputPort("grip"):
        builder.ExportOutput(hand.GetOutputPort("grip"), "grip")
    builder.ExportOutput(motion, "motion")
    builder.ExportOutput(parts.get_output_port(1), "status")
    builder.ExportOutput(parts.get_output_port(0), "applied_force")
    builder.ExportOutput(switch.GetOutputPort("switches"), "switches")
    diagram = builder.Build()
    diagram.set_name(f"supervised {hand.get_name()}")
    return diagram
