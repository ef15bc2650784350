"""Experiments give the numbers of the recordings they leave, and say what the numbers say."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mmt_drake.analysis.lags import Lags
from mmt_drake.diagrams.proof.experiments.changes import NOISE
from mmt_drake.diagrams.proof.experiments.findings import findings, smeared
from mmt_drake.diagrams.proof.experiments.report import EXPERIMENTS
from mmt_drake.diagrams.proof.experiments.runs import MeasuredRun, run_case, run_cases
from mmt_drake.diagrams.proof.experiments.targets import RENDERED
from mmt_drake.diagrams.proof.experiments.thesis import (
    DELAYED,
    FIGURES,
    FREEZE_AFTER_S,
    FROZEN,
    MAIN,
    NOT_THE_THESIS_S,
    OUTPUT_ERROR,
    SECOND_DETECTOR,
    SETTLE_S,
    SETTLED,
    figures_to_reach,
    thesis_cases,
)
from mmt_drake.diagrams.proof.studies import Asked
from mmt_drake.diagrams.proof.studies.study import NOISE_FORBIDS, Reached, Target, reached_table
from mmt_drake.diagrams.stations.hands import Scripted
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.errors import BadInput
from mmt_drake.model.regrouping import EQUATIONS
from mmt_drake.recording import Recording, load

SECONDS = 11.0  # the parameters freeze in the first half, at 5.4 s
BANDS = ("all", "below_0.3_hz", "0.3_to_3_hz", "3_to_10_hz")


@pytest.fixture(scope="module")
def one(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """Experiment 1 with two of the ways of solving eq. 30: its cases and their report."""
    chosen = (MAIN, "thesis_rls_without_c", SETTLED, OUTPUT_ERROR, FROZEN)
    made = thesis_cases(1, seconds=SECONDS)
    experiment = replace(EXPERIMENTS[1], cases=lambda asked: {name: made[name] for name in chosen})
    asked = Asked(tmp_path_factory.mktemp("one"), seconds=SECONDS)
    cases = experiment.run(asked)
    return SimpleNamespace(cases=cases, report=experiment.report(asked, cases))


def off(case: MeasuredRun, recording: Recording, delay_steps: int = 0) -> float:
    """Error of the rendered force by the contract's words, from the recording alone."""
    contact = recording["in_contact"] == 1.0
    counts = contact & (np.cumsum(contact) * case.scenario.step > 5.0)
    measured = recording.vector("force")[:, :2]
    rendered = np.roll(recording.vector("rendered_force")[:, :2], delay_steps, axis=0)
    return float(np.linalg.norm((rendered - measured)[counts]) / np.linalg.norm(measured[counts]))


def motion_with_two_lifts() -> Recording:
    """Strokes of three sines along y and two along x, lifted at 7 and at 9.5 s for half a second."""
    time = np.arange(0.0, 12.0, 1e-3)
    y = 0.02 * np.sin(2 * np.pi * 0.4 * time) + 0.006 * np.sin(2 * np.pi * 1.7 * time)
    y += 0.003 * np.sin(2 * np.pi * 3.6 * time)
    x = 0.01 * np.sin(2 * np.pi * 0.7 * time) + 0.003 * np.sin(2 * np.pi * 2.9 * time)
    z = np.full_like(time, -0.004)
    for start in (7.0, 9.5):
        phase = np.clip((time - start) / 0.5, 0.0, 1.0)
        z += 0.012 * np.sin(np.pi * phase) ** 2
    return Recording(time, {"position_x": x, "position_y": y, "position_z": z}, source="two_lifts.csv")


def test_there_is_a_case_for_each_way_of_solving_equation_30_and_one_frozen_in_experiment_1():
    for number in EXPERIMENTS:
        cases = thesis_cases(number, seed=3, seconds=20.0)
        assert [name for name in cases if name not in NOT_THE_THESIS_S] == [f"thesis_rls_{way}" for way in EQUATIONS]
        for way in EQUATIONS:
            assert cases[f"thesis_rls_{way}"].estimator.equations == way
        assert cases[SETTLED].estimator.settle == SETTLE_S == 0.5
        assert (FROZEN in cases) == (number == 1)
        assert all(case.seed == 3 and case.duration == 20.0 for case in cases.values())
        delays = {case.to_operator.delay for name, case in cases.items() if name not in DELAYED.values()}
        assert delays == {0.4 if number == 3 else 0.0}
        assert (SECOND_DETECTOR in cases) == (number == 3)
        assert {near in cases for near in DELAYED.values()} == {number == 3}
    assert thesis_cases(1)[FROZEN].estimator.freeze_after == FREEZE_AFTER_S == 5.0
    assert sorted(FIGURES[1]) == [8, 9, 10, 11, 24, 25, 26, 27, 28, 29, 30, 31]
    assert sorted(FIGURES[3]) == [14, 35]


