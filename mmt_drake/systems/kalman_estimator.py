"""A Kalman filter over the object's motion and its parameters, as a system."""

from __future__ import annotations

from pydrake.systems.framework import LeafSystem

from mmt_drake.estimation.recursive.kalman import KalmanLearner
from mmt_drake.estimation.recursive.options import KalmanOptions
from mmt_drake.systems.learning import Learning


class KalmanEstimator(LeafSystem):
    """An extended Kalman filter whose prediction is the plant itself, stick and slip included.

    It takes each sample once (`mmt_drake.estimation.recursive.kalman_step`); when that is done is said by
    `Learning`. The gate that checks what comes in is that of `OutputErrorEstimator`.

    .. pydrake_system::

        name: KalmanEstimator
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
        options: `KalmanOptions`; `step` is the period of the discrete update.
        worker: learn in a thread, see `Learning`.
    """

    def __init__(self, options: KalmanOptions | None = None, *, worker: bool = False) -> None:
        super().__init__()
        self._learning = Learning(self, KalmanLearner(KalmanOptions() if options is None else options), worker)
