"""Force rendered from a point cloud alone."""

import numpy as np
from numba import njit

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.cloud.proxy import MEMORY_SIZE, SURFACE, ProxySettings, pressed, step_proxy
from mmt_drake.errors import check_number
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.vectors import ZERO, get, minus, put, times
from mmt_drake.systems.kernel_system import KernelSystem
from mmt_drake.systems.renderer_ports import declare_rendering


class ProxySpringRenderer(KernelSystem):
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
        - readout
        - status

    - ``motion`` (6): the hand's position [m] and velocity [m/s], table frame; the velocity is not used.
    - ``point_cloud`` (abstract, `mmt_drake.cloud.Cloud`): the surface now; None or an empty cloud: no force.
    - ``force`` (3): on the hand [N], table frame. Direct feedthrough from ``motion`` and ``point_cloud``: it belongs to
      the hand's position now. The proxy's step behind it is computed once and stored by the update at the same time.
    - ``readout`` (3 and the memory): the force, then the proxy's memory.
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
        self._packed = self.settings.packed()
        self.declare_inputs("motion", "point_cloud")
        self.declare_readout({"force": 3}, np.zeros(MEMORY_SIZE), self.settings.period)
        declare_rendering(self)
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, motion: Array, cloud: Cloud | None) -> None:
        following = out[3:]
        following[:] = memory
        step_proxy(following, motion, cloud, self._packed)
        _spring(following, motion, self.k, out[:3])


@njit(cache=True)
def _spring(memory: Array, hand: Array, k: float, force: Array) -> None:
    """Thesis eq. 3, to the proxy's foot on the surface; only while the hand is below it."""
    put(force, 0, times(k, minus(get(memory, SURFACE), get(hand, 0))) if pressed(memory, hand) else ZERO)
