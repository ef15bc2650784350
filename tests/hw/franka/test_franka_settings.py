"""Settings of an arm, and its library where it is missing."""

import sys
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from mmt_drake.errors import BadInput, MissingDependency
from mmt_drake.hw.franka.faults import ArmFault, describe_fault
from mmt_drake.hw.franka.sdk import load_franky
from mmt_drake.hw.franka.settings import FrankaSettings
from mmt_drake.systems.cartesian_impedance import Impedance


@pytest.mark.parametrize(
    "changed, told",
    [
        ({"force": 0.0}, "force"),
        ({"impedance": Impedance(stiffness=0.0)}, "impedance.stiffness"),
        ({"load_mass": -0.1}, "load_mass"),
        ({"table": (0.0, float("inf"), 0.0)}, "table"),
        ({"low": (0.3, 0.0, 0.0)}, "low, high"),
        ({"hold_after": 0.5}, "hold_after"),
        ({"stop_ramp": 0.6}, "stop_ramp"),
        ({"address": ""}, "address"),
    ],
)
def test_a_setting_out_of_range_is_refused_in_one_line(changed: dict[str, Any], told: str) -> None:
    with pytest.raises(BadInput, match=f"^franka: {told}: found .* expected ") as error:
        FrankaSettings(**({"address": "robot"} | changed))
    assert "\n" not in str(error.value)


def test_the_table_is_turned_by_roll_then_pitch_then_yaw() -> None:
    turned = FrankaSettings("robot", rotation=(90.0, 0.0, 90.0)).rotation_matrix()
    np.testing.assert_allclose(turned @ [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], atol=1e-15)
    np.testing.assert_allclose(turned @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(turned @ turned.T, np.eye(3), atol=1e-15)


def test_a_missing_library_is_named_in_one_line_with_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "franky", None)
    with pytest.raises(MissingDependency, match=r"^franka: .*franky-control .*pip install 'mmt_drake\[franka\]'$"):
        load_franky()


def test_a_library_that_cannot_stream_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "franky", ModuleType("franky"))
    monkeypatch.setattr("importlib.metadata.version", lambda name: "1.1.4")
    with pytest.raises(MissingDependency, match=r"franky-control 2\.0 or newer not found, but 1\.1\.4"):
        load_franky()


def test_every_fault_has_words() -> None:
    assert len({describe_fault(float(fault)) for fault in ArmFault}) == len(ArmFault)