def test_with_a_delay_the_free_running_estimator_has_noise_and_so_has_what_it_is_compared_with():
    cases = thesis_cases(3)
    noisy = {name for name, case in cases.items() if case.environment.noise == NOISE}
    assert noisy == {OUTPUT_ERROR, DELAYED[OUTPUT_ERROR]}


def test_errors_are_those_of_the_recording_that_the_case_names(one):
    for case in one.cases.values():
        error = case.metrics.rendered_error.tangential["all"]
        assert off(case, load(case.recording)) == pytest.approx(error, rel=2e-3)


def test_cases_share_motion_and_measurement_and_differ_in_what_is_rendered(one):
    recordings = {case.name: load(case.recording) for case in one.cases.values()}
    main = recordings.pop(MAIN)
    for name, recording in recordings.items():
        assert np.array_equal(recording.vector("force"), main.vector("force")), name
        assert not np.array_equal(recording.vector("rendered_force"), main.vector("rendered_force")), name
        if name not in (FROZEN, SETTLED, OUTPUT_ERROR):  # eq. 30 is solved after the estimate of the force
            assert np.array_equal(recording.vector("estimated_force"), main.vector("estimated_force")), name


def test_frozen_parameters_follow_the_free_ones_for_5_s_of_contact_and_then_stand_still(one):
    free, frozen = load(one.cases[MAIN].recording), load(one.cases[FROZEN].recording)
    learning = np.cumsum(frozen["in_contact"]) * one.cases[FROZEN].scenario.step < FREEZE_AFTER_S - 0.01
    known = np.isfinite(frozen["theta_m"])
    for name in ("m", "k1", "k2", "b1", "b2", "Fc", "normal_k", "normal_b"):
        column = f"theta_{name}"
        assert np.array_equal(frozen[column][learning], free[column][learning], equal_nan=True)
        late = frozen[column][~learning & known][20:]
        assert np.ptp(late) == 0.0 and np.ptp(free[column][-3000:]) > 0.0


def test_the_json_has_the_contract_s_keys_and_plain_values(one):
    document = one.report.document
    assert [document[key] for key in ("experiment", "scenario", "seed", "operator")] == [1, "setup1", 0, "strokes"]
    for case in document["cases"]:
        assert case["estimator"] == ("output_error" if case["name"] == OUTPUT_ERROR else "rls")
        assert case["renderer"] == "runge_kutta" and case["delay_s"] == 0.0
        for name in ("rendered_error", "rendered_error_true", "estimated_error"):
            assert set(BANDS) | {"z"} == set(case[name])
            assert all(isinstance(case[name][band], float) for band in BANDS)
        assert {"time_to_stable_s", "touch_lag_s", "release_lag_s"} <= set(case)
        assert {"m", "k1", "k2", "b1", "b2", "Fc"} <= set(case["parameters"])
        assert load(case["recording"]).kind == "contact"


def test_what_is_to_reach_stands_beside_what_is_and_what_the_thesis_says_in_every_case(one):
    figures = {(each["case"], each["figure"]): each for each in one.report.document["figures_to_reach"]}
    for case in one.cases.values():
        for band, thesis in (("below_0.3_hz", 0.3), ("0.3_to_3_hz", 1.0), ("3_to_10_hz", 1.0)):
            error = case.metrics.rendered_error_true
            if band in error.telling:
                told = figures[case.name, RENDERED[band].figure]
                assert (told["value"], told["thesis"], told["to_reach"]) == (error.tangential[band], thesis, 0.005)
                assert told["verdict"] == ("reached" if error.tangential[band] <= 0.005 else "missed")
        estimated, stable = figures[case.name, "estimated force"], figures[case.name, "stable after"]
        assert (estimated["thesis"], estimated["to_reach"], estimated["reached"]) == (0.05, None, None)
        assert (stable["thesis"], stable["to_reach"]) == (16.1, 0.5)
        # It is so by construction, which is no figure to judge.
        assert (stable["verdict"] == "by its prior") == (case.name == OUTPUT_ERROR)
    assert not any("lag" in figure or "delay" in figure for _, figure in figures)  # there is none


