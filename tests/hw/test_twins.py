"""Simulated and hardware versions of every device have the same ports and behave alike: one test for all of them.

A device's session is that of its simulated twin, and so is every claim; the devices are emulated ones.
"""

from collections.abc import Callable

import numpy as np
import pytest
import twins
from twins import Log

from mmt_drake.hw.realsense.faults import NO_FRAME, WELL

STIFFNESS = 1500.0  # [N/m], of every telerobot here

PORTS = {
    "operator": {"out motion": 6},
    "telerobot": {"in commanded": 6, "out motion": 6, "out raw_measurement": 9},
    "camera": {"out point_cloud": 0, "out camera": 3},
}


def has_the_ports_of_its_kind(kind: str, log: Log) -> None:
    shared = {name: size for name, size in log.ports.items() if name not in log.own}
    assert shared == PORTS[kind] and log.own <= set(log.ports)


def shows_states_alone(kind: str, log: Log) -> None:
    """A loop through it has no algebraic loop; the force that a simulated sensor reads is of this instant."""
    assert not {(i, o) for i, o in log.through if o != "raw_measurement"}


def starts_at_rest_where_it_is(kind: str, log: Log) -> None:
    motion = log.array("motion")
    assert np.isfinite(motion).all()
    np.testing.assert_allclose(motion[1, :3], motion[0, :3], atol=1e-3)
    np.testing.assert_allclose(motion[0, 3:], 0.0, atol=0.02)


def moves_without_a_jump_at_the_velocity_that_it_tells(kind: str, log: Log) -> None:
    motion, took = log.array("motion"), np.diff(log.clock)
    way = np.diff(motion[:, :3], axis=0)
    assert np.linalg.norm(way, axis=1).max() < 2e-3
    told = ((motion[1:, 3:] + motion[:-1, 3:]) / 2 * took[:, None]).cumsum(axis=0)
    assert np.ptp(motion[:, :3], axis=0).max() > 0.005, "it moves"
    np.testing.assert_allclose(told, motion[1:, :3] - motion[0, :3], atol=2e-3)


def _between(log: Log, name: str, start: float, end: float) -> np.ndarray:
    time = np.array(log.time)
    return log.array(name)[(time > start) & (time < end)].mean(axis=0)


def comes_to_where_it_is_commanded(kind: str, log: Log) -> None:
    moved = _between(log, "motion", twins.PUSHED - 0.2, twins.PUSHED)[:3] - log.array("motion")[0, :3]
    np.testing.assert_allclose(moved, twins.AWAY, atol=6e-3)  # the emulated joints stick: 1 N m over 1500 N/m


def feels_a_push_with_its_sign(kind: str, log: Log) -> None:
    before, after = (
        _between(log, "raw_measurement", end - 0.2, end)[6:] for end in (twins.PUSHED, twins.END)
    )  # its offset, and the weight of its probe, are in both
    np.testing.assert_allclose(after - before, twins.PUSH, atol=0.05)


def yields_to_it_by_force_over_stiffness(kind: str, log: Log) -> None:
    before, after = (_between(log, "motion", end - 0.2, end)[:3] for end in (twins.PUSHED, twins.END))
    np.testing.assert_allclose(after - before, twins.PUSH / STIFFNESS, atol=4e-3)  # joints that stick, again


def measures_the_motion_that_it_shows(kind: str, log: Log) -> None:
    wrong = log.array("raw_measurement")[:, :6] - log.array("motion")
    assert np.abs(wrong[:, :3]).max() < 1e-4 and np.abs(wrong[:, 3:]).max() < 5e-3  # five times its noise and more


def shows_nothing_before_the_first_frame_and_says_so(kind: str, log: Log) -> None:
    assert len(log.shown["point_cloud"][0]) == 0 and log.shown["camera"][0][0] == NO_FRAME


def shows_the_surface_where_it_is(kind: str, log: Log) -> None:
    cloud, (fault, age, lost) = log.shown["point_cloud"][-1], log.shown["camera"][-1]
    points = cloud.points()
    middle = points[(np.abs(points[:, :2]) < 0.05).all(axis=1)]
    assert fault == WELL and len(middle) > 100 and 0.0 <= lost < 0.6
    assert np.abs(middle[:, 2]).max() < 1e-3
    assert age >= 0.0 and cloud.stamp <= log.time[-1]


MOVES = (starts_at_rest_where_it_is, moves_without_a_jump_at_the_velocity_that_it_tells)
CLAIMS: dict[str, tuple[Callable[[str, Log], None], ...]] = {
    "operator": MOVES,
    "telerobot": (
        *MOVES,
        comes_to_where_it_is_commanded,
        feels_a_push_with_its_sign,
        yields_to_it_by_force_over_stiffness,
        measures_the_motion_that_it_shows,
    ),
    "camera": (shows_nothing_before_the_first_frame_and_says_so, shows_the_surface_where_it_is),
}
VERSIONS = {
    "operator": (twins.simulated_hand, twins.omega),
    "telerobot": (twins.compliant_tip, twins.simulated_panda, twins.franka),
    "camera": (twins.rendered_camera, twins.depth_camera),
}
CASES = [
    pytest.param(kind, version, claim, id=f"{version.__name__}-{claim.__name__}")
    for kind, versions in VERSIONS.items()
    for version in versions
    for claim in (has_the_ports_of_its_kind, shows_states_alone, *CLAIMS[kind])
]


@pytest.fixture(scope="module")
def logs() -> dict[str, Log]:
    """Of each version, once it has been through its session."""
    return {}


@pytest.mark.parametrize(("kind", "version", "claim"), CASES)
def test_a_device_and_its_simulated_twin(
    kind: str,
    version: Callable[[pytest.FixtureRequest], Log],
    claim: Callable[[str, Log], None],
    logs: dict[str, Log],
    request: pytest.FixtureRequest,
) -> None:
    if version.__name__ not in logs:
        logs[version.__name__] = version(request)
    claim(kind, logs[version.__name__])
