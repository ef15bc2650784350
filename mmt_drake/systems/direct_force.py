"""The peer that needs no model: the telerobot's force, as it comes over the network."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from mmt_drake.errors import check_number
from mmt_drake.rendering.finite import share_held
from mmt_drake.systems.leaf import LeafSystem
from mmt_drake.systems.renderer_ports import declare_renderer_inputs, declare_rendering


class DirectForceRenderer(LeafSystem):
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
        (self._remote_force,) = declare_renderer_inputs(self, "remote_force")
        self.DeclareDiscreteState(4)  # the last finite force, and when that was
        sources = {self.time_ticket(), self.xd_ticket(), self._remote_force.ticket()}
        self.DeclareVectorOutputPort("force", 3, self._calc_force, sources)
        declare_rendering(self, (self._remote_force,))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)
        share_held(0.0)  # compiles before the clock starts

    def _calc_force(self, context: Context, force: BasicVector) -> None:
        remote = self._remote_force.Eval(context)
        if not np.isfinite(remote).all():
            last = context.get_discrete_state_vector().value()
            remote = share_held(context.get_time() - last[3]) * last[:3]
        force.SetFromVector(remote)

    def _update(self, context: Context, state: DiscreteValues) -> None:
        remote = self._remote_force.Eval(context)
        if np.isfinite(remote).all():
            state.get_mutable_value()[:] = (*remote, context.get_time())
