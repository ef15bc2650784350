"""The age of what is known of the surface, as a depth camera tells it to a supervisor."""

from pydrake.systems.framework import BasicVector, Context

from mmt_drake.hw.realsense.faults import WELL
from mmt_drake.systems.leaf import LeafSystem

LOST = 1e9
"""An age that nobody waits for [s]; finite, for a link refuses what is not."""


class CameraAge(LeafSystem):
    """How old a camera's latest frame is; `LOST` while the camera reports a fault.

    Without a surface there is no contact, and so no force. With the surface the force would come back by itself, to a
    hand that is by then deep in the object: for a supervisor to watch, which lets nothing through until a person arms.

    .. pydrake_system::

        name: CameraAge
        input_ports:
        - camera
        output_ports:
        - age

    - `camera` (3): as on the port of `DepthCameraSystem`.
    - `age` (1): [s]; direct feedthrough.
    """

    def __init__(self) -> None:
        super().__init__()
        self.set_name("CameraAge")
        self._camera = self.DeclareVectorInputPort("camera", 3)
        self.DeclareVectorOutputPort("age", 1, self._calc, {self._camera.ticket()})

    def _calc(self, context: Context, output: BasicVector) -> None:
        fault, age, _ = self._camera.Eval(context)
        output.SetAtIndex(0, age if fault == WELL else LOST)
