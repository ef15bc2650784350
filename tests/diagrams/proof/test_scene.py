"""What the experiment with several objects counts."""

import numpy as np

from mmt_drake.analysis.carried import CarriedObject
from mmt_drake.diagrams.proof.experiments.scene import CASES, IdentityWatch, SceneCase, Visit, judge, latest
from mmt_drake.model.scene_layout import ROW, SeenState
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording

PLACES = np.array([[0.0, 0.0], [0.2, 0.0]])


def rows(*seen: tuple[float, SeenState, float]) -> Array:
    found = np.zeros((len(seen), ROW))
    for row, (thing, state, x) in zip(found, seen, strict=True):
        row[:3] = thing, state, x
    return found


def test_a_swap_without_a_word_is_counted_and_one_that_is_told_is_not() -> None:
    silent, told = IdentityWatch(2), IdentityWatch(2)
    first = rows((1.0, SeenState.SEEN, 0.0), (2.0, SeenState.SEEN, 0.2))
    other = rows((2.0, SeenState.SEEN, 0.0), (1.0, SeenState.SEEN, 0.2))
    silent.look(first, PLACES)
    silent.look(other, PLACES)
    assert silent.swapped == 2 and silent.kept == 2 and silent.frames == 4
    told.look(first, PLACES)
    told.look(rows((1.0, SeenState.LOST, 0.0), (2.0, SeenState.LOST, 0.2)), PLACES)
    told.look(other, PLACES)
    assert told.swapped == 0 and told.told["lost"] == 2


def test_an_object_that_is_not_seen_has_no_identity() -> None:
    watch = IdentityWatch(2)
    watch.look(rows((1.0, SeenState.SEEN, 0.0)), PLACES)
    assert watch.kept == 1 and watch.frames == 2


def test_the_latest_touch_or_release_is_told_and_one_that_is_missed() -> None:
    time = np.arange(0.0, 3.0, 1e-3)
    true = ((time > 1.0) & (time < 2.0)).astype(float)
    early = ((time > 0.6) & (time < 1.613)).astype(float)
    columns = {"in_contact": true, "operator_contact": early}
    recording = Recording(time, {**columns, **{f"position_{axis}": 0.0 * time for axis in "xyz"}}, "test")
    assert abs((latest(recording, 0.4) or 0.0) - 0.013) < 2e-3
    columns["operator_contact"] = 0.0 * time
    recording = Recording(time, {**columns, **{f"position_{axis}": 0.0 * time for axis in "xyz"}}, "test")
    assert latest(recording, 0.4) is None


def test_the_report_says_what_is_reached_and_what_is_missed() -> None:
    visits = (Visit("sponge", 0, 0.5, 0.2), Visit("sponge", 1, 0.02, 0.01), Visit("brick", 1, 0.2, 0.1))
    carried = CarriedObject(0.15, 0.001, 0.02, 0.001, 7.0, 0.06, 0.2, 0)
    case = SceneCase(0, "own", visits, carried, 0.01, 0.01, 0.0, 4.0, 30.0, 0.95, 0, {"seen": 3})
    verdicts = {(each.case, each.target.figure): each.reached for each in CASES.report([case]).reached}
    second = "first 0.5 s of a touch of a known object, worst"
    assert verdicts["own, seed 0, sponge", second] and not verdicts["own, seed 0, brick", second]
    missed = {figure for (name, figure), reached in verdicts.items() if name == "own, seed 0" and not reached}
    assert missed == {"force while an object is carried"}


def test_the_median_of_second_touches_is_told_by_object_and_plant() -> None:
    visits = [(Visit("sponge", 0, 0.5, 0.2), Visit("sponge", 1, error, 0.01)) for error in (0.01, 0.02, 0.09)]
    cases = [SceneCase(i, "own", some, None, 0.0, 0.0, 0.0, 3.0, 0.0, 1.0, 0, {}) for i, some in enumerate(visits)]
    told = " ".join(judge(cases, 0).sentences)
    assert "at the second touch, own plant: sponge 2 %; foreign plant: none" in told
