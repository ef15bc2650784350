"""Faults of all that the supervisor watches: the session, the kinds, and what comes of each."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from mmt_drake.diagrams.proof.faults.table import Row
from mmt_drake.hw.safety import kernel
from mmt_drake.hw.safety.limits import STOP_WITHIN, SafetyLimits
from mmt_drake.hw.safety.reasons import Reason
from mmt_drake.numeric.arrays import Array

PERIOD = 1e-3  # [s]
LIMITS = SafetyLimits()
OLDEST = np.array([0.1, 0.5])  # [s] of a peer and a worker


@dataclass
class Inputs:
    """What the supervisor sees at one tick."""

    t: float
    command: Array
    motion: Array
    device: Array
    ages: Array
    switches: Array


def ordinary(tick: int) -> Inputs:
    """A hand that strokes and presses at up to 0.35 m/s, a force within every limit, everything fresh."""
    t = tick * PERIOD
    w = 2 * np.pi * 2.0
    position = np.array([0.02 * np.sin(w * t), 0.025 * np.sin(0.7 * w * t), 0.01 * np.cos(1.3 * w * t)])
    velocity = w * np.array([0.02 * np.cos(w * t), 0.0175 * np.cos(0.7 * w * t), -0.013 * np.sin(1.3 * w * t)])
    return Inputs(
        t=t,
        command=np.array([1.5 * np.cos(5 * t), -2.0 * np.sin(3 * t), 2.5 + np.sin(7 * t)]),
        motion=np.concatenate([position, velocity]),
        device=np.array([0.0, 1000.0 + t, 0.0]),
        ages=np.array([0.005, 0.03]),
        switches=np.zeros(2),
    )


@dataclass
class Bench:
    """Runs the kernel and keeps what it gave out."""

    limits: SafetyLimits = field(default_factory=SafetyLimits)
    memory: Array = field(default_factory=kernel.initial_memory)
    tick: int = 0

    def step(self, inputs: Inputs) -> Array:
        """One tick; gives the force (3)."""
        out = np.empty(kernel.MEMORY_SIZE)
        seen = (inputs.command, inputs.motion, inputs.device, inputs.ages, inputs.switches)
        kernel.supervise(self.memory, inputs.t, *seen, self.limits.kernel_vector(), OLDEST, out)
        self.memory = out
        self.tick += 1
        return out[:3].copy()

    def run(self, ticks: int, change: Callable[[Inputs], None] = lambda inputs: None) -> Array:
        """(ticks, 3) the forces of so many ticks."""
        forces = np.empty((ticks, 3))
        for i in range(ticks):
            inputs = ordinary(self.tick)
            change(inputs)
            forces[i] = self.step(inputs)
        return forces

    def arm(self) -> None:
        """A person presses and lets go; then the force comes back in full."""
        self.run(2)
        self.run(100, press)
        self.run(300)

    @property
    def status(self) -> Array:
        """(6) as on the port."""
        return self.memory[3:9]

    @property
    def armed(self) -> bool:
        """Whether force is let through."""
        return bool(self.status[0])

    @property
    def reason(self) -> int:
        """`mmt_drake.hw.safety.Reason`, as a number."""
        return int(self.status[1])


def press(inputs: Inputs) -> None:
    """The arm switch."""
    inputs.switches[0] = 1.0


def armed_bench(limits: SafetyLimits | None = None) -> Bench:
    """A session that is under way."""
    bench = Bench(limits or SafetyLimits())
    bench.arm()
    return bench


Change = Callable[[Inputs, int, np.random.Generator], None]
"""Changes what the supervisor sees, so many ticks after the fault began."""


@dataclass(frozen=True)
class SupervisorFault:
    """One kind of fault.

    Attributes:
        change: what the supervisor sees of it.
        reason: that it must give; None where it must go on within its limits.
        seen_after: how long it takes until it can be seen [s], beside one tick.
        lasts: ticks; None for ever.
    """

    change: Change
    reason: int | None
    seen_after: float = 0.0
    lasts: int | None = None


def _put(name: str, index: int | tuple[int, int], value: Callable[[float, float], float]) -> Change:
    """A number of an input becomes another.

    Args:
        name: of the input.
        index: of the number; of two the range from which it is drawn at every tick.
        value: what it becomes, given what it was and for how long there has been the fault [s].
    """

    def change(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
        numbers = getattr(inputs, name)
        at = index if isinstance(index, int) else rng.integers(*index)
        numbers[at] = value(numbers[at], since * PERIOD)

    return change


def _frozen(*, clock: bool, moving: bool = True) -> Change:
    """The position stays what it was; its clock too, or not."""

    def change(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
        start = ordinary(round(inputs.t / PERIOD) - since - 1)
        inputs.motion[:3] = start.motion[:3]
        if not moving:
            inputs.motion[3:] = 0.0
        if clock:
            inputs.device[1] = start.device[1]

    return change


def _always(value: float) -> Callable[[float, float], float]:
    return lambda was, since: value


def _later(offset: float) -> Callable[[float, float], float]:
    return lambda was, since: was + offset


def _let_go(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
    inputs.motion[3:] = [0.0, 1.4, 0.0]
    inputs.motion[1] += 1.4 * since * PERIOD


def _lost(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
    """A driver that lost its device: its code, the last position, at rest, time goes on."""
    _frozen(clock=False, moving=False)(inputs, since, rng)
    inputs.device[0] = 2.0


def _random_force(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
    inputs.command = 10.0 ** rng.uniform(-3, 12) * rng.standard_normal(3)


def _resonance(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
    inputs.command = 30.0 * inputs.motion[3:]  # negative damping: it gives power wherever the hand goes


_NAN = _always(np.nan)
_FORCE, _POSITION, _VELOCITY = ("command", (0, 3)), ("motion", (0, 3)), ("motion", (3, 6))
_CODE, _CLOCK, _STOP, _PEER, _WORKER = ("device", 0), ("device", 1), ("switches", 1), ("ages", 0), ("ages", 1)

KINDS: dict[str, SupervisorFault] = {
    "command NaN": SupervisorFault(_put(*_FORCE, _NAN), Reason.COMMAND_NOT_FINITE),
    "command infinite": SupervisorFault(_put("command", 1, _always(np.inf)), Reason.COMMAND_NOT_FINITE),
    "command NaN for one tick": SupervisorFault(_put(*_FORCE, _always(-np.inf)), Reason.COMMAND_NOT_FINITE, lasts=1),
    "position NaN": SupervisorFault(_put(*_POSITION, _NAN), Reason.MOTION_NOT_FINITE),
    "velocity NaN": SupervisorFault(_put(*_VELOCITY, _NAN), Reason.MOTION_NOT_FINITE),
    "SDK error": SupervisorFault(_put(*_CODE, _always(1.0)), Reason.DEVICE_FAULT, lasts=1),
    "fault code NaN": SupervisorFault(_put(*_CODE, _NAN), Reason.DEVICE_FAULT),
    "device lost": SupervisorFault(_lost, Reason.DEVICE_FAULT),
    "emergency stop": SupervisorFault(_put(*_STOP, _always(1.0)), Reason.EMERGENCY_STOP),
    "emergency stop with a broken wire": SupervisorFault(_put(*_STOP, _NAN), Reason.EMERGENCY_STOP),
    "clock NaN": SupervisorFault(_put(*_CLOCK, _NAN), Reason.CLOCK, lasts=1),
    "clock set back": SupervisorFault(_put(*_CLOCK, _later(-3600.0)), Reason.CLOCK),
    "clock set forward": SupervisorFault(_put(*_CLOCK, _later(3600.0)), Reason.OVERRUN),
    "overrun": SupervisorFault(_put(*_CLOCK, _later(0.030)), Reason.OVERRUN),
    "reading thread dead": SupervisorFault(_frozen(clock=True), Reason.SILENT_DEVICE, seen_after=LIMITS.gap),
    "value stuck": SupervisorFault(_frozen(clock=False), Reason.STUCK, seen_after=LIMITS.stuck),
    "value stuck, velocity zero": SupervisorFault(
        _frozen(clock=False, moving=False), Reason.STUCK, seen_after=LIMITS.stuck
    ),
    "position corrupted": SupervisorFault(_put("motion", 0, _later(0.05)), Reason.JUMP, lasts=1),
    "handle let go": SupervisorFault(_let_go, Reason.SPEED),
    "out of the workspace": SupervisorFault(
        _put("motion", 0, lambda was, since: was + 5.0 * since), Reason.WORKSPACE, seen_after=0.05
    ),
    "peer killed": SupervisorFault(_put(*_PEER, lambda was, since: was + since), Reason.STALE, seen_after=0.095),
    "peer's age NaN": SupervisorFault(_put(*_PEER, _NAN), Reason.STALE, lasts=1),
    "clock of the network set back": SupervisorFault(_put(*_PEER, _always(-60.0)), Reason.STALE),
    "worker dead": SupervisorFault(_put(*_WORKER, lambda was, since: was + since), Reason.STALE + 1, seen_after=0.47),
    "corrupted parameters": SupervisorFault(_random_force, None),
    "negative damping": SupervisorFault(_resonance, None),
}


_SESSION = 2000  # ticks of the session into which the faults are put
_LONGER = 60  # ticks that are watched once the force must be zero


def ordinary_session() -> list[Bench]:
    """The bench at every tick of an ordinary session, from which each fault starts."""
    bench, kept = armed_bench(), []
    for _ in range(_SESSION):
        kept.append(replace(bench))
        bench.run(1)
    return kept


def rows(moments: int, folder: Path) -> Iterator[Row]:
    """Numbers on the supervisor's inputs."""
    session = ordinary_session()
    for kind in KINDS:
        yield try_fault(kind, session, moments)


