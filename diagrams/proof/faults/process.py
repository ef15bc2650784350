"""Processes killed in the midst of a run in real time (SIGKILL): the other side's, and the run itself."""

from __future__ import annotations

import multiprocessing
import socket
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from multiprocessing.context import ForkServerContext
from multiprocessing.sharedctypes import Synchronized
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator

from mmt_drake.diagrams.proof.faults.injection import PERIOD, HandRig, Tally, emulated_omega
from mmt_drake.diagrams.proof.faults.patient_clock import PatientClock
from mmt_drake.diagrams.proof.faults.session import FORCE, KEY, SCENARIO
from mmt_drake.diagrams.proof.faults.table import Row
from mmt_drake.diagrams.stations.devices import Hand
from mmt_drake.diagrams.stations.returned import returned
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.site import Devices
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.diagrams.stations.two_sides import Side, build_side
from mmt_drake.errors import BadInput
from mmt_drake.hw.link.link import Link
from mmt_drake.hw.link.options import OPERATOR, TELEROBOT, LinkOptions, LinkSignal, Role
from mmt_drake.hw.link.udp import Address, UdpSocket
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.safety.limits import STOP_WITHIN
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.realtime import Pace, ProcessOptions, real_time_process
from mmt_drake.realtime.runner import wait_until
from mmt_drake.recording import load
from mmt_drake.recording.atomic import part_of
from mmt_drake.systems.recorder import BLOCK
from mmt_drake.with_parent import end_with_parent

_HOST = "127.0.0.1"
_TIMEOUT = 0.1  # of the link [s]
_DEVICE = replace(SCENARIO.operator_device, watchdog=None)
_READY_WITHIN = 60.0  # [s] a machine that is busy needs to start a process and to be armed
_ARM_AGAIN = 0.5  # [s] a busy machine makes the supervisor stop; a person arms again
_BUSY = 0.25  # [s] that a busy machine may take to hand a block to the disk
_CONTACT = {"stable": 1.0, "in_contact": 1.0}  # what a telerobot says that touches the object of `FlexibleBoxModel`


def serve(
    listen: Address,
    peer: Address,
    signals: Mapping[Role, LinkSignal],
    agreed: str,
    returned: Mapping[str, int],
    timeout: float,
) -> None:
    """A telerobot's end of a link, while the other process lives: it touches an object that is known."""
    end_with_parent()
    link = Link(TELEROBOT, signals, KEY, UdpSocket(listen, peer), LinkOptions(timeout=timeout), scenario=agreed)
    known = {"theta": FlexibleBoxModel().theta(), **{name: np.array([value]) for name, value in _CONTACT.items()}}
    vector = np.concatenate([known.get(name, np.zeros(size)) for name, size in returned.items()])
    shown, start, tick = np.zeros(signals["operator"].size), time.monotonic(), 0
    while True:
        link.exchange(tick * PERIOD, vector, shown)
        tick += 1
        time.sleep(max(0.0, start + tick * PERIOD - time.monotonic()))


def record_run(record: Path, reached: Synchronized[float]) -> None:
    """Set-up 1 in real time, recorded, and how far it is."""
    end_with_parent()

    class Counting(Pace):
        def done(self, behind: float) -> None:
            super().done(behind)
            reached.value = len(self.late_s) * PERIOD

    pace = Counting()
    build_station(load_scenario("setup1"), record=record, worker=True, pace=pace).simulate(60.0, pace=pace)


def rows(moments: int, folder: Path) -> Iterator[Row]:
    """The telerobot's side of two over loopback, and a run that is being recorded."""
    children = multiprocessing.get_context("forkserver")
    children.set_forkserver_preload([__name__])
    yield try_peer_killed(emulated_omega(folder), children, moments, folder / "operator.mcap")
    yield try_run_killed(children, moments, folder / "killed.mcap")


def try_peer_killed(omega: EmulatedOmega, children: ForkServerContext, moments: int, record: Path) -> Row:
    """One session; each peer is a process of its own, which the operator's side finds by itself.

    A machine that is busy takes the processor away now and then. No program can act meanwhile; on a device its own
    watchdog does, which would end this run. It is off here, and what the pauses took is allowed for.
    """
    rng, tally = np.random.default_rng(0), Tally(FORCE)
    allowed = longest = _TIMEOUT + STOP_WITHIN
    omega.reset()
    omega.set(real_time=1.0, target_z=-0.02, swing_x=0.01, swing_y=0.015, swing_z=0.004, swing_hz=2.3)
    with Hand(_DEVICE, PERIOD, {"peer": _TIMEOUT}, supervisor_clock=PatientClock()) as hand:
        operator = _Operator(hand, omega, record)
        with operator.side, real_time_process(ProcessOptions()):
            for moment in range(moments):
                peer = children.Process(target=serve, args=operator.for_peer, daemon=True)
                peer.start()
                operator.stays = float(rng.uniform(0.05, 0.3))
                if not tally.armed(operator, moment):
                    tally.wrong += [] if operator.heard else [f"{moment}: the peer was never heard"]
                    peer.kill()
                    break
                peer.kill()
                omega.update()  # or this moment would be that of the tick before
                tally.begin(operator)
                operator.paused = 0.0
                operator.go(round((allowed + 0.1) / PERIOD))
                may_take = allowed + operator.paused
                longest = max(longest, may_take)
                on_for = tally.force_for(operator, moment)
                if operator.armed or on_for > may_take:
                    tally.surprise(operator, moment, on_for)
                peer.join()
    tally.must_have_felt(1, moments)
    tally.recorded(operator, record)
    return tally.row("peer killed", "process", moments, longest)


