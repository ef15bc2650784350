"""Which object a tip touches, by what is known of all of them."""

import math

import numpy as np
from numba import njit

from mmt_drake.cloud.facet import FACET_SIZE
from mmt_drake.model import scene_layout as at
from mmt_drake.model.grasped_box import LEAST_GRIP
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout
from mmt_drake.systems.kernel_system import KernelSystem

PORT_SIZES = {"in_contact": 1, "thing": 1, "clearance": 1, "facet": FACET_SIZE, "height": 1}
_CONTACT, _THING, _CLEARANCE, _FACET, _HEIGHT, _MEMORY = map(Layout(), (*PORT_SIZES.values(), 0))
# The memory: which is held, height of its top, the tip's height at the last tick, whether it has begun, the last facet,
# the object's height, which is in the grip.
_HELD, _TOP, _LAST, _BEGUN, _PLANE, _TALL, _KEPT, _SIZE = map(Layout(), (1, 1, 1, 1, FACET_SIZE, 1, 1, 0))


@njit(cache=True)
def _read(
    memory: Array, position: Array, scene: Array, grip: float, has: float, lost: float, margin: float, out: Array
) -> None:
    now, z = out[_MEMORY:], position[2]
    assign(now, memory)
    out[_CLEARANCE] = -math.inf
    if not grip >= LEAST_GRIP or has == lost:  # nor is NaN
        now[_KEPT] = 0.0
    elif now[_HELD] != 0.0 and now[_KEPT] == 0.0:
        now[_KEPT] = now[_HELD]
    if now[_KEPT] != 0.0:  # it goes where the tip goes; its top is where it was when it stands on the table again
        now[_HELD] = now[_KEPT] if z < now[_TOP] else 0.0
        out[_THING], out[_CLEARANCE] = now[_KEPT], z - now[_TOP]
        _put(now, z, out)
        return
    held = at.row_of(scene, now[_HELD])
    if now[_HELD] != 0.0 and (held < 0 or not at.is_there(scene[held + at.STATE]) or z >= now[_TOP]):
        now[_HELD] = 0.0
    row = at.row_of(scene, now[_HELD]) if now[_HELD] != 0.0 else at.under(scene, position[0], position[1], margin)
    out[_THING] = scene[row] if row >= 0 else 0.0
    if row >= 0 and now[_HELD] == 0.0:
        now[_TOP] = scene[row + at.TOP]  # as long as it is held the plane stays
        now[_TALL] = scene[row + at.HEIGHT]
        now[_PLANE], now[_PLANE + 1], now[_PLANE + 2], now[_PLANE + 3] = 0.0, 0.0, 1.0, now[_TOP]
        if now[_BEGUN] != 0.0 and now[_LAST] >= now[_TOP] and z < now[_TOP]:
            now[_HELD] = scene[row]
    if row >= 0:
        out[_CLEARANCE] = z - now[_TOP]
    _put(now, z, out)


@njit(cache=True)
def _put(now: Array, z: float, out: Array) -> None:
    out[_CONTACT] = 1.0 if now[_HELD] != 0.0 else 0.0
    if not math.isnan(z):  # where nobody knows the tip is where it was
        now[_LAST], now[_BEGUN] = z, 1.0
    assign(out[_FACET:_HEIGHT], now[_PLANE:_TALL])
    out[_HEIGHT] = now[_TALL]


class TouchedObject(KernelSystem):
    """Says which of the objects of a scene the tip is over, and whether it holds it; no point of a cloud is asked.

    It touches the object through whose top it comes down, and holds that until it is above its top again, or until the
    object is taken away or no longer in the scene: then nothing is felt of it. What a closed grip holds is the same one
    until it opens or has lost it, wherever the tip is: the tip touches it below the height at which its top was. A tip
    that is below a top already, when the object appears or from beside, does not touch it. While it is held the height
    of its top stays what it was.

    .. pydrake_system::

        name: TouchedObject
        input_ports:
        - position
        - scene
        - grip
        - has
        output_ports:
        - in_contact
        - thing
        - clearance
        - facet
        - height
        - readout

    Ports (table frame):

    - `position` (3): of the tip [m].
    - `scene` (72): what is seen of the objects (`mmt_drake.model.scene_layout`) [SI].
    - `grip` (1): of the hand [N]; there only with `lost`.
    - `has` (1): counts what is known of the grip [1]; there only with `lost`.
    - `in_contact` (1): 1 where the tip holds an object.
    - `thing` (1): identity of the one that it holds, else of the one under it [1]; 0: none.
    - `clearance` (1): height of the tip above the top of that [m]; -inf: there is none.
    - `facet` (4): the plane of its top: outward unit normal n, and n · x of its points x [m]; the last one where there
      is none; zeros before the first.
    - `height` (1): of that one above the table [m]; as the facet.
    - `readout` (18): the five above in that order, then the memory.

    All outputs belong to the inputs at the same instant (direct feedthrough).

    Args:
        period: of the ticks [s].
        lost: value of `has` where the grip has lost what it had; None: there is no grip.
    """

    def __init__(self, *, period: float = 1e-3, lost: float | None = None) -> None:
        super().__init__()
        self._lost = 0.0 if lost is None else lost
        there = 0 if lost is None else 1
        self.declare_inputs("position", "scene", grip=there, has=there)
        self.declare_readout(PORT_SIZES, np.zeros(_SIZE), period)
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, position: Array, scene: Array, *gripped: Array) -> None:
        grip, has = gripped
        closed, told = (0.0, 0.0) if grip is None else (grip[0], has[0])
        _read(memory, position, scene, closed, told, self._lost, at.MARGIN, out)
