"""The peer that needs no model: the telerobot's force, as it comes over the network."""

from __future__ import annotations

from pydrake.systems.framework import BasicVector, Context, LeafSystem

from mmt_drake.systems.renderer_ports import declare_renderer_inputs, declare_rendering


class DirectForce(LeafSystem):
    """Renders the force that the telerobot measured, when it arrives: direct force feedback.

    A round trip late, so that a hand that yields to it may become unstable. It is here to be compared with.

    .. pydrake_system::

        name: DirectForce
        input_ports:
        - motion
        - theta
        - stable
        - in_contact
        - point_cloud
        - remote_force
        - remote_energy
        - high_band
        - held_body
        output_ports:
        - force
        - status

    Ports (table frame):

    - `motion` (6), `theta` (10), `stable` (1), `in_contact` (1), `point_cloud` (abstract, `Cloud`),
      `remote_energy` (3), `high_band` (3), `held_body` (6): so that all renderers have the same ports; not used, may
      stay unconnected.
    - `remote_force` (3): force on the telerobot's probe as the network delivers it [N].
    - `force` (3): the same [N]; direct feedthrough.
    - `status` (1): 1 where it renders, as always: it waits for no parameters (`mmt_drake.rendering.status`).
    """

    def __init__(self) -> None:
        super().__init__()
        self._remote_force = declare_renderer_inputs(self).remote_force
        self.DeclareVectorOutputPort("force", 3, self._calc_force, {self._remote_force.ticket()})
        declare_rendering(self)

    def _calc_force(self, context: Context, force: BasicVector) -> None:
        force.SetFromVector(self._remote_force.Eval(context))
