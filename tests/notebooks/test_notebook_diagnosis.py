"""The notebook of the diagnosis: it runs, and finds every cause in the block that it was put into."""

from functools import partial

import numpy as np
import pytest

import mmt_drake.diagnosis.diagnose as steps
from mmt_drake.diagnosis.tell.report_tables import block_table
from mmt_drake.diagrams.proof.experiments import own_mismatch
from mmt_drake.diagrams.proof.experiments.own_mismatch import CAUSES, error_table
from mmt_drake.effects import LIBRARY

SOME = ("coulomb_friction", "static_friction", "quadratic_drag", "force_bias")
SECONDS = 9.0


@pytest.fixture(scope="module")
def left(run_notebook):
    """As the notebook has it, but that few effects are tried, and causes in shorter runs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(steps, "LIBRARY", {name: LIBRARY[name] for name in SOME})
        patch.setattr(own_mismatch, "believed", partial(own_mismatch.believed, SECONDS))
        left = run_notebook("diagnosis")
    assert left.stderr == "" and left.stdout
    yield left
    left.folder.cleanup()


@pytest.fixture(scope="module")
def trials(left):
    return left.trials


def test_every_cause_is_found_in_its_block_and_in_no_other(trials):
    assert [trial.cause for trial in trials] == list(CAUSES)
    for trial in trials:
        assert trial.right, (trial.cause.name, trial.named)


def test_a_cause_makes_the_rendered_force_worse_and_all_else_stays_as_recorded(trials):
    none, by_name = trials[0], {trial.cause.name: trial for trial in trials}
    assert none.rendered_error["all"] < 0.1
    for cause in CAUSES[2:]:
        trial = by_name[cause.name]
        assert trial.rendered_error["all"] > 1.5 * none.rendered_error["all"], cause.name
        if cause.group == "renderer":
            differing = {
                n for n, v in trial.recording.columns.items() if not np.array_equal(v, none.recording[n], True)
            }
            of_the_renderer = {f"{name}_{axis}" for name in ("rendered_force", "update_jump") for axis in "xyz"}
            assert {"rendered_force_x", "rendered_force_y"} <= differing <= of_the_renderer | {"stored_energy"}
    # Without velocity: as large as the signal at high, small at low frequencies. Without d: the other way round.
    lost = by_name["renderer's input without velocity"].rendered_error
    assert lost["3_to_10_hz"] > 0.7 and lost["below_0.3_hz"] < lost["3_to_10_hz"] / 2
    without_d = by_name["eq. 30 solved without d"].rendered_error
    assert without_d["below_0.3_hz"] > 2 * without_d["3_to_10_hz"]


def test_the_tables_say_what_was_put_where_and_what_was_named(trials):
    rows = error_table(trials).texts()
    assert rows[0][:2] == ["none", "no block"] and rows[0][-1] == "no block"
    assert [row[1] for row in rows] == [row[-1] for row in rows]
    named = [row for row in block_table(trials[3].replays).texts() if row[0] == "renderer"]
    assert named[0][1] == "rendered_force" and "late" in named[0][3]
