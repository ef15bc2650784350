"""A tip that is elsewhere than recorded, on a hand that turns: found where it is, and not where it is not."""

import pytest
from palpation_samples import palpation

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.model_files import with_effects
from mmt_drake.replay import replayed
from mmt_drake.simulation import simulate

BELIEVED = SurfaceContact(k=400.0, b=0.5)
SEARCHED = [LIBRARY[name] for name in ("surface_shape", "probe_slip", "tool_offset", "coulomb_friction")]
TOOL = (0.004, -0.003, 0.006)


def with_tool(model):
    entry = {"name": "tool_offset", "parameters": dict(zip("xyz", TOOL, strict=True))}
    return with_effects(model, [entry], "test")


@pytest.fixture(scope="module")
def outcome():
    return diagnose([palpation(tool=TOOL)], BELIEVED, library=SEARCHED)


def test_it_is_named_on_a_level_surface_and_found_again(outcome):
    (effect,) = outcome.diagnosis.effects
    assert (effect.name, effect.certain) == ("tool_offset", "law")
    assert [effect.parameters[axis].value for axis in "xyz"] == pytest.approx(TOOL, abs=1e-4)
    for axis, truth in zip("xyz", TOOL, strict=True):
        low, high = effect.parameters[axis].ci95
        assert low < truth < high


def test_what_is_delivered_simulates_in_drake_as_it_was_replayed(outcome):
    recording, model = outcome.prepared.recordings[0], outcome.best.model
    for name, force in replayed(model, recording).items():
        assert simulate(model, recording)[name] == pytest.approx(force, abs=1e-12)


def test_beside_a_dome_and_a_tip_that_slips_each_is_named():
    found = diagnose([palpation(radius=0.08, mu=0.3, tool=TOOL)], BELIEVED, library=SEARCHED).diagnosis
    assert {e.name for e in found.effects} == {"surface_shape", "probe_slip", "tool_offset"}
    tool = next(e for e in found.effects if e.name == "tool_offset").parameters
    assert [tool[axis].value for axis in "xy"] == pytest.approx(TOOL[:2], abs=3e-4)
    # Along its own axis the hand moves the tip by a fiftieth of the offset, and a surface can follow that.
    assert tool["z"].value == pytest.approx(TOOL[2], abs=2e-3)


def test_a_hand_that_turns_about_its_very_tip_has_no_offset():
    found = diagnose([palpation(radius=0.08, seed=1, tool=(0.0, 0.0, 0.0))], BELIEVED, library=SEARCHED).diagnosis
    assert [(e.name, e.certain) for e in found.effects] == [("surface_shape", "law")]


def test_it_is_believed_when_handed_in():
    found = diagnose([palpation(tool=TOOL, seed=2)], with_tool(BELIEVED), library=SEARCHED).diagnosis
    assert (found.verdict, found.effects) == ("parameters", ())


@pytest.mark.parametrize("what", [simulate, lambda model, recording: diagnose([recording], model)])
def test_a_recording_without_orientation_is_refused_by_its_columns(what):
    with pytest.raises(BadInput, match="orientation_x"):
        what(with_tool(BELIEVED), palpation())
