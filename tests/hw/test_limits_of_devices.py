"""Every option that guards a hand or an arm: bounded by the device, and told and asked about when it is loosened."""

import dataclasses
import json
import math
from argparse import Namespace
from typing import Any

import numpy as np
import pytest

from mmt_drake.ceilings import Option, looser_options, options
from mmt_drake.cli.hardware import loosened_limits
from mmt_drake.cli.main import main
from mmt_drake.diagrams.proof.faults.supervisor import PERIOD, Inputs, armed_bench
from mmt_drake.diagrams.stations import scenario as scenario_module
from mmt_drake.diagrams.stations.device_options import Franka, Omega
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario, shipped
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.diagrams.stations.surfaces import DepthCamera
from mmt_drake.errors import BadInput
from mmt_drake.hw.link.options import LinkOptions
from mmt_drake.hw.omega.settings import Trigger
from mmt_drake.hw.safety.limits import STOP_WITHIN, SafetyLimits
from mmt_drake.recording import load, save
from mmt_drake.systems.cartesian_impedance import Impedance
from mmt_drake.viewer import charts

CAMERA = "environment.cloud=!DepthCamera {extrinsics: camera.yaml}"
TABLE = tuple(option for option in options(load_scenario("setup3", [CAMERA])) if "telerobot." not in option.path)
LINK = tuple(options(LinkOptions(), "link"))
LIMITS = [option for option in (*TABLE, *LINK) if not option.bound.fact]
NUMBERS = [option for option in (*TABLE, *LINK) if not option.bound.order]
#: What must be longer for an option to reach its bound.
LONGER = {"telerobot_device.stop_ramp": ["telerobot_device.stop_within=1.0"]}
#: Where a device is, what it holds and how it looks at it: nothing to loosen.
FACTS = {
    Omega: "library device gravity_compensation rotation centre origin clutch_button trigger",
    Trigger: "open closed grip",
    Franka: "address table rotation tip load_centre",
    LinkOptions: "playout cloud_points cloud_interval",
    DepthCamera: "extrinsics serial recording width height rate",
    SafetyLimits: "",
    Impedance: "",
}


#: Shipped value and bound, as docs/lab.md tells them: no change of one goes unseen.
SHIPPED = """\
operator_device: velocity_window 0.01 0.02, watchdog 0.015 0.02, force 8 12, scale 1 5, force_scale 1 5
operator_device.limits: force 6 12, power 5 24, speed 1 2, low -0.2 -0.2 -0.2 0.855, high 0.2 0.2 0.2 0.855
operator_device.limits: gap 0.01 0.02, stuck 0.1 0.2, ramp 0.015 0.02, rise 0.25 0.02
telerobot_device: load_mass 0 3, pull 30 65, force 25 65, collision_force 40 140, collision_torque 40 87
telerobot_device.impedance: stiffness 1500 3000, damping 120 490, rotational_stiffness 100 300, rotational_damping 5 38
telerobot_device.impedance: posture_stiffness 10 100, posture_damping 3 20
telerobot_device: speed 0.5 1.7, tip_speed 0.75 1.7, low -0.2 -0.2 -0.05 0.855, high 0.2 0.2 0.3 0.855
telerobot_device: approach 0.05 0.25, jump 0.02 0.05, gap 0.05 0.5, hold_after 0.02 0.1, stop_after 0.5 2
telerobot_device: stop_ramp 0.1 0.5, stop_within 0.5 1
environment.cloud: stale 0.25 1
link: timeout 0.1 2, oldest 0.5 5
"""


def path(option: Option) -> str:
    return option.path


def towards_bound(option: Option, share: float) -> Any:
    """A value between the default (0) and the bound (1), or beyond it."""
    if option.bound.order:
        return option.bound.order[-1]
    if isinstance(option.default, tuple):
        return [math.copysign(abs(x) + share * (option.bound.limit - abs(x)), x) for x in option.default]
    return option.bound.limit if share == 1.0 else option.default + share * (option.bound.limit - option.default)


def with_value(option: Option, value: Any) -> Scenario | LinkOptions:
    if option.path.startswith("link."):
        return LinkOptions(**{option.path.removeprefix("link."): value})
    change = f"{option.path}={json.dumps(value)}"
    return load_scenario("setup3", [CAMERA, *LONGER.get(option.path, []), change])


def loosened(option: Option, value: Any) -> list[str]:
    made = with_value(option, value)
    found = looser_options(made, "link") if isinstance(made, LinkOptions) else scenario_module.loosened(made)
    return [option.path for option in found]


def command_line(option: Option, value: Any) -> list[str]:
    line = ["run", "setup3", "--hardware", "--set", CAMERA]
    if option in LINK:
        beside = ["--side", "operator", "--realtime", "--peer", "a", "--key", "b"]
        return [*line, *beside, "--link", f"{option.path.removeprefix('link.')}={value}"]
    return [*line, "--set", f"{option.path}={json.dumps(value)}"]


def test_shipped_values_and_bounds_are_those_that_are_told() -> None:
    told = {}
    for line in SHIPPED.splitlines():
        owner, _, rest = line.partition(": ")
        told |= {f"{owner}.{name}": tuple(map(float, numbers)) for name, *numbers in map(str.split, rest.split(", "))}
    assert told == {o.path: (*np.atleast_1d(o.default).tolist(), o.bound.limit) for o in NUMBERS}
    assert [o.path for o in NUMBERS if o.bound.least] == ["operator_device.limits.rise"]


