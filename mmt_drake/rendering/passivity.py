"""Time-domain passivity control of a network that carries motion one way and force the other.

Ryu, Kwon, Hannaford, "Stable teleoperation with time-domain passivity control", IEEE Trans. Robotics and Automation
20(2), 2004; with delay: Ryu, Artigas, Preusche, "A passive bilateral control scheme for a teleoperator with
time-varying communication delay", Mechatronics 20(7), 2010.

The network is a two-port. At each end an observer adds up, axis by axis, the energy that flows into the network,
E_in, and out of it, E_out; E_in travels to the other end, where it arrives late and is therefore never too large. The
network makes no energy as long as at each end

    E_out - (what the controller there has burnt)  <=  E_in of the other end, as received.

Where that fails, the controller burns the difference: at the operator's end by a force against the motion, -alpha v, at
the telerobot's end by a motion that yields to the force, v + beta F. The second makes the telerobot drift away from its
command; as long as there is energy left it is led back (Chawda, Van Quang, O'Malley, Ryu: "Compensating position drift
in time domain passivity approach based teleoperation", IEEE Haptics Symposium, 2014).
"""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from numba import njit

from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout
from mmt_drake.quantities import Checked, Quantity, Time
from mmt_drake.rendering.finite import all_finite, share_held


@dataclass(frozen=True)
class PassivityControl(Checked):
    """The strength with which both ends may act.

    Attributes:
        most_damping: alpha at most [N s/m]; a device with a moving mass m and a period T takes less than 2 m / T.
        most_yielding: beta at most [m/(N s)].
        yielding_lag: time constant with which the telerobot takes up such a motion [s]: its inertia. An object with a
            damper b answers a motion at once, and the loop of both stays calm where beta b < 2 yielding_lag / T.
        return_time: time constant in which a drifted telerobot is led back to its command [s]; null: never.

    Raises:
        BadInput: a number that is not positive.
    """

    most_damping: Annotated[float, Quantity("N s/m", positive=True)] = 50.0
    most_yielding: Annotated[float, Quantity("m/(N s)", positive=True)] = 0.1
    yielding_lag: Time = 0.01
    return_time: Annotated[float | None, Quantity("s", positive=True)] = 0.5

    CALLED: ClassVar = "passivity control"


# Both memories begin with the energies [J], three numbers each: into the network, out of it, burnt by the controller.
ENERGY_PORT = {"energy_in": 3}
_BOTH = (3, 3, 3, 3)
IN, _OUT, _BURNT, _POSITION = map(Layout(), _BOTH)

# The operator's end: then its position, the force that came from the network, what the controller added to it, and for
# how long [s] nothing has come that could be used.
*_, _FORCE, _ADDED, _AGE, FORCE_MEMORY_SIZE = map(Layout(), (*_BOTH, 3, 3, 1, 0))

# The telerobot's end: then the position commanded, the force there, the drift and its rate.
*_, _FELT, _DRIFT, _RATE, _BEGUN, MOTION_MEMORY_SIZE = map(Layout(), (*_BOTH, 3, 3, 3, 1, 0))


@njit(cache=True)
def _observe(memory: Array, i: int, energy: float) -> None:
    """Add what flowed into the network along axis i [J]."""
    memory[IN + i] += max(energy, 0.0)
    memory[_OUT + i] += max(-energy, 0.0)


@njit(cache=True)
def _deficit(memory: Array, i: int, received: float) -> float:
    """Energy that has come out along axis i and is covered by nothing [J]; negative: what may still come out."""
    return memory[_OUT + i] - memory[_BURNT + i] - received


@njit(cache=True)
def _strength(deficit: float, burnt_by_one: float, most: float) -> float:
    """The strength, `most` at most, that burns the deficit [J] where a strength of one burns `burnt_by_one` [J]."""
    return most if deficit >= most * burnt_by_one else deficit / burnt_by_one


