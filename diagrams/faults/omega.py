"""Faults of the haptic device itself: a rig with an emulated one, the kinds, and what comes of each."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, System
from pydrake.systems.primitives import ConstantVectorSource

from mmt_drake.diagrams.faults.session import emulated_omega
from mmt_drake.diagrams.faults.table import Row
from mmt_drake.hw.omega import OmegaOperator, OmegaSettings
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.safety import STOP_WITHIN, OperatorSwitch, Reason, SafetyLimits, describe, supervised
from mmt_drake.systems.leaf import LeafSystem

Array = NDArray[np.float64]

PERIOD = 1e-3  # [s]
SETTINGS = OmegaSettings(device=0, calibration="required", force=7.0, origin=(0.0, 0.0, 0.01))
LIMITS = SafetyLimits(force=5.0, power=2.0, speed=0.6, rise=0.02)


class Wall(LeafSystem):
    """F_z = -k z - b v_z below z = 0, k = 400 N/m, b = 2 N s/m, and whatever a trial adds.

    .. pydrake_system::

        name: Wall
        input_ports:
        - motion
        output_ports:
        - force

    - `motion` (6): position [m] and velocity [m/s], table frame.
    - `force` (3): [N].
    """

    def __init__(self) -> None:
        super().__init__()
        self.added = np.zeros(3)
        self._motion = self.DeclareVectorInputPort("motion", 6)
        self.DeclareVectorOutputPort("force", 3, self._calc)

    def _calc(self, context: Context, output: BasicVector) -> None:
        motion = self._motion.Eval(context)
        force = self.added.copy()
        if motion[2] < 0.0:
            force[2] += -400.0 * motion[2] - 2.0 * motion[5]
        output.SetFromVector(force)


class RigClock:
    """The emulated device's, as its driver reads it.

    Attributes:
        offset: added to it [s].
    """

    def __init__(self, omega: EmulatedOmega) -> None:
        self._omega, self.offset = omega, 0.0

    def __call__(self) -> float:
        return self._omega.get("clock") + self.offset


class OmegaRig:
    """A session with an emulated hand that presses and strokes; nothing happens but in `go`.

    Attributes:
        omega: the far side of the device.
        wall: what is felt; a trial may add to it.
        switch: the person's.
        operator: the system of the driver.
        clock: the driver's.

    Args:
        omega: a fresh one.
        settings: of the driver.
        limits: of the supervisor.
    """

    def __init__(self, omega: EmulatedOmega, settings: OmegaSettings = SETTINGS, limits: SafetyLimits = LIMITS) -> None:
        self.omega, self.clock = omega, RigClock(omega)
        omega.set(target_z=-0.018, swing_x=0.01, swing_y=0.007, swing_z=0.006, swing_hz=1.7)
        self.operator = OmegaOperator(settings, clock=self.clock)
        self.switch = OperatorSwitch(
            period=2e-3, press=0.01, clock=lambda: omega.get("clock"), on_arm=self.operator.request_forces
        )
        self._diagram = supervised(self.operator, limits, watched={"peer": 0.05}, switch=self.switch)
        builder = DiagramBuilder()
        builder.AddSystem(self._diagram)
        self.wall = builder.AddSystem(Wall())
        self._age = builder.AddSystem(ConstantVectorSource([0.001]))
        builder.Connect(self._diagram.GetOutputPort("motion"), self.wall.GetInputPort("motion"))
        builder.Connect(self.wall.GetOutputPort("force"), self._diagram.GetInputPort("force"))
        builder.Connect(self._age.get_output_port(), self._diagram.GetInputPort("ages"))
        self.simulator = Simulator(builder.Build())
        self.simulator.Initialize()
        self.go(3)

    def go(self, ticks: int, each: Callable[[int], object] | None = None) -> Array:
        """So many ticks; `each` is called before each one. Gives what the motors did (ticks, 3) [N], device frame."""
        applied = np.empty((ticks, 3))
        for i in range(ticks):
            if each is not None:
                each(i)
            self.simulator.AdvanceTo(self.simulator.get_context().get_time() + PERIOD)
            self.omega.advance(PERIOD)
            applied[i] = self.omega.vector("applied")
        return applied

    def arm(self) -> bool:
        """A person presses the switch, and the force comes back; gives whether it does."""
        self.go(6)
        self.switch.arm()
        self.go(34)
        return bool(self.status[0])

    def set_age(self, age: float) -> None:
        """Age of the peer's latest packet [s]."""
        context = self._age.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        self._age.get_mutable_source_value(context).SetFromVector([age])

    def _eval(self, system: System, port: str) -> Array:
        context = system.GetMyContextFromRoot(self.simulator.get_context())
        return np.array(system.GetOutputPort(port).Eval(context))

    @property
    def status(self) -> Array:
        """(6) of the supervisor."""
        return self._eval(self._diagram, "status")

    @property
    def motion(self) -> Array:
        """(6) of the hand, table frame."""
        return self._eval(self._diagram, "motion")

    @property
    def device(self) -> Array:
        """(3) of the driver."""
        return self._eval(self.operator, "device")

    def told(self) -> str:
        """The supervisor's status in words."""
        return describe(self.status, ("peer",))

    def close(self) -> None:
        """Give the device back."""
        self.operator.close()


