"""The refined instrumental variable on the thesis's regressors, as a system."""

from __future__ import annotations

from pydrake.systems.framework import LeafSystem

from mmt_drake.estimation.recursive.instrumental import InstrumentalLearner
from mmt_drake.estimation.recursive.options import InstrumentalOptions
from mmt_drake.systems.learning import Learning


class InstrumentalEstimator(LeafSystem):
    """Eq. 7 of the thesis without the bias of least squares: instruments come from a model that runs freely.

    It takes each sample once (`mmt_drake.estimation.recursive.instrumental_step`); when that is done is said by
    `Learning`. The gate that checks what comes in is that of `OutputErrorEstimator`.

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

    Ports: those of `OutputErrorEstimator`, which says more of each; what it puts out are states, one step younger than
    what comes in.

    - `measurement` (9) [m], [m/s], [N]; `in_contact` (1), 0 or 1; `reading` (3) [N] and `stamp` (1) [s], which may stay
      unconnected: in.
    - `theta` (10) [kg], [N/m], [N s/m], [N], [m/s], `regrouped` (7), eq. 7, `stable` (1), 0 or 1, `estimated_force` (3)
      [N], `filtered_force` (3) [N], `deviation` (10), in the units of theta [kg] and so on, `status` (1), counts of
      `mmt_drake.estimation.output_error.places.Status`: out.
    - `held_body` (6) [m], [s]: zeros; where friction holds the body is told by `OutputErrorEstimator` alone.
    - `readout` (41 and the memory, whose size depends on the options): all that is put out, then the memory.

    Args:
        options: `InstrumentalOptions`; `step` is the period of the discrete update.
        worker: learn in a thread, see `Learning`.
    """

    def __init__(self, options: InstrumentalOptions | None = None, *, worker: bool = False) -> None:
        super().__init__()
        self._learning = Learning(
            self, InstrumentalLearner(InstrumentalOptions() if options is None else options), worker
        )
