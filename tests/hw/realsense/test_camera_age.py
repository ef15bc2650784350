"""What a camera tells a supervisor."""

import contract
import pytest

from mmt_drake.hw.realsense.age import LOST, CameraAge
from mmt_drake.hw.realsense.faults import FAULTS, WELL


def test_its_ports_are_those_of_its_docstring() -> None:
    block, system = contract.documented_ports(CameraAge), CameraAge()
    assert (block["name"], block["input_ports"]) == ("CameraAge", contract.inputs(system))
    assert block["output_ports"] == contract.outputs(system)


@pytest.mark.parametrize("fault", FAULTS)
def test_it_is_as_old_as_its_frame_and_lost_with_a_fault(fault: float) -> None:
    system = CameraAge()
    context = system.CreateDefaultContext()
    system.GetInputPort("camera").FixValue(context, [fault, 0.04, 0.1])
    assert system.GetOutputPort("age").Eval(context) == (0.04 if fault == WELL else LOST)
