"""The operator's hand moved by sliders in the browser."""

import math

import numpy as np
from numba import njit
from pydrake.systems.framework import Context, DiscreteValues

from mmt_drake.errors import check_number
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.kernel_system import KernelSystem
from mmt_drake.viewer.viewer import Viewer

#: Name, least, greatest and first value [m] of the sliders.
SLIDERS = (("hand x [m]", -0.1, 0.1, 0.0), ("hand y [m]", -0.1, 0.1, 0.0), ("hand z [m]", -0.01, 0.05, 0.02))
_STEP = 0.0005  # [m]
_SLIDER_PERIOD = 0.02  # [s]; a browser sends no faster


@njit(cache=True)
def follow(target: Array, omega: float, greatest_speed: float, dt: float, motion: Array) -> None:
    """Advances x'' = -2 w x' - w^2 (x - target) by dt [s], exactly for a target that rests meanwhile.

    A target further away than 2 v / w counts as being that far: so v is never exceeded, since x'' <= -2 w (x' - v).

    Args:
        target: (3) [m].
        omega: w [rad/s].
        greatest_speed: v, of each axis [m/s].
        dt: [s].
        motion: (6) position [m] and velocity [m/s], updated.
    """
    decay = math.exp(-omega * dt)
    furthest = 2.0 * greatest_speed / omega
    for axis in range(3):
        error = min(max(motion[axis] - target[axis], -furthest), furthest)
        near = motion[axis] - error
        slope = motion[3 + axis] + omega * error
        motion[axis] = near + (error + slope * dt) * decay
        motion[3 + axis] = (motion[3 + axis] - omega * slope * dt) * decay


class InteractiveOperator(KernelSystem):
    """A hand that follows three sliders of the viewer's page, smoothly, so that its velocity exists.

    .. pydrake_system::

        name: InteractiveOperator
        output_ports:
        - motion

    - `motion` (6): position [m] and velocity [m/s] of the hand, table frame: a critically damped second-order
      filter behind the sliders.

    The sliders are the world outside and read 50 times a second; what they said last, and the filter, are state.
    What a browser sends that is no number within a slider's range is not believed: the hand stays where it was sent
    last, as it does when the browser is closed.

    Args:
        viewer: where the sliders are added.
        period: step of the filter [s].
        bandwidth: of the filter [Hz].
        greatest_speed: of the hand along each axis [m/s], however far a slider jumps.

    Raises:
        BadInput: a period, a bandwidth or a speed that is not positive.
    """

    def __init__(self, viewer: Viewer, *, period: float = 0.001, bandwidth: float = 2.0, greatest_speed: float = 0.5):
        super().__init__()
        for name, value in (("period", period), ("bandwidth", bandwidth), ("greatest_speed", greatest_speed)):
            check_number("interactive operator", name, value, least=0.0, open_interval=True)
        self._viewer, self._period, self._omega = viewer, period, 2.0 * math.pi * bandwidth
        self._greatest_speed = greatest_speed
        for name, least, greatest, first in SLIDERS:
            viewer.add_slider(name, least, greatest, _STEP, first)
        start = np.array([first for *_, first in SLIDERS])
        state = self.DeclareDiscreteState(np.concatenate([start, np.zeros(3)]))
        self._target = self.DeclareDiscreteState(start)
        self.DeclareStateOutputPort("motion", state)
        self.DeclarePeriodicDiscreteUpdateEvent(_SLIDER_PERIOD, 0.0, self._read)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)
        self.compile_kernels()

    def _read(self, context: Context, state: DiscreteValues) -> None:
        target, said = state.get_mutable_value(1), self._viewer.hear()
        for axis, (name, least, greatest, _) in enumerate(SLIDERS):
            if least <= said[name] <= greatest:
                target[axis] = said[name]

    def _update(self, context: Context, state: DiscreteValues) -> None:
        target = context.get_discrete_state(self._target).value()
        follow(target, self._omega, self._greatest_speed, self._period, state.get_mutable_value(0))
