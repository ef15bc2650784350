"""What a run says of the objects on the telerobot's table."""

import numpy as np
import pytest

from mmt_drake.analysis.objects_touched import THINGS, objects_touched
from mmt_drake.errors import BadInput
from mmt_drake.model.scene_layout import ENTRY, MOST, SCENE, SeenState
from mmt_drake.recording import Recording

TIME = np.arange(0.0, 4.0, 1e-3)
BRICK = {"state": SeenState.SEEN, "top": 0.0, "height": 0.06, "along": 0.09, "across": 0.07, "age": 1.0}
ROLL = {**BRICK, "x": 0.13, "top": 0.02}


def run(x: np.ndarray, z: np.ndarray, contact: np.ndarray) -> Recording:
    """A brick at 0, and at 0.13 m a roll whose top is 20 mm higher."""
    still = np.zeros(len(TIME))
    columns = {f"scene_{name}": still.copy() for name in SCENE}
    for row, (thing, entry) in enumerate(((1, BRICK), (2, ROLL)), start=1):
        for name, value in {"thing": thing, **entry}.items():
            assert name in ENTRY and row <= MOST
            columns[f"scene_{row}_{name}"][:] = value
    columns |= {"position_x": x, "position_y": still, "position_z": z, "detected_contact": 1.0 * contact}
    return Recording(TIME, columns, "a run")


def test_touches_are_counted_by_object() -> None:
    pressing = (TIME % 1.0) > 0.5
    x, z = np.where(TIME < 3.0, 0.0, 0.13), np.where(pressing, -0.01, 0.03)
    found = objects_touched(run(x, z, pressing))
    assert found is not None and found.touches == {1: 3, 2: 1} and found.passed == {}
    assert found.line() == "objects: 2 seen, touched: 1 (3x), 2 (1x)"


def test_a_touch_counts_that_begins_a_little_above_a_top_seen_too_low() -> None:
    """As where the noise of the camera moves the top between two frames."""
    pressing = (TIME % 1.0) > 0.5
    z = np.where(pressing, 4e-4 - 0.02 * (TIME % 1.0 - 0.5), 0.03)
    found = objects_touched(run(np.zeros(len(TIME)), z, pressing))
    assert found is not None and found.touches == {1: 4, 2: 0}


def test_an_object_that_the_tip_went_into_from_beside_is_told() -> None:
    z = np.full(len(TIME), 0.01)  # above the brick, below the top of the roll
    found = objects_touched(run(np.clip(0.1 * TIME, 0.0, 0.13), z, np.zeros(len(TIME), dtype=bool)))
    assert found is not None and list(found.passed) == [2]
    assert abs(found.passed[2] - (4.0 - 0.85)) < 2e-3  # from its rim at x = 85 mm on
    assert "touched: none; NOT TOUCHED although the tip was below the top of 2 for 3.15 s" in found.line()
    assert found.to_json() == {
        "touches": {"1": 0, "2": 0},
        "passed_s": {"2": found.passed[2]},
        "names": {},
        "unseen": [],
    }


def test_a_recording_without_a_scene_has_no_objects() -> None:
    assert objects_touched(Recording(TIME, {"detected_contact": np.zeros(len(TIME))}, "a run")) is None


def test_simulated_objects_are_called_by_their_names_wherever_the_camera_counts_them() -> None:
    """The scenario has a plate that nobody sees, and the roll before the brick."""
    pressing = (TIME % 1.0) > 0.5
    seen = run(np.full(len(TIME), 0.13), np.where(pressing, -0.01, 0.03), pressing)
    places = {"places_1_x": 0.13, "places_2_x": 0.0, "places_3_x": 0.5}
    still = np.zeros(len(TIME))
    columns = {**seen.columns, **{f"places_{i}_y": still for i in (1, 2, 3)}}
    columns |= {name: still + x for name, x in places.items()}
    found = objects_touched(Recording(TIME, columns, "a run", made_by={THINGS: '["roll", "brick", "plate"]'}))
    assert found is not None and found.names == {1: "brick", 2: "roll"} and found.unseen == ["plate"]
    expected = "objects: 2 seen, touched: roll (4x); never touched: brick; NEVER SEEN by the camera: plate"
    assert found.line() == expected


def test_a_table_of_which_no_true_places_are_known_has_no_names_and_nothing_is_called_unseen() -> None:
    seen = run(np.zeros(len(TIME)), np.full(len(TIME), 0.03), np.zeros(len(TIME), dtype=bool))
    found = objects_touched(Recording(TIME, seen.columns, "a run", made_by={THINGS: '["roll", "brick"]'}))
    assert found is not None and found.names == {} and list(found.unseen) == []


def test_names_that_are_no_list_are_refused() -> None:
    seen = run(np.zeros(len(TIME)), np.full(len(TIME), 0.03), np.zeros(len(TIME), dtype=bool))
    columns = {**seen.columns, "places_1_x": TIME, "places_1_y": TIME}
    with pytest.raises(BadInput, match="things: found roll"):
        objects_touched(Recording(TIME, columns, "a run", made_by={THINGS: "roll"}))
