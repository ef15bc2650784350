"""A surface that touches correct."""

import math

import numpy as np
from numba import njit
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.cloud.touch import (
    AFTER_S,
    BEFORE_S,
    SeenPlane,
    TouchSettings,
    compile_touch,
    height_of_touch,
    plane_below,
)
from mmt_drake.errors import BadInput, check_number
from mmt_drake.estimation.output_error.adequacy import ModelStatus
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout
from mmt_drake.rendering.finite import all_finite
from mmt_drake.systems.kernel_system import KernelSystem

PORT_SIZES = {"surface_raised": 2}

# The memory. Of the surface, how much higher it is and the deviation of that: as it is put out, as it is known, and as
# it was known before this touch. How much higher it was put out when this contact began. How high the cloud was below
# the latest touch, where the one before was, and the plane of the cloud at the latest. The force in free space and its
# variance; ticks so far, in free space, and since a force has shown. The last samples, which stay from `AFTER_S` after
# a touch to its end.
_RAISED, _KNOWN, _BEFORE, _BEGAN, _SEEN, _PLACE, _NORMAL, _MEAN, _VARIANCE, _TICK, _FREE, _SINCE, _RING = map(
    Layout(), (2, 2, 2, 1, 1, 3, 5, 3, 3, 1, 1, 1, 0)
)

_SAMPLE = 9
_NOTHING, _TOUCHED, _HELD, _ENDED = range(4)
_NOISES, _LEAST_FORCE = 6.0, 1e-3  # deviations of the force, and [N], from which on it is no noise
_LEARN_S, _FORGET_S = 0.02, 0.2  # time in free space after which the force there is known, and forgotten
_SURE = 2.0  # deviations by which a surface must be elsewhere to be moved
_OFF, _FARTHEST = 1e-3, 3.0  # [m], and deviations, above which the tip is in free space
_AGAIN_S = 0.5  # after which a touch is evaluated once more
_LONGEST_S = 0.01  # between ticks
_UNKNOWN_S = 5e-3  # standard deviation of a lateness that is not known
_UNDER_TIP = 1e-3  # [m/s] by which the surface is moved where the tip is on it


