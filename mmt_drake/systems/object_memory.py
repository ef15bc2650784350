"""The operator's side remembers each object: what is rendered of it before the telerobot's answer is there."""

import numpy as np
from numba import njit

from mmt_drake.estimation.first_guess import guess
from mmt_drake.model import scene_layout as at
from mmt_drake.model.parameters import THETA
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout
from mmt_drake.systems.kernel_system import KernelSystem

PORT_SIZES = {"theta": len(THETA), "stable": 1, "model_status": 1, "remembered": 1}
_THETA, _STABLE, _STATUS, _REMEMBERED, _MEMORY = map(Layout(), (*PORT_SIZES.values(), 0))
_ROOM = 12  # objects that are remembered; of more the one that was told longest ago is forgotten
# Of a row of the memory: identity, when it was told last, theta, whether it is
# stable, its status, whether it is a guess; looks.
_THING, _TOLD, _NUMBERS, _FLAGS, _LOOKS, _ROW = map(Layout(), (1, 1, len(THETA), 3, at.LOOKS, 0))
_LAST = _ROOM * _ROW  # which is rendered
_UNEXCITED = 3.0  # `ModelStatus`: not every number is told, so it is no example for others


@njit(cache=True)
def _find(memory: Array, thing: float) -> int:
    for i in range(_ROOM):
        if memory[i * _ROW + _THING] == thing:
            return i * _ROW
    return -1


@njit(cache=True)
def _keep(now: Array, t: float, thing: float, theta: Array, stable: float, status: float, scene: Array) -> int:
    row = _find(now, thing)
    if row < 0:
        row = 0
        for i in range(_ROOM):
            if now[i * _ROW + _TOLD] < now[row + _TOLD]:
                row = i * _ROW
    now[row + _THING], now[row + _TOLD] = thing, t
    assign(now[row + _NUMBERS : row + _FLAGS], theta)
    now[row + _FLAGS], now[row + _FLAGS + 1], now[row + _FLAGS + 2] = stable, status, 0.0
    seen = at.row_of(scene, thing)
    if seen >= 0:
        assign(now[row + _LOOKS : row + _ROW], scene[seen + at.HEIGHT : seen + at.AGE])
    return row


@njit(cache=True)
def _guess(now: Array, scene: Array, seen: int, theta: Array) -> None:
    looks, thetas, count = np.empty((_ROOM, at.LOOKS)), np.empty((_ROOM, len(theta))), 0
    for i in range(_ROOM):
        row = i * _ROW
        if now[row + _THING] != 0.0 and now[row + _FLAGS + 1] != _UNEXCITED and now[row + _LOOKS] > 0.0:
            assign(looks[count], now[row + _LOOKS : row + _ROW])
            assign(thetas[count], now[row + _NUMBERS : row + _FLAGS])
            count += 1
    guess(scene[seen + at.HEIGHT : seen + at.AGE], looks, thetas, count, theta)


@njit(cache=True)
def _read(
    memory: Array,
    t: float,
    thing: float,
    told: float,
    theta: Array,
    stable: float,
    status: float,
    scene: Array,
    out: Array,
) -> None:
    now = out[_MEMORY:]
    assign(now, memory)
    finite = True
    for i in range(len(theta)):
        finite = finite and np.isfinite(theta[i])
    if told > 0.0 and finite and stable > 0.0:
        _keep(now, t + 1.0, told, theta, stable, status, scene)
    other = thing > 0.0 and thing != now[_LAST]
    now[_LAST] = thing if thing > 0.0 else now[_LAST]
    row, seen = _find(now, now[_LAST]) if now[_LAST] > 0.0 else -1, at.row_of(scene, now[_LAST])
    guessed = row >= 0 and now[row + _FLAGS + 2] != 0.0
    if seen >= 0 and (row < 0 or (guessed and other)):  # each time that the hand comes to it
        _guess(now, scene, seen, out[_THETA:_STABLE])
        row = _keep(now, t + 1.0, now[_LAST], out[_THETA:_STABLE], 1.0, _UNEXCITED, scene)
        now[row + _FLAGS + 2], guessed = 1.0, True
    if row >= 0:
        assign(out[_THETA:_STABLE], now[row + _NUMBERS : row + _FLAGS])
        out[_STABLE], out[_STATUS] = now[row + _FLAGS], now[row + _FLAGS + 1]
        out[_REMEMBERED] = 1.0 if guessed else 2.0
    else:
        assign(out[_THETA:_STABLE], theta)
        out[_STABLE], out[_STATUS], out[_REMEMBERED] = stable, status, 0.0


class ObjectMemory(KernelSystem):
    """Keeps the latest theta that has come for each object, and shows that of the one which the hand is over.

    So what is rendered at the second touch is there before the telerobot has got to the object. Of one that nothing has
    come of it shows a first guess (`mmt_drake.estimation.first_guess`).

    .. pydrake_system::

        name: ObjectMemory
        input_ports:
        - thing
        - scene
        - told_thing
        - theta
        - stable
        - model_status
        output_ports:
        - theta
        - stable
        - model_status
        - remembered
        - readout

    Ports:

    - `thing` (1): identity of the object that the hand holds or is over [1]; 0: none, and the last one stays.
    - `scene` (72): what is seen of the objects (`mmt_drake.model.scene_layout`) [SI], for what they look like.
    - `told_thing` (1): whose theta has come [1]; 0: nobody's, and nothing is kept.
    - `theta` (10): what has come [SI], in the order of `mmt_drake.model.parameters.THETA`; and so put out.
    - `stable` (1): 1 where that may be rendered; else nothing is kept.
    - `model_status` (1): counts of `ModelStatus`, 0 where theta explains the force; an object whose numbers are not all
      told, 3, is no example for others.
    - `remembered` (1): counts where what is put out comes from: 0 from what has come, of no object in particular, 1
      from a guess, 2 from what is remembered.
    - `readout` (13 and the memory): the four outputs in that order, then the memory.

    All outputs belong to the inputs at the same instant (direct feedthrough).

    Args:
        period: of the ticks [s].
    """

    def __init__(self, *, period: float = 1e-3) -> None:
        super().__init__()
        self.declare_inputs("thing", "scene", "told_thing", "theta", "stable", "model_status")
        self.declare_readout(PORT_SIZES, np.zeros(_LAST + 1), period)
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, *inputs: Array) -> None:
        thing, scene, told, theta, stable, status = inputs
        _read(memory, t, thing[0], told[0], theta, stable[0], status[0], scene, out)
