"""A Simulator advanced tick by tick, each at its time by the wall clock."""

import time
from collections.abc import Callable

from pydrake.systems.analysis import Simulator

from mmt_drake.errors import check_number
from mmt_drake.realtime.pace import Pace

_SPIN = 200_000
"""How long before a tick is due sleeping ends and spinning begins [ns]; a sleep wakes up later than this seldom."""

_WARMING_ROUNDS = 50


def wait_until(due: int, clock: Callable[[], int] = time.monotonic_ns) -> int:
    """Sleep until shortly before a time, and spin the rest.

    Args:
        due: when to return, on the clock [ns]; if that is past, at once.
        clock: [ns].

    Returns:
        The time at the end [ns].
    """
    now = clock()
    if due - now > _SPIN:
        time.sleep((due - now - _SPIN) * 1e-9)
        now = clock()
    while now < due:
        now = clock()
    return now


def advance_paced(
    simulator: Simulator,
    end: float,
    period: float,
    pace: Pace,
    *,
    ended: Callable[[], bool] = lambda: False,
    progress: Callable[[float], None] | None = None,
    progress_interval: float = 0.5,
    clock: Callable[[], int] = time.monotonic_ns,
) -> None:
    """Advance a Simulator from where it is to `end`, one period at a time, none before it is due.

    What happens in the period that begins at t, updates at t among it, is computed when the wall clock gets to t; the
    wall clock starts here. A loop that is late goes on without waiting until it has made up for it; no tick is left
    out.

    Args:
        simulator: initialised.
        end: simulation time [s].
        period: of the fast path [s].
        pace: takes down every tick.
        ended: asked before every tick; true ends the run.
        progress: called now and then between ticks with the simulation time [s].
        progress_interval: between its calls [s of simulation].
        clock: [ns], never set.

    Raises:
        BadInput: a period that is not positive.
    """
    check_number("pacing", "period", period, least=0.0, open_interval=True)
    first = simulator.get_context().get_time()
    step = period * 1e9
    every = max(1, round(progress_interval / period))
    pace.reserve(round((end - first) / period) + 1)
    start = clock()
    tick = 0
    reached = first
    while reached < end and not ended():
        due = start + round(tick * step)
        began = wait_until(due, clock)
        tick += 1
        reached = first + tick * period
        if reached > end - 1e-9 * period:
            reached = end
        pace.began((began - due) * 1e-9)
        simulator.AdvanceTo(reached)
        pace.done((clock() - start - tick * step) * 1e-9)
        if progress is not None and (tick % every == 0 or reached >= end):
            progress(reached)


def warm(simulator: Simulator) -> None:
    """Evaluate the diagram's outputs on a copy of the Context until code and data are in the caches.

    Nothing is updated or published, so that nothing is sent, recorded or counted.
    """
    diagram = simulator.get_system()
    context = simulator.get_context().Clone()
    context.DisableCaching()
    for _ in range(_WARMING_ROUNDS):
        for index in range(diagram.num_output_ports()):
            diagram.get_output_port(index).Eval(context)
