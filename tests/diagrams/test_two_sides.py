"""A station split in two is the station: in step to the bit, in two processes on loopback within margins."""

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sides_in_step import InStep

from mmt_drake.analysis.metrics import measure
from mmt_drake.diagrams.stations.returned import returned
from mmt_drake.diagrams.stations.run import run
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario
from mmt_drake.hw.link.keys import write_key
from mmt_drake.hw.link.options import OPERATOR, ROLES, TELEROBOT
from mmt_drake.network.config import ChannelConfig
from mmt_drake.recording import Recording, load
from mmt_drake.recording.signals import LINK_CLOCKS
from mmt_drake.recording.two_recordings import join

pytest.importorskip("cryptography", reason="the extra `link` is not installed")

PARAMETERS = ("m", "k1", "k2", "b1", "b2", "Fc", "normal_k", "normal_b")


def one_process(scenario: Scenario, seconds: float) -> Recording:
    """The station with the ticks that the link takes: the operator ticks first.

    Its motion is there a tick later, and what answers it one more.
    """
    delayed = replace(scenario, to_telerobot=ChannelConfig(delay=1e-3), to_operator=ChannelConfig(delay=2e-3))
    return run(delayed, seconds=seconds)


def tick_until_felt(made: InStep) -> int:
    """Go on until there is a force; gives the next tick."""
    for _ in made.ticks(0, 2000):
        if np.abs(made.read(OPERATOR, "rendered_force")).max() > 0.3:
            return round(made.simulators[OPERATOR].get_context().get_time() * 1e3)
    pytest.fail("nothing was felt in 2 s")


@pytest.fixture
def in_step(tmp_path: Path) -> Iterator[InStep]:
    with ExitStack() as stack:
        made = InStep(load_scenario("setup1", ["estimator.equations=all", "operator.parameters={}"]), tmp_path)
        for side in made.sides.values():
            stack.enter_context(side)
        yield made


def test_two_sides_in_step_are_the_station_with_the_ticks_that_the_link_takes_to_the_bit(
    in_step: InStep, tmp_path: Path
) -> None:
    ticks = 2500
    assert [*in_step.ticks(0, ticks)][-1] == ticks
    in_step.close()
    one = one_process(in_step.sides[OPERATOR].scenario, ticks * 1e-3)
    operator, telerobot = load(tmp_path / "operator.mcap", forces=False), load(tmp_path / "telerobot.mcap")
    more = telerobot.columns.keys() - one.columns.keys()
    assert more == {"peer_alive", *(f"link_clock_{name}" for name in LINK_CLOCKS)}
    assert telerobot.columns["peer_alive"][1:].all()
    for name in telerobot.columns.keys() & one.columns.keys():
        assert np.array_equal(telerobot.columns[name], one.columns[name], equal_nan=True), name
    assert telerobot.columns["in_contact"].any() and np.isfinite(telerobot.columns["theta_k2"]).any()
    for axis in "xyz":
        for name in (f"master_position_{axis}", f"rendered_force_{axis}"):
            assert np.array_equal(operator.columns[name], one.columns[name]), name
    assert np.abs(operator.columns["rendered_force_z"]).max() > 0.5
    for name in ("detected_contact", "theta_k2", "theta_normal_k"):
        late = operator.columns[name][2:]
        early = one.columns[name][:-2]
        told = np.isfinite(early)
        assert np.array_equal(late[told], early[told])


def test_two_sides_joined_are_what_one_process_records_within_what_their_clocks_leave_open(tmp_path: Path) -> None:
    scenario = load_scenario("setup1", ["estimator=!OutputErrorOptions {}", "operator.parameters={}"])
    made = InStep(scenario, tmp_path)
    for _ in made.ticks(0, 4000):
        pass
    made.close()
    one = one_process(scenario, 4.0)
    both = join(load(tmp_path / "operator.mcap", forces=False), load(tmp_path / "telerobot.mcap"))
    open_s, joined = both.clocks.uncertainty, both.recording
    assert open_s < 0.6e-3 and abs(both.clocks.offset) <= open_s  # there is one clock, and a tick of a way back
    assert one.columns.keys() <= joined.columns.keys()
    rows = np.isin(one.time, joined.time)
    assert rows.sum() == len(joined) > 3990
    for axis in "xyz":
        for name in (f"position_{axis}", f"force_{axis}"):
            assert np.array_equal(joined[name], one[name][rows])
        hand, alone = joined[f"master_position_{axis}"], one[f"master_position_{axis}"]
        assert np.abs(hand - alone[rows]).max() <= np.abs(np.diff(alone)).max() * 1e3 * open_s + 1e-9
    scored = measure(joined, delay_s=both.delay_s, after_s=1.0).rendered_error
    alone_scored = measure(one, delay_s=1e-3, after_s=1.0).rendered_error
    assert scored.tangential["all"] == pytest.approx(alone_scored.tangential["all"], rel=0.02, abs=1e-3)
    assert scored.normal["all"] == pytest.approx(alone_scored.normal["all"], rel=0.02, abs=1e-3)