@njit(cache=True)
def control_force(
    memory: Array,
    motion: Array,
    remote_force: Array,
    remote_energy: Array,
    period: float,
    most_damping: float,
    force: Array,
) -> None:
    """One tick of the operator's end.

    Forces are held between ticks, so what flowed in the last one is known exactly. In a tick with anything that is not
    finite the last force is held on, then let go (`finite`); what flows meanwhile is accounted for as soon as the hand
    is seen.

    Args:
        memory: (FORCE_MEMORY_SIZE,) changed; zeros before the first tick.
        motion: (6,) of the hand [m], [m/s].
        remote_force: (3,) as received [N].
        remote_energy: (3,) that went in at the telerobot's end, as received [J].
        period: [s].
        most_damping: [N s/m].
        force: (3,) on the hand, to be filled [N].
    """
    seen = all_finite(motion)
    if seen:
        for i in range(3):
            moved = motion[i] - memory[_POSITION + i]
            _observe(memory, i, -memory[_FORCE + i] * moved)
            memory[_BURNT + i] -= memory[_ADDED + i] * moved
            memory[_POSITION + i] = motion[i]
    if not (seen and all_finite(remote_force) and all_finite(remote_energy)):
        left = share_held(memory[_AGE])
        memory[_AGE] += period
        left = share_held(memory[_AGE]) / left if left > 0.0 else 0.0
        for i in range(3):
            memory[_FORCE + i] *= left
            memory[_ADDED + i] *= left
            force[i] = memory[_FORCE + i] + memory[_ADDED + i]
        return
    for i in range(3):
        v, added = motion[3 + i], 0.0
        deficit = _deficit(memory, i, remote_energy[i])
        if deficit > 0.0:
            added = -_strength(deficit, v * v * period, most_damping) * v
        memory[_FORCE + i], memory[_ADDED + i] = remote_force[i], added
        force[i] = remote_force[i] + added
    memory[_AGE] = 0.0


@njit(cache=True)
def control_motion(
    memory: Array,
    commanded: Array,
    force: Array,
    remote_energy: Array,
    period: float,
    most_yielding: float,
    share: float,
    return_rate: float,
) -> None:
    """One tick of the telerobot's end: how it drifts until the next. A tick with anything not finite is skipped.

    Args:
        memory: (MOTION_MEMORY_SIZE,) changed; zeros before the first tick.
        commanded: (6,) as received [m], [m/s].
        force: (3,) on the probe now [N].
        remote_energy: (3,) that went in at the operator's end, as received [J].
        period: [s].
        most_yielding: [m/(N s)].
        share: of the way to a new rate that is made in a tick.
        return_rate: [1/s], 0: never.
    """
    if not (all_finite(commanded) and all_finite(force) and all_finite(remote_energy)):
        return
    for i in range(3):
        if memory[_BEGUN] != 0.0:
            mean = 0.5 * (memory[_FELT + i] + force[i])
            _observe(memory, i, mean * (commanded[i] - memory[_POSITION + i]))
            memory[_BURNT + i] += mean * memory[_RATE + i] * period
        deficit = _deficit(memory, i, remote_energy[i])
        # Back to the command, as far as there is energy for it.
        available, wanted = max(-deficit, 0.0), -return_rate * memory[_DRIFT + i]
        if -force[i] * wanted * period > available:
            wanted = -available / (force[i] * period)
        if deficit > 0.0:
            wanted += _strength(deficit, force[i] * force[i] * period, most_yielding) * force[i]
        rate = memory[_RATE + i] + share * (wanted - memory[_RATE + i])
        memory[_RATE + i] = rate
        memory[_DRIFT + i] += rate * period
        memory[_POSITION + i], memory[_FELT + i] = commanded[i], force[i]
    memory[_BEGUN] = 1.0


@njit(cache=True)
def drifted(memory: Array, commanded: Array, motion: Array) -> None:
    """Write the (6,) motion of a telerobot that has drifted from the one commanded."""
    for i in range(3):
        motion[i] = commanded[i] + memory[_DRIFT + i]
        motion[3 + i] = commanded[3 + i] + memory[_RATE + i]
