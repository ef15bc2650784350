"""Faults injected into a run with a hand on an emulated device: the rig, a kind of fault, and what comes of it."""

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, Generic, TypeVar

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import System

from mmt_drake.closing import Closing
from mmt_drake.diagrams.proof.faults.table import Row
from mmt_drake.hw.omega.emulator import EmulatedOmega, load_emulated
from mmt_drake.hw.safety.limits import STOP_WITHIN
from mmt_drake.hw.safety.reasons import describe
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import load

PERIOD: Final = 1e-3  # [s]
_ROUNDING: Final = 1 + 1e-9  # of a force at its limit
_LOADED: list[EmulatedOmega] = []


def emulated_omega(folder: Path) -> EmulatedOmega:
    """The first emulated device, as it left the factory; the bindings of a process load one library, once.

    Args:
        folder: where to build the library, if this process has none yet.

    Raises:
        MissingDependency: the bindings or a C compiler are not installed.
    """
    if not _LOADED:
        _LOADED.append(EmulatedOmega(load_emulated(folder)))
    _LOADED[0].reset()
    return _LOADED[0]


class HandRig(Closing):
    """A run with a supervised hand on an emulated device.

    Attributes:
        omega: the far side of the device.
        supervised: the driver and its supervisor.
        simulator: of the run.
        watched: names of the ages that the supervisor watches.
        tick: how many there were.
    """

    omega: EmulatedOmega
    supervised: System
    simulator: Simulator
    watched: Sequence[str] = ()
    tick: int = 0

    @abstractmethod
    def go(self, ticks: int) -> object:
        """So many ticks."""

    @abstractmethod
    def arm(self) -> bool:
        """A person presses the switch, and the force comes back; gives whether it does."""

    def read(self, system: System, port: str) -> Array:
        """A vector output of a system of the run, now."""
        context = system.GetMyContextFromRoot(self.simulator.get_context())
        return np.array(system.GetOutputPort(port).Eval(context))

    @property
    def status(self) -> Array:
        """(6) of the supervisor."""
        return self.read(self.supervised, "status")

    @property
    def armed(self) -> bool:
        """Whether the supervisor lets force through."""
        return bool(self.status[0])

    def describe(self) -> str:
        """The supervisor's status in words."""
        return describe(self.status, self.watched)

    def begin_moment(self) -> float:
        """Forget the greatest force; gives the time by the device's clock [s]."""
        now = self.omega.get("simulated")
        self.omega.set(greatest_force=0.0, last_force_at=now)
        return now


R = TypeVar("R", bound=HandRig)


@dataclass(frozen=True)
class Injection(Generic[R]):
    """One kind of fault, and what must come of it.

    Attributes:
        start, stop: what brings it and what takes it away.
        reasons: one of which the supervisor must stop for; empty where the run goes on, None where it may do either.
        seen_after: how long it takes until it can be seen [s].
        watched: ticks that are watched once the force must be zero.
        after: ticks without the fault, for which the force must stay zero until a person arms.
    """

    start: Callable[[R], object]
    stop: Callable[[R], object]
    reasons: tuple[int, ...] | None
    seen_after: float = 0.0
    watched: int = 20
    after: int = 10

    @property
    def allowed(self) -> float:
        """After how long the force must be zero [s]; NaN where the run may go on."""
        return self.seen_after + STOP_WITHIN if self.reasons else math.nan


@dataclass
class Tally:
    """Moment by moment: the force that the hand felt, and what was not as it must be.

    Attributes:
        limit: of the force [N].
        greatest: force [N].
        slowest: the longest that there was a force after a moment [s].
        unreadable: the longest end of a recording that was lost [s]; NaN without one.
        felt: moments at which there was a force.
        wrong: a line each.
    """

    limit: float
    greatest: float = 0.0
    slowest: float = 0.0
    unreadable: float = math.nan
    felt: int = 0
    wrong: list[str] = field(default_factory=list)
    _start: float = 0.0

    def armed(self, rig: HandRig, moment: int | str) -> bool:
        """Have a person arm; whether that came to anything."""
        if rig.arm():
            return True
        self.wrong.append(f"{moment}: cannot be armed: {rig.describe()}")
        return False

    def begin(self, rig: HandRig) -> None:
        """The moment is now."""
        self.felt += bool(rig.omega.vector("applied").any())
        self._start = rig.begin_moment()

    def force_for(self, rig: HandRig, moment: int) -> float:
        """How long there was a force after the moment [s]; it must have been within its limit."""
        force, on_for = rig.omega.get("greatest_force"), rig.omega.get("last_force_at") - self._start
        self.greatest, self.slowest = max(self.greatest, force), max(self.slowest, on_for)
        if force > self.limit * _ROUNDING or rig.omega.get("not_finite"):
            self.wrong.append(f"{moment}: a force of {force:.3g} N, or none that is a number, was sent")
        return on_for

    def surprise(self, rig: HandRig, moment: int, on_for: float) -> None:
        """The supervisor did not do what it must."""
        self.wrong.append(f"{moment}: {rig.describe()}, a force for {1e3 * on_for:.1f} ms")

    def goes_on(self, rig: HandRig, moment: int) -> None:
        """The hand must be armed and have felt a force since the moment; else that is wrong."""
        self.force_for(rig, moment)
        force = rig.omega.get("greatest_force")
        if not (rig.armed and force > 0.0):
            self.wrong.append(f"{moment}: {rig.describe()}, {force:.3g} N")

    def must_have_felt(self, least: int, moments: int) -> None:
        """At fewer moments with a force nothing was shown."""
        if self.felt < least:
            self.wrong.append(f"at {self.felt} of {moments} moments was there a force: too few to show anything")

    def recorded(self, rig: HandRig, record: Path) -> None:
        """A run that has ended must have recorded every tick."""
        time = load(record, forces=False).time
        self.unreadable = (rig.tick - 1) * PERIOD - float(time[-1])
        if len(time) != rig.tick:
            self.wrong.append(f"{rig.tick} ticks, of which {len(time)} were recorded")

    def row(self, kind: str, where: str, moments: int, allowed: float = math.nan) -> Row:
        """The line of the table; `allowed` [s] is NaN where the run goes on."""
        slowest = math.nan if math.isnan(allowed) else self.slowest
        wrong = tuple(self.wrong)
        return Row(kind, where, moments, self.greatest, self.limit, slowest, allowed, self.unreadable, wrong=wrong)


def inject(rig: R, fault: Injection[R], moments: int, approach: Callable[[], object], tally: Tally) -> None:
    """Inject a fault at some moments, with a person who arms again after each.

    Args:
        rig: into which.
        fault: of this kind.
        moments: how many.
        approach: goes on from arming to the next moment.
        tally: of what comes of it.
    """
    for moment in range(moments):
        if not tally.armed(rig, moment):
            return
        approach()
        tally.begin(rig)
        fault.start(rig)
        rig.go(round((fault.seen_after + STOP_WITHIN) / PERIOD) + fault.watched)
        on_for = tally.force_for(rig, moment)
        if fault.reasons:
            as_it_must = not rig.armed and rig.status[1] in fault.reasons and on_for <= fault.allowed + 1e-9
        else:
            as_it_must = fault.reasons is None or rig.armed
        if not as_it_must:
            tally.surprise(rig, moment, on_for)
        fault.stop(rig)
        if fault.reasons:
            rig.begin_moment()
            rig.go(fault.after)
            if rig.omega.get("greatest_force"):
                tally.wrong.append(f"{moment}: it went on by itself")
