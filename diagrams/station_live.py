"""What a station that runs in real time tells beside its signals: its pace, and what its supervisor does."""

from __future__ import annotations

from collections.abc import Callable

from pydrake.systems.framework import DiagramBuilder, OutputPort

from diagrams.devices import Hand
from diagrams.ports import split
from hw.safety import SafetyAnnouncer
from mmt_drake.realtime import Pace, PaceReport

Columns = tuple[tuple[OutputPort, tuple[str, ...]], ...]
"""Ports to be recorded, each with the base names of the signals that it carries."""


def live_signals(
    builder: DiagramBuilder, hand: Hand | None, pace: Pace | None, tell: Callable[[str], None] | None
) -> Columns:
    """Add what shows the pace and announces the supervisor; gives what is to be recorded of both.

    Args:
        builder: of a diagram with the hand's system in it.
        hand: on a device, if there is one.
        pace: of the run to come, if it is paced.
        tell: called with a line for a person whenever the supervisor has something new.
    """
    columns: Columns = ()
    if pace is not None:
        report = builder.AddNamedSystem("pace", PaceReport(pace))
        columns += tuple((report.GetOutputPort(name), (name,)) for name in ("lateness", "overruns"))
    if hand is not None:
        status = hand.system.GetOutputPort("status")
        armed, _, present = split(builder, status, (1, 1, 1))
        columns += (
            (hand.system.GetOutputPort("applied_force"), ("applied_force",)),
            (armed, ("safety_armed",)),
            (present, ("safety_reason",)),
        )
        if tell is not None:
            announcer = builder.AddNamedSystem("announcer", SafetyAnnouncer(tell, tuple(hand.watched)))
            builder.Connect(status, announcer.GetInputPort("status"))
    return columns