class TouchedSurface(KernelSystem):
    """Moves a cloud up or down to where the tip has touched the surface that it shows.

    A camera errs by a millimetre. Then the tip touches some milliseconds before or after a detector says so, the
    contact spring is anchored elsewhere, and the force along the normal is that of another depth. A touch tells the
    height by when the force begins (`mmt_drake.cloud.touch`). It outvotes the cloud as far as it is more certain, by a
    Kalman filter of one state that knows less beside the place of the last touch. What is less than two deviations off
    stays where it is seen. While the tip is on the surface that is moved by 1 mm/s at most. A touch is evaluated again
    and again until it ends, since meanwhile more is known of the lateness of the force.

    .. pydrake_system::

        name: TouchedSurface
        input_ports:
        - measurement
        - point_cloud
        - clearance
        - force_lateness
        - model_status
        output_ports:
        - surface_raised
        - readout
        - corrected
        - lowered

    - ``measurement`` (9): position [m], velocity [m/s] of the tip and force [N] on it, table frame; samples that
      are not finite are left out.
    - ``point_cloud`` (abstract, `mmt_drake.cloud.Cloud`): the surface as it is seen; None or an empty cloud is none.
    - ``clearance`` (1): height of the tip above the corrected surface [m]; -inf: none is seen.
    - ``force_lateness`` (6): by what the force is late [s], as of `OutputErrorEstimator`; may stay unconnected, and
      then it is not late.
    - ``model_status`` (1): 0 where that estimator is sure of its model; anything else: the lateness is not known to
      5 ms. May stay unconnected, and then it is sure.
    - ``surface_raised`` (2): by how much the cloud is moved up [m], and the standard deviation of that.
    - ``readout`` (1177 at 1 kHz): that, and the rest of the memory.
    - ``corrected`` (abstract, `mmt_drake.cloud.Cloud`): the cloud, moved up by that; direct feedthrough.
    - ``lowered`` (9): the measurement [m], [m/s], [N], its z the height above a level surface that the latest touch
      found, above z = 0 before the first one; direct feedthrough. That surface does not move while the tip is on it.

    Args:
        settings: what is known of the cloud beforehand.
        period: of the ticks [s].
        radius: points of the cloud within it of the tip tell where the surface is seen [m].

    Raises:
        BadInput: a period that is not above 0 or above 10 ms; a radius that is not above 0.
    """

    def __init__(self, settings: TouchSettings | None = None, *, period: float = 1e-3, radius: float = 5e-3) -> None:
        super().__init__()
        check_number("TouchedSurface", "radius", radius, least=0.0, open_interval=True)
        check_number("TouchedSurface", "period", period, least=0.0, open_interval=True)
        if period > _LONGEST_S:
            found, expected = f"{period:g} s", f"{_LONGEST_S:g} s at most: a touch is told by samples"
            raise BadInput("TouchedSurface", at="period", found=found, expected=expected)
        self._settings, self._period, self._radius = settings or TouchSettings(), period, radius
        self._before, self._after, self._again = (round(time / period) for time in (BEFORE_S, AFTER_S, _AGAIN_S))
        may_be_left = "force_lateness", "model_status"
        self.declare_inputs("measurement", "point_cloud", "clearance", *may_be_left, optional=may_be_left)
        initial = np.zeros(_RING + _SAMPLE * (self._before + self._after))
        for known in (_RAISED, _KNOWN, _BEFORE):
            initial[known + 1] = self._settings.deviation
        initial[_PLACE] = math.nan
        self.declare_state_readout(PORT_SIZES, initial, period)
        sources = {self.GetInputPort("point_cloud").ticket(), self.xd_ticket()}
        self.DeclareAbstractOutputPort(
            "corrected", lambda: AbstractValue.Make(Cloud.empty()), self._put_corrected, sources
        )
        self.declare_computed("lowered", 9, self._put_lowered, ("measurement",))
        self.compile_kernels()
        compile_touch(self._radius)

    def _put_corrected(self, context: Context, output: AbstractValue) -> None:
        cloud = self.GetInputPort("point_cloud").Eval(context)
        height = context.get_discrete_state_vector().value()[_RAISED]
        if cloud is not None and height != 0.0:
            cloud = cloud.moved(cloud.translation + np.array([0.0, 0.0, height]), cloud.stamp)
        output.set_value(cloud)

    def _put_lowered(self, t: float, memory: Array, out: Array, measurement: Array) -> None:
        out[:] = measurement
        out[2] -= memory[_SEEN] + memory[_BEGAN]

    def _step(
        self,
        t: float,
        memory: Array,
        measurement: Array,
        cloud: Cloud | None,
        clearance: Array,
        late: Array | None,
        status: Array | None,
    ) -> None:
        happened = _follow(memory, measurement, clearance[0], self._period, self._after, self._again)
        if happened == _NOTHING:
            return
        ring = memory[_RING:].reshape(-1, _SAMPLE)
        samples = np.roll(ring, -(int(memory[_TICK]) % len(ring)), axis=0)
        tip = samples[self._before - 1, :3]
        if happened == _TOUCHED:
            below = None if cloud is None else plane_below(cloud, tip, self._radius)
            memory[_NORMAL : _NORMAL + 5] = math.nan if below is None else (*below.normal, below.along, below.deviation)
        if math.isnan(memory[_NORMAL]):
            return
        unsure = status is not None and status[0] != ModelStatus.ADEQUATE
        lateness = (0.0, 0.0) if late is None else (float(late[2]), float(late[5]))
        if unsure:
            lateness = 0.0, _UNKNOWN_S
        if happened == _TOUCHED or not unsure:
            self._evaluate(memory, samples, lateness)
        if happened == _ENDED:
            memory[_BEFORE : _BEFORE + 2] = memory[_KNOWN : _KNOWN + 2]
            memory[_PLACE : _PLACE + 3] = tip

    def _evaluate(self, memory: Array, samples: Array, lateness: tuple[float, float]) -> None:
        """Take in the latest touch, by what is known now of the lateness of the force, and how surely [s]."""
        samples[:, 6:] -= memory[_MEAN : _MEAN + 3]
        noise, onset = np.sqrt(memory[_VARIANCE : _VARIANCE + 3]), self._before - 1
        *normal, along, deviation = memory[_NORMAL : _NORMAL + 5].tolist()
        seen = SeenPlane((normal[0], normal[1], normal[2]), along, deviation)
        lateness = lateness[0], math.hypot(lateness[1], self._settings.lateness)
        told = height_of_touch(samples, noise, onset, seen, self._period, lateness)
        if told is None:
            return
        was, spread = memory[_BEFORE : _BEFORE + 2]
        if not math.isnan(memory[_PLACE]):
            way = float(np.linalg.norm(samples[onset, :3] - memory[_PLACE : _PLACE + 3]))
            spread = self._settings.beside(spread, way)
        share = spread**2 / (spread**2 + told.deviation**2)
        memory[_SEEN] = seen.below(samples[onset])
        memory[_KNOWN] = was + share * (told.height - was)
        memory[_KNOWN + 1] = max(math.sqrt(1.0 - share) * spread, told.shared)


