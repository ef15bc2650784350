"""Every block of a station gives its recorded outputs again, and a fault is found in the block that has it."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.primitives import Gain
from trial_samples import changed

from mmt_drake.diagnosis.decide.block_replay import EXACT, TIMES_NOISE, compared
from mmt_drake.diagnosis.decide.blocks import Block, differing, replay_block, replay_blocks
from mmt_drake.diagnosis.signals.lateness import lateness
from mmt_drake.diagrams.stations.blocks import station_blocks
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.errors import BadInput
from mmt_drake.recording import Recording, load

RATE = 1000.0
AXES = "xyz"
DIFFERS = {
    "to_telerobot": {"position", "velocity"},
    "environment": {"force", "in_contact", "body_position"},
    "detector": {"detected_contact", "proxy_position"},
    "estimator": {"filtered_force", "estimated_force", "theta", "theta_stable"},
    "renderer": {"rendered_force"},
}


def ran(scenario: Scenario, folder: Path) -> Recording:
    build_station(scenario, record=folder / "run.mcap").simulate()
    return load(folder / "run.mcap")


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return load_scenario("setup1", ["duration=4", "estimator.settle=0.3"])


@pytest.fixture(scope="module")
def recording(scenario: Scenario, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return ran(scenario, tmp_path_factory.mktemp("setup1"))


def strokes(time: np.ndarray) -> np.ndarray:
    """(n, 2): sines over the band in which a phase is read."""
    first = sum(np.sin(2 * np.pi * f * time + f**2) for f in (0.4, 1.7, 3.6, 5.3))
    return np.column_stack([first, np.sin(2 * np.pi * 2.2 * time)])


def test_every_block_gives_again_what_was_recorded_of_it(scenario, recording):
    found = replay_blocks(recording, station_blocks(scenario), noise={})
    assert {name: {r.output for r in found if r.block == name} for name in DIFFERS} == DIFFERS
    for replay in found:
        # The clouds of a proxy are moved by the body between two ticks.
        exact = 0.0 if replay.output != "proxy_position" else EXACT
        assert replay.nrmse is not None and replay.nrmse <= exact, replay
        assert not replay.differs and replay.note
    assert differing(found) == ()


def test_a_network_with_jitter_and_loss_and_sensors_with_noise_are_no_difference(tmp_path):
    everything = load_scenario(
        "setup1-everything", ["duration=6", "environment.cloud.points=5000", "environment.surface=null", "touch=null"]
    )
    found = replay_blocks(ran(everything, tmp_path), station_blocks(everything))
    assert differing(found) == (), [replay for replay in found if replay.differs]
    by_output = {replay.output: replay for replay in found}
    # What stands between recorded columns is given again to the last bit, noise or not.
    for name in ("filtered_force", "estimated_force", "theta", "theta_stable", "rendered_force"):
        assert by_output[name].nrmse == 0.0
    # What does not is off by the noise of the sensors, and by no more.
    forces = load(tmp_path / "run.mcap").vector("force")
    spread = np.sqrt(np.mean(np.var(forces, axis=0)))
    assert by_output["force"].nrmse == pytest.approx(0.02 / spread, rel=0.5)
    assert 0.8 < by_output["force"].floor / by_output["force"].nrmse < np.sqrt(3.0)


@pytest.mark.parametrize(
    ("change", "block", "outputs"),
    [
        ("to_telerobot.delay=0.02", "to_telerobot", {"position", "velocity"}),
        ("environment.object.parameters.k2=450.0", "environment", {"force", "body_position"}),
        ("environment.object.friction.Fs=0.6", "environment", {"force", "body_position"}),
        ("detector.r2=0.0045", "detector", {"proxy_position"}),
        ("estimator.equations=without_d", "estimator", {"theta", "theta_stable"}),
        ("estimator.cutoff_hz=12.0", "estimator", {"filtered_force", "estimated_force", "theta", "theta_stable"}),
        ("to_operator.delay=0.05", "renderer", {"rendered_force"}),
    ],
)
def test_what_was_changed_in_one_block_is_found_in_that_block_alone(scenario, tmp_path, change, block, outputs):
    other = load_scenario("setup1", ["duration=4", "estimator.settle=0.3", change])
    found = replay_blocks(ran(other, tmp_path), station_blocks(scenario), noise={})
    assert differing(found) == (block,)
    assert {replay.output for replay in found if replay.differs} <= outputs
    assert {replay.output for replay in found if replay.differs} & outputs


def test_another_object_than_the_one_believed_in_is_a_difference_of_the_environment(scenario, recording):
    thing = scenario.environment.object
    model = replace(thing, parameters=replace(thing.parameters, m=1.3))
    assert differing(replay_blocks(recording, station_blocks(scenario, model=model), noise={})) == ("environment",)


def test_a_network_that_is_late_is_late_by_its_delay_in_the_words_too(scenario, recording):
    late = {
        f"{what}_{axis}": np.concatenate([np.repeat(values[:1], 20), values[:-20]])
        for what in ("position", "velocity")
        for axis in AXES
        for values in (recording[f"master_{what}_{axis}"],)
    }
    found = {r.output: r for r in replay_blocks(changed(recording, **late), station_blocks(scenario)[:1], noise={})}
    for replay in found.values():
        assert replay.delay_s == pytest.approx(0.02, abs=2e-4)
        assert re.search(r"20 ms late, and without that off by \d(\.\d+)?e-0[5-9]\.$", replay.note)
        # A sine of frequency f that is late by tau is off by 2 sin(pi f tau) of itself.
        assert 2 * np.sin(np.pi * 3.0 * 0.02) < replay.by_band["3_to_10_hz"] < 2 * np.sin(np.pi * 5.0 * 0.02)


def test_a_gain_is_told_from_a_delay(recording):
    doubled = changed(recording, **{f"rendered_force_{axis}": 2.0 * recording[f"force_{axis}"] for axis in AXES})
    block = Block("gain", Gain(1.0, 3), {"u0": ("force",)}, {"rendered_force": ("y0", 0)})
    (found,) = replay_blocks(doubled, [block], noise={})
    force = doubled.vector("rendered_force")
    spread = np.sqrt(np.mean(np.var(force, axis=0)))
    assert found.nrmse == pytest.approx(0.5 * np.sqrt(np.mean(force**2)) / spread, rel=1e-9)
    assert list(found.by_band.values()) == pytest.approx([0.5] * 4, rel=0.02)
    assert found.delay_s == pytest.approx(0.0, abs=1e-9) and "no delay explains it" in found.note


def test_what_was_not_recorded_is_said_and_not_guessed(scenario, recording):
    missing = {name for name in recording.columns if name.startswith(("theta", "proxy"))}
    left = replace(recording, columns={n: v for n, v in recording.columns.items() if n not in missing})
    found = {replay.output: replay for replay in replay_blocks(left, station_blocks(scenario), noise={})}
    assert found["rendered_force"].nrmse is None and "theta, theta_stable" in found["rendered_force"].note
    assert found["proxy_position"].nrmse is None and found["detected_contact"].nrmse == 0.0
    assert found["theta"].nrmse is None and found["estimated_force"].nrmse == 0.0
    assert not any(replay.differs for replay in found.values())


def test_only_samples_that_count_enter_the_errors(scenario, recording):
    broken = recording["rendered_force_y"].copy()
    broken[:1000] += 5.0
    spoiled = changed(recording, rendered_force_y=broken)
    renderer = station_blocks(scenario)[-1:]
    assert differing(replay_blocks(spoiled, renderer, noise={})) == ("renderer",)
    late = recording.time >= 1.0
    assert differing(replay_blocks(spoiled, renderer, counts=late, noise={})) == ()
    with pytest.raises(BadInput, match="counts"):
        replay_blocks(spoiled, renderer, counts=np.zeros(len(recording), dtype=bool), noise={})


def test_a_replay_leaves_the_system_as_it_was(scenario, recording):
    renderer = station_blocks(scenario)[-1]
    once, again = (replay_block(recording, renderer)["rendered_force"] for _ in range(2))
    assert np.array_equal(once, again)


def test_bad_input_is_told_in_one_line(scenario, recording):
    blocks = {block.name: block for block in station_blocks(scenario)}
    coarse = replace(recording, time=2.0 * recording.time)
    with pytest.raises(BadInput, match=r"a step of 0\.002 s.*the period of estimator, 0\.001 s"):
        replay_blocks(coarse, [blocks["estimator"]], noise={})
    with pytest.raises(BadInput, match=r"3 columns.*6 numbers"):
        replay_blocks(recording, [replace(blocks["environment"], inputs={"motion": ("position",)})], noise={})
    with pytest.raises(BadInput, match="did you mean 'position'"):
        replay_blocks(recording, [replace(blocks["environment"], inputs={"motion": ("positon",)})], noise={})
    with pytest.raises(BadInput, match="ProxySpring"):
        station_blocks(load_scenario("setup1", ["renderer=!ProxySpring {}"]))


@pytest.mark.parametrize("delay", [0.0, 0.0003, 0.0123, 0.02, 0.4, -0.035])
def test_lateness_is_the_delay_of_a_noisy_copy_to_a_tenth_of_a_sample(delay):
    time = np.arange(20_000) / RATE
    noise = 0.05 * np.random.default_rng(1).standard_normal((len(time), 2))
    assert lateness(strokes(time - delay) + noise, strokes(time), RATE) == pytest.approx(delay, abs=1e-4)


def test_lateness_is_not_moved_by_a_step_that_comes_at_once():
    time = np.arange(20_000) / RATE
    touch = 3.0 * (time > 9.0)[:, np.newaxis]
    assert lateness(strokes(time - 0.02) + touch, strokes(time) + touch, RATE) == pytest.approx(0.02, abs=1e-4)


def test_there_is_no_lateness_between_signals_that_are_unlike_or_still():
    time = np.arange(8_000) / RATE
    noise = np.random.default_rng(2).standard_normal((len(time), 2))
    assert lateness(noise, strokes(time), RATE) is None
    assert lateness(np.ones((8_000, 2)), strokes(time), RATE) is None


def test_parameters_known_in_one_and_not_in_the_other_differ_without_bound():
    recorded, replayed = np.full((4, 1), 2.0), np.array([[np.nan], [2.0], [2.0], [2.0]])
    every, none = np.ones(4, dtype=bool), np.zeros((4, 1))
    found = compared("estimator", "theta", recorded, replayed, none, every, RATE, held=True)
    assert found.nrmse == np.inf and found.differs and "1 sample" in found.note
    counts = np.array([False, True, True, True])
    assert compared("estimator", "theta", recorded, replayed, none, counts, RATE, held=True).nrmse == 0.0


def test_a_slow_difference_is_seen_below_noise_that_is_as_large():
    time, sigma = np.arange(20_000) / RATE, 0.02
    replayed, every = strokes(time), np.ones(20_000, dtype=bool)
    noise, chance = sigma * np.random.default_rng(3).standard_normal((2, *replayed.shape))
    slow = sigma * np.sin(2 * np.pi * 1.3 * time)[:, np.newaxis]
    alike = compared("environment", "force", replayed + noise, replayed, chance, every, RATE, held=False)
    other = compared("environment", "force", replayed + noise + slow, replayed, chance, every, RATE, held=False)
    assert not alike.differs and other.differs
    for found in (alike, other):  # over all it is not told from noise
        assert found.nrmse is not None and found.nrmse < TIMES_NOISE * found.floor
    # In that band are three sines of amplitude 1 in two columns, and the slow one in each.
    assert other.by_band["0.3_to_3_hz"] == pytest.approx(sigma / np.sqrt(1.5), rel=0.15)


def test_a_parameter_that_stands_is_off_by_a_part_of_itself_and_one_that_is_zero_by_what_it_is():
    recorded, every = np.tile([0.3, 0.0], (5, 1)), np.ones(5, dtype=bool)
    for off, nrmse in (([0.03, 0.0], 0.1), ([0.0, 0.03], 0.03)):
        found = compared("estimator", "theta", recorded, recorded + off, np.zeros((5, 2)), every, RATE, held=True)
        assert found.nrmse == pytest.approx(nrmse / np.sqrt(2.0))


@pytest.mark.parametrize(
    ("off", "noise", "words"),
    [(0.0, 0.0, "to the last bit"), (1e-9, 0.0, "to rounding"), (1e-3, 1e-3, "which sensor noise accounts for")],
)
def test_agreement_is_told_as_exact_as_rounding_or_as_noise(off, noise, words):
    recorded, every = strokes(np.arange(8000) / RATE), np.ones(8000, dtype=bool)
    made, chance = np.random.default_rng(4).standard_normal((2, *recorded.shape))
    found = compared("e", "force", recorded, recorded + off * made, noise * chance, every, RATE, held=False)
    assert not found.differs and words in found.note


@pytest.mark.parametrize(("hz", "words"), [(0.1, "below 0.3 Hz"), (1.3, "at 0.3 to 3 Hz"), (6.0, "at 3 to 10 Hz")])
def test_the_band_where_a_difference_is_largest_is_named(hz, words):
    time, every = np.arange(20_000) / RATE, np.ones(20_000, dtype=bool)
    recorded = strokes(time) + np.sin(2 * np.pi * 0.1 * time)[:, np.newaxis]
    other = recorded + 0.3 * np.sin(2 * np.pi * hz * time)[:, np.newaxis]
    found = compared("e", "force", recorded, other, np.zeros_like(recorded), every, RATE, held=False)
    assert f" {words}" in found.note and "no delay explains it" in found.note
