"""Objects on a table keep their identity from cloud to cloud, or lose it visibly."""

from dataclasses import replace

import numpy as np
import pytest

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.cloud.seen import SeenScene, SeenThing
from mmt_drake.cloud.segment import registered
from mmt_drake.cloud.tracking import tracked
from mmt_drake.cloud.tracking_options import Tracking
from mmt_drake.model import scene_layout as at
from mmt_drake.model.scene_layout import SeenState
from mmt_drake.numeric.arrays import Array

TABLE, STEP, SPACING = -0.06, 1.0 / 15.0, 0.004
FAR = np.array([0.0, 0.4, 0.2])
SIZES = {"sponge": (0.08, 0.08, 0.04), "brick": (0.09, 0.07, 0.06), "roll": (0.06, 0.06, 0.05)}


def cloud_of(
    places: dict[str, tuple[float, float]], t: float, random: np.random.Generator, *, table: bool = True
) -> Cloud:
    """Tops and the table beside them as a camera right above samples them, 0.5 mm of noise."""
    side = np.arange(-0.25, 0.25, SPACING)
    grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2) + random.uniform(0.0, SPACING, 2)
    z = np.full(len(grid), TABLE)
    for name, place in places.items():
        wide, deep, high = SIZES[name]
        inside = (np.abs(grid - place) <= [0.5 * wide, 0.5 * deep]).all(axis=1)
        z[inside] = TABLE + high
    points = np.column_stack([grid, z]) + random.normal(0.0, 5e-4, (len(grid), 3))
    return Cloud(points if table else points[z > TABLE], stamp=t)


class Film:
    """Frames one after the other."""

    def __init__(self, seed: int = 0) -> None:
        self.random, self.t = np.random.default_rng(seed), 0.0
        self.scene = SeenScene()
        self.states: dict[int, set[SeenState]] = {}

    def show(
        self,
        places: dict[str, tuple[float, float]],
        frames: int = 1,
        probe: Array = FAR,
        hole: float = 0.0,
        table: bool = True,
        gripped: int = 0,
    ) -> None:
        for _ in range(frames):
            self.t += STEP
            cloud = cloud_of(places, self.t, self.random, table=table)
            if hole > 0.0:
                points = cloud.points()
                cloud = Cloud(points[np.hypot(*(points[:, :2] - probe[:2]).T) > hole], stamp=self.t)
            self.scene = tracked(self.scene, cloud, probe, self.t, TABLE, Tracking(), gripped)
            for thing in self.scene.things:
                self.states.setdefault(thing.thing, set()).add(thing.state)

    def at(self, place: tuple[float, float]) -> SeenThing:
        there = [thing for thing in self.scene.things if thing.state != SeenState.TAKEN_AWAY]
        return min(there, key=lambda thing: float(np.hypot(*np.subtract(thing.place, place))))


THREE = {"sponge": (-0.13, 0.0), "brick": (0.0, 0.0), "roll": (0.13, 0.0)}


def test_each_object_has_a_row_with_place_size_and_height() -> None:
    film = Film()
    film.show(THREE, 3)
    scene = at.rows(film.scene.vector(film.t))
    assert scene[:, at.THING].tolist() == [1.0, 2.0, 3.0]
    for row, (name, place) in zip(scene, THREE.items(), strict=True):
        assert row[[at.X, at.Y]] == pytest.approx(place, abs=2e-3)
        assert row[[at.ALONG, at.ACROSS]] == pytest.approx(SIZES[name][:2], abs=8e-3)
        assert row[at.HEIGHT] == pytest.approx(SIZES[name][2], abs=1e-3)
        assert row[at.TOP] == pytest.approx(TABLE + SIZES[name][2], abs=1e-3)


def test_each_has_the_colour_that_it_was_last_seen_in_and_none_before() -> None:
    film = Film()
    film.show(THREE, 3)
    assert np.isnan(at.rows(film.scene.vector(film.t))[:, at.LIGHTNESS]).all()
    cloud = cloud_of(THREE, film.t + STEP, film.random)
    colours = np.full((len(cloud), 3), 0.5)
    colours[cloud.points()[:, 0] < -0.07] = 1.0, 0.0, 0.0  # all about the sponge
    colours[cloud.points()[:, 0] > 0.07] = np.nan
    coloured = Cloud(cloud.points(), stamp=film.t + STEP, colours=colours)
    film.scene = tracked(film.scene, coloured, FAR, film.t + STEP, TABLE, Tracking())
    film.t += STEP
    film.show(THREE, 3)
    left, middle, right = (film.at(place).colour for place in THREE.values())
    assert left == pytest.approx((53.24, 80.09, 67.20), abs=0.03) and middle == pytest.approx((53.39, 0, 0), abs=0.03)
    assert np.isnan(right).all()


