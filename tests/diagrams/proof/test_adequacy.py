"""The experiment on what the estimator says of its model."""

from pathlib import Path

from mmt_drake.diagrams.proof.experiments.adequacy import ADEQUATE, CASES, KINDS, AdequacyCase, adequacy_table
from mmt_drake.diagrams.proof.studies import Asked


def test_no_object_that_fits_is_doubted_and_every_other_is_noticed() -> None:
    cases = CASES.run(Asked(Path(), count=1))
    assert [case.kind for case in cases] == list(KINDS)
    for case in cases:
        assert (case.noticed_s is None) is (case.kind in ADEQUATE), case
        assert (case.error is not None) is (case.kind in ("k2 + 30 %", "mass doubled", "ground spring, 300 N/m"))
    assert next(case for case in cases if case.kind == "mass doubled").changed


def test_alarms_and_the_latest_notice_are_counted_over_all_objects() -> None:
    cases = tuple(AdequacyCase(0, kind, 0.4 if kind == "strokes, own" else 0.9, False, None) for kind in KINDS)
    assert [figure.value for figure in CASES.report(cases).reached] == [6.0, 0.9]
    quiet = tuple(AdequacyCase(0, kind, None, False, None) for kind in KINDS)
    alarms, noticed = CASES.report(quiet).reached
    assert alarms.value == 0.0 and alarms.reached and noticed.value is None and noticed.reached is False
    assert adequacy_table(cases).rows[0][:2] == ["strokes, own", "1 of 1"]
