"""Faults of the haptic device itself: a rig with an emulated one, the kinds, and what comes of each."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from mmt_drake.diagrams.proof.faults.injection import PERIOD, HandRig, Injection, Tally, emulated_omega, inject
from mmt_drake.diagrams.proof.faults.table import Row
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.omega.operator import OmegaOperator
from mmt_drake.hw.omega.settings import OmegaSettings
from mmt_drake.hw.safety.limits import SafetyLimits
from mmt_drake.hw.safety.operator_switch import OperatorSwitch
from mmt_drake.hw.safety.reasons import Reason
from mmt_drake.hw.safety.supervised import supervised
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.leaf import LeafSystem

SETTINGS = OmegaSettings(device=0, calibration="required", force=7.0, origin=(0.0, 0.0, 0.01))
LIMITS = SafetyLimits(force=5.0, power=2.0, speed=0.6, rise=0.02)


class Wall(LeafSystem):
    """F_z = -k z - b v_z below z = 0, k = 400 N/m, b = 2 N s/m, and whatever a fault adds.

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


class OmegaRig(HandRig):
    """A session with an emulated hand that presses and strokes; nothing happens but in `go`.

    Attributes:
        wall: what is felt; a fault may add to it.
        switch: the person's.
        operator: the system of the driver.
        clock: the driver's.

    Args:
        omega: a fresh one.
        settings: of the driver.
    """

    def __init__(self, omega: EmulatedOmega, settings: OmegaSettings = SETTINGS) -> None:
        self.omega, self.clock = omega, RigClock(omega)
        omega.set(target_z=-0.018, swing_x=0.01, swing_y=0.007, swing_z=0.006, swing_hz=1.7)
        self.operator = OmegaOperator(settings, clock=self.clock)
        self.switch = OperatorSwitch(
            period=2e-3, press=0.01, clock=lambda: omega.get("clock"), on_arm=self.operator.request_forces
        )
        self.supervised = supervised(self.operator, LIMITS, watched={"peer": 0.05}, switch=self.switch)
        self.watched = ("peer",)
        builder = DiagramBuilder()
        builder.AddSystem(self.supervised)
        self.wall = builder.AddSystem(Wall())
        self._age = builder.AddSystem(ConstantVectorSource([0.001]))
        builder.Connect(self.supervised.GetOutputPort("motion"), self.wall.GetInputPort("motion"))
        builder.Connect(self.wall.GetOutputPort("force"), self.supervised.GetInputPort("force"))
        builder.Connect(self._age.get_output_port(), self.supervised.GetInputPort("ages"))
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

    @property
    def motion(self) -> Array:
        """(6) of the hand, table frame."""
        return self.read(self.supervised, "motion")

    @property
    def device(self) -> Array:
        """(3) of the driver."""
        return self.read(self.operator, "device")

    def close(self) -> None:
        """Give the device back."""
        self.operator.close()


OmegaFault = Injection[OmegaRig]
_Action = Callable[[OmegaRig], object]


def _set(**members: float) -> _Action:
    return lambda rig: rig.omega.set(**members)


def _device(reasons: tuple[int, ...], *, healed: float = 0.0, seen_after: float = 0.0, **members: float) -> OmegaFault:
    """Members of the device are set, and all healed again."""
    return OmegaFault(_set(**members), _set(**dict.fromkeys(members, healed)), reasons, seen_after)


def _force(x: float) -> _Action:
    def change(rig: OmegaRig) -> None:
        rig.wall.added = np.array([x, 0.0, 0.0])

    return change


def _clock(offset: float) -> _Action:
    def change(rig: OmegaRig) -> None:
        rig.clock.offset += offset

    return change


def _nothing(rig: OmegaRig) -> None:
    pass


def _let_go(rig: OmegaRig) -> None:
    rig.omega.set(hand_stiffness=0.0, hand_damping=0.0, hand_mass=0.0)
    rig.wall.added = np.array([0.0, 0.0, 5.0])


def _hold_again(rig: OmegaRig) -> None:
    rig.omega.set(hand_stiffness=250.0, hand_damping=4.0, hand_mass=0.15, x=0.0, y=0.0, z=-0.01, vx=0.0, vy=0.0, vz=0.0)
    rig.wall.added = np.zeros(3)


CLOSED = "device closed"  # after which nothing goes on
FAULT = (Reason.DEVICE_FAULT,)
#: A slow call also makes the device's own watchdog hungry; either may be seen first.
SLOW = (Reason.OVERRUN, Reason.DEVICE_FAULT)

KINDS: dict[str, OmegaFault] = {
    "unplugged": _device(FAULT, connected=0.0, healed=1.0),
    "one call fails": _device(FAULT, failing=1.0, error=1.0),
    "thirty calls fail": _device(FAULT, failing=30.0, error=2.0),
    "every call times out": _device(FAULT, failing=1e9, error=7.0),
    "an error number that nobody knows": _device(FAULT, failing=2.0, error=77.0),
    "position NaN": _device(FAULT, nan_position=1.0),
    "velocity NaN": _device(FAULT, nan_velocity=1.0),
    "position stuck": _device((Reason.STUCK,), seen_after=LIMITS.stuck, stuck=1.0),
    "position off by 5 cm": _device((Reason.JUMP,), jump=0.05),
    "calls take 15 ms": _device(SLOW, slow=0.015),
    "force button": _device(FAULT, force_button=1.0),
    "no power": _device(FAULT, powered=0.0, healed=1.0),
    "diagram stalls for 40 ms": OmegaFault(lambda rig: rig.omega.advance(0.040), _nothing, SLOW),
    "force NaN": OmegaFault(_force(np.nan), _force(0.0), (Reason.COMMAND_NOT_FINITE,)),
    "force of 1 MN": OmegaFault(_force(1e6), _force(0.0), ()),
    "handle let go": OmegaFault(_let_go, _hold_again, (Reason.SPEED, Reason.WORKSPACE, Reason.DEVICE_FAULT), 0.150),
    "clock set back": OmegaFault(_clock(-100.0), _nothing, (Reason.CLOCK,)),
    "clock set forward": OmegaFault(_clock(100.0), _nothing, (Reason.OVERRUN,)),
    "peer lost": OmegaFault(lambda rig: rig.set_age(10.0), lambda rig: rig.set_age(0.001), (Reason.STALE,)),
    "emergency stop": OmegaFault(
        lambda rig: rig.switch.stop(), lambda rig: rig.switch.release(), (Reason.EMERGENCY_STOP,)
    ),
    CLOSED: OmegaFault(lambda rig: rig.close(), _nothing, FAULT),
}


def rows(moments: int, folder: Path) -> Iterator[Row]:
    """The haptic device, its driver and whoever holds it."""
    device = emulated_omega(folder)
    for kind in KINDS:
        yield try_fault(kind, device, moments)


def try_fault(name: str, omega: EmulatedOmega, moments: int = 50) -> Row:
    """Bring about one kind of fault at random moments, with a person who arms again after each.

    Args:
        name: of one of `KINDS`.
        omega: an emulated device.
        moments: how many.
    """
    rng = np.random.default_rng([0, list(KINDS).index(name)])
    omega.reset()
    tally, moments = Tally(LIMITS.force), 1 if name == CLOSED else moments
    with OmegaRig(omega) as rig:
        inject(rig, KINDS[name], moments, lambda: rig.go(int(rng.integers(0, 40))), tally)
    tally.must_have_felt(moments // 2, moments)
    return tally.row(name, "omega", moments, KINDS[name].allowed)