def test_heights_that_a_camera_mixes_at_a_rim_do_not_lower_a_top() -> None:
    random, scene = np.random.default_rng(3), SeenScene()
    for k in range(40):
        t = (k + 1) * STEP
        points = cloud_of({"brick": (0.0, 0.0)}, t, random).points()
        brick = points[:, 2] > TABLE + 0.03
        rim = brick & ((np.abs(points[:, :2]) > np.array([0.045, 0.035]) - 0.005).any(axis=1))
        points[rim, 2] -= random.uniform(0.0, 0.002, np.count_nonzero(rim))
        scene = tracked(scene, Cloud(points, stamp=t), FAR, t, TABLE, Tracking())
    assert scene.things[0].top == pytest.approx(TABLE + SIZES["brick"][2], abs=3e-5)


def test_where_a_camera_has_stopped_all_are_lost_and_stay_where_they_were() -> None:
    film = Film()
    film.show(THREE, 5)
    t = film.t + 0.3
    scene = tracked(film.scene, Cloud.empty(t), FAR, t, TABLE, Tracking())
    assert [thing.state for thing in scene.things] == [SeenState.LOST] * 3
    assert [thing.place for thing in scene.things] == [thing.place for thing in film.scene.things]


def test_of_seven_objects_the_newcomer_waits_until_one_is_taken_away() -> None:
    film = Film()
    film.show({"brick": (0.0, 0.0)}, 2)
    (brick,) = film.scene.things
    many = [replace(brick, thing=thing) for thing in range(1, 8)]
    assert at.rows(SeenScene(tuple(many)).vector(1.0))[:, at.THING].tolist() == [1, 2, 3, 4, 5, 6]
    many[2] = replace(many[2], state=SeenState.TAKEN_AWAY)
    assert at.rows(SeenScene(tuple(many)).vector(1.0))[:, at.THING].tolist() == [1, 2, 4, 5, 6, 7]


def test_an_empty_table_and_no_cloud_at_all_are_no_objects() -> None:
    film = Film()
    film.show({}, 3)
    assert film.scene.things == () and not film.scene.vector(1.0).any()
    assert tracked(film.scene, Cloud.empty(1.0), FAR, 1.0, TABLE, Tracking()).things == ()


@pytest.mark.parametrize("table", [True, False])
def test_an_object_that_is_pushed_keeps_its_identity(table: bool) -> None:
    film = Film()
    for k in range(60):
        film.show({**THREE, "sponge": (-0.13 + 0.02 * np.sin(0.2 * k), 0.002 * k)}, table=table)
    assert film.at((-0.13, 0.118)).thing == 1
    assert {thing.thing for thing in film.scene.things} == {1, 2, 3}


@pytest.mark.parametrize("seed", range(3))
def test_two_of_one_height_that_are_one_cluster_are_told_apart_and_nobody_is_swapped(seed: int) -> None:
    SIZES["second"] = SIZES["sponge"]
    film = Film(seed)
    for k in range(90):  # the first comes up to the second, pushes it along, and goes back
        x = -0.13 + 0.002 * min(k, 90 - k)
        second = -0.13 + 0.1 + max(0.0, 0.002 * min(k, 45) - 0.02)
        film.show({"sponge": (x, 0.0), "second": (second, 0.01)})
        if k == 45:
            told = {thing.thing: thing for thing in film.scene.things}
            assert {thing.state for thing in told.values()} == {SeenState.MERGED}
            assert told[1].place == pytest.approx((x, 0.0), abs=8e-3)
            assert told[2].place == pytest.approx((second, 0.01), abs=8e-3)
    del SIZES["second"]
    assert film.at((x, 0.0)).thing == 1 and film.at((second, 0.01)).thing == 2
    assert len(film.scene.things) == 2


def test_one_that_falls_into_two_clusters_is_split_and_still_one() -> None:
    film = Film()
    film.show(THREE, 5)
    cut = cloud_of(THREE, film.t + STEP, film.random)
    points = cut.points()
    cut = Cloud(points[np.abs(points[:, 0] + 0.13) > 0.012], stamp=film.t + STEP)
    scene = tracked(film.scene, cut, FAR, film.t + STEP, TABLE, Tracking())
    assert [thing.thing for thing in scene.things] == [1, 2, 3]
    assert scene.things[0].state == SeenState.SPLIT
    assert scene.things[0].place == pytest.approx((-0.13, 0.0), abs=3e-3)


