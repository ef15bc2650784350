"""Other packages on the trial's files: that each gets the object as it is, and what its answer is worth."""

from __future__ import annotations

import dataclasses
import math
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from mmt_drake.diagrams.trial.cases import Case, draw_plain, draw_single
from mmt_drake.diagrams.trial.other_cases import draw_driven
from mmt_drake.diagrams.trial.peers import (
    Estimate,
    PeerResult,
    compare,
    extra,
    fits_tables,
    missing_extra,
    missing_lines,
    speed_lines,
    speed_ratios,
)
from mmt_drake.diagrams.trial.peers.case import PeerCase, read_case, runs
from mmt_drake.diagrams.trial.peers.mujoco_sysid import model_xml, thinned
from mmt_drake.diagrams.trial.peers.own import fit_own
from mmt_drake.diagrams.trial.peers.result import OURS, SINDY, SYSID, WITH, WITHOUT
from mmt_drake.diagrams.trial.peers.sindy import RECONSTRUCTED, RECORDED, fit_sindy
from mmt_drake.diagrams.trial.sealed import write_case
from mmt_drake.errors import BadInput, MissingDependency
from mmt_drake.model.parameters import BoxParameters

reason = missing_extra()
needs_extra = pytest.mark.skipif(reason is not None, reason=f"the extra `peers`: {reason}")


def short(case: Case) -> Case:
    """The case with a recording of 10 s."""
    return dataclasses.replace(case, session=dataclasses.replace(case.session, duration=10.0))


@pytest.fixture(scope="module")
def friction(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Case]:
    case = short(draw_single(np.random.default_rng((11, 2)), "friction", "coulomb_friction", 0.8))
    return write_case(case, tmp_path_factory.mktemp("peers")), case


@pytest.fixture(scope="module")
def friction_case(friction: tuple[Path, Case]) -> PeerCase:
    return read_case(friction[0])


def result(tool: str, setting: str, rate_hz: float, cpu_seconds: float) -> PeerResult:
    return PeerResult(tool, "1.0", setting, rate_hz, 2.0 * cpu_seconds, cpu_seconds)


def test_without_the_extra_one_line_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extra, "find_spec", lambda name: None if name == "pysindy" else find_spec("numpy"))
    with pytest.raises(MissingDependency, match=r"^peers: pysindy not found; .*\[peers\]") as caught:
        extra.peer("pysindy")
    assert "\n" not in str(caught.value)


def test_speed_is_compared_between_fits_of_the_same_numbers_alone() -> None:
    results = [
        result(OURS, WITHOUT, 250.0, 0.1),
        result(SYSID, WITHOUT, 1000.0, 2.0),
        result(OURS, WITH, 250.0, 0.2),
        result(SYSID, WITH, 1000.0, 5.0),
        result(SYSID, WITH, 250.0, 1.0),
        result(SINDY, RECORDED, 250.0, 0.1),
    ]
    ratios = speed_ratios(results)
    assert ratios == pytest.approx({(WITHOUT, 1000.0): 20.0, (WITH, 1000.0): 25.0, (WITH, 250.0): 5.0})


def test_what_is_free_has_a_table_with_a_row_for_every_fit_and_a_dash_for_what_a_package_does_not_give() -> None:
    fit = dataclasses.replace(
        result(SYSID, WITH, 1000.0, 1.0), simulations=50, estimates={"m": Estimate(0.61389, 0.0123)}
    )
    other = dataclasses.replace(fit, setting=WITHOUT, error=0.02)
    first, second = fits_tables([fit, other, result(SINDY, RECORDED, 250.0, 0.1)], "case-0001")
    assert (first.caption, second.caption) == (f"case-0001: {WITH} free", f"case-0001: {WITHOUT} free")
    assert first.texts() == [[SYSID, "1000", "1", "50", "–", "m 0.6139 ± 0.012"]]
    assert [row[4] for row in second.texts()] == ["0.02"]


def test_the_lines_below_say_how_fast_and_what_is_missing() -> None:
    own = dataclasses.replace(
        result(OURS, WITHOUT, 250.0, 0.1), before_seconds=0.25, names=("coulomb_friction",), says="It rubs."
    )
    fine = dataclasses.replace(result(SYSID, WITHOUT, 1000.0, 2.0), says="No issues.")
    rows = [own, dataclasses.replace(own, setting=WITH), fine, dataclasses.replace(fine, rate_hz=250.0)]
    rows.append(dataclasses.replace(result(SINDY, RECORDED, 250.0, 0.1), says="f'' = v"))
    first, second = speed_lines(rows)
    assert first.startswith("mujoco.sysid takes 20 times as long at 1000 samples/s, 20 times as long at 250 samples/s;")
    assert first.endswith("in 0.25 s")
    assert "times as long" not in second
    assert missing_lines(rows) == [
        "mmt_drake: coulomb_friction. It rubs.",
        "mujoco.sysid: nothing. No issues.",
        f"pysindy, {RECORDED}: nothing. f'' = v",
    ]


def test_runs_are_the_stretches_of_true_flags() -> None:
    assert runs(np.array([True, True, False, False, True])) == [(0, 2), (4, 5)]
    assert runs(np.zeros(3, dtype=bool)) == []


def test_every_touch_starts_unstretched_and_holds_what_was_recorded(friction_case: PeerCase) -> None:
    recording = friction_case.recording
    contact = recording["in_contact"] != 0.0
    assert sum(len(touch.time) for touch in friction_case.touches) == pytest.approx(np.count_nonzero(contact), abs=4)
    for touch in friction_case.touches:
        # At touch the probe moves by less than a sample's way, and 1e-5 m is its noise.
        assert abs(touch.stretch[0]) < 1e-3 * np.abs(touch.velocity[:5]).max() + 6e-5
        here = slice(touch.first, touch.first + len(touch.time))
        assert np.array_equal(touch.force, recording["force_y"][here])