@pytest.mark.parametrize(
    "changes",
    [
        ["renderer=!DirectForce {}"],
        ["renderer=!DirectForce {passivity: {}}"],
        ["renderer=!FusedReflection {}"],
        ["to_renderer={delay: 0.004}", "estimator=!OutputErrorOptions {}"],
        ["telerobot=!CompliantTip {}", "estimator=!OutputErrorOptions {}"],
    ],
    ids=["force", "passivity", "two models", "late hand, free-running estimator", "an arm"],
)
def test_every_renderer_gets_across_what_it_needs(tmp_path: Path, changes: list[str]) -> None:
    """As the station with the ticks that the link takes, once both have begun alike."""
    scenario = load_scenario("setup1", ["operator.parameters={}", "environment.cloud.points=2000", *changes])
    made, ticks = InStep(scenario, tmp_path), 1500
    felt = [made.read(OPERATOR, "rendered_force") for _ in made.ticks(0, ticks)]
    made.close()
    one = one_process(scenario, ticks * 1e-3)
    expected = np.column_stack([one.columns[f"rendered_force_{axis}"] for axis in "xyz"])[1:]
    assert np.abs(expected).max() > 0.5
    # A recording waits for an arm's measurement, who feels does not.
    late = 0 if scenario.telerobot is None else scenario.telerobot.compensation.ticks_late
    np.testing.assert_allclose(felt[: ticks - late], expected[late:], atol=1e-9)
    operator = load(tmp_path / "operator.mcap", forces=False).columns
    telerobot = load(tmp_path / "telerobot.mcap").columns
    assert {name for name in one.columns if name.startswith(("theta", "estimat", "filtered"))} <= telerobot.keys()
    assert not telerobot["peer_alive"][:late].any() and telerobot["peer_alive"][late + 1 :].all()
    told = [name for name in operator if name.startswith("held_body")]
    assert bool(told) == ("held_body" in returned(scenario))
    for name in told:  # stamps too: they are of the operator's clock
        np.testing.assert_allclose(operator[name][2:], one.columns[name][:-2], atol=1e-9)
    # Under an arm nothing has been held yet in so short a time.
    assert not told or scenario.telerobot is not None or one.columns["held_body_stamp_y"].max() > 0.3


def test_a_detector_beside_the_operator_sees_the_telerobot_s_surface_until_it_is_lost(tmp_path: Path) -> None:
    changes = ["switching=operator", "environment.cloud.points=2000", "estimator=!OutputErrorOptions {}"]
    scenario = load_scenario("setup1", [*changes, "operator.parameters={}"])
    made = InStep(scenario, tmp_path)
    start = tick_until_felt(made)
    made.cut = True
    felt = [np.abs(made.read(OPERATOR, "rendered_force")).max() for _ in made.ticks(start, start + 140)]
    assert felt[90] > 0.1 and not any(felt[101 + 34 :])  # the timeout, and a frame
    made.close()


def test_a_lost_telerobot_is_no_longer_felt_and_a_lost_operator_s_probe_stands_still(in_step: InStep) -> None:
    start = tick_until_felt(in_step)
    in_step.cut = True
    felt = [np.abs(in_step.read(OPERATOR, "rendered_force")).max() for _ in in_step.ticks(start, start + 130)]
    assert in_step.read(OPERATOR, "alive") == in_step.read(TELEROBOT, "alive") == 0.0
    assert felt[90] > 0.1 and not any(felt[103:])  # the timeout is 100 ms
    probe = in_step.read(TELEROBOT, "measurement")
    assert not probe[3:6].any()
    for _ in in_step.ticks(start + 130, start + 200):
        assert np.array_equal(in_step.read(TELEROBOT, "measurement")[:3], probe[:3])
    in_step.cut = False
    for _ in in_step.ticks(start + 200, start + 260):
        pass
    assert in_step.read(OPERATOR, "alive") == in_step.read(TELEROBOT, "alive") == 1.0
    assert np.abs(in_step.read(OPERATOR, "rendered_force")).max() > 0.1


