"""`experiment fit`: what is drawn, and what is counted of it."""

import numpy as np
import pytest

from mmt_drake.diagrams.proof.experiments.first_models import CASES, KINDS, LATE, FittedCase, drawn_recording, run_case


@pytest.mark.parametrize("kind", KINDS)
def test_a_seed_draws_the_same_system_again_and_another_one_another(kind: str) -> None:
    (one, truth), (again, same), (_, other) = (drawn_recording(np.random.default_rng(seed), kind) for seed in (1, 1, 2))
    assert truth == same != other
    for name in one.columns:
        np.testing.assert_array_equal(one[name], again[name])


@pytest.mark.parametrize("kind", ["box, own plant", "spring and damper"])
def test_the_numbers_of_a_drawn_system_lie_in_their_intervals(kind: str) -> None:
    case = run_case(0, kind, 0)
    assert case.explains and len(case.holds()) >= 3 and all(case.holds())


def test_a_mass_that_may_be_any_does_not_end_a_fit() -> None:
    case = run_case(12, LATE, 0)
    assert set(case.told) == set(case.truth)
    assert case.told["m"]["told"] != "determined"


def test_a_recording_that_a_fit_refuses_is_counted() -> None:
    refused = FittedCase(0, LATE, {"k": 1.0}, {}, False, None, None, 3.0)
    report = CASES.report((case("servo", 1.05, "determined"), refused))
    assert "1 of 1 numbers" in report.sentences[0] and "1 of 1 fits" in report.sentences[1]


def case(kind: str, truth: float, told: str, explains: bool = True) -> FittedCase:
    number = {"value": 1.0, "ci95": (0.9, 1.1), "told": told}
    return FittedCase(0, kind, {"k": truth}, {"k": number}, explains, 0.02, 0.01, 3.0)


def test_only_what_is_called_determined_counts() -> None:
    told = [case("servo", 1.05, "determined"), case("servo", 1.2, "determined"), case("servo", 5.0, "at most")]
    report = CASES.report((*told, case(LATE, 2.0, "of this structure", explains=False)))
    (reached,) = report.reached
    assert reached.value == 0.5 and reached.reached is False
    assert "1 of 2 numbers called determined" in report.sentences[0]
    assert "1 of 1 fits say that they leave more than noise" in report.sentences[1]
