"""What the experiment on learned laws says of its runs."""

import pytest

from mmt_drake.diagrams.proof.experiments.learning import CASES, KINDS, LAWS, LearningCase, LearningKind
from mmt_drake.estimation.output_error.options import check_side_by_side
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.model_message import ModelMessage, ToldEffect

CUBIC = LearningCase(0, "a", ("nonlinear_stiffness",), "own", ("nonlinear_stiffness",), (), 27.0, 0.06, 0.001)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.label)
def test_every_object_is_one_that_a_station_can_have(kind: LearningKind) -> None:
    first, second = (kind.scenario(number, seed=0) for number in (0, 1))
    assert first.environment.object.theta()[0] == 1.0 != second.environment.object.theta()[0]
    assert (kind.plant == "foreign") == (type(first.environment).__name__ == "ForeignBox")


def test_every_law_is_one_that_may_be_felt() -> None:
    theta = FlexibleBoxModel(BoxParameters(m=1.0, k2=500.0, b1=60.0, b2=60.0, Fc=0.5)).theta()
    for name, values in LAWS.items():
        told = ToldEffect(name, dict(values))
        assert ModelMessage(tuple(map(float, theta)), (told,)).acting
        check_side_by_side([told], "test")


def test_a_report_counts_laws_that_came_in_time_and_wrong_ones() -> None:
    late = LearningCase(1, "a", ("nonlinear_stiffness",), "own", ("nonlinear_stiffness",), (), 41.0, 0.06, 0.02)
    wrong = LearningCase(0, "b", (), "foreign", (), ("hysteresis",), None, 0.01, None)
    report = CASES.report([CUBIC, late, wrong])
    assert [(r.target.figure, r.value, r.reached) for r in report.reached] == [
        ("laws that did not enter in time", 0.5, False),
        ("runs in which a wrong law was told", pytest.approx(1 / 3), False),
        ("rendered force after the laws have entered, at worst", 0.02, False),
    ]
    assert "Of 2 objects with a law that is felt" in report.sentences[0] and "in 1 of 3 runs" in report.sentences[0]
    assert [r.reached for r in CASES.report([CUBIC]).reached] == [True, True, True]


def test_each_draw_has_every_kind() -> None:
    assert len(CASES.tasks(2, 0)) == 2 * len(KINDS)
