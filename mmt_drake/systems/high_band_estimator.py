"""The telerobot's estimator of the second model, for high frequencies."""

import numpy as np

from mmt_drake.errors import check_number
from mmt_drake.numeric.arrays import Array
from mmt_drake.rendering.high_band import ESTIMATE_SIZE, HighBand, estimate, settings
from mmt_drake.systems.kernel_system import KernelSystem


class HighBandEstimator(KernelSystem):
    """Fits a variable spring to the high band of force and motion, and says how far it is to be trusted.

    See `mmt_drake.rendering.high_band`; `FusedRenderer` renders it.

    .. pydrake_system::

        name: HighBandEstimator
        input_ports:
        - measurement
        - in_contact
        - theta
        - stable
        output_ports:
        - high_band

    Ports (table frame):

    - `measurement` (9): the probe's position [m], velocity [m/s] and the force on it [N]; a sample with NaN is skipped.
    - `in_contact` (1): 1 where the probe touches; elsewhere nothing is learned.
    - `theta` (10): the first model's latest set: m [kg], k1, k2 [N/m], b1, b2 [N s/m], Fc [N], normal_k [N/m], normal_b
      [N s/m], Fs [N], v_d [m/s].
    - `stable` (1): 1 where theta may be rendered.
    - `high_band` (3): stiffness k [N/m], damping b [N s/m] and the second model's weight, 0 to 1; a state.

    Args:
        options: of the second model.
        period: of the updates [s].

    Raises:
        BadInput: a period that is not positive, or a crossover above half the clock's rate.
    """

    def __init__(self, options: HighBand | None = None, *, period: float = 1e-3) -> None:
        super().__init__()
        check_number("high band", "period", period, least=0.0, open_interval=True)
        self._settings = settings(options or HighBand(), period)
        self.declare_inputs("measurement", "in_contact", "theta", "stable")
        self.declare_memory(np.zeros(ESTIMATE_SIZE), period)
        self.declare_state_parts({"high_band": 3})
        self.compile_kernels()

    def _step(self, t: float, memory: Array, *inputs: Array) -> None:
        measurement, contact, theta, stable = inputs
        estimate(memory, t, measurement, contact[0], theta, stable[0], self._settings)
