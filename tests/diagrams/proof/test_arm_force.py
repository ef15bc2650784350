"""The force on the probe of set-up 3's arm, told from its joints: with all that is true, and with what was found."""

import pytest

from mmt_drake.diagrams.proof.experiments import study_of
from mmt_drake.diagrams.proof.experiments.arms.probe import ProbeCase, report_of, run_case
from mmt_drake.diagrams.stations.arm import missing_arm

pytestmark = pytest.mark.skipif(missing_arm() is not None, reason="the extra `arm` is not installed")


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> ProbeCase:
    return run_case(tmp_path_factory.mktemp("arm"), 1, {"free": 16.0, "contact": 8.0})


def test_with_all_that_is_true_the_force_on_the_probe_is_that_which_was_put_there(case: ProbeCase) -> None:
    assert case.known < 0.03 * case.force


def test_what_the_diagnosis_finds_clears_the_force_of_the_arm(case: ProbeCase) -> None:
    assert case.handed_in > 0.3 * case.force, "the file handed in is no good for this"
    assert case.found < 0.2 * case.handed_in


def test_the_report_says_what_is_reached(case: ProbeCase) -> None:
    report = report_of([case])
    assert [one.reached for one in report.reached] == [True]
    assert report.data["cases"][0]["found"] == case.found
    assert study_of("arm-force").label
