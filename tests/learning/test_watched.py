"""What a learner asks, tells and takes back, by what it has seen and what was answered."""

from dataclasses import replace

import numpy as np
import pytest

from mmt_drake.learner_status import LearnerStatus
from mmt_drake.learning.answer import FREE_S, ROW, LookResult
from mmt_drake.learning.beside import Question
from mmt_drake.learning.left import Left
from mmt_drake.learning.options import Learning
from mmt_drake.learning.watched import Piece, Watched, left_of
from mmt_drake.model_message import NO_ERROR, UNKNOWN_THETA, ModelMessage, SensorError, ToldEffect

OPTIONS = Learning(window=3.0)
BIAS = SensorError(bias=0.4)
SAMPLE = 0.01
WINDOW = round(OPTIONS.window / SAMPLE)
FREE = round(FREE_S / SAMPLE)
REACH = WINDOW // 4
CUBIC = ToldEffect("nonlinear_stiffness", {"k3": 3e6})
DEEPER = ToldEffect("normal_nonlinear_stiffness", {"k3": 2e7})
NUMBERS = (1.0, 0.0, 500.0, 60.0, 60.0, 0.5, 500.0, 60.0, 0.5, 0.0)
NAMED = LookResult("missing_physics", (CUBIC,), NUMBERS)
EXPLAINED = LookResult("parameters", (), NUMBERS)


def piece(count: int, left: float, contact: float = 1.0) -> Piece:
    rows = np.zeros((count, ROW))
    rows[:, -1] = contact
    return Piece.of(rows, left)


def asked(left: float = 9.0, normal: float = 1.0, **known: object) -> Watched:
    """A learner that has asked of a contact of which the numbers leave so much, over its noise."""
    seen = replace(Watched(), **known).seeing(piece(WINDOW, left), SAMPLE, OPTIONS)
    rows = tuple(one.rows for one in seen.pieces)
    return seen.asking(Question(rows, SAMPLE, np.array(NUMBERS), 3.0, Left(left, normal)))


def test_a_window_holds_the_contact_that_is_asked_for_and_the_free_motion_within() -> None:
    seen = Watched().seeing(piece(10, 1.0), SAMPLE, OPTIONS).seeing(piece(WINDOW - 1, 1.0), SAMPLE, OPTIONS)
    assert len(seen.window(SAMPLE, OPTIONS)) == 2
    seen = seen.seeing(piece(50, 5.0, contact=0.0), SAMPLE, OPTIONS).seeing(piece(1, 9.0), SAMPLE, OPTIONS)
    window = seen.window(SAMPLE, OPTIONS)
    assert window == seen.pieces[1:]
    assert left_of(window) == 1.0, "the median of the contact's later half"
    assert replace(seen, windows=2).window(SAMPLE, OPTIONS) == ()


def flags(window: tuple[Piece, ...]) -> list[float]:
    """Contact of each sample of a window."""
    return np.concatenate([one.rows[:, -1] for one in window]).tolist()


@pytest.mark.parametrize(("free", "with_it"), [(FREE - 1, 0), (FREE, FREE)])
def test_a_window_begins_with_the_free_space_right_before_its_contact_if_that_is_enough(
    free: int, with_it: int
) -> None:
    seen = Watched().seeing(piece(WINDOW, 1.0), SAMPLE, OPTIONS)
    seen = seen.seeing(piece(free, 1.0, contact=0.0), SAMPLE, OPTIONS).seeing(piece(WINDOW, 1.0), SAMPLE, OPTIONS)
    assert flags(seen.window(SAMPLE, OPTIONS)) == [0.0] * with_it + [1.0] * WINDOW


def test_free_space_within_the_first_piece_counts() -> None:
    first = np.zeros((5 + WINDOW, ROW))
    first[5:, -1] = 1.0
    seen = Watched().seeing(piece(FREE - 5, 1.0, contact=0.0), SAMPLE, OPTIONS)
    seen = seen.seeing(Piece.of(first, 1.0), SAMPLE, OPTIONS)
    assert flags(seen.window(SAMPLE, OPTIONS)) == [0.0] * FREE + [1.0] * WINDOW


@pytest.mark.parametrize(("earlier", "from_touch"), [(REACH, True), (REACH + 1, False)])
@pytest.mark.parametrize("free", [3, FREE])
def test_a_window_begins_with_the_touch_where_that_is_not_long_ago(earlier: int, from_touch: bool, free: int) -> None:
    mixed = np.zeros((5 + free + earlier, ROW))  # the end of another contact, free space, a touch
    mixed[:5, -1] = mixed[5 + free :, -1] = 1.0
    seen = Watched().seeing(piece(WINDOW, 1.0), SAMPLE, OPTIONS).seeing(Piece.of(mixed, 1.0), SAMPLE, OPTIONS)
    seen = seen.seeing(piece(WINDOW, 1.0), SAMPLE, OPTIONS)
    before = ([0.0] * free if free == FREE else []) + [1.0] * earlier if from_touch else []
    assert flags(seen.window(SAMPLE, OPTIONS)) == before + [1.0] * WINDOW


def test_what_is_kept_is_bounded() -> None:
    seen = Watched()
    for _ in range(40):
        seen = seen.seeing(piece(WINDOW, 1.0), SAMPLE, OPTIONS)
    assert len(seen.pieces) == 12