def try_fault(name: str, session: list[Bench], moments: int = 50) -> Row:
    """Bring about one kind of fault at random moments, while somebody leans on the arm switch.

    Args:
        name: of one of `KINDS`.
        session: from `ordinary_session`.
        moments: how many.
    """
    kind, rng = KINDS[name], np.random.default_rng([0, list(KINDS).index(name)])
    allowed = kind.seen_after + STOP_WITHIN
    must_be_zero = round(allowed / PERIOD)
    greatest, slowest, wrong = 0.0, 0.0, []
    for start in rng.integers(0, len(session), moments):
        bench, draw = replace(session[start]), np.random.default_rng(start)
        begun, last = bench.tick, 0
        for since in range(must_be_zero + _LONGER):
            inputs = inputs_under(bench, kind, begun, draw)
            press(inputs)
            force = bench.step(inputs)
            size = float(np.linalg.norm(force))
            greatest = max(greatest, size)
            if size:
                last = since + 1
            if not size <= LIMITS.force * (1 + 1e-12):
                wrong.append(f"tick {start}, {since} ms later: {size:.3g} N")
            power = force @ inputs.motion[3:] if np.isfinite(inputs.motion).all() else 0.0
            if power > LIMITS.power * (1 + 1e-9):
                wrong.append(f"tick {start}, {since} ms later: {power:.3g} W")
        slowest = max(slowest, last * PERIOD)
        if kind.reason is None:
            if not bench.armed:
                wrong.append(f"tick {start}: stopped, reason {bench.reason}")
        elif last > must_be_zero or bench.armed or bench.reason != kind.reason:
            wrong.append(f"tick {start}: a force for {last} ms, reason {bench.reason}")
    zero = (np.nan, np.nan) if kind.reason is None else (slowest, allowed)
    return Row(name, "supervisor", moments, greatest, LIMITS.force, *zero, wrong=tuple(wrong))


def inputs_under(bench: Bench, kind: SupervisorFault, start: int, rng: np.random.Generator) -> Inputs:
    """What the supervisor sees at a tick of a session in which a fault began at `start`."""
    inputs, since = ordinary(bench.tick), bench.tick - start
    if kind.lasts is None or since < kind.lasts:
        kind.change(inputs, since, rng)
    return inputs