class _Operator(HandRig):
    """The operator's side, paced; `until` runs it.

    Attributes:
        stays: armed for so long is armed [s].
        paused: beyond the time of a tick, by the machine [s].
        heard: the peer, since arming began.
    """

    watched = ("peer",)

    def __init__(self, hand: Hand, omega: EmulatedOmega, record: Path) -> None:
        self._hand, self.omega, self._pace, self.supervised = hand, omega, Pace(), hand.system
        self.stays, self.paused, self.heard = 0.0, 0.0, False
        self._ours, theirs = _free_ports()
        self._theirs = Address(_HOST, theirs)
        self.side: Side = build_side(
            SCENARIO, OPERATOR, self._open, record=record, devices=Devices(hand), pace=self._pace
        )
        self.simulator = Simulator(self.side.diagram)
        self.simulator.Initialize()

    def _open(self, role: Role, signals: Mapping[Role, LinkSignal], agreed: str) -> Link:
        socket_ = UdpSocket(Address(_HOST, self._ours), self._theirs)
        # What a peer needs: where to listen and to send, and what is said.
        self.for_peer = (self._theirs, Address(_HOST, self._ours), dict(signals), agreed, returned(SCENARIO), _TIMEOUT)
        return Link(role, signals, KEY, socket_, LinkOptions(timeout=_TIMEOUT), scenario=agreed)

    def go(self, ticks: int) -> None:
        """So many ticks, by the clock."""
        self.until(lambda: False, ticks * PERIOD)

    def arm(self) -> bool:
        """A person arms, again and again where a busy machine has it stopped, until it stays armed for a while."""
        patience = time.monotonic() + _READY_WITHIN
        self.heard = False
        while time.monotonic() < patience:
            if self.side.link.alive:
                self.heard = True
                self._hand.switch.arm()
            if self.until(lambda: self.armed, _ARM_AGAIN) and not self.until(lambda: not self.armed, self.stays):
                return True
        return False

    def until(self, done: Callable[[], bool], seconds: float) -> bool:
        """Tick by the clock until something is so, or so long; gives whether it came to be."""
        began = start = time.monotonic_ns()
        for tick in range(round(seconds / PERIOD)):
            due = start + round(tick * PERIOD * 1e9)
            began, before = wait_until(due), began
            self.paused += max(0.0, (began - before) * 1e-9 - 2.0 * PERIOD)
            self._pace.began((began - due) * 1e-9)
            self.simulator.AdvanceTo((self.tick + 0.5) * PERIOD)
            self._pace.done((time.monotonic_ns() - due) * 1e-9 - PERIOD)
            self.tick += 1
            if done():
                return True
        return False


def try_run_killed(children: ForkServerContext, moments: int, record: Path) -> Row:
    """A run each, in real time; what it leaves on the disk is read."""
    rng = np.random.default_rng(0)
    lost, wrong = 0.0, []
    for moment in range(moments):
        part_of(record).unlink(missing_ok=True)
        reached = children.Value("d", 0.0)
        run = children.Process(target=record_run, args=(record, reached), daemon=True)
        run.start()
        at, patience = float(rng.uniform(1.3, 3.3)), time.monotonic() + _READY_WITHIN
        while reached.value < at and run.is_alive() and time.monotonic() < patience:
            time.sleep(1e-3)
        run.kill()
        run.join()
        try:
            unreadable = reached.value - float(load(part_of(record)).time[-1])
        except BadInput as error:
            unreadable = reached.value
            wrong.append(f"{moment}: {error}")
        lost = max(lost, unreadable)
        if unreadable > BLOCK + _BUSY or reached.value < at:
            wrong.append(f"{moment}: killed at {reached.value:.2f} s, {unreadable:.2f} s of them cannot be read")
    return Row("run killed", "process", moments, unreadable=lost, ended=True, wrong=tuple(wrong))


def _free_ports() -> list[int]:
    """Two ports of UDP on loopback that are free just now."""
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2)]
    for item in sockets:
        item.bind((_HOST, 0))
    ports = [item.getsockname()[1] for item in sockets]
    for item in sockets:
        item.close()
    return ports
