"""Contact on a measured cloud: the score counts what it says, and the detector finds contact through a camera."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from diagrams.experiments.cloud.__main__ import main
from diagrams.experiments.cloud.plan import Plan
from diagrams.experiments.cloud.report import document, table, write
from diagrams.experiments.cloud.run import Result, run
from diagrams.experiments.cloud.score import score
from mmt_drake.errors import BadInput

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
    plan = Plan(touches=5, seed=3)
    motion = plan.motion()
    position, velocity = motion.sample(np.arange(0.0, motion.cycle, 1e-3))
    below = position[:, 2] < 0.0
    assert np.sum(below[1:] & ~below[:-1]) == 5
    assert position[:, 2].max() == pytest.approx(0.004)
    assert position[:, 2].min() >= -0.006 - 1e-9
    assert 0.01 < np.abs(velocity[:, 2]).max() <= 0.2 + 1e-9


@pytest.fixture(scope="module")
def small() -> Result:
    return run(Plan(touches=2, noise=(0.0, 1.0), voxel=(0.003,), focal=305.0, width=200, height=0.25))


def test_without_noise_contact_is_seen_at_the_surface_through_the_camera(small: Result) -> None:
    perfect = small.cases[0]
    assert (perfect.score.contacts, perfect.score.missed, perfect.score.false) == (2, 0, 0)
    assert np.abs(perfect.score.touch_heights).max() < 1e-3
    assert abs(perfect.height) < 5e-5
    assert perfect.score.wrong < 0.02


def test_with_a_stereo_camera_s_noise_every_contact_is_seen(small: Result) -> None:
    noisy = small.cases[1]
    assert (noisy.score.contacts, noisy.score.missed) == (2, 0)
    assert noisy.roughness > 3.0 * small.cases[0].roughness
    assert noisy.offset > small.cases[0].offset
    assert np.abs(noisy.score.touch_heights).max() < 3e-3


def test_the_report_says_what_was_found(small: Result, tmp_path: Path) -> None:
    files = write(small, tmp_path / "out")
    assert [path.name for path in files] == ["cloud.csv", "cloud.png"]
    rows = list(csv.DictReader(files[0].open()))
    assert [float(row["noise"]) for row in rows] == [0.0, 1.0]
    assert [row[0] for row in table(small).rows] == [0.0, 1.0]
    said = json.loads(json.dumps(document(small), allow_nan=False))
    assert said["cases"][1]["roughness_m"] == small.cases[1].roughness


def test_a_plan_without_meaning_is_one_line_and_status_2(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--touches", "0"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    with pytest.raises(BadInput, match="noise, voxel"):
        Plan(voxel=())
