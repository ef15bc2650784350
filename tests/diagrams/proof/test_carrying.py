"""What the experiment on carried objects says of its runs, and that no adversary gets energy out."""

import math

from mmt_drake.diagrams.proof.experiments.carrying import (
    ADVERSARIES,
    CASES,
    KINDS,
    SIGNALS,
    CarryingCase,
    run_adversary,
    run_case,
)

GOOD = CarryingCase(0, "own, 0 ms", 0.02, 0.2, 0.004, 0.02, None, 1e-6, 0.2)


def test_a_report_counts_what_is_missed() -> None:
    bad = CarryingCase(0, "foreign, 0 ms", 0.06, 0.2, 0.03, 0.04, math.inf, 2e-5, 0.5)
    assert all(reached.reached is not False for reached in CASES.report([GOOD]).reached)
    assert not any(reached.reached for reached in CASES.report([bad]).reached)
    assert "1 of 2 runs and 0 adversaries" in CASES.report([GOOD, bad]).sentences[0]
    assert "0 of 1 slips" in CASES.report([GOOD, bad]).sentences[1]


def test_each_draw_has_every_kind_and_its_adversaries() -> None:
    assert len(CASES.tasks(2, 0)) == 2 * (len(KINDS) + ADVERSARIES)
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