@njit(cache=True)
def _follow(memory: Array, measurement: Array, clearance: float, period: float, after: int, again: int) -> int:
    """Take in a sample, in place.

    Returns:
        _TOUCHED: a touch is to be evaluated; _HELD: again; _ENDED: for the last time; else _NOTHING.
    """
    if not all_finite(measurement):
        return _NOTHING
    count = (len(memory) - _RING) // _SAMPLE
    off = clearance > _OFF + _FARTHEST * memory[_KNOWN + 1]
    if off and memory[_SINCE] > after:
        memory[_SINCE] = 0.0
        return _ENDED
    if memory[_SINCE] <= after:
        at = _RING + _SAMPLE * (int(memory[_TICK]) % count)
        assign(memory[at : at + _SAMPLE], measurement)
        memory[_TICK] += 1.0
    wanted = memory[_KNOWN] if abs(memory[_KNOWN]) > _SURE * memory[_KNOWN + 1] else 0.0
    memory[_RAISED + 1] = memory[_KNOWN + 1] + abs(memory[_KNOWN] - memory[_RAISED])
    if off:
        memory[_RAISED] = memory[_BEGAN] = wanted
        _learn_free_force(memory, measurement, period)
        memory[_SINCE] = 0.0
        return _NOTHING
    most = _UNDER_TIP * period
    memory[_RAISED] += min(max(wanted - memory[_RAISED], -most), most)
    unknown = memory[_FREE] * period < _LEARN_S or memory[_TICK] < count
    if unknown or (memory[_SINCE] == 0.0 and not _shows_force(memory, measurement)):
        return _NOTHING
    memory[_SINCE] += 1.0
    over = memory[_SINCE] - after - 1.0
    if over == 0.0:
        return _TOUCHED
    return _HELD if over > 0.0 and over % again == 0.0 else _NOTHING


@njit(cache=True)
def _learn_free_force(memory: Array, measurement: Array, period: float) -> None:
    memory[_FREE] += 1.0
    share = max(1.0 / memory[_FREE], period / _FORGET_S)
    for i in range(3):
        away = measurement[6 + i] - memory[_MEAN + i]
        memory[_MEAN + i] += share * away
        memory[_VARIANCE + i] += share * ((1.0 - share) * away * away - memory[_VARIANCE + i])


@njit(cache=True)
def _shows_force(memory: Array, measurement: Array) -> bool:
    """Whether the force is no noise about that in free space."""
    squared = variance = 0.0
    for i in range(3):
        squared += (measurement[6 + i] - memory[_MEAN + i]) ** 2
        variance += memory[_VARIANCE + i]
    limit = max(_NOISES * math.sqrt(variance / 3.0), _LEAST_FORCE)
    return squared > limit * limit
