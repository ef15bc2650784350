"""What the experiment on carried objects says of its runs, and that no adversary gets energy out."""

import math

import pytest

from mmt_drake.diagrams.proof.experiments.carrying import (
    ADVERSARIES,
    KINDS,
    SIGNALS,
    CarryingCase,
    report_of,
    run_adversary,
    run_case,
    tasks_of,
)
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.errors import BadInput

GOOD = CarryingCase(0, "own, 0 ms", 0.02, 0.2, 0.004, 0.02, None, 1e-6, 0.2)


def test_a_report_counts_what_is_missed() -> None:
    bad = CarryingCase(0, "foreign, 0 ms", 0.06, 0.2, 0.03, 0.04, math.inf, 2e-5, 0.5)
    assert all(reached.reached is not False for reached in report_of([GOOD]).reached)
    assert not any(reached.reached for reached in report_of([bad]).reached)
    assert "1 of 2 runs and 0 adversaries" in report_of([GOOD, bad]).sentences[0]
    assert "0 of 1 slips" in report_of([GOOD, bad]).sentences[1]


def test_each_draw_has_every_kind_and_its_adversaries() -> None:
    assert len(tasks_of(2, seed=0)) == 2 * (len(KINDS) + ADVERSARIES)
    masses = {kind.scenario(1, 0).environment.object.parameters.m for kind in KINDS}
    assert len(masses) == 1 and masses != {0.3}


def test_no_adversary_gets_out_more_than_it_has_put_in() -> None:
    cases = [run_adversary(number, 3) for number in range(30)]
    assert {case.kind.rsplit(" ", 1)[1] for case in cases} == set(SIGNALS)
    assert max(case.given for case in cases) <= 1e-5
    assert max(case.given for case in cases) > 0.0  # the overdraft is used: they try


def test_a_weak_grip_slips_and_that_is_told() -> None:
    case = run_case(0, KINDS[-2], 0)
    assert case.slip_s is not None and case.slip_s <= 0.03
    assert case.given <= 1e-5


@pytest.mark.parametrize(
    ("change", "at"),
    [
        ("environment.surface=!Sphere {}", "environment.surface"),
        ("learner={}", "learner"),
        ("renderer=!DirectForce {}", "renderer"),
        ("carrying.opens=3.0", "carrying"),
        ("carrying.hang.centre=0.0", "centre"),
        ("carrying.grip=-1", "grip"),
    ],
)
def test_what_is_not_carried_is_refused(change: str, at: str) -> None:
    with pytest.raises(BadInput, match=at):
        load_scenario("setup1-carrying", [change])
