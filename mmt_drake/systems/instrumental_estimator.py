"""The refined instrumental variable on the thesis's regressors, as a system."""

from __future__ import annotations

from pydrake.systems.framework import LeafSystem

from mmt_drake.estimation.recursive.instrumental import InstrumentalLearner
from mmt_drake.estimation.recursive.options import InstrumentalOptions
from mmt_drake.systems.learning import Learning


class InstrumentalEstimator(LeafSystem):
    """Eq. 7 of the thesis without the bias of least squares: instruments come from a model that runs freely.

    It takes each sample once (`mmt_drake.estimation.recursive.instrumental_step`); when that is done is said by
    `Learning`. The ports are those of `OutputErrorEstimator`, and so is the gate that checks what comes in.

    .. pydrake_system::

        name: InstrumentalEstimator
        input_ports:
        - measurement
        - in_contact
        - reading
        - stamp
        output_ports:
        - theta
        - regrouped
        - stable
        - estimated_force
        - filtered_force
        - deviation
        - status
        - held_body
        - readout

    Inputs: `measurement` (9), the probe's position [m], velocity [m/s] and the force on it [N] in the table frame;
    `in_contact` (1), 0.0 or 1.0; `reading` (3), what the force sensor itself says [N] where the force has been made of
    it and of other things (`ProbeCompensation`), since only there is it seen to saturate or freeze; the measured force
    where it is not connected. They may be NaN, frozen, saturated, repeated or late: see `status`. `stamp` (1) [s]: when
    the operator sent the motion that the probe follows now, by the operator's clock; the Context's time where it is not
    connected.

    Outputs, all of them states, hence one step younger than the inputs:

    - `theta` (10): m [kg], k1, k2 [N/m], b1, b2 [N s/m], Fc [N], normal k [N/m], normal b [N s/m], Fs [N], v_d [m/s];
      the prior until there is an estimate. Always physical and stable.
    - `regrouped` (7): a ... g of eq. 7 that belong to theta.
    - `stable` (1): 1.0 where theta can be rendered, which is always: the prior can, and so whoever renders it knows
      where the object was before the first touch.
    - `estimated_force` (3) [N]: of the model, which runs freely along the measured motion; zero out of contact.
    - `filtered_force` (3) [N]: the latest measured force that was believed, not filtered; what `estimated_force` is
      held against.
    - `deviation` (10): standard deviations of theta, in its units [kg, N/m, N s/m, N, m/s]; where the motion does not
      excite a parameter, that of the prior.
    - `status` (1): counts of `mmt_drake.estimation.output_error.gate.Status`: 0 learning, 1 free, from 2 on what is
      wrong with the input, told for 0.1 s at least; 8 while learning beside the clock fails or does not end.
    - `held_body` (6) [m], [s]: zeros; where friction holds the body is told by `OutputErrorEstimator` alone.
    - `readout` (41 and the memory, whose size depends on the options): the eight above in that order, then the memory.

    Args:
        options: `InstrumentalOptions`; `step` is the period of the discrete update.
        worker: learn in a thread, see `Learning`.
    """

    def __init__(self, options: InstrumentalOptions | None = None, *, worker: bool = False) -> None:
        super().__init__()
        self._learning = Learning(
            self, InstrumentalLearner(InstrumentalOptions() if options is None else options), worker
        )
