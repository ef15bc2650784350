"""What rubs in a station is named, by the recordings and the model of the notebook on diagnosis."""

import pytest

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.recording import load


def test_coulomb_friction_of_the_station_has_its_name_and_no_law_of_which_it_is_a_limit(tmp_path):
    noise = {"force": 0.02, "position": 1e-5, "velocity": 5e-4}
    sensors = [f"environment.noise.{name}={value}" for name, value in noise.items()]
    rubbing = [f"environment.object.friction.{name}" for name in ("Fs=0.5", "Fd=0.5", "v_d=0.0")]
    file = tmp_path / "contact.mcap"
    build_station(load_scenario("setup1", ["duration=15", *sensors, *rubbing]), record=file).simulate()
    believed = FlexibleBoxModel(
        BoxParameters(m=1.0, k1=0.0, k2=500.0, b1=60.0, b2=60.0), NormalContact(500.0, 60.0), in_plane=None
    )
    outcome = diagnose([load(file)], believed)
    (found,) = outcome.diagnosis.effects
    assert (outcome.diagnosis.verdict, found.name) == ("missing_physics", "coulomb_friction")
    assert found.parameters["Fc"].value == pytest.approx(0.5, rel=0.01)
