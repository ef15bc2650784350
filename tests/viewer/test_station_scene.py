"""The scene shows where things are, and sends nothing that has not changed."""

import numpy as np
import pytest
from packed import is_drawn, is_visible, transform

from mmt_drake.cloud import Cloud, ProxySettings, plane
from mmt_drake.model.scene_layout import ACROSS, ALONG, HEIGHT, MOST, ROW, STATE, THING, SeenState
from mmt_drake.viewer.scene import METRES_PER_NEWTON, Scene, stretched
from mmt_drake.viewer.viewer import Viewer


@pytest.mark.parametrize("vector", [(0, 0, 0.4), (0, 0, -0.4), (0.1, 0, 0), (-0.03, 0.2, -0.05), (0, -0.01, 1e-9)])
def test_an_arrow_is_stretched_along_its_axis_and_turned_without_shear(vector: tuple[float, float, float]) -> None:
    matrix = stretched([1.0, 2.0, 3.0], vector)
    assert matrix is not None
    foot, tip = matrix @ [0.0, 0.0, 0.0, 1.0], matrix @ [0.0, 0.0, 1.0, 1.0]
    np.testing.assert_allclose(foot[:3], [1.0, 2.0, 3.0])
    np.testing.assert_allclose(tip[:3] - foot[:3], vector, atol=1e-15)
    axes = matrix[:3, :3] / [1.0, 1.0, np.linalg.norm(vector)]
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-14)
    assert np.linalg.det(axes) == pytest.approx(1.0)


@pytest.mark.parametrize("vector", [(0, 0, 0), (5e-4, 0, 0), (np.nan, 0, 1), (0, np.inf, 0)])
def test_no_arrow_is_drawn_of_nothing_or_of_what_is_no_number(vector: tuple[float, float, float]) -> None:
    assert stretched([0.0, 0.0, 0.0], vector) is None


def test_hand_and_probe_stand_where_they_are_with_their_forces(viewer: Viewer) -> None:
    scene = Scene(viewer)
    scene.show_hand([0.01, 0.02, 0.03], [0.0, -2.0, 0.0])
    scene.show_probe([0.04, 0.05, -0.002], [0.0, 0.0, 3.0])
    for name, at, force, arrow in (
        ("hand", [0.01, 0.02, 0.03], [0.0, -2.0, 0.0], "rendered"),
        ("probe", [0.04, 0.05, -0.002], [0.0, 0.0, 3.0], "measured"),
    ):
        np.testing.assert_allclose(transform(viewer, f"/station/{name}")[:3, 3], at)
        drawn = transform(viewer, f"/station/force/{arrow}")
        np.testing.assert_allclose(drawn[:3, 3], at)
        np.testing.assert_allclose(drawn[:3, 2], METRES_PER_NEWTON * np.array(force))
        assert is_visible(viewer, f"/station/force/{arrow}")
    scene.show_probe([np.nan, 0.0, 0.0], [0.0, 0.0, np.nan])  # a sensor that fails
    np.testing.assert_allclose(transform(viewer, "/station/probe")[:3, 3], [0.04, 0.05, -0.002])
    assert not is_visible(viewer, "/station/force/measured")


def test_the_proxy_s_spheres_have_its_radii_and_the_normal_shows_in_contact_alone(viewer: Viewer) -> None:
    scene = Scene(viewer, ProxySettings(r1=0.002, r2=0.004, r3=0.009))
    for name in ("r1", "r2", "r3"):
        assert is_drawn(viewer, f"/station/proxy/{name}")
    scene.show_proxy([0.1, 0.0, 0.001], [0.0, 0.0, 1.0], touching=True)
    assert is_visible(viewer, "/station/normal")
    np.testing.assert_allclose(transform(viewer, "/station/proxy")[:3, 3], [0.1, 0.0, 0.001])
    scene.show_proxy([0.1, 0.0, 0.02], [0.0, 0.0, 1.0], touching=False)
    assert not is_visible(viewer, "/station/normal")


def test_what_is_told_of_an_object_is_its_colour_and_one_that_is_taken_away_is_hidden(viewer: Viewer) -> None:
    drawn, shown = {}, {}
    scene = Scene(viewer)
    for state in SeenState:
        row = np.zeros((MOST, ROW))
        row[0, [THING, STATE, HEIGHT, ALONG, ACROSS]] = 1.0, state, 0.05, 0.08, 0.06
        scene.show_objects(row.ravel())
        (material,) = viewer.drawn["object", "/station/things/1"]["object"]["materials"]
        drawn[state], shown[state] = material["color"], is_visible(viewer, "/station/things/1")
    assert [state for state in SeenState if not shown[state]] == [SeenState.TAKEN_AWAY]
    told = set(SeenState) - {SeenState.NONE, SeenState.SEEN, SeenState.TAKEN_AWAY}
    assert all(drawn[state] != drawn[SeenState.SEEN] for state in told)
    assert drawn[SeenState.MERGED] == drawn[SeenState.SPLIT] != drawn[SeenState.LOST]


def test_a_cloud_that_moved_rigidly_is_moved_and_its_points_are_sent_once(viewer: Viewer) -> None:
    scene, surface = Scene(viewer), plane(20_000, (0.2, 0.1), centre=(0.05, 0.0, 0.0))
    scene.show_cloud(surface)
    sent = viewer.drawn["object", "/station/cloud"]
    scene.show_cloud(surface.moved((0.01, -0.02, 0.0), 0.1))
    assert viewer.drawn["object", "/station/cloud"] is sent
    np.testing.assert_allclose(transform(viewer, "/station/cloud")[:3, 3], [0.01, -0.02, 0.0])
    # The object lies below its surface, and moves with the body.
    box = transform(viewer, "/station/object/box")[:3, 3]
    np.testing.assert_allclose(box[:2], [0.05, 0.0], atol=2e-3)
    assert box[2] < 0.0
    scene.show_object([0.01, -0.02])
    np.testing.assert_allclose(transform(viewer, "/station/object")[:3, 3], [0.01, -0.02, 0.0])


def test_fresh_points_are_sent_five_times_a_second_at_most(viewer: Viewer, monkeypatch: pytest.MonkeyPatch) -> None:
    now = 100.0
    monkeypatch.setattr("mmt_drake.viewer.scene.time.monotonic", lambda: now)
    scene, sent = Scene(viewer), {}
    for frame in range(100):  # of a camera with 100 pictures a second
        now = 100.0 + frame / 100.0
        scene.show_cloud(Cloud(np.full((3, 3), frame / 1000.0) + np.eye(3)))
        drawn = viewer.drawn["object", "/station/cloud"]
        sent[id(drawn)] = drawn
    assert len(sent) == 5


def test_a_cloud_without_points_draws_no_object(viewer: Viewer) -> None:
    scene = Scene(viewer)
    scene.show_cloud(Cloud.empty())
    scene.show_object([0.0, 0.0])
    assert not is_drawn(viewer, "/station/object")
