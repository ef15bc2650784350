"""The peer that needs no model: the telerobot's force, as it comes over the network."""

import numpy as np

from mmt_drake.errors import check_number
from mmt_drake.numeric.arrays import Array
from mmt_drake.rendering.finite import share_held
from mmt_drake.systems.kernel_system import KernelSystem
from mmt_drake.systems.renderer_ports import declare_rendering


class DirectForceRenderer(KernelSystem):
    """Renders the force that the telerobot measured, when it arrives: direct force feedback.

    A round trip late, so that a hand that yields to it may become unstable. It is here to be compared with.

    .. pydrake_system::

        name: DirectForceRenderer
        input_ports:
        - remote_force
        output_ports:
        - force
        - status

    Ports (table frame):

    - `remote_force` (3): force on the telerobot's probe as the network delivers it [N].
    - `force` (3): the same [N]; direct feedthrough. Where that is not finite the last one that was, held and then let
      go (`mmt_drake.rendering.finite`).
    - `status` (1): 1 where it renders, since it waits for no parameters; 6 where `remote_force` is not finite
      (`mmt_drake.rendering.status`).

    Args:
        period: of the updates [s].

    Raises:
        BadInput: a period that is not positive.
    """

    def __init__(self, *, period: float = 1e-3) -> None:
        super().__init__()
        check_number("renderer", "period", period, least=0.0, open_interval=True)
        inputs = self.declare_inputs("remote_force")
        self.declare_memory(np.zeros(4), period)  # the last finite force, and when that was
        self.declare_computed("force", 3, self._rendered, ("remote_force",))
        declare_rendering(self, inputs)
        self.compile_kernels()
        share_held(0.0)

    def _rendered(self, t: float, last: Array, out: Array, remote: Array) -> None:
        out[:] = remote if np.isfinite(remote).all() else share_held(t - last[3]) * last[:3]

    def _step(self, t: float, last: Array, remote: Array) -> None:
        if np.isfinite(remote).all():
            last[:] = (*remote, t)
