"""The experiment on how sure the free-running estimator says it is."""

from mmt_drake.diagrams.proof.experiments.coverage import CASES, TOUCHED, CoverageCase, coverage_table, run_case


def test_of_an_object_under_reaches_the_truth_is_near_and_the_deviations_are_those_of_the_noise() -> None:
    case = run_case(0, "reaches", "own", 0)
    off = [value for values in case.off.values() for value in values if value is not None]
    over = [value for values in case.over_bound.values() for value in values if value is not None]
    assert set(case.off) == set(TOUCHED) and len(off) == len(over) >= 15
    assert max(map(abs, off)) < 4.0 and 0.8 < sorted(over)[len(over) // 2] < 3.0


def test_numbers_that_a_motion_does_not_tell_are_counted_apart() -> None:
    cases = [
        CoverageCase(
            0, "strokes", "own", {5.0: [None, 0.5, 2.5, -1.0, 0.0, -3.0]}, {5.0: [None, 1.0, 2.0, 4.0, 1.0, 1.0]}
        ),
        CoverageCase(1, "strokes", "foreign", {5.0: [1.0, 0.5, 0.5, -1.0, 0.0, 0.0]}, {}),
    ]
    row = coverage_table(cases).rows[0]
    assert row[:4] == ["own", 5.0, "m", 0] and row[-1] == 1
    report = CASES.report(cases)
    assert "60.0 % of 5 numbers" in report.sentences[0] and "100.0 % of 6" in report.sentences[1]
    missed = {(figure.case, figure.target.figure) for figure in report.reached if figure.reached is False}
    assert {case for case, _ in missed} == {"k2 after 5 s, own", "Fc after 5 s, own", "b1 after 5 s, own"}
