"""The learner as a system: it asks when the numbers leave too much, and tells when the answer is due."""

import os
import pickle
import time
from collections.abc import Iterator

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from mmt_drake.errors import MmtError
from mmt_drake.learner_status import LearnerStatus
from mmt_drake.learning import beside, law_learner
from mmt_drake.learning.answer import ROW, LookResult
from mmt_drake.learning.beside import Looks, Question
from mmt_drake.learning.law_learner import LawLearner
from mmt_drake.learning.left import Left
from mmt_drake.learning.options import Learning
from mmt_drake.model.parameters import THETA
from mmt_drake.model_message import ModelMessage, ToldEffect
from mmt_drake.numeric.arrays import Array

NUMBERS = (1.0, 0.0, 500.0, 60.0, 60.0, 0.5, 500.0, 60.0, 0.5, 0.0)
CUBIC = ToldEffect("nonlinear_stiffness", {"k3": 3e6})
NAMED = LookResult("missing_physics", (CUBIC,), NUMBERS)
OPTIONS = Learning(window=3.0, delay=2.0)


class Answering(Looks):
    """Answers the same whatever is asked, when it may."""

    def __init__(self) -> None:
        self.asked: list[Question] = []
        self.may, self.closed, self.found = True, False, NAMED

    def close(self) -> None:
        self.closed = True

    def ask(self, question: Question) -> None:
        self.asked.append(question)

    def is_answered(self, question: Question) -> bool:
        return self.may

    def answer(self, question: Question, *, here: bool) -> LookResult | None:
        return self.found


@pytest.fixture
def looks(monkeypatch: pytest.MonkeyPatch) -> Iterator[Answering]:
    answering = Answering()
    monkeypatch.setattr(law_learner, "Looks", lambda idle: answering)
    yield answering


def felt(learner: LawLearner, until: float, left: float = 9.0, contact: float = 1.0) -> tuple[float, Array]:
    """Status and message at a time, of a contact of which the numbers leave so much over its noise."""
    simulator = Simulator(learner)
    context = simulator.get_mutable_context()
    values = {"measurement": np.zeros(9), "in_contact": contact, "theta": NUMBERS, "model_status": 1.0}
    for name, value in {**values, "residual_ratio": left}.items():
        learner.GetInputPort(name).FixValue(context, np.atleast_1d(value))
    simulator.AdvanceTo(until)
    return learner.GetOutputPort("status").Eval(context)[0], learner.GetOutputPort("model").Eval(context).copy()


def test_what_is_named_is_told_after_the_declared_delay(looks: Answering) -> None:
    status, model = felt(LawLearner(OPTIONS), 3.2)
    assert status == LearnerStatus.LOOKING and not model.any() and len(looks.asked) == 1
    question = looks.asked[0]
    assert sum(map(len, question.pieces)) == 1500 and question.sample == 0.002 and question.left == Left(9.0)
    status, model = felt(LawLearner(OPTIONS), 3.0 + 2.0 + 0.3)
    assert status == LearnerStatus.TOLD
    assert ModelMessage.from_vector(model) == ModelMessage(NUMBERS, (CUBIC,))


@pytest.mark.parametrize(("left", "contact"), [(1.2, 1.0), (9.0, 0.0)])
def test_nothing_is_asked_where_the_numbers_explain_the_contact_or_there_is_none(
    looks: Answering, left: float, contact: float
) -> None:
    status, model = felt(LawLearner(OPTIONS), 8.0, left, contact)
    assert status == LearnerStatus.WATCHING and not model.any() and not looks.asked


def test_beside_the_clock_an_answer_is_told_when_it_comes(looks: Answering) -> None:
    looks.may = False
    status, _ = felt(LawLearner(OPTIONS, worker=True), 8.0)
    assert status == LearnerStatus.LOOKING
    looks.may = True
    status, _ = felt(LawLearner(OPTIONS, worker=True), 3.5)
    assert status == LearnerStatus.TOLD


def test_the_first_message_is_told_from_the_beginning(looks: Answering) -> None:
    first = ModelMessage(NUMBERS, (CUBIC,))
    _, model = felt(LawLearner(OPTIONS, first=first), 0.2, left=1.0)
    assert ModelMessage.from_vector(model) == first


def test_samples_that_are_not_finite_are_in_no_window(looks: Answering) -> None:
    learner = LawLearner(OPTIONS)
    simulator = Simulator(learner)
    context = simulator.get_mutable_context()
    for name, value in {"in_contact": 1.0, "theta": NUMBERS, "model_status": 1.0, "residual_ratio": 9.0}.items():
        learner.GetInputPort(name).FixValue(context, np.atleast_1d(value))
    for until, position in ((2.0, 0.0), (2.1, np.nan), (4.0, 0.0)):
        learner.GetInputPort("measurement").FixValue(context, np.full(9, position))
        simulator.AdvanceTo(until)
    assert not looks.asked, "there were 3 s of contact, and no 3 s without a break"


def test_its_process_is_closed_with_it(looks: Answering) -> None:
    LawLearner(OPTIONS).close()
    assert looks.closed


def test_a_process_answers_what_it_is_asked_and_ends() -> None:
    looks = Looks()
    still = Question((np.zeros((1500, ROW)),), 0.002, np.array(NUMBERS), 3.0, Left(9.0))
    looks.ask(still)
    until = time.monotonic() + 120.0
    while not looks.is_answered(still) and time.monotonic() < until:
        time.sleep(0.05)
    answer = looks.answer(still, here=False)
    assert answer is not None and answer.verdict == "insufficient_data" and not answer.settled
    assert looks.answer(still, here=False) is answer, "of a run that is repeated"
    looks.close()
    looks.ask(unknown := Question(still.pieces, 0.002, still.theta, 4.0, Left(9.0)))
    assert looks.is_answered(unknown) and looks.answer(unknown, here=False) is None


@pytest.mark.skipif(not hasattr(os, "SCHED_IDLE"), reason="no such policy here")
@pytest.mark.parametrize("idle", [False, True])
def test_in_real_time_a_look_works_when_nobody_else_does(idle: bool) -> None:
    with Looks(idle=idle) as looks:
        policy = os.sched_getscheduler(looks._own.process.pid)
    assert policy == (os.SCHED_IDLE if idle else os.SCHED_OTHER)


def test_who_knows_no_answer_of_a_process_finds_the_same_here() -> None:
    still = Question((np.zeros((1500, ROW)),), 0.002, np.array(NUMBERS), 3.0, Left(9.0))
    with Looks() as looks:
        found = looks.answer(still, here=True)
    assert found == beside._answered(*still.wording)


def test_an_answer_crosses_the_line_whole() -> None:
    assert pickle.loads(pickle.dumps(NAMED)) == NAMED
    assert len(NUMBERS) == len(THETA)


def test_a_process_that_cannot_begin_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(beside, "own_files", lambda _: ["/there/is/no/such.py"])
    with pytest.raises(MmtError, match="learner: the process for its looks did not begin"):
        Looks()
