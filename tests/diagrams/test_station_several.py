"""A station with several objects."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest
from pydrake.common.value import AbstractValue
from pydrake.systems.analysis import Simulator

from mmt_drake.beside import Later
from mmt_drake.cloud import Cloud
from mmt_drake.cloud.tracking_options import Tracking
from mmt_drake.diagrams.stations.run import run
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.errors import BadInput
from mmt_drake.recording import Recording, load
from mmt_drake.systems.scene_tracker import SceneTracker

T = TypeVar("T")
IDEAL = ["environment.cloud={points: 6000, rate: 15}", "environment.cloud.!=SurfaceCloud"]
NOT_LATE = [f"{way}={{}}" for way in ("to_telerobot", "to_operator")]


@pytest.fixture(scope="module")
def recording() -> Recording:
    """The first two visits of set-up 4 without delay, tops as they are."""
    return run(load_scenario("setup4", IDEAL + NOT_LATE), seconds=14.0)


def test_the_object_below_the_hand_is_touched_and_both_sides_tell_it_in_time(recording: Recording) -> None:
    touched = recording["touched"]
    assert set(np.unique(touched)) == {0.0, 1.0, 2.0}
    np.testing.assert_array_equal(touched > 0.0, recording["in_contact"] > 0.0)
    for column in ("detected_contact", "operator_contact"):
        assert np.count_nonzero((recording[column] > 0.5) != (touched > 0.0)) <= 12  # ms, of four changes


def test_what_is_seen_is_where_it_is(recording: Recording) -> None:
    for k in (2000, 6500, 13999):
        for i in range(3):
            row = [recording[f"scene_{i + 1}_{name}"][k] for name in ("thing", "x", "y")]
            true = [recording[f"places_{i + 1}_{axis}"][k] for axis in "xy"]
            assert row[0] == i + 1
            assert np.hypot(*np.subtract(row[1:], true)) < 0.012  # 67 ms old and faster than 0.1 m/s


def test_the_pushed_object_moves_and_the_others_stay(recording: Recording) -> None:
    assert np.ptp(recording["places_1_x"][:7500]) > 0.02
    assert np.ptp(recording["places_3_x"]) == 0.0


def test_what_a_scenario_says_of_several_objects_is_checked() -> None:
    with pytest.raises(BadInput, match=r"things\.sponge\.object"):
        load_scenario("setup4", ["environment.things.sponge.object.effects=[{name: none_such}]"])
    with pytest.raises(BadInput, match="in one place"):
        build_station(load_scenario("setup4", [*IDEAL, "environment.things.sponge.at=[0.0, 0.01]"]))
    with pytest.raises(BadInput, match=r"environment\.tracking\.latency: found 1"):
        load_scenario("setup4", ["environment.tracking.latency=1.0"])
    with pytest.raises(BadInput, match="one object"):
        _ = load_scenario("setup4").single


@pytest.mark.study
def test_processes_of_its_own_change_nothing_in_a_run_by_simulated_time(tmp_path: Path) -> None:
    found = []
    for spread in (False, True):
        file = tmp_path / f"{spread}.mcap"
        station = build_station(load_scenario("setup4"), record=file, spread=spread)
        station.simulate(10.0)
        assert len(station.begun) == (2 if spread else 0)  # of the camera and of who is who; fits are the estimator's
        found.append(load(file))
    for name in found[0].columns:
        np.testing.assert_array_equal(found[0][name], found[1][name], err_msg=name)


def test_what_is_told_of_a_cloud_comes_after_its_latency_and_before_the_next_cloud() -> None:
    cloud = Cloud(
        [(x, y, 0.0) for x in np.arange(-0.04, 0.04, 0.002) for y in np.arange(-0.04, 0.04, 0.002)], stamp=0.1
    )
    for latency, told in ((0.0, [1.0, 1.0]), (0.02, [0.0, 1.0])):
        tracker = SceneTracker(-0.05, Tracking(latency=latency), period=0.1)
        context = tracker.CreateDefaultContext()
        tracker.GetInputPort("position").FixValue(context, [0.2, 0.0, 0.1])
        tracker.GetInputPort("point_cloud").FixValue(context, AbstractValue.Make(cloud))
        simulator, scene, found = Simulator(tracker, context), tracker.GetOutputPort("scene"), []
        for t in (0.015, 0.025):
            simulator.AdvanceTo(t)
            found.append(scene.Eval(context)[0])
        assert found == told
    with pytest.raises(BadInput, match=r"latency: found 0\.2"):
        SceneTracker(-0.05, Tracking(latency=0.2), period=0.1)


def test_in_real_time_nobody_waits_for_what_is_not_there() -> None:
    asked: list[tuple[Any, ...]] = []

    def never(work: Callable[..., T], prepare: Callable[[], object] | None = None) -> Callable[..., Later[T]]:
        def later(*given: Any) -> Later[T]:
            asked.append(given)
            return Later(lambda: pytest.fail("it waits"), lambda: False)

        return later

    tracker = SceneTracker(-0.05, Tracking(latency=0.02), period=0.1, apart=never, waits=False)
    context = tracker.CreateDefaultContext()
    tracker.GetInputPort("position").FixValue(context, [0.2, 0.0, 0.1])
    clouds = [Cloud([(0.0, 0.0, 0.0)], stamp=stamp) for stamp in (0.1, 0.2)]
    port = tracker.GetInputPort("point_cloud").FixValue(context, AbstractValue.Make(clouds[0]))
    simulator = Simulator(tracker, context)
    simulator.AdvanceTo(0.05)
    port.GetMutableData().set_value(clouds[1])
    simulator.AdvanceTo(0.35)
    assert len(asked) == 1
    assert not tracker.GetOutputPort("scene").Eval(context).any()