def test_a_proxy_renderer_sees_the_telerobot_s_surface(tmp_path: Path) -> None:
    scenario = load_scenario("setup1", ["renderer=!ProxySpring {}", "environment.cloud.points=2000"])
    made = InStep(scenario, tmp_path)
    felt = [made.read(OPERATOR, "rendered_force")[2] for _ in made.ticks(0, 1500)]
    made.close()
    expected = run(scenario, seconds=1.5)["rendered_force_z"]
    # Points in single precision, a frame of 33 ms later at most.
    assert np.max(felt) == pytest.approx(np.max(expected), rel=0.05)
    assert np.corrcoef(felt, expected[1:])[0, 1] > 0.98


@pytest.fixture(scope="module")
def two_processes(
    tmp_path_factory: pytest.TempPathFactory,
) -> tuple[dict[str, dict[str, object]], dict[str, Recording]]:
    """Set-up 1 for 12 s on both sides, through the program itself, 2 ms a tick; what both told and recorded."""
    folder = tmp_path_factory.mktemp("sides")
    write_key(folder / "link.key")
    command = [sys.executable, "-m", "mmt_drake", "run", "setup1", "--realtime", "--seconds", "12", "--json"]
    command += ["--set", "estimator.equations=all", "--set", "step=0.002", "--key", str(folder / "link.key")]
    command += ["--link", "playout=0.2", "--link", "timeout=1.0", "--peer", "127.0.0.1"]
    started = {
        side: subprocess.Popen(
            [*command, "--side", side, "--record", str(folder / f"{side}.mcap")],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for side in ROLES
    }
    try:
        outcome = {side: process.communicate(timeout=150) for side, process in started.items()}
    finally:
        for process in started.values():
            process.kill()
    for side, process in started.items():
        assert process.returncode == 0, outcome[side][1]
    summaries = {side: json.loads(out) for side, (out, _) in outcome.items()}
    for side in ROLES:
        overruns = summaries[side]["overruns"]
        if overruns["behind_p99_s"] > 0.1:
            pytest.skip(f"the machine is too busy: {side} was {overruns['behind_p99_s']:.2f} s late at p99")
    recordings = {side: load(folder / f"{side}.mcap", forces=side == TELEROBOT) for side in ROLES}
    scenario = load_scenario("setup1", ["estimator.equations=all", "step=0.002"])
    recordings["one"] = run(scenario, seconds=12.0)
    return summaries, recordings


def test_two_processes_joined_have_one_clock_and_the_force_that_one_process_renders(
    two_processes: tuple[dict[str, dict[str, object]], dict[str, Recording]],
) -> None:
    both = join(*(two_processes[1][side] for side in ROLES))
    assert abs(both.clocks.offset) <= both.clocks.uncertainty < 0.02  # both on this machine's clock
    assert both.delay_s == pytest.approx(0.2, abs=0.02)  # the play-out
    scored, alone = measure(both.recording, delay_s=both.delay_s), measure(two_processes[1]["one"])
    assert scored.rendered_error.normal["all"] == pytest.approx(alone.rendered_error.normal["all"], abs=0.01)


def test_two_processes_on_loopback_find_the_contact_and_the_parameters_of_the_single_station(
    two_processes: tuple[dict[str, dict[str, object]], dict[str, Recording]],
) -> None:
    """Margins: touch 0.2 s (the play-out) later than the hand's +- 0.05 s; normal axis 2 %; m, k2, b2 10 %."""
    summaries, recordings = two_processes
    for side in ROLES:
        link = summaries[side]["link"]
        assert isinstance(link, dict)
        assert (
            link["received"] > 5000 and link["lost"] == link["refused"] == link["stale"] == 0 and link["sessions"] == 1
        )
    hand, probe = recordings[OPERATOR], recordings[TELEROBOT]  # which began when each was ready
    touched = probe["link_clock_own"][[np.argmax(probe.columns["detected_contact"])]]
    on_hand = join(hand, probe).clocks.second(touched)[0]
    alone = recordings["one"].time[np.argmax(recordings["one"].columns["detected_contact"])]
    assert np.interp(on_hand, hand["link_clock_own"], hand.time) - alone == pytest.approx(0.2, abs=0.05)
    last = {name: {p: r.columns[f"theta_{p}"][-1] for p in PARAMETERS} for name, r in recordings.items()}
    for side in ROLES:
        for name, margin in (("normal_k", 0.02), ("m", 0.1), ("k2", 0.1), ("b2", 0.1)):
            assert last[side][name] == pytest.approx(last["one"][name], rel=margin), (side, name)
