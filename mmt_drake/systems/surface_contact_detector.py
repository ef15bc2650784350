"""Contact detection beside the operator, on the cloud that the network has brought."""

import numpy as np

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.cloud.facet import FACET_SIZE, compile_touching_plane, is_below, touching_plane
from mmt_drake.cloud.proxy import MEMORY_SIZE, POSITION, STATE, ProxySettings, step_proxy
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.kernel_system import KernelSystem

PORT_SIZES = {"in_contact": 1, "proxy": 3, "proxy_state": 1, "facet": FACET_SIZE}
_MEMORY = sum(PORT_SIZES.values())
_FACET = _MEMORY - FACET_SIZE


class SurfaceContactDetector(KernelSystem):
    """Says whether the hand is below the surface that a point cloud shows, in the tick in which it gets there.

    The second contact detector that the thesis recommends (appendix H.2.1): it stands beside the operator, sees the
    cloud as it was when it left the telerobot, and switches the renderer's model without waiting for the network. What
    moves along its own surface, or slowly, is in the old cloud where it is now.

    A proxy follows the hand as in `ContactDetector`. It says *where* on the surface the hand is; *whether* it is below
    is then read off the plane through the points around the proxy (`mmt_drake.cloud.proxy.pressed`), or, of a cloud
    with normals, the one that touches the surface under the hand (`mmt_drake.cloud.facet`). So the spacing of
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
        - facet
        - readout

    - ``position`` (3): of the hand [m], table frame.
    - ``point_cloud`` (abstract, `mmt_drake.cloud.Cloud`): the surface as it was; None or an empty cloud is no surface
      yet, which is no contact.
    - ``in_contact`` (1): 1.0 or 0.0.
    - ``proxy`` (3): the proxy's centre [m], table frame.
    - ``proxy_state`` (1): what decided the proxy's step: 0 free, 1 in contact, 2 entrenched.
    - ``facet`` (4): the plane that touches the surface under the hand: outward unit normal n, and n · x of its points x
      [m], table frame; zeros while the proxy touches nothing.
    - ``readout`` (9 and the memory): the four above in that order, then the proxy's memory.

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
        self._packed = self.settings.packed()
        self.declare_inputs("position", "point_cloud")
        self.declare_readout(PORT_SIZES, np.zeros(MEMORY_SIZE), self.settings.period)
        self.compile_kernels()
        compile_touching_plane(self._packed)

    def _compute(self, t: float, memory: Array, out: Array, position: Array, cloud: Cloud | None) -> None:
        following = out[_MEMORY:]
        following[:] = memory
        step_proxy(following, position, cloud, self._packed)
        out[1:4] = following[POSITION : POSITION + 3]
        out[4] = following[STATE]
        facet = out[_FACET:_MEMORY]
        touching_plane(following, position, cloud, self._packed, facet)
        out[0] = is_below(following, position, cloud, facet)
