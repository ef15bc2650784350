"""The estimator whose model runs freely, as a system."""

from functools import lru_cache

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, State

from mmt_drake.closing import Closing
from mmt_drake.errors import BadInput, MmtError
from mmt_drake.estimation.output_error.beside import FitProcess
from mmt_drake.estimation.output_error.gate import drop_laws, hand_over, initial_readout, settings, take_samples, tick
from mmt_drake.estimation.output_error.knowledge import Knowledge
from mmt_drake.estimation.output_error.layout import PORT_SIZES, STATUS, LearningSettings, Status
from mmt_drake.estimation.output_error.learn import Learner
from mmt_drake.estimation.output_error.options import OutputErrorOptions, check_told
from mmt_drake.model.message_layout import MESSAGE_NUMBER
from mmt_drake.model.scene_layout import AGE, HEIGHT, SCENE_SIZE, row_of
from mmt_drake.model_message import ModelMessage
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.kernel_system import KernelSystem

_PATIENCE = 1.0
"""How long a fit beside the clock may take before that is reported [s]."""


class OutputErrorEstimator(KernelSystem, Closing):
    """Least squares of the free-running force over a moving window and a prior (`mmt_drake.estimation.output_error`).

    Every tick a sample is checked and joins the next sample of the fit; once a period a fit takes a step from where the
    one before ended. What a fit finds from the samples until t is put out `OutputErrorOptions.latency` later, be it
    computed in an instant or, with `worker`, beside the clock: two runs give the same numbers, and so does a worker
    that keeps up.

    .. pydrake_system::

        name: OutputErrorEstimator
        input_ports:
        - measurement
        - in_contact
        - reading
        - stamp
        - model
        - thing
        - scene
        output_ports:
        - theta
        - regrouped
        - stable
        - estimated_force
        - filtered_force
        - deviation
        - status
        - held_body
        - model_status
        - residual_ratio
        - force_lateness
        - model
        - thing
        - readout

    Inputs: `measurement` (9), the probe's position [m], velocity [m/s] and the force on it [N] in the table frame;
    `in_contact` (1), 0.0 or 1.0; `reading` (3), what the force sensor itself says [N] where the force has been made of
    it and of other things (`ProbeCompensation`), since only there is it seen to saturate or freeze; the measured force
    where it is not connected. They may be NaN, frozen, saturated, repeated or late: see `status`. `stamp` (1) [s]: when
    the operator sent the motion that the probe follows now, by the operator's clock; the Context's time where it is not
    connected. `model` (44): the message [SI] whose laws act beside theta (`mmt_drake.model_message`); a later one
    takes the place of the last, and of `effects` of the options. It is read once a period. What it says that the force
    sensor adds is taken off the measured force along x and y, a lag is where the fit of `force_lateness` begins.
    `thing` (1) [1]: which of several objects the probe is at, by its identity, 0 where nobody knows, and `scene` (72)
    [SI], what is seen of them (`mmt_drake.model.scene_layout`): each then has a theta of its own, which is taken up
    again when it is met again.

    Outputs, all of them states, hence one step younger than the inputs:

    - `theta` (10): m [kg], k1, k2 [N/m], b1, b2 [N s/m], Fc [N], normal k [N/m], normal b [N s/m], Fs [N], v_d [m/s];
      the prior until there is an estimate. Always physical and stable.
    - `regrouped` (7): a ... g of eq. 7 that belong to theta.
    - `stable` (1): 1.0 where theta can be rendered, which is always: the prior can, and so whoever renders it knows
      where the object was before the first touch.
    - `estimated_force` (3) [N]: of the model, which runs freely along the measured motion; zero out of contact.
    - `filtered_force` (3) [N]: the latest measured force that was believed, not filtered, less what the sensor is told
      to add; what `estimated_force` is
      held against.
    - `deviation` (10): standard deviations of theta, in its units [kg, N/m, N s/m, N, m/s]; where the motion does not
      excite a parameter, that of the prior.
    - `status` (1): counts of `mmt_drake.estimation.output_error.layout.Status`: 0 learning, 1 free, from 2 on what is
      wrong with the input, shown for 0.1 s at least; 8 while learning beside the clock fails or does not end.
    - `held_body` (7): where friction holds the body with theta (`mmt_drake.model.held_body`): position and anchor of
      the contact spring [m] and `stamp` of the sample [s], along x and then y; as it was when last held in contact.
      Behind them [s] of which sample the anchors are: the latest in contact.
    - `model_status` (1): 0 where the model explains the force, 1 it does not, 2 the object is another one than before
      and what was known is forgotten, 3 the motion does not tell every number
      (`mmt_drake.estimation.output_error.adequacy.ModelStatus`). Learning goes on whatever it is.
    - `residual_ratio` (1): what the latest fit leaves of the latest half second of contact, over the noise of the
      force [1].
    - `force_lateness` (6): by how much the measured force is later than the motion: its delay, the time constant of a
      first-order low pass, and their sum, which slow motion tells alone, 50 ms at most; then the standard deviations of
      these [s], too small for a time constant below some 2 ms.
      `estimated_force` is that of the object, which is not late.
    - `model` (44): the message that theta goes with [SI]; zeros without laws.
    - `thing` (1): identity of the object that theta is of [1]; 0: nobody has said.
    - `readout` (51, a message and the memory, whose size depends on the options): the thirteen above in that order,
      then the memory.

    Attributes:
        fits: the process that makes them; None: they are made in the run.

    Args:
        options: `OutputErrorOptions`; `step` is the period of the discrete update.
        worker: compute fits in a process of their own, for a run in real time. A fit that is not done in time is handed
            over with the next period; one that fails is left out, and the next samples are tried. The Context then is
            not all there is, and must not be cloned.
        waits: with `worker`, for a run by simulated time: wait for a fit that is not done in time. One that fails ends
            the run with an `MmtError`.
    """

    def __init__(self, options: OutputErrorOptions | None = None, *, worker: bool = False, waits: bool = False) -> None:
        super().__init__()
        chosen = OutputErrorOptions() if options is None else options
        self._settings: LearningSettings = settings(chosen)
        self._learner = learner = Learner(chosen)
        # It begins now: in the run it would take the loop's priority and processor.
        self.fits = FitProcess(chosen, waits=waits) if worker else None
        self._begun, self._no_fit, self._retold, self._met, self._waits = 0.0, False, 0.0, 0, waits
        known = learner.beginning()
        self._told = known.told
        initial = initial_readout(self._settings, known)
        may_be_left = "reading", "stamp", "model", "thing", "scene"
        self.declare_inputs("measurement", "in_contact", *may_be_left, optional=may_be_left)
        self.declare_state_readout(PORT_SIZES, initial, chosen.step)
        self._knowledge = self.DeclareAbstractState(AbstractValue.Make(known))
        # Half-way between ticks: multiples of two periods that should coincide differ in their last bit now and then.
        first = chosen.latency - 0.5 * chosen.step
        self.DeclarePeriodicUnrestrictedUpdateEvent(chosen.latency, first, self._learn)
        row_of(np.zeros(SCENE_SIZE), 0.0)  # compiled before the clock starts, as all else
        self.compile_kernels()
        if self.fits is None:
            learner.compile()

    def close(self) -> None:
        """End the process of the fits, if there is one; may be called again."""
        if self.fits is not None:
            self.fits.close()

    def _step(self, t: float, readout: Array, *inputs: Array) -> None:
        measurement, contact, reading, stamp, model, *_ = inputs
        reading = measurement[6:] if reading is None else reading
        given = measurement, reading, contact[0], t, t if stamp is None else stamp[0], readout, self._settings
        try:
            tick(*given)
        except RuntimeError:  # of laws that are too fast: the run goes on without them, and this sample
            drop_laws(readout)
            readout[STATUS] = Status.NO_FIT
        if self._no_fit:
            readout[STATUS] = Status.NO_FIT
        if model is not None and _refused(model.tobytes()):
            readout[STATUS] = Status.NO_MODEL

    def _learn(self, context: Context, state: State) -> None:
        if self.fits is not None:
            self._take_up(self.fits, context, state)
            return
        known: Knowledge = context.get_abstract_state(self._knowledge).get_value()
        readout = state.get_mutable_discrete_state().get_mutable_value()
        hand_over(readout, known.told)
        met = self._learner.met(known, *self._thing_at(context))
        if met is not known:
            known = met
            hand_over(readout, known.told)
        if (model := self._model_at(context)) is not None:
            known = self._learner.retold(known, model)
        known = self._learner.learned(known, *take_samples(readout, self._settings))
        state.get_mutable_abstract_state(int(self._knowledge)).set_value(known)

    def _model_at(self, context: Context) -> Array | None:
        """The message that there is; None: there is none that could be taken up."""
        model: Array | None = self.inputs_at(context)[-3]
        return None if model is None or _refused(model.tobytes()) else model.copy()

    def _thing_at(self, context: Context) -> tuple[int, tuple[float, ...]]:
        """Which object the probe is at, and what it looks like; 0: nobody knows."""
        thing, scene = self.inputs_at(context)[-2:]
        row = -1 if thing is None or scene is None else row_of(scene, thing[0])
        if row < 0:
            return 0, ()
        return int(thing[0]), tuple(scene[row + HEIGHT : row + AGE].tolist())

    def _take_up(self, beside: FitProcess, context: Context, state: State) -> None:
        """Hand over the fit that is done, if any, and have the next one made."""
        beside.wait_until_ready()
        failed, t = False, context.get_time()
        if beside.under_way:
            if not beside.is_done():
                self._no_fit |= t - self._begun > _PATIENCE
                return
            failed = not self._taken_from(beside)
        thing, looks = self._thing_at(context)
        if thing not in (0, self._met):
            self._met = thing
            failed |= not beside.met(thing, looks) or (self._waits and not self._taken_from(beside))
        readout = state.get_mutable_discrete_state().get_mutable_value()
        hand_over(readout, self._told)
        samples, broken = take_samples(readout, self._settings)
        self._begun = t
        if (model := self._model_at(context)) is not None and model[MESSAGE_NUMBER] > self._retold:
            self._retold = model[MESSAGE_NUMBER]
            failed |= not beside.retell(model)
        self._no_fit = not beside.submit(samples, broken or failed) or failed

    def _taken_from(self, beside: FitProcess) -> bool:
        told = beside.result()
        if told is None and self._waits:
            raise MmtError("estimator: a fit failed, or the process for its fits has ended")
        self._told = self._told if told is None else told
        return told is not None


@lru_cache(maxsize=64)
def _refused(model: bytes) -> bool:
    """Whether a message in bytes is not to be taken up; zeros are none, and refused by nobody."""
    try:
        message = ModelMessage.from_vector(np.frombuffer(model))
        if message is not None:
            check_told(message, "model message")
    except BadInput:
        return True
    return False