def test_a_case_of_another_structure_is_refused(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    folder = write_case(draw_driven(rng, "driven", "viscous_friction", 0.5, wrong=False), tmp_path)
    with pytest.raises(BadInput, match="structure: found driven_body, expected flexible_box"):
        read_case(folder)


def test_a_ground_spring_whose_rest_only_whole_recordings_tell_is_refused(
    friction: tuple[Path, Case], tmp_path: Path
) -> None:
    case = friction[1]
    nominal = {**case.nominal, "parameters": {**case.nominal["parameters"], "k1": 30.0}}
    with pytest.raises(BadInput, match=r"k1: found 30\.0, expected 0"):
        read_case(write_case(dataclasses.replace(case, nominal=nominal), tmp_path))


def test_the_own_fit_with_friction_finds_what_is_concealed(
    friction: tuple[Path, Case], friction_case: PeerCase
) -> None:
    without, with_ = (fit_own(friction_case, friction=free) for free in (False, True))
    (concealed,) = friction[1].effects
    assert with_.estimates["Fc"].value == pytest.approx(concealed.parameters["Fc"], rel=0.03)
    assert with_.estimates["m"].value == pytest.approx(friction[1].base["m"], rel=0.05)
    assert with_.error is not None and without.error is not None
    assert with_.error < 0.5 * without.error


def test_the_own_row_speaks_with_the_diagnosis_words(friction_case: PeerCase) -> None:
    answer = {"verdict": "missing_physics", "summary": "It rubs.", "effects": [{"name": "coulomb_friction"}]}
    row = fit_own(friction_case, friction=False, diagnosis=answer)
    assert row.names == ("coulomb_friction",)
    assert row.says == "missing_physics: It rubs."


@needs_extra
@pytest.mark.parametrize("hertz", [0.7, 2.0, 4.0])
def test_the_object_in_mujoco_has_the_exact_transfer_function(hertz: float) -> None:
    mujoco = extra.peer("mujoco")
    own, h, amplitude = BoxParameters(m=0.7, k1=60.0, k2=450.0, b1=20.0, b2=35.0), 2e-4, 0.01
    model = mujoco.MjModel.from_xml_string(model_xml(own, h))
    data = mujoco.MjData(model)
    s = 2j * math.pi * hertz
    t = h * np.arange(round((3.0 + 2.0 / hertz) / h))
    force = np.empty(len(t))
    for i, phase in enumerate(s * t):
        data.ctrl[:] = amplitude * np.exp(phase).imag, amplitude * (s * np.exp(phase)).imag
        mujoco.mj_step(model, data)
        force[i] = data.sensordata[0]  # read before the step
    late = t >= t[-1] - 1.0 / hertz
    measured = 2.0 * np.mean(force[late] * 1j * np.exp(-s * t[late]))
    contact, body = own.k2 + own.b2 * s, own.m * s**2 + own.b1 * s + own.k1
    exact = contact * body / (contact + body) * amplitude
    # Held controls are half a step late: 2e-4 s / 2 * 2 pi 4 Hz = 0.25 %.
    assert abs(measured - exact) < 5e-3 * abs(exact)


@needs_extra
def test_sindy_finds_the_equation_of_a_body_that_hides_nothing(tmp_path: Path) -> None:
    seeds = (draw_plain(np.random.default_rng(seed), "plain", wrong=False) for seed in range(50))
    case = short(next(c for c in seeds if c.base["Fc"] == 0.0 and c.base["k1"] == 0.0))
    found = fit_sindy(read_case(write_case(case, tmp_path)), setting=RECONSTRUCTED)
    assert found.names == ()
    assert found.estimates["m"].value == pytest.approx(case.base["m"], rel=0.15)
    assert found.estimates["b1"].value == pytest.approx(case.base["b1"], rel=0.05)
    assert found.says.startswith("v_m' = ")


@pytest.fixture(scope="module")
def results(friction: tuple[Path, Case]) -> list[PeerResult]:
    return compare(friction[0])


@needs_extra
def test_a_comparison_runs_every_package_on_the_same_case(results: list[PeerResult], friction_case: PeerCase) -> None:
    every = thinned(friction_case)
    assert every > 1
    fits = [(r.tool, r.setting, r.rate_hz) for r in results if r.tool != SINDY]
    assert fits == [
        (tool, setting, rate)
        for setting in (WITHOUT, WITH)
        for tool, rate in ((OURS, 1000.0 / every), (SYSID, 1000.0), (SYSID, 1000.0 / every))
    ]
    assert [r.setting for r in results if r.tool == SINDY] == [RECORDED, RECONSTRUCTED]
    assert all(ratio > 1.0 for ratio in speed_ratios(results).values())
    assert [len(table.rows) for table in fits_tables(results)] == [3, 3]


@needs_extra
def test_sysid_agrees_where_it_is_told_of_friction_and_names_nothing_where_it_is_not(
    results: list[PeerResult], friction: tuple[Path, Case]
) -> None:
    runs_of = {r.setting: r for r in results if (r.tool, r.rate_hz) == (SYSID, 1000.0)}
    without, with_ = runs_of[WITHOUT], runs_of[WITH]
    (concealed,) = friction[1].effects
    assert with_.estimates["Fc"].value == pytest.approx(concealed.parameters["Fc"], rel=0.05)
    assert with_.estimates["k2"].value == pytest.approx(friction[1].base["k2"], rel=0.1)
    assert with_.error is not None and without.error is not None
    assert with_.error < 0.5 * without.error
    assert without.names == ()
    assert without.says
    assert without.simulations is not None and without.simulations > len(without.estimates)
