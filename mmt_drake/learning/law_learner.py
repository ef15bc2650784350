"""The learner, as a system."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, State

from mmt_drake.closing import Closing
from mmt_drake.errors import MmtError, attempt
from mmt_drake.estimation.output_error.adequacy import ModelStatus
from mmt_drake.learning.answer import ROW, LookResult
from mmt_drake.learning.beside import Looks, Question
from mmt_drake.learning.left import NOT_LATE, Left, left_along_normal
from mmt_drake.learning.options import Learning
from mmt_drake.learning.watched import Piece, Watched, left_of
from mmt_drake.model.message_layout import MESSAGE_SIZE
from mmt_drake.model_message import ModelMessage
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout
from mmt_drake.systems.kernel_system import KernelSystem
from mmt_drake.told_laws import NO_LAWS, told_by_bytes

_PERIOD = 0.25  # [s], at which a window is looked at: as rare a tick as may be, for it costs more than others
PORT_SIZES = {"model": MESSAGE_SIZE, "status": 1}
_next = Layout()
_MODEL, _STATUS = _next.part(MESSAGE_SIZE), _next()
_COUNT, _BROKEN, _TIME, _ROWS = _next(), _next(), _next(), _next(0)


class LawLearner(KernelSystem, Closing):
    """Names the physics that an estimator's numbers leave out, and tells it while it is felt (`mmt_drake.learning`).

    Where the estimator leaves more of a window of contact than its noise explains, or a spring and a damper along the
    normal do (`left_along_normal`), the diagnosis holds that window against the library of effects, in a process of its
    own. Laws that it names and that may be felt are told on `model`, with the numbers beside them, and what of the
    force is the sensor's. They leave again when they do not earn their place: when a window of contact with them leaves
    more than half of what it did without along their axis, beyond noise, or when a later look finds another answer.

    .. pydrake_system::

        name: LawLearner
        input_ports:
        - measurement
        - in_contact
        - theta
        - model_status
        - residual_ratio
        - force_lateness
        output_ports:
        - model
        - status
        - readout

    Inputs, the last four of an estimator beside it:

    - `measurement` (9): position [m], velocity [m/s] of the probe and force on it [N] in the table frame.
    - `in_contact` (1): 0.0 or 1.0.
    - `theta` (10): m [kg], k1, k2 [N/m], b1, b2 [N s/m], Fc [N], normal k [N/m], normal b [N s/m], Fs [N], v_d [m/s].
    - `model_status` (1): counts of `mmt_drake.estimation.output_error.adequacy.ModelStatus`.
    - `residual_ratio` (1): what theta leaves of the latest contact, over the noise of the force [1].
    - `force_lateness` (6): by how much the force is late, as an estimator tells it [s]. May stay
      unconnected, and then it is not late.

    Outputs, states, hence younger than the inputs:

    - `model` (44): the message that is told (`mmt_drake.model_message`) [SI]; zeros as long as there is none.
    - `status` (1): counts of `mmt_drake.learner_status.LearnerStatus`: 0 the numbers explain the contact, 1 a
      diagnosis is under way, 2 laws, or what the force sensor adds, are told, 3 what was found last is not to be felt,
      4 what is left has no name so far, 5 the diagnosis failed.
    - `readout` (45 and the memory): both, then the memory.

    Args:
        options: how it goes about it.
        step: between samples of its inputs [s].
        worker: for a run in real time: an answer is taken up when it comes. Otherwise it is taken up after
            `Learning.delay`, and waited for.
        first: the message that is told at first; None: none.

    Raises:
        MmtError: the process for its looks cannot be begun.
    """

    def __init__(
        self,
        options: Learning | None = None,
        *,
        step: float = 1e-3,
        worker: bool = False,
        first: ModelMessage | None = None,
    ) -> None:
        super().__init__()
        self._options = Learning() if options is None else options
        self._sample = max(1, round(self._options.sample / step)) * step
        self._worker, self._looks = worker, Looks(idle=worker)
        rows = 4 * round(_PERIOD / self._sample) + 1
        initial = np.zeros(_ROWS + rows * ROW)
        initial[_MODEL] = 0.0 if first is None else first.vector()
        of_estimator = "theta", "model_status", "residual_ratio", "force_lateness"
        self.declare_inputs("measurement", "in_contact", *of_estimator, optional=("force_lateness",))
        self.declare_state_readout(PORT_SIZES, initial, self._sample)
        begun = Watched(message=first)
        self._watched = self.DeclareAbstractState(AbstractValue.Make(begun))
        self.DeclarePeriodicUnrestrictedUpdateEvent(_PERIOD, _PERIOD - 0.5 * step, self._watch)
        self.compile_kernels()
        pressed = Piece.of(np.ones((rows, ROW)), 0.0)
        self._left_along_normal((pressed,), first, np.full(2, self._sample))  # it is slow the first time

    def close(self) -> None:
        """End the process of its looks; may be called again."""
        self._looks.close()

    def answered_by(self, looks: Looks) -> None:
        """Ask somebody else, before a run begins."""
        self._looks.close()
        self._looks = looks

    def _step(self, t: float, memory: Array, *inputs: Array) -> None:
        measurement, contact, *_ = inputs
        count = int(memory[_COUNT])
        row = _ROWS + count * ROW
        late = memory[_TIME] > 0.0 and t - memory[_TIME] > 1.5 * self._sample
        memory[_TIME] = t
        if row + ROW > len(memory) or late or not (np.isfinite(measurement).all() and np.isfinite(contact[0])):
            memory[_BROKEN], memory[_COUNT] = 1.0, 0.0
            return
        memory[row : row + ROW - 1], memory[row + ROW - 1] = measurement, contact[0]
        memory[_COUNT] = count + 1.0

    def _watch(self, context: Context, state: State) -> None:
        _, _, theta, model_status, left, late = self.inputs_at(context)
        memory = state.get_mutable_discrete_state().get_mutable_value()
        seen: Watched = context.get_abstract_state(self._watched).get_value()
        seen = seen.touching(model_status[0] == ModelStatus.CHANGED)
        if memory[_BROKEN] != 0.0:
            seen = seen.anew()
        rows = memory[_ROWS : _ROWS + int(memory[_COUNT]) * ROW].reshape(-1, ROW).copy()
        memory[_BROKEN] = memory[_COUNT] = 0.0
        seen = seen.seeing(Piece.of(rows, left[0]), self._sample, self._options)
        seen = self._gone_on(seen, context.get_time(), theta, left[0], NOT_LATE if late is None else late[:2])
        memory[_MODEL] = 0.0 if seen.message is None else seen.message.vector()
        memory[_STATUS] = seen.status
        state.get_mutable_abstract_state(int(self._watched)).set_value(seen)

    def _gone_on(self, seen: Watched, t: float, theta: Array, left: float, late: Array) -> Watched:
        """With the answer that is due, or with a question that is worth while."""
        options = self._options
        if (question := seen.question) is not None:
            due = self._looks.is_answered(question) if self._worker else t > question.asked + options.delay
            if not due:
                return seen
        window = seen.window(self._sample, options)
        of_contact = Left(left)
        if window:
            of_contact = Left(left_of(window), self._left_along_normal(window, seen.message, late))
        if question is not None:
            return seen.answered(self._answer(question), of_contact.doubts(options.doubt))
        if not window:
            return seen
        seen = seen.judged(of_contact, options)
        if not (of_contact.doubts(options.doubt) and seen.pieces):
            return seen
        question = Question(tuple(piece.rows for piece in window), self._sample, theta.copy(), t, of_contact)
        self._looks.ask(question)
        return seen.asking(question)

    def _left_along_normal(self, window: tuple[Piece, ...], message: ModelMessage | None, late: Array) -> float:
        rows = np.concatenate([piece.rows for piece in window])
        told = NO_LAWS if message is None else told_by_bytes(message.vector().tobytes())
        left = attempt(left_along_normal, rows, self._sample, told, late)
        return 0.0 if left is None else left  # a law too fast for the samples, of which nothing can be said

    def _answer(self, question: Question) -> LookResult | None:
        try:
            return self._looks.answer(question, here=not self._worker)
        except MmtError:  # looked for here: it is none that could be diagnosed
            return None
