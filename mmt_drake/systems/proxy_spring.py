"""Force rendered from a point cloud alone."""

import numpy as np
from numba import njit
from pydrake.systems.framework import BasicVector, Context

from mmt_drake.cloud.proxy import SURFACE, ProxySettings, new_memory, pressed
from mmt_drake.cloud.vectors import ZERO, Array, get, minus, put, times
from mmt_drake.errors import check_number
from mmt_drake.systems.leaf import LeafSystem
from mmt_drake.systems.proxy_steps import declare_proxy
from mmt_drake.systems.renderer_ports import declare_renderer_inputs, declare_rendering


class ProxySpringRenderer(LeafSystem):
    """Pulls the hand by a spring to a proxy that stays out of the cloud (point-cloud mediated teleoperation).

    F = k (x_proxy - x_hand), thesis eq. 3 and 11. The proxy's centre floats somewhere between r1 and r2 above the
    points, where exactly depends on how it got there; so x_proxy is taken as the centre's foot on the plane through the
    points around it. The force then is 0 at the surface and k times the depth below it, along the normal, whatever the
    radii, and follows the mean of noisy points. There is no force while the hand is outside the surface: the proxy's
    sticking (eq. 23) is not felt. The spring can only render what geometry tells: no damping, no friction, no body
    that moves.

    The force is not limited: how much a device can give is the device's affair, which knows its limit and reports
    when it is met.

    .. pydrake_system::

        name: ProxySpringRenderer
        input_ports:
        - motion
        - point_cloud
        output_ports:
        - force
        - status

    - ``motion`` (6): the hand's position [m] and velocity [m/s], table frame; the velocity is not used.
    - ``point_cloud`` (abstract, `mmt_drake.cloud.Cloud`): the surface now; None or an empty cloud: no force.
    - ``force`` (3): on the hand [N], table frame. Direct feedthrough from ``motion`` and ``point_cloud``: it belongs to
      the hand's position now. The proxy's step behind it is computed once and stored by the update at the same time.
    - ``status`` (1): 1 where it renders, as always: it waits for no parameters (`mmt_drake.rendering.status`).

    Args:
        k: stiffness [N/m]. A device with a loop at 1 kHz and damping b of its own stays passive up to about
            2 b / 1 ms.
        settings: radii, step factors, period, surface offset; see `ProxySettings`.

    Raises:
        BadInput: k is not a positive number; in a step, a position that is not finite or a point cloud of another type.
    """

    def __init__(self, k: float = 500.0, settings: ProxySettings | None = None) -> None:
        super().__init__()
        check_number("proxy spring", "k", k, least=0.0, open_interval=True)
        self.k = float(k)
        self.settings = settings or ProxySettings()
        self._motion, cloud = declare_renderer_inputs(self, "motion", "point_cloud")
        self._next = declare_proxy(self, self._motion, cloud, self.settings)
        self.DeclareVectorOutputPort("force", 3, self._calc_force, {self._next.ticket(), self._motion.ticket()})
        declare_rendering(self)
        _spring(new_memory(), np.zeros(6), self.k, np.zeros(3))  # compiles before the clock starts

    def _calc_force(self, context: Context, force: BasicVector) -> None:
        _spring(self._next.Eval(context), self._motion.Eval(context), self.k, force.get_mutable_value())


@njit(cache=True)
def _spring(memory: Array, hand: Array, k: float, force: Array) -> None:
    """Thesis eq. 3, to the proxy's foot on the surface; only while the hand is below it."""
    put(force, 0, times(k, minus(get(memory, SURFACE), get(hand, 0))) if pressed(memory, hand) else ZERO)