@pytest.mark.parametrize("option", NUMBERS, ids=path)
def test_an_option_may_reach_its_bound_and_go_no_further(option: Option) -> None:
    with_value(option, towards_bound(option, 1.0))
    most = f"at {'least' if option.bound.least else 'most'} {option.bound.limit:g}"
    name = option.path.removeprefix("link.")
    with pytest.raises(BadInput, match=rf"{name}: found .*, expected {most} "):
        with_value(option, towards_bound(option, 1.01))


@pytest.mark.parametrize("option", LIMITS, ids=path)
def test_what_is_looser_than_shipped_is_told_and_needs_a_word_with_hardware(
    option: Option, capsys: pytest.CaptureFixture[str]
) -> None:
    value = towards_bound(option, 0.5)
    assert option.path not in loosened(option, option.default) and option.path in loosened(option, value)
    assert main(command_line(option, value)) == 2
    refused = capsys.readouterr().err
    assert refused.count("\n") == 1 and "--loosened-limits" in refused and f"{option.path} = " in refused


@pytest.mark.parametrize("schema", FACTS, ids=lambda schema: schema.__name__)
def test_no_option_is_without_a_bound_but_those_that_guard_nothing(schema: type) -> None:
    given = {"address": "robot"} if schema is Franka else {"extrinsics": "x"} if schema is DepthCamera else {}
    bounded = {option.path.split(".")[0] for option in options(schema(**given))}
    held = {"compensation", "settings", "smooth"}  # what is made of a measurement moves nothing
    assert {field.name for field in dataclasses.fields(schema)} - bounded - held == set(FACTS[schema].split())


def test_with_the_word_each_is_told_and_a_csv_admits_that_it_cannot(capsys: pytest.CaptureFixture[str]) -> None:
    scenario = load_scenario("setup1", ["operator_device.watchdog=null", "operator_device.calibration=none"])
    given = {"hardware": True, "loosened_limits": True, "sliders_move_hardware": True, "side": None, "record": "a.csv"}
    told = loosened_limits(Namespace(**given), scenario)
    assert "sliders_move_hardware = yes, looser than no" in told
    assert "operator_device.calibration = none, looser than required" in told
    assert any("watchdog = null" in line and "a process that hangs leaves its last force" in line for line in told)
    said = capsys.readouterr().err
    assert said.count("limit: ") == 4 and "a.csv cannot say so" in said


def test_the_recording_and_the_view_say_what_was_loosened(tmp_path: Any) -> None:
    changes = ["duration=0.1", "operator_device.watchdog=null", "operator_device.limits.low=[-0.3, 0, 0]"]
    station = build_station(load_scenario("setup1", changes), record=tmp_path / "a.mcap")
    station.simulate()
    recording = load(tmp_path / "a.mcap")
    axes = {f"loosened.operator_device.limits.low_{axis}": x for axis, x in zip("xyz", (-0.3, 0.0, 0.0), strict=True)}
    assert recording.constants == {"loosened.operator_device.watchdog": 0.0} | axes
    save(recording, tmp_path / "a.npz")
    assert load(tmp_path / "a.npz").constants == recording.constants
    page = charts.page(["watchdog = null, looser than <0.015 s>"])
    assert "watchdog = null, looser than &lt;0.015 s&gt;" in page


def test_of_the_shipped_scenarios_only_that_which_says_everything_loosens_anything() -> None:
    assert [name for name in shipped() if scenario_module.loosened(load_scenario(name))] == ["setup1-everything"]


def test_at_the_loosest_the_force_is_zero_20_ms_after_a_fault_and_a_hung_process_is_cut_off_in_the_same_time() -> None:
    loosest = {option.path.split(".")[-1]: towards_bound(option, 1.0) for option in TABLE if ".limits." in option.path}
    bench = armed_bench(SafetyLimits(**{**loosest, "ramp": STOP_WITHIN - PERIOD}))
    assert bench.run(1).any()

    def fail(inputs: Inputs) -> None:
        inputs.device[0] = 1.0

    assert not bench.run(30, fail)[round(STOP_WITHIN / PERIOD) - 1 :].any()
    watchdog = next(option for option in TABLE if option.path.endswith("watchdog"))
    assert watchdog.bound.limit == STOP_WITHIN


def test_a_file_names_no_library_without_a_switch_but_a_person_may(tmp_path: Any) -> None:
    file = tmp_path / "strange.yaml"
    file.write_text("operator_device: {library: evil}\n")
    with pytest.raises(BadInput, match=r"operator_device.library: found 'evil', expected .*--trust-library"):
        load_scenario(file, ["operator_device.force=2"])
    assert main(["run", str(file), "--seconds", "0.01"]) == 2
    assert load_scenario(file, trust_library=True).operator_device.library == "evil"
    assert load_scenario(file, ["operator_device.library=mine"]).operator_device.library == "mine"
    assert load_scenario(file, ["operator_device={}"]).operator_device.library is None
    assert load_scenario("setup1-everything").operator_device.library == "sdk"
