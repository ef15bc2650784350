"""`run --side`: one side of a scenario, and the link to the other."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mmt_drake.cli.output import RunFigure, say
from mmt_drake.cli.run_options import SIDES, WAIT
from mmt_drake.errors import BadInput
from mmt_drake.recording import Recording

if TYPE_CHECKING:
    from mmt_drake.diagrams.stations.station import Station
    from mmt_drake.diagrams.stations.two_sides import Side
    from mmt_drake.hw.link.link import Link
    from mmt_drake.hw.link.options import LinkOptions, LinkSignal, Role


def watched(arguments: argparse.Namespace) -> dict[str, float]:
    """The ages of the link that a device's supervisor has to watch: name -> greatest age [s]."""
    return {} if arguments.side is None else {"peer": link_options(arguments).timeout}


def link_options(arguments: argparse.Namespace) -> LinkOptions:
    """The limits of the link.

    Raises:
        BadInput: one is unknown or refused.
    """
    from mmt_drake.hw.link.options import LinkOptions
    from mmt_drake.typed_yaml import fill, override

    data: dict[str, Any] = {}
    for change in arguments.link:
        override(data, change)
    return fill(LinkOptions, data, "--link")


def builder(arguments: argparse.Namespace) -> Callable[..., Side]:
    """The function that builds the side that was asked for, its socket open; called as `build_station` is.

    Raises:
        BadInput: an address, the key or an option of the link is refused.
        MissingDependency: the package that encrypts is not installed.
    """
    from mmt_drake.diagrams.stations.two_sides import build_side
    from mmt_drake.hw.link.keys import load_key
    from mmt_drake.hw.link.link import Link
    from mmt_drake.hw.link.udp import DEFAULT_PORTS, Address, UdpSocket

    side: Role = arguments.side
    options = link_options(arguments)
    key = load_key(arguments.key)
    other = SIDES[1 - SIDES.index(side)]
    peer = Address.parse(arguments.peer, "--peer", DEFAULT_PORTS[other])
    loopback = "[::1]" if ":" in peer.host else "127.0.0.1"
    listen = Address.parse(arguments.listen or loopback, "--listen", DEFAULT_PORTS[side])

    def open_link(role: Role, signals: Mapping[Role, LinkSignal], agreed: str) -> Link:
        return Link(role, signals, key, UdpSocket(listen, peer), options, scenario=agreed)

    wait = arguments.wait or WAIT
    if sys.stderr.isatty():
        say(f"waiting for the {other} at {peer}, {wait:g} s at most", stderr=True)
    follows = arguments.sliders_move_hardware
    return partial(build_side, side=side, open_link=open_link, wait=wait, sliders_move_hardware=follows)


def apart(file: Path) -> BadInput:
    """Why there are neither errors nor energies of one side's recording."""
    expected = "motion and force of both: `mmt-drake join` makes one of two"
    return BadInput(file, found="one side of two", expected=expected)


def figure(side: Station, recording: Recording) -> RunFigure:
    """The link of one side in the run that was recorded.

    `lost_ticks` counts those that had nothing new of the peer in time, once it had been there.
    """
    from mmt_drake.diagrams.stations.two_sides import Side
    from mmt_drake.hw.link.link import STATUS

    if not isinstance(side, Side):
        raise TypeError(f"{type(side).__name__} has no link")
    alive = recording["peer_alive"]
    lost_ticks = int(np.count_nonzero(alive[np.argmax(alive) :] == 0.0)) if alive.any() else 0
    status = zip(STATUS, side.link.status.tolist(), strict=True)
    data = {name: value if value == value else None for name, value in status}
    data |= {"ended": side.link.ended, "lost_ticks": lost_ticks}
    trip = "unknown" if data["round_trip"] is None else f"{data['round_trip'] * 1e3:.2f} ms"
    end = "alive" if data["alive"] else "ended by the other side" if data["ended"] else "LOST"
    packets = ("received", "lost", "overtaken", "repeated", "refused", "stale")
    counts = ", ".join(f"{data[name]:.0f} {name}" for name in packets)
    lost = f"; lost for {lost_ticks} steps" if lost_ticks else ""
    line = f"link: {end} at the end, round trip {trip}, packets {counts}; {data['sessions']:.0f} session(s){lost}"
    return RunFigure(data, line)
