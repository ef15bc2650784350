"""A Simulator advanced tick by tick, each at its time by the wall clock."""

import time
from collections.abc import Callable

from pydrake.systems.analysis import Simulator

from mmt_drake.errors import check_number
from mmt_drake.realtime.pace import Pace

SPIN = 200e-6
"""How long before a tick is due sleeping ends and spinning begins [s]; a sleep wakes up later than this seldom."""

_WARMING_ROUNDS = 50


def wait_until(due: int, spin: int, clock: Callable[[], int] = time.monotonic_ns) -> int:
    """Sleep until shortly before a time, and spin the rest.

    Args:
        due: when to return, on the clock [ns]; if that is past, at once.
        spin: how long to spin [ns].
        clock: [ns].

    Returns:
        The time at the end [ns].
    """
    now = clock()
    if due - now > spin:
        time.sleep((due - now - spin) * 1e-9)
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
    spin: float = SPIN,
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
        spin: see `SPIN`.
        ended: asked before every tick; true ends the run.
        progress: called now and then between ticks with the simulation time [s].
        progress_interval: between its calls [s of simulation].
        clock: [ns], never set.

    Raises:
        BadInput: a period that is not positive, or a negative spin.
    """
    check_number("pacing", "period", period, least=0.0, open_interval=True)
    check_number("pacing", "spin", spin, least=0.0)
    first = simulator.get_context().get_time()
    step, spinning = period * 1e9, round(spin * 1e9)
    every = max(1, round(progress_interval / period))
    pace.reserve(round((end - first) / period) + 1)
    start = clock()
    tick = 0
    reached = first
    while reached < end and not ended():
        due = start + round(tick * step)
        began = wait_until(due, spinning, clock)
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
