"""`experiment fit`: what is drawn, and what is counted of it."""

import numpy as np
import pytest

from mmt_drake.diagrams.proof.experiments.first_models import (
    KINDS,
    LATE,
    FittedCase,
    drawn_recording,
    report_of,
    run_case,
)


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


def case(kind: str, truth: float, told: str, explains: bool = True) -> FittedCase:
    number = {"value": 1.0, "ci95": (0.9, 1.1), "told": told}
    return FittedCase(0, kind, {"k": truth}, {"k": number}, explains, 0.02, 0.01, 3.0)


def test_only_what_is_called_determined_counts() -> None:
    told = [case("servo", 1.05, "determined"), case("servo", 1.2, "determined"), case("servo", 5.0, "at most")]
    report = report_of((*told, case(LATE, 2.0, "of this structure", explains=False)))
    (reached,) = report.reached
    assert reached.value == 0.5 and reached.reached is False
    assert "1 of 2 numbers called determined" in report.sentences[0]
    assert "1 of 1 fits say that they leave more than noise" in report.sentences[1]
