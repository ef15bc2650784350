"""Random faults at random moments: force and power within limits at every tick, zero in time, and zero it stays."""

from dataclasses import replace

import numpy as np
import pytest

from mmt_drake.diagrams.proof.faults.supervisor import (
    KINDS,
    LIMITS,
    Bench,
    Inputs,
    SupervisorFault,
    inputs_under,
    ordinary,
    ordinary_session,
    try_fault,
)
from mmt_drake.hw.safety.reasons import Reason


@pytest.fixture(scope="module")
def session() -> list[Bench]:
    """The bench at every tick of an ordinary session, from which each fault starts."""
    return ordinary_session()


@pytest.mark.parametrize("name", KINDS)
def test_force_is_within_limits_always_and_zero_in_time(name: str, session: list[Bench]) -> None:
    outcome = try_fault(name, session, moments=50)
    assert not outcome.wrong, "\n".join(outcome.wrong)


def test_a_supervisor_that_does_not_stop_would_be_seen(session: list[Bench], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(KINDS, "nothing", SupervisorFault(lambda inputs, since, rng: None, Reason.STUCK))
    assert len(try_fault("nothing", session, moments=3).wrong) == 3


def _garbage(inputs: Inputs, rng: np.random.Generator) -> None:
    """Every number of every input is random bits."""
    for array in (inputs.command, inputs.motion, inputs.device, inputs.ages):
        array[:] = np.frombuffer(rng.bytes(8 * array.size), dtype=np.float64)


def test_random_bits_on_every_input_end_in_zero_force(session: list[Bench]) -> None:
    rng = np.random.default_rng(7)
    for _ in range(200):
        bench = replace(session[int(rng.integers(len(session)))])
        for _ in range(40):
            inputs = ordinary(bench.tick)
            _garbage(inputs, rng)
            force = bench.step(inputs)
            assert np.isfinite(force).all() and np.linalg.norm(force) <= LIMITS.force * (1 + 1e-12)
        assert not force.any() and not bench.armed


def test_after_each_fault_that_passes_a_person_can_go_on(session: list[Bench]) -> None:
    rng = np.random.default_rng(3)
    for kind in KINDS.values():
        if kind.lasts is None or kind.reason is None:
            continue
        bench = replace(session[int(rng.integers(len(session)))])
        start = bench.tick
        for _ in range(50):
            bench.step(inputs_under(bench, kind, start, rng))
        assert not bench.armed
        bench.arm()
        assert bench.armed
        inputs = ordinary(bench.tick)
        np.testing.assert_array_equal(bench.step(inputs), inputs.command)
