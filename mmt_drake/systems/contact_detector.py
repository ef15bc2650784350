"""Contact detection by a proxy on a point cloud."""

import numpy as np

from mmt_drake.cloud.clearance import NO_SURFACE, clearance
from mmt_drake.cloud.cloud import Cloud
from mmt_drake.cloud.facet import FACET_SIZE, compile_touching_plane, is_below, touching_plane
from mmt_drake.cloud.proxy import MEMORY_SIZE, POSITION, STATE, TOUCHING, ProxySettings, step_proxy
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.kernel_system import KernelSystem

PORT_SIZES = {"in_contact": 1, "proxy": 3, "proxy_state": 1, "clearance": 1, "facet": FACET_SIZE}
_MEMORY = sum(PORT_SIZES.values())
_FACET = _MEMORY - FACET_SIZE
_CLEARANCE = _FACET - 1
_SHOWN = np.array([TOUCHING, POSITION, POSITION + 1, POSITION + 2, STATE])  # what of the memory the ports show


class ContactDetector(KernelSystem):
    """Says from a point cloud of the surface whether the probe touches it (thesis appendices C and D.3).

    A proxy follows the probe and is held up by the cloud; the probe is in contact if, after the proxy's step, points
    are within r2 of the proxy; of a cloud with normals also only where the probe is below the plane that touches the
    surface there, for a proxy that has slid over an edge stays near it for long. The spheres would notice the surface
    from r2 away, so the cloud is taken to lie `surface_offset` lower, against the normals of its points: contact begins
    and ends where the tip passes the surface,
    to the unevenness of a sampled surface (spacing²/(4 r2) from highest to lowest on a square lattice, 0.15 mm for
    30 000 points on 0.3 x 0.3 m). The default offset follows from each cloud's own spacing; for a noisy cloud pass
    `contact_offset(r2, spacing, noise)`. On a flat surface a slow probe is so detected at z = 0; the probe has gone
    speed x period further by the time the port shows it.

    .. pydrake_system::

        name: ContactDetector
        input_ports:
        - position
        - point_cloud
        output_ports:
        - in_contact
        - proxy
        - proxy_state
        - clearance
        - facet
        - readout

    - ``position`` (3): probe tip [m], table frame.
    - ``point_cloud`` (abstract, `mmt_drake.cloud.Cloud`): the surface now; None or an empty cloud is no surface yet,
      which is no contact.
    - ``in_contact`` (1): 1.0 or 0.0.
    - ``proxy`` (3): the proxy's centre [m], table frame, on the lowered cloud: it rests r1 to r2 above that, so between
      z = 0 and r2 - r1 below.
    - ``proxy_state`` (1): what decided the proxy's step: 0 free, 1 in contact, 2 entrenched. It may lag or lead
      ``in_contact``, which is about the proxy after that step, by a tick.
    - ``clearance`` (1): height of the tip above the cloud's points within r3 across z, else above the whole cloud [m];
      -inf without a cloud. No proxy has a part in it: one that came through the surface is free, and this is below 0.
    - ``facet`` (4): the plane that touches the surface under the hand: outward unit normal n, and n · x of its points x
      [m], table frame; zeros while the proxy touches nothing.
    - ``readout`` (30): the five above in that order, then the proxy's memory.

    The outputs are states, updated once in every period: one period younger than the inputs.

    Args:
        settings: radii, step factors, period, surface offset; see `ProxySettings`.
        by_plane: the plane under the tip says whether it is in contact, as of `SurfaceContactDetector`, and not which
            point a sphere meets first; with an offset as there.

    Raises:
        BadInput: in a step, for a position that is not finite or a point cloud of another type.
    """

    def __init__(self, settings: ProxySettings | None = None, *, by_plane: bool = False) -> None:
        super().__init__()
        self.settings, self._by_plane = settings or ProxySettings(), by_plane
        self._packed = self.settings.packed()
        self.declare_inputs("position", "point_cloud")
        initial = np.zeros(_MEMORY + MEMORY_SIZE)
        initial[_CLEARANCE] = NO_SURFACE
        self.declare_state_readout(PORT_SIZES, initial, self.settings.period)
        self.compile_kernels()
        clearance(Cloud(np.zeros((1, 3))), np.zeros(3), self.settings.r3)
        compile_touching_plane(self._packed)

    def _step(self, t: float, readout: Array, position: Array, cloud: Cloud | None) -> None:
        memory = readout[_MEMORY:]
        step_proxy(memory, position, cloud, self._packed)
        readout[:_CLEARANCE] = memory[_SHOWN]
        readout[_CLEARANCE] = clearance(cloud, position, self.settings.r3)
        facet = readout[_FACET:_MEMORY]
        touching_plane(memory, position, cloud, self._packed, facet)
        if self._by_plane:
            readout[0] = is_below(memory, position, cloud, facet)
        elif memory[TOUCHING] and cloud is not None and cloud.normals is not None:
            uneven = cloud.spacing**2 / (4.0 * self.settings.r2)
            readout[0] = facet[:3] @ position[:3] < facet[3] + uneven