Action = Callable[[OmegaRig], object]


@dataclass(frozen=True)
class OmegaFault:
    """One kind of fault.

    Attributes:
        start, stop: what brings it and what takes it away.
        reasons: that the supervisor may give; empty where it goes on.
        seen_after: how long it takes until it can be told [s].
        once: nothing goes on after it.
    """

    start: Action
    stop: Action
    reasons: tuple[int, ...]
    seen_after: float = 0.0
    once: bool = False


def _set(**members: float) -> Action:
    return lambda rig: rig.omega.set(**members)


def _fail(calls: float, error: float) -> OmegaFault:
    return OmegaFault(_set(failing=calls, error=error), _set(failing=0.0), (Reason.DEVICE_FAULT,))


def _member(reasons: tuple[int, ...], seen_after: float = 0.0, **members: float) -> OmegaFault:
    return OmegaFault(_set(**members), _set(**dict.fromkeys(members, 0.0)), reasons, seen_after)


def _force(x: float) -> Action:
    def change(rig: OmegaRig) -> None:
        rig.wall.added = np.array([x, 0.0, 0.0])

    return change


def _clock(offset: float) -> Action:
    def change(rig: OmegaRig) -> None:
        rig.clock.offset += offset

    return change


def _nothing(rig: OmegaRig) -> None:
    pass


def _stall(seconds: float) -> Action:
    return lambda rig: rig.omega.advance(seconds)


def _let_go(rig: OmegaRig) -> None:
    rig.omega.set(hand_stiffness=0.0, hand_damping=0.0, hand_mass=0.0)
    rig.wall.added = np.array([0.0, 0.0, 5.0])


def _hold_again(rig: OmegaRig) -> None:
    rig.omega.set(hand_stiffness=250.0, hand_damping=4.0, hand_mass=0.15, x=0.0, y=0.0, z=-0.01, vx=0.0, vy=0.0, vz=0.0)
    rig.wall.added = np.zeros(3)


FAULT = (Reason.DEVICE_FAULT,)
LOST = OmegaFault(_set(connected=0.0), _set(connected=1.0), FAULT)
#: A slow call also makes the device's own watchdog hungry; either may be told first.
SLOW = (Reason.OVERRUN, Reason.DEVICE_FAULT)