def test_the_table_of_figures_has_the_thesis_and_what_is_to_reach_above_the_cases(one):
    table = reached_table(one.report.reached)
    thesis, most, *rows = (dict(zip(table.headers, row, strict=True)) for row in table.texts())
    assert (thesis["case"], most["case"]) == ("the thesis", "to reach")
    assert (thesis["rendered force, below 0.3 Hz [%]"], most["rendered force, below 0.3 Hz [%]"]) == ("30", "0.5")
    assert (thesis["stable after [s of contact]"], most["stable after [s of contact]"]) == ("16.1", "0.5")
    assert [row["case"] for row in rows] == [case.name for case in one.cases.values()]
    ours = next(row for row in rows if row["case"] == OUTPUT_ERROR)
    assert ours["updates"] == "at_once" and ours["stable after [s of contact]"] == "0 (by its prior)"
    assert ours["rendered force, 3 to 10 Hz [%]"][-1] in "✓✗"


def test_a_delay_that_costs_nothing_is_told_as_reached_and_a_lost_answer_as_missed(one):
    ours = one.cases[OUTPUT_ERROR]
    lost = replace(ours.metrics, touch=Lags((1.0, 2.0), (0.0, None)), release=Lags((1.5, 9.9), (0.001, None), unseen=1))
    lost = replace(lost, delay_s=0.4)
    far, near = replace(ours, metrics=lost), replace(ours, name=DELAYED[OUTPUT_ERROR])
    found = {
        each.target.figure: each
        for each in figures_to_reach({case.name: case for case in (far, near)})
        if each.case == OUTPUT_ERROR
    }
    assert found["error less that without the delay"].value == 0.0
    lost, late = found["longest lag of a touch"], found["longest lag of a release"]
    assert lost.reached is False and lost.cell() == "never ✗"
    assert late.reached is True and (late.target.thesis, late.target.to_reach) == (0.8, 0.001)
    assert found["rendered force, 3 to 10 Hz"].target.thesis is None  # of which it says the reverse, without a figure


def test_a_figure_is_missed_where_it_never_happened_and_not_asked_where_the_noise_forbids_it():
    target = Target("m within 5 % after", "s of contact", to_reach=3.0)
    never = Reached("a", target, None, bound=1.2, never=True)
    assert never.reached is False and never.cell() == "never / 1.2 ✗"
    forbidden = Reached("a", target, 9.0, bound=3.4, unasked=NOISE_FORBIDS)
    assert forbidden.reached is None and forbidden.cell() == "9 / 3.4"
    assert Reached("a", target, 3.0).verdict == "reached" and Reached("a", target, 3.1).verdict == "missed"
    assert Reached("a", replace(target, to_reach=None), 3.0).verdict == "nothing to reach"


def test_processes_change_no_number(tmp_path):
    made = thesis_cases(1, seconds=6.0)
    scenarios = {name: made[name] for name in (MAIN, "thesis_rls_without_c")}
    files = [{name: tmp_path / folder / f"{name}.mcap" for name in scenarios} for folder in ("here", "there")]
    here = run_cases(scenarios, files[0], Asked(tmp_path)).values()
    done = []
    there = run_cases(scenarios, files[1], Asked(tmp_path, jobs=2), done.append).values()
    assert done == [1, 2]
    assert [case.name for case in there] == [case.name for case in here]
    for a, b in zip(here, there, strict=True):
        assert a.recording.read_bytes() == b.recording.read_bytes()
        assert a.metrics == b.metrics and a.settled == b.settled


def test_with_a_delay_touch_and_release_are_answered_one_round_trip_late(tmp_path):
    scenario = replace(load_scenario("setup1-delay"), duration=None)
    case = run_case("delayed", scenario, tmp_path / "delayed.mcap", motion_with_two_lifts())
    for lags in (case.metrics.touch, case.metrics.release):
        assert len(lags.events_s) == 2
        assert lags.median_s == pytest.approx(0.8, abs=5e-3)
    assert off(case, load(case.recording), 400) == pytest.approx(
        case.metrics.rendered_error.tangential["all"], rel=2e-3
    )


def test_with_a_second_detector_touch_release_and_error_are_those_without_a_delay(tmp_path):
    scenarios, strokes = thesis_cases(3, seconds=11.9), Scripted("strokes", {"duration": 12.0})
    far, near = (
        run_case(name, replace(scenarios[name], operator=strokes), tmp_path / f"{name}.mcap")
        for name in (OUTPUT_ERROR, DELAYED[OUTPUT_ERROR])
    )
    for case in (far, near):
        assert [len(lags.events_s) >= 2 for lags in (case.metrics.touch, case.metrics.release)] == [True, True]
        # One tick is to be reached.
        assert max(map(abs, case.metrics.touch.lags_s + case.metrics.release.lags_s)) < 1e-6
    # Half a percentage point is to be reached; here a tenth of that.
    errors = [case.metrics.rendered_error.tangential["all"] for case in (far, near)]
    assert abs(errors[0] - errors[1]) < 0.0005


