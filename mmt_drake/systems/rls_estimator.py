"""The thesis's recursive estimator of the object's impedance, as a system."""

from mmt_drake.errors import BadInput
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.thesis import PORT_SIZES, initial_readout, readout_step, settings
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.kernel_system import KernelSystem


class RlsEstimator(KernelSystem):
    """Recursive least squares on eq. 7 and 8 of the thesis, paused out of contact, and the back-solve of eq. 30.

    .. pydrake_system::

        name: RlsEstimator
        input_ports:
        - measurement
        - in_contact
        output_ports:
        - theta
        - regrouped
        - stable
        - estimated_force
        - filtered_force
        - readout

    Inputs: `measurement` (9), the probe's position [m], velocity [m/s] and the force on it [N] in the table frame;
    `in_contact` (1), 0.0 or 1.0.

    Outputs, all of them states, hence one step younger than the inputs:

    - `theta` (10): m [kg], k1, k2 [N/m], b1, b2 [N s/m], Fc [N], normal k [N/m], normal b [N s/m], and, since eq. 7
      knows no static friction, Fs = Fc [N] and v_d = 0 [m/s]; NaN until there is an estimate. Estimates come as they
      are, not clipped: a k1, b1 or Fc that is 0 in truth scatters about 0.
    - `regrouped` (7): a ... g of eq. 7, zero at the start.
    - `stable` (1): 1.0 while the latest back-solve is admissible: both eigenvalues in contact have a negative real
      part, and the normal axis has k > 0, b >= 0. `mmt_drake.model.regrouping.Root` says what else makes a root
      admissible; the eigenvalues are the roots of m s^2 + (b1 + b2) s + k1 + k2. The body by itself is not asked: with
      k1 = 0 it has an eigenvalue of 0 and stays where it was left. Otherwise 0.0, and the first six of theta hold their
      last values. Out of contact and once frozen it keeps its value. A renderer may still pass over a theta that is
      stable, because it is too stiff to integrate.
    - `estimated_force` (3) [N]: psi' theta of eq. 7 and 8 with the latest estimate; zero out of contact.
    - `filtered_force` (3) [N]: the measured force through the same low-pass, what `estimated_force` is held against.
    - `readout` (22 and the memory, whose size depends on the filters): the five above in that order, then the memory.

    Args:
        options: `RlsOptions`; its `step` is the period of the one discrete update.

    Raises:
        BadInput: during simulation, where an input is not finite.
    """

    def __init__(self, options: RlsOptions | None = None) -> None:
        super().__init__()
        options = RlsOptions() if options is None else options
        self._settings = settings(options)
        self.declare_inputs("measurement", "in_contact")
        self.declare_state_readout(PORT_SIZES, initial_readout(options), options.step)
        self.compile_kernels()

    def _step(self, t: float, readout: Array, measurement: Array, in_contact: Array) -> None:
        if not readout_step(measurement, in_contact[0], readout, self._settings):
            raise BadInput(
                f"{self.get_name()} (RlsEstimator)",
                at=f"t = {t:g} s",
                found="NaN or infinity at measurement or in_contact",
                expected="finite numbers",
            )
