"""The force renderer with a second model for high frequencies."""

import numpy as np

from mmt_drake.model.held_body import NO_REPORT
from mmt_drake.model.parameters import InPlane
from mmt_drake.numeric.arrays import Array
from mmt_drake.rendering.finite import share_held
from mmt_drake.rendering.high_band import FUSE_SIZE, HighBand, fuse, settings
from mmt_drake.rendering.impedance import MEMORY_SIZE, MODEL_KNOWN, MODEL_TIME, PORT_SIZES, READOUT_SIZES, render
from mmt_drake.rendering.updates import Policy, renderer_rules
from mmt_drake.systems.kernel_system import KernelSystem

_BANK = sum(READOUT_SIZES)  # where in the readout the memory of `fuse` begins, behind that of `render`


class FusedRenderer(KernelSystem):
    """`ImpedanceRenderer` below a frequency, and as far as it is the better one a variable spring above.

    The proposal of the thesis (appendix H.2.2), see `mmt_drake.rendering.high_band`; the spring and its weight come
    from `HighBandEstimator`. Until there is a first model nothing is rendered at all. What the hand can get back is
    known of the first model alone, so `stored_energy` is its.

    .. pydrake_system::

        name: FusedRenderer
        input_ports:
        - motion
        - theta
        - stable
        - in_contact
        - high_band
        - held_body
        - model_status
        output_ports:
        - force
        - status
        - update_jump
        - stored_energy
        - readout

    Ports (table frame):

    - `motion` (6), `theta` (10), `stable` (1), `in_contact` (1), `held_body` (7), `model_status` (1): [m], [m/s] and so
      on, as for `ImpedanceRenderer`.
    - `high_band` (3): stiffness [N/m], damping [N s/m] and weight of the second model.
    - `force` (3): force on the operator's probe [N]; direct feedthrough from all inputs.
    - `status` (1), `update_jump` (3) [N], `stored_energy` (1) [J]: of the first model, 0 or 1 and so on, as there.
    - `readout` (8 and the memory): the four above in that order, then the memory.

    Args:
        high_band: options of the second model; those of the estimator.
        period, substeps, updates, in_plane: see `ImpedanceRenderer`.

    Raises:
        BadInput: a period that is not positive, less than one substep, or a crossover above half the clock's rate.
    """

    def __init__(
        self,
        high_band: HighBand | None = None,
        *,
        period: float = 1e-3,
        substeps: int = 1,
        updates: Policy | None = None,
        in_plane: InPlane = "vector",
    ) -> None:
        super().__init__()
        self._sure, self._unsure = renderer_rules(updates, period, substeps, in_plane)
        self._settings = settings(high_band or HighBand(), period)
        names = "motion", "theta", "stable", "in_contact", "high_band", "held_body", "model_status"
        self.declare_inputs(*names, optional=("held_body", "model_status"))
        self.declare_readout(PORT_SIZES, np.zeros(MEMORY_SIZE + FUSE_SIZE), period)
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, *inputs: Array) -> None:
        motion, theta, stable, contact, high_band, held, model_status = inputs
        held, first = NO_REPORT if held is None else held, memory[:MEMORY_SIZE]
        rule = self._sure if model_status is None or model_status[0] == 0.0 else self._unsure
        render(first, t, motion, motion, theta, stable[0], contact[0], rule, False, held, out[:_BANK])
        out[_BANK:] = memory[MEMORY_SIZE:]
        left = share_held(t - out[MODEL_TIME])
        # Before there is a first model nothing is rendered, so there is nothing to fuse with.
        fuse(out[_BANK:], motion, high_band, contact[0] * out[MODEL_KNOWN], self._settings, out[:3], left)