def test_a_run_too_short_to_count_is_bad_input_and_leaves_no_recording(tmp_path):
    with pytest.raises(BadInput, match="s of contact, expected more than the 5 s"):
        EXPERIMENTS[3].run(Asked(tmp_path, seconds=2.0))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"seconds": -1.0}, "duration"),
        ({"seed": -1}, "seed"),
        ({"jobs": 0}, "jobs: found 0, expected 1 or more"),
        ({"operator": "builtin:nobody"}, "found builtin:nobody"),
        ({"operator": "nowhere.csv"}, "nowhere.csv"),
    ],
)
def test_bad_arguments_are_told_in_one_line(tmp_path, change, told):
    with pytest.raises(BadInput) as error:
        EXPERIMENTS[1].run(Asked(tmp_path, **change))
    assert told in str(error.value) and "\n" not in str(error.value)


def test_a_folder_that_is_a_file_is_bad_input(tmp_path):
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(BadInput, match="taken"):
        EXPERIMENTS[1].run(Asked(tmp_path / "taken"))


def test_the_report_has_every_figure_of_the_plan_and_a_page_that_needs_nothing_else(one, tmp_path):
    page = one.report.write(tmp_path)
    for number in FIGURES[1]:
        assert (tmp_path / f"figure_{number:02d}.png").read_bytes().startswith(b"\x89PNG")
    text = page.read_text()
    assert text.count('src="data:image/png;base64,') == len(list(tmp_path.glob("*.png")))
    assert "src=" not in text.replace('src="data:', "") and "<link" not in text and "<script" not in text
    for number in FIGURES[1]:
        assert f"Figure {number}, case" in text


def test_where_frozen_parameters_never_stand_still_the_page_says_that_figures_11_and_31_are_missing(one):
    never = replace(one.cases[FROZEN], recording=one.cases[MAIN].recording)
    cases = {MAIN: one.cases[MAIN], FROZEN: never}
    section = EXPERIMENTS[1].judge(cases).sections[-1]
    drawn = {picture.name for picture in section.figures}
    assert drawn and not drawn & {"figure_11", "figure_31"}
    for number in (11, 31):
        told = f"Figure {number} is not drawn, the run is too short for it: theta_*: found changes up to"
        assert told in section.text


def with_bands(case: MeasuredRun, *ratios: float, peak: float = 1.0) -> MeasuredRun:
    """The case with other errors, relative to 1 N in every band."""
    error = replace(
        case.metrics.rendered_error,
        tangential=dict(zip(BANDS, ratios, strict=True)),
        reference_rms=dict.fromkeys(BANDS, 1.0),
    )
    return replace(case, peak_force=peak, metrics=replace(case.metrics, rendered_error=error))


def test_sentences_follow_the_numbers(one):
    main = one.cases[MAIN]
    rising, falling = with_bands(main, 0.5, 0.1, 0.3, 0.4), with_bands(main, 0.5, 0.4, 0.3, 0.1)

    def told(case: MeasuredRun) -> str:
        return "\n".join(findings({case.name: case}))

    assert "experiment 1: thesis_rls_all. The other way round, as it has it in experiment 3: no case" in told(rising)
    assert "experiment 1: no case. The other way round, as it has it in experiment 3: thesis_rls_all" in told(falling)


def test_a_band_larger_than_the_whole_is_named_as_smeared_from_the_wind_up(one):
    smooth = with_bands(one.cases[MAIN], 0.5, 0.1, 0.3, 0.4)
    smear = with_bands(one.cases[MAIN], 0.2, 5.0, 0.1, 0.1, peak=4321.0)
    assert smeared(smooth) == [] and smeared(smear) == ["below_0.3_hz"]
    told = "\n".join(findings({smear.name: smear}))
    assert "reached 4,321 N" in told and "below 0.3 Hz 500 %" in told


def test_the_truth_beside_the_estimates_is_the_plant_s_and_the_thesis_s(one):
    normal_and_stiction = {"normal_k": 500.0, "normal_b": 60.0, "Fs": 0.1, "v_d": 0.005}
    thesis = {"m": 1.0, "k1": 0.0, "k2": 500.0, "b1": 60.0, "b2": 60.0, "Fc": 0.05, **normal_and_stiction}
    assert one.cases[MAIN].truth == thesis
    assert thesis_cases(3)[MAIN].environment.object == thesis_cases(1)[MAIN].environment.object
