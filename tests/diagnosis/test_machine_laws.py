"""Laws that machines have, each concealed in a driven pendulum and named with its numbers."""

from collections.abc import Mapping

import numpy as np
import pytest
from scipy.signal import TransferFunction, lsim

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.effects import LIBRARY
from mmt_drake.model_files import parse_model
from mmt_drake.recording.check import completed
from mmt_drake.simulation import simulate

NOMINAL = {
    "structure": "driven_body",
    "parameters": {"m": 0.3, "b": 0.9},
    "gravity": {"kind": "pendulum", "value": 3.0},
    "units": {"position": "rad", "force": "N m"},
}
TRIED = ("gravity_offset", "torque_ripple", "dead_band", "coulomb_friction", "constant_force")
TIME = np.arange(3000) * 0.005
INPUT = sum(
    level * np.sin(2.0 * np.pi * hertz * TIME + phase)
    for level, hertz, phase in ((2.0, 0.13, 5.9), (1.5, 0.37, 0.3), (1.0, 0.71, 5.8), (0.6, 1.3, 5.1))
)


@pytest.mark.parametrize(
    ("name", "values", "units"),
    [
        ("gravity_offset", {"angle": 0.15}, ["rad"]),
        ("torque_ripple", {"amplitude": 0.5, "period": 0.11, "phase": 1.0}, ["N m", "rad", "rad"]),
        ("dead_band", {"width": 1.2}, ["1"]),
    ],
)
def test_a_law_of_machines_is_named(name: str, values: Mapping[str, float], units: list[str]) -> None:
    still = completed(TIME, {"input": INPUT, "output": 0.0 * TIME}, "servo")
    truth = parse_model({**NOMINAL, "effects": [{"name": name, "parameters": values}]}, "truth")
    noise = np.random.default_rng(4).normal(0.0, 2e-4, len(TIME))
    recording = completed(TIME, {"input": INPUT, "output": simulate(truth, still)["output"] + noise}, "servo")
    model, library = parse_model(dict(NOMINAL), "nominal"), [LIBRARY[other] for other in TRIED]
    (found,) = diagnose([recording], model, library=library).diagnosis.effects
    assert (found.name, found.certain) == (name, "law")
    assert {symbol: p.value for symbol, p in found.parameters.items()} == pytest.approx(values, rel=0.02)
    assert [p.unit for p in found.parameters.values()] == units


@pytest.mark.parametrize("tau", [0.03, 0.1])
def test_a_drive_that_lags_is_no_delay_beside_a_second_mass(tau: float) -> None:
    body = {"m": 0.5, "b": 1.2, "k": 20.0}
    output = TransferFunction([1.0], np.polymul([tau, 1.0], [body["m"], body["b"], body["k"]]))
    noise = np.random.default_rng(7).normal(0.0, 2e-5, len(TIME))
    x = lsim(output, INPUT - INPUT[0], TIME)[1] + INPUT[0] / body["k"] + noise
    believed = parse_model({"structure": "driven_body", "parameters": {"m": 0.6, "b": 1.0, "k": 25.0}}, "believed")
    library = [LIBRARY[name] for name in ("input_lag", "time_delay", "second_mode", "coulomb_friction")]
    told = diagnose([completed(TIME, {"input": INPUT, "output": x}, "lsim")], believed, library=library).diagnosis
    (found,) = told.effects
    assert (found.name, found.certain) == ("input_lag", "law")
    assert found.parameters["tau"].value == pytest.approx(tau, rel=0.02)
    assert {name: p.value for name, p in told.parameters.items()} == pytest.approx(body, rel=0.02)
