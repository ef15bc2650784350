"""The force renderer: the operator's own copy of the object, integrated without waiting for the network."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput
from mmt_drake.model import flexible_box as box
from mmt_drake.model.parameters import KERNEL_SIZE, THETA, adopt_theta
from mmt_drake.systems.readout import declare_parts, frozen_zeros

Array = NDArray[np.float64]

_HELD = box.STATE_SIZE  # the latest stable theta, as a kernel vector
_KNOWN = _HELD + KERNEL_SIZE  # 1 once a stable theta has arrived
_MEMORY_SIZE = _KNOWN + 1

#: A model so stiff that it needs more substeps than this for one of the settings' own is not rendered.
_MOST_SUBSTEPS = 100

# The readout: the force, then the memory.
_MEMORY = 3
READOUT_SIZES = (_MEMORY, _MEMORY_SIZE)


@njit(cache=True)
def _render(
    memory: Array, t: float, motion: Array, theta: Array, stable: float, in_contact: float, max_step: float, out: Array
) -> None:
    """Bring the memory to time t with the operator at `motion`; write force and new memory to `out`."""
    now = out[_MEMORY:]
    now[:] = memory
    state, p = now[: box.STATE_SIZE], now[_HELD:_KNOWN]
    known = memory[_KNOWN] != 0.0
    if known:
        # What lies between the last update and now is integrated with the model as it was known then.
        box.advance(state, t, motion, in_contact, p)
    if stable != 0.0 and adopt_theta(theta, max_step, max_step / _MOST_SUBSTEPS, p) and not known:
        now[_KNOWN] = 1.0
        box.begin(state, t, motion, in_contact, p)
    box.force_on_probe(state, p, out[:_MEMORY])


class ImpedanceReflection(LeafSystem):
    """Force of the estimated object on the operator's probe (thesis, section 3.1.1 and D.4).

    An instance of the model of figure 3, driven by the operator's motion and integrated by a Runge-Kutta method of
    order 4 with that motion evaluated inside the step. Parameters are swapped in as they arrive, the body's position
    and velocity carrying over. While `in_contact` is 0 the model is free space, F = 0 (eq. 9); the body then moves on
    by itself, and the next touch starts with an unstretched contact spring. Contact is what the flag says and nothing
    else.

    Until the first stable, finite theta the force is zero; later ones that are not stable, or so stiff that they would
    need more than a hundred steps for one, are passed over and the latest good one is kept. Estimates scatter about
    zero: a negative Fc counts as no friction, since friction must not push; the other numbers are used as they come.

    .. pydrake_system::

        name: ImpedanceReflection
        input_ports:
        - motion
        - theta
        - stable
        - in_contact
        - point_cloud
        output_ports:
        - force
        - readout

    Ports (table frame):

    - `motion` (6): the operator's position [m] and velocity [m/s].
    - `theta` (8): m [kg], k1, k2 [N/m], b1, b2 [N s/m], Fc [N], normal_k [N/m], normal_b [N s/m].
    - `stable` (1): 1 where theta is an admissible, stable model (see `RlsEstimator`).
    - `in_contact` (1): 1 where the operator touches the object.
    - `point_cloud` (abstract, `Cloud`): not used; there so that renderers can be exchanged. May stay unconnected.
    - `force` (3): force on the operator's probe [N]; direct feedthrough from `motion`, so it is never a tick late.
    - `readout` (57): the force, then the system's memory (`READOUT_SIZES`).

    Args:
        period: of the updates [s].
        substeps: Runge-Kutta steps per update at least; stiff parameters may take more (`accurate_step`).

    Raises:
        BadInput: a period that is not positive or less than one substep.
    """

    def __init__(self, *, period: float = 1e-3, substeps: int = 1) -> None:
        super().__init__()
        if not (math.isfinite(period) and period > 0.0):
            raise BadInput("renderer", at="period", found=period, expected="a time above 0 s")
        if not (isinstance(substeps, int) and substeps >= 1):
            raise BadInput("renderer", at="substeps", found=substeps, expected="a whole number >= 1")
        # The margin keeps rounding from adding a substep.
        self._max_step = period / substeps * (1.0 + 1e-9)
        self._motion = self.DeclareVectorInputPort("motion", 6)
        self._theta = self.DeclareVectorInputPort("theta", len(THETA))
        self._stable = self.DeclareVectorInputPort("stable", 1)
        self._contact = self.DeclareVectorInputPort("in_contact", 1)
        self.DeclareAbstractInputPort("point_cloud", AbstractValue.Make(Cloud.empty()))
        self.DeclareDiscreteState(_MEMORY_SIZE)
        inputs = (self._motion, self._theta, self._stable, self._contact)
        sources = {self.time_ticket(), self.xd_ticket(), *(self.input_port_ticket(port.get_index()) for port in inputs)}
        declare_parts(self, {"force": 3}, lambda context: self._readout.Eval(context), sources)
        self._readout = self.DeclareVectorOutputPort("readout", sum(READOUT_SIZES), self._calc_readout, sources)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)
        # Compiles before the clock starts.
        out = np.zeros(sum(READOUT_SIZES))
        _render(frozen_zeros(_MEMORY_SIZE), 0.0, np.zeros(6), np.ones(8), 1.0, 1.0, self._max_step, out)

    def _calc_readout(self, context: Context, output: BasicVector) -> None:
        _render(
            context.get_discrete_state_vector().value(),
            context.get_time(),
            self._motion.Eval(context),
            self._theta.Eval(context),
            self._stable.Eval(context)[0],
            self._contact.Eval(context)[0],
            self._max_step,
            output.get_mutable_value(),
        )

    def _update(self, context: Context, state: DiscreteValues) -> None:
        state.get_mutable_value()[:] = self._readout.Eval(context)[_MEMORY:]
