"""Processes killed in the midst of a run in real time (SIGKILL): the other side's, and the run itself."""

import multiprocessing
import socket
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from multiprocessing.context import ForkServerContext
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator

from mmt_drake.diagrams.faults.children import KEY, record_run, serve
from mmt_drake.diagrams.faults.patient_clock import PatientClock
from mmt_drake.diagrams.faults.session import FORCE, SCENARIO, emulated_omega
from mmt_drake.diagrams.faults.table import Row
from mmt_drake.diagrams.stations.devices import Devices, Hand
from mmt_drake.diagrams.stations.returned import returned
from mmt_drake.diagrams.stations.two_sides import Side, build_side
from mmt_drake.errors import BadInput
from mmt_drake.hw.link import OPERATOR, Link, LinkOptions
from mmt_drake.hw.link.options import LinkSignal, Role
from mmt_drake.hw.link.udp import Address, UdpSocket
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.safety import STOP_WITHIN, describe
from mmt_drake.realtime import Pace, ProcessOptions, real_time_process
from mmt_drake.realtime.runner import wait_until
from mmt_drake.recording import load
from mmt_drake.recording.atomic import part_of
from mmt_drake.systems.recorder import BLOCK

_HOST = "127.0.0.1"
_PERIOD = 1e-3
_TIMEOUT = 0.1  # of the link [s]
_DEVICE = replace(SCENARIO.operator_device, watchdog=None)
_READY_WITHIN = 60.0  # [s] a machine that is busy needs to start a process and to be armed
_ARM_AGAIN = 0.5  # [s] a busy machine makes the supervisor stop; a person arms again
_BUSY = 0.25  # [s] that a busy machine may take to hand a block to the disk


def try_process(moments: int, folder: Path) -> Iterator[Row]:
    """The telerobot's side of two over loopback, and a run that is being recorded."""
    children = multiprocessing.get_context("forkserver")
    children.set_forkserver_preload(["mmt_drake.diagrams.faults.children"])
    yield try_peer_killed(emulated_omega(folder), children, moments, folder / "operator.mcap")
    yield try_run_killed(children, moments, folder / "killed.mcap")


def try_peer_killed(omega: EmulatedOmega, children: ForkServerContext, moments: int, record: Path) -> Row:
    """One session; each peer is a process of its own, which the operator's side finds by itself.

    A machine that is busy takes the processor away now and then. No program can act meanwhile; on a device its own
    watchdog does, which would end this trial. It is off here, and what the pauses took is allowed for.
    """
    rng = np.random.default_rng(0)
    allowed = longest = _TIMEOUT + STOP_WITHIN
    felt, slowest, greatest, wrong = 0, 0.0, 0.0, []
    omega.reset()
    omega.set(real_time=1.0, target_z=-0.02, swing_x=0.01, swing_y=0.015, swing_z=0.004, swing_hz=2.3)
    with Hand(_DEVICE, _PERIOD, {"peer": _TIMEOUT}, clock=PatientClock()) as hand:
        operator = _Operator(hand, omega, record)
        with operator.side, real_time_process(ProcessOptions()):
            for moment in range(moments):
                peer = children.Process(target=serve, args=operator.for_peer, daemon=True)
                peer.start()
                if not operator.arm(float(rng.uniform(0.05, 0.3))):
                    why = f"cannot be armed: {operator.told()}" if operator.heard else "the peer was never heard"
                    wrong.append(f"{moment}: {why}")
                    peer.kill()
                    break
                felt += bool(omega.vector("applied").any())
                peer.kill()
                omega.update()  # or this moment would be that of the tick before
                start = omega.get("simulated")
                omega.set(greatest_force=0.0, last_force_at=start)
                operator.paused = 0.0
                operator.until(lambda: False, allowed + 0.1)
                may_take = allowed + operator.paused
                force, on_for = omega.get("greatest_force"), omega.get("last_force_at") - start
                slowest, greatest = max(slowest, on_for), max(greatest, force)
                longest = max(longest, may_take)
                if operator.armed or on_for > may_take or force > FORCE * (1 + 1e-9):
                    wrong.append(f"{moment}: {operator.told()}, {force:.3g} N, for {1e3 * on_for:.1f} ms")
                peer.join()
    recorded = load(record, forces=False).time
    unreadable = (operator.tick - 1) * _PERIOD - float(recorded[-1])
    if not felt:
        wrong.append("no force was felt at any moment")
    if len(recorded) != operator.tick:
        wrong.append(f"{operator.tick} ticks, of which {len(recorded)} were recorded")
    return Row("peer killed", "process", moments, greatest, FORCE, slowest, longest, unreadable, wrong=tuple(wrong))


class _Operator:
    """The operator's side, paced; `until` runs it.

    Attributes:
        tick: how many there were.
        paused: beyond the time of a tick, by the machine [s].
        heard: the peer, since arming began.
    """

    def __init__(self, hand: Hand, omega: EmulatedOmega, record: Path) -> None:
        self._hand, self._omega, self._pace, self.tick = hand, omega, Pace(), 0
        self.paused, self.heard = 0.0, False
        self._ours, theirs = _free_ports()
        self._theirs = Address(_HOST, theirs)
        self.side: Side = build_side(
            SCENARIO, OPERATOR, self._open, record=record, devices=Devices(hand), pace=self._pace
        )
        self._simulator = Simulator(self.side.diagram)
        self._simulator.Initialize()

    def _open(self, role: Role, signals: Mapping[Role, LinkSignal], agreed: str) -> Link:
        socket_ = UdpSocket(Address(_HOST, self._ours), self._theirs)
        # What a peer needs: where to listen and to send, and what is said.
        self.for_peer = (self._theirs, Address(_HOST, self._ours), dict(signals), agreed, returned(SCENARIO), _TIMEOUT)
        return Link(role, signals, KEY, socket_, LinkOptions(timeout=_TIMEOUT), scenario=agreed)

    def arm(self, seconds: float) -> bool:
        """A person arms, again and again where a busy machine has it stopped, until it stays armed for so long."""
        patience = time.monotonic() + _READY_WITHIN
        self.heard = False
        while time.monotonic() < patience:
            if self.side.link.alive:
                self.heard = True
                self._hand.switch.arm()
            if self.until(lambda: self.armed, _ARM_AGAIN) and not self.until(lambda: not self.armed, seconds):
                return True
        return False

    def until(self, done: Callable[[], bool], seconds: float) -> bool:
        """Tick by the clock until something is so, or so long; gives whether it came to be."""
        began = start = time.monotonic_ns()
        for tick in range(round(seconds / _PERIOD)):
            due = start + round(tick * _PERIOD * 1e9)
            began, before = wait_until(due), began
            self.paused += max(0.0, (began - before) * 1e-9 - 2.0 * _PERIOD)
            self._pace.began((began - due) * 1e-9)
            self._simulator.AdvanceTo((self.tick + 0.5) * _PERIOD)
            self._pace.done((time.monotonic_ns() - due) * 1e-9 - _PERIOD)
            self.tick += 1
            if done():
                return True
        return False

    @property
    def _status(self) -> NDArray[np.float64]:
        system = self._hand.system
        context = system.GetMyContextFromRoot(self._simulator.get_context())
        return np.array(system.GetOutputPort("status").Eval(context))

    @property
    def armed(self) -> bool:
        """Whether the supervisor lets force through."""
        return bool(self._status[0])

    def told(self) -> str:
        """The supervisor's status in words."""
        return describe(self._status, ("peer",))


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
