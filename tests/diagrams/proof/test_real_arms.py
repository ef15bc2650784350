"""Real arms: friction that is known to be there is named, and another log is predicted better than by simple fits."""

from pathlib import Path

import pytest

from mmt_drake.diagrams.proof.experiments.arms.report import WITHIN, report_of
from mmt_drake.diagrams.proof.trial.real.arm_cases import CASES, ArmResult, run_case

UR10E, _, LOADED = CASES[:3]


@pytest.fixture(scope="module")
def ur10e() -> ArmResult:
    return run_case(UR10E)


def test_dry_friction_is_named_on_all_joints_of_the_ur10e(recordings: Path, ur10e: ArmResult) -> None:
    assert set(ur10e.dry) == set(ur10e.joints)
    assert not any("not sure" in said for said in ur10e.dry.values())


@pytest.mark.parametrize("name", ["UR10e", "KR300", "PSM"])
def test_another_log_is_predicted_no_worse_than_by_simple_fits(recordings: Path, name: str) -> None:
    result = run_case(next(case for case in CASES if case.name == name))
    known = [(f, s) for f, s in zip(result.found, result.simple, strict=True) if s is not None]
    assert known and all(found <= WITHIN * simple for found, simple in known)


def test_a_load_is_found_as_a_payload_within_what_the_gains_allow(recordings: Path) -> None:
    assert run_case(LOADED).payload_kg == pytest.approx(2.805, rel=0.15)


def test_the_report_tells_what_is_reached_and_what_is_missed(recordings: Path, ur10e: ArmResult) -> None:
    report = report_of([ur10e])
    assert report.data["cases"][0]["joints"] == ur10e.joints
    assert [one.reached for one in report.reached] == [True, True]