def test_two_that_were_taken_for_one_are_told_to_be_split_when_they_part() -> None:
    SIZES["second"] = SIZES["sponge"]
    film = Film()
    film.show({"sponge": (-0.04, 0.0), "second": (0.041, 0.0)}, 5)
    assert len(film.scene.things) == 1
    film.show({"sponge": (-0.06, 0.0), "second": (0.06, 0.0)}, 10)
    del SIZES["second"]
    assert len(film.scene.things) == 2 and SeenState.SPLIT in film.states[1] and SeenState.NEW in film.states[2]


def test_an_object_that_the_probe_hides_is_occluded_and_comes_back_as_itself() -> None:
    film = Film()
    film.show(THREE, 5)
    probe = np.array([0.13, 0.0, -0.01])
    film.show(THREE, 8, probe=probe, hole=0.06)
    assert film.at((0.13, 0.0)).state == SeenState.OCCLUDED
    film.show(THREE, 3, probe=FAR)
    assert film.at((0.13, 0.0)).thing == 3 and film.at((0.13, 0.0)).state == SeenState.SEEN


def test_one_that_is_taken_away_under_the_probe_is_lost_then_told_to_be_away() -> None:
    film = Film()
    film.show(THREE, 5)
    probe = np.array([-0.13, 0.0, -0.024])
    film.show({"brick": (0.0, 0.0), "roll": (0.13, 0.0)}, 4, probe=probe)
    assert film.scene.things[0].state == SeenState.LOST
    film.show({"brick": (0.0, 0.0), "roll": (0.13, 0.0)}, 15, probe=probe)
    assert film.scene.things[0].state == SeenState.TAKEN_AWAY
    film.show({**THREE, "sponge": (-0.1, 0.1)}, 4)
    back = film.at((-0.1, 0.1))
    assert back.thing == 1 and back.state == SeenState.FOUND


def test_one_that_comes_in_is_new_and_never_takes_another_s_identity() -> None:
    film = Film()
    film.show({name: THREE[name] for name in ("sponge", "brick")}, 5)
    film.show(THREE, 5)
    assert film.at((0.13, 0.0)).thing == 3 and film.at((0.13, 0.0)).state == SeenState.NEW


def test_of_two_alike_that_are_lost_neither_is_found_by_guess() -> None:
    SIZES["second"] = SIZES["sponge"]
    film = Film()
    film.show({"sponge": (-0.13, 0.0), "second": (0.13, 0.0)}, 5)
    film.show({}, 30)
    film.show({"sponge": (0.0, 0.05)}, 5)
    del SIZES["second"]
    assert film.at((0.0, 0.05)).thing == 3 and SeenState.FOUND not in set().union(*film.states.values())


def test_outlines_together_are_registered_to_the_spacing_of_points() -> None:
    side = np.arange(-0.04, 0.0401, 0.002)
    square = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    points = np.concatenate([square + np.array([0.006, -0.004]), square + np.array([0.086, 0.01])])
    apart = registered([square, square + np.array([0.08, 0.0])], points, 0.003)
    assert np.abs(np.array(apart) - [[0.006, -0.004], [0.006, 0.01]]).max() < 2.5e-3


def test_what_the_tip_takes_with_it_faster_than_frames_come_is_the_same_one() -> None:
    film = Film()
    film.show(THREE, frames=10)
    for x in np.arange(0.0, 0.2, 0.055):  # of the 60 mm of a roll, on which the tip is 10 mm beside the middle
        film.show({**THREE, "roll": (0.13, x)}, probe=np.array([0.13, x + 0.01, TABLE + 0.045]))
    assert film.states[3] == {SeenState.NEW, SeenState.SEEN} and len(film.scene.things) == 3
    assert np.hypot(*np.subtract(film.at((0.13, x)).place, (0.13, x))) < 5e-3


def test_a_tip_takes_nothing_that_is_no_longer_there_with_it() -> None:
    film = Film()
    film.show(THREE, frames=10)
    film.show({name: THREE[name] for name in ("sponge", "brick")}, frames=40)
    assert SeenState.TAKEN_AWAY in film.states[3]
    for x in np.arange(0.0, 0.1, 0.02):
        film.show({name: THREE[name] for name in ("sponge", "brick")}, probe=np.array([0.13, x, TABLE + 0.045]))
    (roll,) = (thing for thing in film.scene.things if thing.thing == 3)
    assert np.hypot(*np.subtract(roll.place, THREE["roll"])) < 3e-3


def test_what_may_be_hidden_of_a_top_draws_it_nowhere_but_what_shows_the_table_does() -> None:
    side = np.arange(-0.04, 0.0401, 0.004)
    square = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    seen = square[square[:, 0] > -0.015]
    table = square + np.array([0.0, 0.1])
    (by,) = registered([square], seen, 0.006, table)
    np.testing.assert_array_equal(by, 0.0)
    (by,) = registered([square], seen, 0.006, np.concatenate([table, square[square[:, 0] < -0.015]]))
    assert by[0] > 0.01