KINDS: dict[str, OmegaFault] = {
    "unplugged": LOST,
    "one call fails": _fail(1.0, 1.0),
    "thirty calls fail": _fail(30.0, 2.0),
    "every call times out": _fail(1e9, 7.0),
    "an error number that nobody knows": _fail(2.0, 77.0),
    "position NaN": _member(FAULT, nan_position=1.0),
    "velocity NaN": _member(FAULT, nan_velocity=1.0),
    "position stuck": _member((Reason.STUCK,), LIMITS.stuck, stuck=1.0),
    "position off by 5 cm": _member((Reason.JUMP,), jump=0.05),
    "calls take 15 ms": _member(SLOW, slow=0.015),
    "force button": _member(FAULT, force_button=1.0),
    "no power": OmegaFault(_set(powered=0.0), _set(powered=1.0), FAULT),
    "diagram stalls for 40 ms": OmegaFault(_stall(0.040), _nothing, SLOW),
    "force NaN": OmegaFault(_force(np.nan), _force(0.0), (Reason.COMMAND_NOT_FINITE,)),
    "force of 1 MN": OmegaFault(_force(1e6), _force(0.0), ()),
    "handle let go": OmegaFault(_let_go, _hold_again, (Reason.SPEED, Reason.WORKSPACE, Reason.DEVICE_FAULT), 0.150),
    "clock set back": OmegaFault(_clock(-100.0), _nothing, (Reason.CLOCK,)),
    "clock set forward": OmegaFault(_clock(100.0), _nothing, (Reason.OVERRUN,)),
    "peer lost": OmegaFault(lambda rig: rig.set_age(10.0), lambda rig: rig.set_age(0.001), (Reason.STALE,)),
    "emergency stop": OmegaFault(
        lambda rig: rig.switch.stop(), lambda rig: rig.switch.release(), (Reason.EMERGENCY_STOP,)
    ),
    "device closed": OmegaFault(lambda rig: rig.close(), _nothing, FAULT, once=True),
}


_LONGER = 20  # ticks that are watched once the force must be zero


def try_omega(moments: int, folder: Path) -> Iterator[Row]:
    """The haptic device, its driver and whoever holds it."""
    device = emulated_omega(folder)
    for kind in KINDS:
        yield try_fault(kind, device, moments)


def try_fault(name: str, omega: EmulatedOmega, moments: int = 50, seed: int = 0) -> Row:
    """Bring about one kind of fault at random moments, with a person who arms again after each.

    Args:
        name: of one of `KINDS`.
        omega: an emulated device.
        moments: how many.
        seed: of the moments.
    """
    kind, rng = KINDS[name], np.random.default_rng([seed, list(KINDS).index(name)])
    allowed = kind.seen_after + STOP_WITHIN
    watched = round(allowed / PERIOD) + _LONGER
    omega.reset()
    rig = OmegaRig(omega)
    felt, greatest, slowest, wrong = 0, 0.0, 0.0, []
    moments = 1 if kind.once else moments
    for moment in range(moments):
        if not rig.arm():
            wrong.append(f"{moment}: cannot be armed: {rig.told()}")
            break
        rig.go(int(rng.integers(0, 40)))
        felt += bool(omega.vector("applied").any())
        start = omega.get("simulated")
        omega.set(greatest_force=0.0, last_force_at=start)
        kind.start(rig)
        rig.go(watched)
        greatest = max(greatest, omega.get("greatest_force"))
        on_for = omega.get("last_force_at") - start
        slowest = max(slowest, on_for)
        if greatest > LIMITS.force * (1 + 1e-9) or omega.get("not_finite"):
            wrong.append(f"{moment}: a force of {greatest:.3g} N, or none that is a number, was sent")
        stopped = on_for <= allowed + 1e-9 and rig.status[0] == 0.0 and rig.status[1] in kind.reasons
        if stopped != bool(kind.reasons):
            wrong.append(f"{moment}: {rig.told()}, a force for {1e3 * on_for:.1f} ms")
        kind.stop(rig)
        if kind.reasons and rig.go(10).any():
            wrong.append(f"{moment}: it went on by itself")
    rig.close()
    if felt < moments // 2:
        wrong.append(f"at {felt} of {moments} moments was there a force: too few to show anything")
    stays = not kind.reasons
    return Row(
        kind=name,
        where="omega",
        moments=moments,
        greatest_force=greatest,
        force_limit=LIMITS.force,
        zero_after=np.nan if stays else slowest,
        allowed=np.nan if stays else allowed,
        wrong=tuple(wrong),
    )
