"""Contact detection beside the operator, on the cloud that the network has brought."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context

from mmt_drake.cloud.proxy import NO_CLOUD, POSITION, STATE, ProxySettings, new_memory, pressed
from mmt_drake.systems.leaf import LeafSystem
from mmt_drake.systems.proxy_steps import declare_proxy


class SurfaceContactDetector(LeafSystem):
    """Says whether the hand is below the surface that a point cloud shows, in the tick in which it gets there.

    The second contact detector that the thesis recommends (appendix H.2.1): it stands beside the operator, sees the
    cloud as it was when it left the telerobot, and switches the renderer's model without waiting for the network. What
    moves along its own surface, or slowly, is in the old cloud where it is now.

    A proxy follows the hand as in `ContactDetector`. It says *where* on the surface the hand is; *whether* it is below
    is then read off the plane through the points around the proxy (`mmt_drake.cloud.proxy.pressed`). So the spacing of
    the points does not show, and of their noise the mean alone. Nor is it a tick late: a model that is switched late
    has its contact spring unstretched too far on, and is wrong for the whole touch.

    .. pydrake_system::

        name: SurfaceContactDetector
        input_ports:
        - position
        - point_cloud
        output_ports:
        - in_contact
        - proxy
        - proxy_state

    - ``position`` (3): of the hand [m], table frame.
    - ``point_cloud`` (abstract, `mmt_drake.cloud.Cloud`): the surface as it was; None or an empty cloud is no surface
      yet, which is no contact.
    - ``in_contact`` (1): 1.0 or 0.0.
    - ``proxy`` (3): the proxy's centre [m], table frame.
    - ``proxy_state`` (1): what decided the proxy's step: 0 free, 1 in contact, 2 entrenched.

    All outputs belong to the inputs at the same instant (direct feedthrough). The proxy's step behind them is computed
    once and stored by the update at the same time.

    Args:
        settings: radii, step factors, period, surface offset; see `ProxySettings`. The offset should be somewhat less
            than `contact_offset`, so that the proxy touches before the hand does.

    Raises:
        BadInput: in a step, for a position that is not finite or a point cloud of another type.
    """

    def __init__(self, settings: ProxySettings | None = None) -> None:
        super().__init__()
        self.settings = settings or ProxySettings()
        self._position = self.DeclareVectorInputPort("position", 3)
        cloud = self.DeclareAbstractInputPort("point_cloud", AbstractValue.Make(NO_CLOUD))
        self._next = declare_proxy(self, self._position, cloud, self.settings)
        sources = {self._next.ticket(), self._position.ticket()}
        self.DeclareVectorOutputPort("in_contact", 1, self._calc_contact, sources)
        self.DeclareVectorOutputPort("proxy", 3, self._calc_proxy, sources)
        self.DeclareVectorOutputPort("proxy_state", 1, self._calc_state, sources)
        pressed(new_memory(), np.zeros(3))  # compiles before the clock starts

    def _calc_contact(self, context: Context, output: BasicVector) -> None:
        below = pressed(self._next.Eval(context), self._position.Eval(context))
        output.SetAtIndex(0, 1.0 if below else 0.0)

    def _calc_proxy(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._next.Eval(context)[POSITION : POSITION + 3])

    def _calc_state(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, self._next.Eval(context)[STATE])
