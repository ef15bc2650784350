"""The notebook of the ablation: it runs, and its runs reproduce what they are to, each judged by its recording."""

import html
import json

import pytest

from mmt_drake.analysis.metrics import measure
from mmt_drake.diagrams.proof.experiments.ablation.claims import CLAIMS, REFERENCES
from mmt_drake.diagrams.proof.experiments.ablation.report import ablation as experiment
from mmt_drake.diagrams.proof.experiments.ablation.report import short_table
from mmt_drake.diagrams.proof.experiments.ablation.run import RUNS
from mmt_drake.recording import load

NO_FILTER = "output error, not equation error"
NOTHING, LOST = "nothing", "velocity of the input lost"


@pytest.fixture(scope="module")
def ablation(run_notebook):
    left = run_notebook("ablation")
    assert left.stderr == "" and left.stdout
    yield left
    left.folder.cleanup()


@pytest.fixture(scope="module")
def report(ablation):
    return experiment().report(ablation.asked, ablation.cases)


def test_the_figures_of_experiment_1_need_a_cause_against_the_raw_force_and_none_against_the_filtered_one(ablation):
    nothing, lost = (ablation.verdicts[name] for name in (NOTHING, LOST))
    assert nothing.figures("raw") == (35,)
    assert {24, 26, 27, 28, 29} <= set(lost.figures("raw"))
    assert {10, *range(24, 31), 35} <= set(nothing.figures("filtered"))


def test_no_estimated_force_is_near_the_raw_one_behind_the_filters(ablation):
    against = [verdict.against["raw"].estimated for name, verdict in ablation.verdicts.items() if name != NO_FILTER]
    assert min(against) > 0.8
    assert max(verdict.against["filtered"].estimated for verdict in ablation.verdicts.values()) < 0.1


def test_the_delayed_run_is_800_ms_late_whatever_is_put_in(ablation):
    assert all(35 in verdict.figures(name) for verdict in ablation.verdicts.values() for name in REFERENCES)


def test_every_case_can_be_computed_again_from_its_recording(ablation, report):
    cases = json.loads(json.dumps(report.document, allow_nan=False))["cases"]
    assert {(case["cause"], case["run"]) for case in cases} == {(name, run) for name in ablation.names for run in RUNS}
    for case in cases[:: len(RUNS) + 1]:  # each run in turn
        again = measure(load(case["recording"]), delay_s=case["delay_s"])
        assert again.rendered_error.tangential["all"] == case["rendered_error"]["all"]
        again = measure(load(case["recording"]), delay_s=case["delay_s"], measured="filtered_force")
        assert again.rendered_error.tangential["all"] == case["rendered_error_filtered"]["all"]


def test_every_cause_stands_beside_the_thesis_and_what_is_to_reach(ablation, report):
    told = {(each["case"], each["figure"]): each for each in report.document["figures_to_reach"]}
    for name in (NOTHING, LOST):
        high = told[name, "rendered force, 3 to 10 Hz"]
        assert (high["thesis"], high["to_reach"]) == (1.0, 0.005)
        assert high["value"] == ablation.verdicts[name].cases["running"].true_error.tangential["3_to_10_hz"]
        assert told[name, "longest lag of a release"]["verdict"] == "missed"  # 800 ms, as in the thesis
    assert told[LOST, "rendered force, 3 to 10 Hz"]["verdict"] == "missed"


def test_a_rendered_force_without_velocity_has_other_spikes_than_the_estimated_one(ablation):
    nothing, lost = (ablation.verdicts[name].against["raw"].spikes for name in (NOTHING, LOST))
    assert nothing < 0.1
    assert lost > 0.4


def test_the_page_shows_every_cause_every_figure_and_what_counts(ablation, report, tmp_path):
    page = html.unescape(report.write(tmp_path).read_text())
    assert (tmp_path / "ablation.png").is_file()
    assert all(name in page for name in ablation.names)
    assert all(claim.needs in page for claim in CLAIMS)
    thesis, most, *rows = short_table(list(ablation.verdicts.values())).rows
    assert [row[0] for row in rows] == list(ablation.names)
    assert thesis[1:5] == thesis[6:10] == pytest.approx([30.0, 100.0, 100.0, 5.0])
    assert most[1:4] == pytest.approx([0.5] * 3)
    assert rows[ablation.names.index(LOST)][-1] == "missed in 3 bands"
    needless = "If it was the filtered force, none is needed for 10, 24 to 30."
    assert needless in report.sentences and needless in page