def test_tops_that_are_one_cluster_do_not_lie_over_each_other() -> None:
    """Each is believed 5 mm in the other, where no rim is seen between them: no point is then farther than 6 mm off."""
    side = np.arange(-0.025, 0.0251, 0.004)
    square = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    points = np.concatenate([square, square + np.array([0.053, 0.0])])
    into = np.array([0.005, 0.0])
    apart = registered([square + into, square + np.array([0.053, 0.0]) - into], points, 0.006)
    assert np.abs(np.array(apart) - [-into, into]).max() < 2.5e-3


def test_two_alike_in_one_cluster_stay_who_they_are_while_the_probe_hides_a_rim() -> None:
    """As the stick of a probe does that comes down on one of them, on the side that the camera sees it before."""
    SIZES["second"] = SIZES["roll"]
    film = Film()
    pair = {"roll": (-0.05, 0.0), "second": (0.016, 0.0)}
    film.show({"roll": (-0.05, 0.0), "second": (0.03, 0.0)}, frames=10)
    one, other = film.at((-0.05, 0.0)).thing, film.at((0.03, 0.0)).thing
    for x in (0.026, 0.022, 0.018):
        film.show({"roll": (-0.05, 0.0), "second": (x, 0.0)}, frames=2)
    film.show(pair, frames=5)
    film.show(pair, frames=30, probe=np.array([-0.07, 0.0, 0.0]), hole=0.018)
    places = {thing.thing: thing.place for thing in film.scene.things}
    del SIZES["second"]
    assert set(places) == {one, other} and SeenState.MERGED in film.states[one]
    assert np.hypot(*np.subtract(places[one], pair["roll"])) < 0.008
    assert np.hypot(*np.subtract(places[other], pair["second"])) < 0.008


def test_what_a_grip_carries_goes_with_the_tip_and_is_seen_again_where_it_is_put_down() -> None:
    film = Film()
    film.show({"sponge": (-0.1, 0.0), "brick": (0.0, 0.0)}, frames=10)
    sponge, brick = film.at((-0.1, 0.0)).thing, film.at((0.0, 0.0)).thing
    closed = np.array([-0.095, 0.0, -0.02])
    film.show({"sponge": (-0.1, 0.0), "brick": (0.0, 0.0)}, probe=closed, gripped=sponge)
    for x in np.linspace(-0.095, 0.105, 9):  # over the brick, of which it hides a part, and all at last
        hole = 0.05 + 0.02 * (abs(x - 0.005) < 0.01)
        film.show({"brick": (0.0, 0.0)}, frames=3, probe=np.array([x, 0.0, 0.05]), hole=hole, gripped=sponge)
        carried = next(thing for thing in film.scene.things if thing.thing == sponge)
        assert carried.state == SeenState.CARRIED
        assert carried.place == pytest.approx((x - 0.005, 0.0), abs=2e-3) and carried.top == pytest.approx(
            TABLE + 0.04 + 0.07, abs=2e-3
        )
    film.show(
        {"sponge": (0.1, 0.0), "brick": (0.0, 0.0)}, frames=3, probe=closed + np.array([0.2, 0.0, 0.0]), gripped=sponge
    )
    film.show({"sponge": (0.1, 0.0), "brick": (0.0, 0.0)}, frames=10)
    down = film.at((0.1, 0.0))
    assert (down.thing, down.state) == (sponge, SeenState.SEEN) and down.top == pytest.approx(TABLE + 0.04, abs=2e-3)
    assert film.at((0.0, 0.0)).thing == brick and len(film.scene.things) == 2
    assert film.states[brick] <= {SeenState.NEW, SeenState.SEEN, SeenState.OCCLUDED}


@pytest.mark.parametrize("speed", [0.03, 0.09, 0.3])
def test_one_that_comes_in_from_beyond_the_view_is_one_and_as_large_as_it_is(speed: float) -> None:
    film, x = Film(), 0.31
    film.show({"brick": (-0.1, 0.0)}, 5)
    while x > 0.12:
        x -= speed * STEP
        film.show({"brick": (-0.1, 0.0), "sponge": (x, 0.05)})
    film.show({"brick": (-0.1, 0.0), "sponge": (x, 0.05)}, 30)
    here = [thing for thing in film.scene.things if at.is_there(float(thing.state))]
    assert [thing.thing for thing in here] == [1, 2]
    np.testing.assert_allclose(here[1].place, (x, 0.05), atol=0.005)
    np.testing.assert_allclose(here[1].size, SIZES["sponge"][:2], atol=0.01)