def test_laws_that_are_named_are_told_with_their_numbers() -> None:
    told = asked().answered(NAMED, doubtful=True)
    assert told.message == ModelMessage(NUMBERS, (CUBIC,), number=1)
    assert told.status == LearnerStatus.TOLD and told.before == Left(9.0, 1.0) and not told.pieces


def test_what_the_force_sensor_adds_is_told_alone_and_leaves_as_laws_do() -> None:
    told = asked().answered(LookResult("missing_physics", (), NUMBERS, sensor=BIAS), doubtful=True)
    assert told.message == ModelMessage(NUMBERS, sensor=BIAS) and told.status == LearnerStatus.TOLD
    gone = told.judged(Left(5.0), OPTIONS)
    assert gone.message is not None and not any(gone.message.sensor) and not gone.tells


def test_another_object_has_a_greater_number() -> None:
    told = asked().answered(replace(NAMED, sensor=BIAS), doubtful=True)
    other = told.touching(True).touching(True)
    assert other.thing == 1
    assert other.message == ModelMessage(UNKNOWN_THETA, (CUBIC,), 1, 2, BIAS), "the sensor is the same"
    assert other.touching(False).touching(True).thing == 2
    assert Watched().touching(True).message is None


def test_another_object_keeps_those_laws_alone_that_may_be_felt_whatever_its_numbers_are() -> None:
    bristles = {"sigma0": 500.0, "sigma1": 0.0, "Fs": 0.5, "v_s": 1e-3}
    stiff = ToldEffect("presliding_friction", bristles)
    damped = ToldEffect("presliding_friction", {**bristles, "sigma1": 40.0, "Fs": 0.8})  # passive beside b1 = 60
    for law, kept in ((stiff, (stiff,)), (damped, ())):
        seen = Watched(message=ModelMessage(NUMBERS, (law, CUBIC))).touching(True)
        assert seen.message is not None and seen.message.number == 2
        assert seen.message.effects == (*kept, CUBIC)
        seen.message.vector()  # it can be told


def test_laws_do_not_enter_where_the_latest_contact_needs_none() -> None:
    told = asked().answered(NAMED, doubtful=False)
    assert told.message is None and told.status == LearnerStatus.WATCHING
    assert told.window(SAMPLE, OPTIONS), "and what was seen counts as soon as one does again"


@pytest.mark.parametrize(
    ("answer", "status"),
    [
        (LookResult("unexplained"), LearnerStatus.CANNOT_TELL),
        (LookResult("missing_physics", refused=("force_bias: ...",)), LearnerStatus.NOT_FELT),
        (None, LearnerStatus.FAILED),
    ],
)
def test_an_answer_that_settles_nothing_changes_nothing_and_more_is_looked_at_next(
    answer: LookResult | None, status: LearnerStatus
) -> None:
    first = ModelMessage(NUMBERS, (CUBIC,), number=4)
    told = asked(message=first).answered(answer, doubtful=True)
    assert told.message == first and told.status == status and told.windows == 2
    assert bool(told.pieces) == (answer is not None), "what was seen meanwhile counts the next time"


def test_laws_leave_when_a_later_look_does_without_them() -> None:
    told = asked(message=ModelMessage(NUMBERS, (CUBIC,), number=4)).answered(EXPLAINED, doubtful=True)
    assert told.message == ModelMessage(NUMBERS, number=5) and told.status == LearnerStatus.WATCHING


@pytest.mark.parametrize(
    ("before", "left", "stays"),
    [(9.0, 1.0, True), (9.0, 4.0, True), (9.0, 5.0, False), (2.1, 1.3, True), (2.1, 1.35, True), (2.1, 1.4, False)],
)
def test_laws_leave_when_more_than_half_is_left_with_them_beyond_noise(before: float, left: float, stays: bool) -> None:
    told = asked(before).answered(NAMED, doubtful=True).seeing(piece(WINDOW, left), SAMPLE, OPTIONS)
    judged = told.judged(Left(left), OPTIONS)
    assert bool(judged.laws) == stays and judged.before is None
    if not stays:
        assert judged.message is not None and judged.message.number == 2
        assert all(map(np.isnan, judged.message.theta)), "the estimator keeps its own numbers"
        assert judged.status == LearnerStatus.CANNOT_TELL and judged.windows == 2


@pytest.mark.parametrize(
    ("surface", "normal", "stay"),
    [
        (1.0, 6.0, (CUBIC,)),  # a rest without a name along the normal
        (6.0, 1.0, (DEEPER,)),
        (1.0, 1.0, (CUBIC, DEEPER)),
        (6.0, 6.0, ()),
    ],
)
def test_each_law_is_judged_by_what_is_left_along_its_own_axis(
    surface: float, normal: float, stay: tuple[ToldEffect, ...]
) -> None:
    both = replace(NAMED, laws=(CUBIC, DEEPER), sensor=BIAS)
    judged = asked(9.0, normal=9.0).answered(both, doubtful=True).judged(Left(surface, normal), OPTIONS)
    assert judged.laws == stay and judged.message is not None
    assert judged.message.sensor == (BIAS if CUBIC in stay else NO_ERROR)
    assert judged.status == (LearnerStatus.TOLD if stay else LearnerStatus.CANNOT_TELL)


def test_a_law_stays_beside_a_rest_along_the_other_axis_that_never_had_a_name() -> None:
    told = asked(9.0, normal=6.0).answered(NAMED, doubtful=True).judged(Left(1.0, 6.0), OPTIONS)
    assert told.laws == (CUBIC,) and told.before is None
