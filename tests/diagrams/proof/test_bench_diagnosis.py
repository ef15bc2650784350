"""`mmt-drake bench diagnosis`: it measures what it says, and what it counts would come out otherwise if it were so."""

import sys

import numpy as np
import pytest

import mmt_drake.diagnosis.diagnose
from mmt_drake.diagrams.proof.bench import GROUPS, contacts, diagnosis, measurements
from mmt_drake.diagrams.proof.bench.contacts import KINDS, material_tests
from mmt_drake.diagrams.proof.trial.cases import Case
from mmt_drake.diagrams.proof.trial.laws import INSIDE, OUTSIDE
from mmt_drake.diagrams.proof.trial.other_cases import draw_material
from mmt_drake.diagrams.proof.trial.real.preparation import beginning
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import MissingDependency

_FEW = ("coulomb_friction", "quadratic_drag", "nonlinear_stiffness")


def short_contacts() -> dict[str, Case]:
    """Two springs, of which a diagnosis takes a second or two."""
    concealed = {"nothing concealed": None, "Coulomb friction": "coulomb_friction"}
    return {
        kind: draw_material(np.random.default_rng(3), kind, effect, 0.6, wrong=False)
        for kind, effect in concealed.items()
    }


def test_a_contact_conceals_what_its_kind_says_for_a_minute_at_1_khz() -> None:
    for kind, case in contacts.contacts().items():
        assert case.truth()["truth"] == ([] if KINDS[kind] is None else [KINDS[kind]])
        assert (case.session.duration, case.session.rate_hz) == (60.0, 1000.0)
    assert KINDS["a law outside the library"] in OUTSIDE
    assert {"coulomb_friction", "nonlinear_stiffness", "static_friction"} <= set(INSIDE)


def test_the_tests_of_a_material_are_all_different_and_the_same_again() -> None:
    found, again = material_tests(6), material_tests(6)
    assert len({case.truth()["base"]["k"] for case, _ in found}) == 6
    assert {tuple(case.truth()["truth"]) for case, _ in found} > {(), ("coulomb_friction",)}
    for (_, one), (_, other) in zip(found, again, strict=True):
        assert one.time[-1] == pytest.approx(4.999)
        np.testing.assert_array_equal(one["force"], other["force"])


def test_the_first_half_of_a_contact_is_its_first_half() -> None:
    recording = short_contacts()["Coulomb friction"].recording()
    half = beginning(recording, 8.0)
    assert len(half) == 8000
    assert all(np.array_equal(half[name], recording[name][:8000]) for name in recording.columns)


def test_speed_is_that_of_right_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mmt_drake.diagnosis.diagnose, "LIBRARY", {name: LIBRARY[name] for name in _FEW})
    monkeypatch.setattr(diagnosis, "contacts", short_contacts)
    monkeypatch.setattr(diagnosis, "cluster_measurements", lambda: iter(()))
    monkeypatch.setattr(diagnosis, "_FIRST_S", 8.0)
    monkeypatch.setattr(diagnosis, "_WARM_UP_S", 8.0)
    found = {measurement.name: measurement for measurement in measurements("diagnosis")}
    assert len(found) == 2 * 2 + 3
    *timed, right = found.values()
    assert all(measurement.value > 0.0 and measurement.target is not None for measurement in timed)
    assert (right.name, right.value, right.target) == ("of these 4 diagnoses say what was concealed", 4, 4)
    without = next(f.value for name, f in found.items() if name.endswith("library: nothing concealed"))
    with_friction = next(f.value for name, f in found.items() if name.endswith("library: Coulomb friction"))
    assert found["diagnosis of 30 s at 1 kHz, whole library: median"].value == pytest.approx(
        0.5 * (without + with_friction)
    )


def test_a_cluster_here_finds_the_same_and_a_difference_would_be_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    monkeypatch.setattr(diagnosis, "contacts", short_contacts)
    monkeypatch.setattr(diagnosis, "_RECORDINGS", 2)
    monkeypatch.setattr(diagnosis, "_CONTACT", "nothing concealed")
    monkeypatch.setattr(diagnosis, "_CONTACT_S", 8.0)
    document, here = diagnosis._document, iter(range(2))
    # One of the two documents in series is made another one; those of the workers are not reached by this.
    monkeypatch.setattr(diagnosis, "_document", lambda *given: document(*given) + " " * (next(here, 1) == 0))
    many, faster, one, slower = diagnosis.cluster_measurements()
    assert (many.value, many.target, many.met) == (1, 0.0, False)
    assert (one.value, one.target, one.met) == (0.0, 0.0, True)
    assert faster.value > 0.0 and slower.value > 0.0


def test_without_dask_one_line_says_so_before_anything_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.setattr(diagnosis, "contacts", lambda: pytest.fail("measured"))
    with pytest.raises(MissingDependency, match="mmt_drake\\[cluster\\]"):
        next(measurements("diagnosis"))
    assert set(GROUPS) == {"quick", "diagnosis", "pacing", "haptics", "learning", "arms"}
