"""Compensation of a wrist's force sensor: its reading cleared of the probe that it carries and of its offset."""

from numpy.typing import ArrayLike

from mmt_drake.estimation.probe import PORT_SIZES, ProbeOptions, compensate, initial_readout, settings
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.kernel_system import KernelSystem


class ProbeCompensation(KernelSystem):
    """Takes the probe's weight and inertia and the sensor's offset off, the offset anew in free space.

    F = r - o - m g + m a, see `mmt_drake.estimation.probe`. Position, velocity, force and contact are handed on
    together, `ProbeOptions.delay` and one step late.

    .. pydrake_system::

        name: ProbeCompensation
        input_ports:
        - raw_measurement
        - in_contact
        - clearance
        output_ports:
        - measurement
        - in_contact
        - offset
        - reading
        - zero
        - readout

    Inputs: `raw_measurement` (9), the probe's position [m], velocity [m/s] and what the sensor reads [N], in the table
    frame and with the sign of a force on the probe; `in_contact` (1), 0.0 or 1.0; `clearance` (1), height of the probe
    above the surface [m], as `ContactDetector` tells it.

    Outputs, all of them states:

    - `measurement` (9): the probe's position [m], velocity [m/s] and the force on its tip [N].
    - `in_contact` (1): the flag that belongs to it, 0.0 or 1.0.
    - `offset` (3): of the sensor as it is known [N]; zero until the first time in free space.
    - `reading` (3): what the sensor itself said of that sample [N]; an estimator that asks for it sees the sensor
      saturate or freeze, which the force on the tip hides.
    - `zero` (1): what becomes of the offset: 0 while held, 1 while renewed in free space; held although no contact is
      told: 2 the probe is under the surface or none is seen, 3 the force is not steady, 4 it is far from the last zero
      (`Zero`).
    - `readout` (17 and the memory, whose size depends on the options): the five above in that order, then the memory.

    Args:
        options: of the probe; `step` is the period of the discrete update.
        start: (3) where the probe is before the first sample [m].
    """

    def __init__(self, options: ProbeOptions | None = None, start: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        super().__init__()
        options = ProbeOptions() if options is None else options
        self._settings = settings(options)
        #: By how many samples what is handed on is late.
        self.ticks_late = options.ticks_late
        self.declare_inputs("raw_measurement", "in_contact", "clearance")
        initial = initial_readout(options)
        initial[:3] = start
        self.declare_state_readout(PORT_SIZES, initial, options.step)
        self.compile_kernels()

    def _step(self, t: float, readout: Array, raw: Array, contact: Array, clearance: Array) -> None:
        compensate(raw, contact[0], clearance[0], readout, self._settings)
