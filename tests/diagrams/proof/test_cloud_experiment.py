"""Contact on a measured cloud: the score counts what it says, and the detector finds contact through a camera."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mmt_drake.cli.main import main
from mmt_drake.diagrams.proof.experiments import cloud_report as cloud
from mmt_drake.diagrams.proof.experiments.cloud_report import cloud_findings, cloud_table
from mmt_drake.diagrams.proof.experiments.cloud_runs import CloudPlan, Result, run_cloud, score
from mmt_drake.errors import BadInput
from mmt_drake.hw.realsense.view import View

TIME = np.arange(2000) * 1e-3


def flags(*stretches: tuple[int, int]) -> np.ndarray:
    on = np.zeros(len(TIME), bool)
    for begin, end in stretches:
        on[begin:end] = True
    return on


def test_missed_false_broken_early_and_late_contacts_are_counted_apart() -> None:
    contact = flags((200, 400), (600, 800), (1000, 1200))
    detected = flags((190, 250), (253, 300), (330, 410), (900, 920), (1030, 1195))
    height = np.linspace(0.02, 0.0, len(TIME))
    found = score(TIME, height, contact, detected)
    assert (found.contacts, found.missed, found.false, found.breaks) == (3, 1, 1, 1)  # 3 ms of a gap is none
    np.testing.assert_allclose(found.touch_lags, [-0.010, 0.030], atol=1e-12)
    np.testing.assert_allclose(found.release_lags, [0.010, -0.005], atol=1e-12)
    np.testing.assert_allclose(found.touch_heights, height[[190, 1030]])
    assert found.wrong == pytest.approx((10 + 3 + 30 + 10 + 200 + 20 + 30 + 5) / len(TIME))


def test_perfect_detection_has_no_errors() -> None:
    contact = flags((200, 400), (600, 2000))
    found = score(TIME, TIME, contact, contact)
    assert (found.contacts, found.missed, found.false, found.breaks, found.wrong) == (2, 0, 0, 0, 0.0)
    assert not found.touch_lags.any()
    assert len(found.release_lags) == 1  # the second has not ended


def test_the_hand_touches_as_often_as_planned_and_hovers_above_in_between() -> None:
    plan = CloudPlan(touches=5, seed=3)
    motion = plan.motion()
    position, velocity = motion.sample(np.arange(0.0, motion.cycle, 1e-3))
    below = position[:, 2] < 0.0
    assert np.sum(below[1:] & ~below[:-1]) == 5
    assert position[:, 2].max() == pytest.approx(0.004)
    assert position[:, 2].min() >= -0.006 - 1e-9
    assert 0.01 < np.abs(velocity[:, 2]).max() <= 0.2 + 1e-9


@pytest.fixture(scope="module")
def small() -> Result:
    near = View(focal=244.0, width=160, height=0.25)
    return run_cloud(CloudPlan(touches=2, noise=(0.0, 1.0), voxel=(0.003,), rate=15.0, view=near))


def test_without_noise_contact_is_seen_at_the_surface_through_the_camera(small: Result) -> None:
    (perfect,) = cloud.cases_of(small, noise=0.0, alpha=1.0)
    assert (perfect.score.contacts, perfect.score.missed, perfect.score.false) == (2, 0, 0)
    assert np.abs(perfect.score.touch_heights).max() < 1e-3
    assert abs(perfect.untouched.height) < 5e-5
    assert perfect.score.wrong < 0.02


def test_with_a_stereo_camera_s_noise_every_contact_is_seen_and_a_temporal_filter_makes_the_cloud_smoother(
    small: Result,
) -> None:
    (perfect,) = cloud.cases_of(small, noise=0.0, alpha=1.0)
    alone, filtered = cloud.cases_of(small, noise=1.0)
    for noisy in (alone, filtered):
        assert (noisy.score.contacts, noisy.score.missed) == (2, 0)
        lifted = noisy.untouched.offset - noisy.untouched.height  # by noise, the calibration's error apart
        assert lifted > perfect.untouched.offset - perfect.untouched.height
        assert np.abs(noisy.score.touch_heights).max() < 3e-3
    assert perfect.untouched.roughness < filtered.untouched.roughness < 0.6 * alone.untouched.roughness


def test_the_verdict_names_the_greatest_noise_without_a_slip(small: Result) -> None:
    def told(*breaks: int) -> str:
        cases = [
            replace(case, score=replace(case.score, missed=0, false=0, breaks=n))
            for case, n in zip(small.cases, breaks, strict=True)
        ]
        return cloud_findings(replace(small, cases=tuple(cases)))[0]

    noises = [case.noise for case in small.cases]
    assert noises == [0.0, 1.0, 0.0, 1.0]
    assert "with 1 times a stereo camera's noise" in told(3, 2, 1, 0)
    assert "no filter" not in told(3, 2, 0, 0)
    assert "with no noise" in told(3, 2, 0, 1) and "no filter that was tried is enough" in told(3, 2, 0, 1)
    assert "on no cloud" in told(1, 1, 1, 1)


def test_the_command_writes_a_page_and_tells_what_was_found(
    small: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[CloudPlan] = []

    def run(plan: CloudPlan, progress: object) -> Result:
        asked.append(plan)
        return small

    monkeypatch.setattr(cloud, "run_cloud", run)
    assert main(["experiment", "cloud", "--count", "2", "--seed", "7", "--out", str(tmp_path)]) == 0
    assert [(plan.touches, plan.seed) for plan in asked] == [(2, 7)]
    told = capsys.readouterr().out
    assert cloud_findings(small)[0].split(":")[0] in told and f"page: {tmp_path / 'index.html'}" in told
    page = (tmp_path / "index.html").read_text()
    assert "Verdict" in page and (tmp_path / "cloud.png").is_file()
    assert main(["experiment", "cloud", "--json", "--out", str(tmp_path)]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["cases"][1]["roughness_m"] == small.cases[1].untouched.roughness
    assert [row[:3] for row in cloud_table(small).rows] == [[0, 3, 1], [1, 3, 1], [0, 3, 0.2], [1, 3, 0.2]]


def test_a_plan_without_meaning_is_one_line_and_status_2(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["experiment", "cloud", "--count", "0"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    with pytest.raises(BadInput, match="noise, voxel, alpha"):
        CloudPlan(voxel=())
