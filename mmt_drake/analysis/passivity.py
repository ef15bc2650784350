"""Energy exchanged at the two ends of the teleoperator, and whether more came back to the hand than was put in."""

from dataclasses import dataclass

import numpy as np

from mmt_drake.analysis.signals import column, component, flag, mean_step, stretches, vector
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording.recording import Recording
from mmt_drake.recording.signals import AXES

ROUNDING = 1e-9


@dataclass(frozen=True)
class PortEnergy:
    """Energy that flows into a port: E(t) = -integral of F v dt, F the force on the hand or probe.

    Attributes:
        time: (n,) [s].
        absorbed: (n,) energy [J] taken in since the first sample, what was given back subtracted. A port at rest with
            nothing stored at the first sample is passive as long as this stays at or above 0.
        put_in: energy [J] of all steps in which it was taken in.
        returned: energy [J] of all steps in which it was given back, positive.
        minimum: the least of `absorbed` [J], 0 at most.
        minimum_at: when that is reached [s].
        worst_contact: the least of `absorbed` [J] counted anew from the start of every contact, 0 at most.
            Energy dissipated earlier cannot hide what a single contact gives back too much; but what was stored before
            the touch, in a moving body or in its ground spring, counts as given.
    """

    time: Array
    absorbed: Array
    put_in: float
    returned: float
    minimum: float
    minimum_at: float
    worst_contact: float

    @property
    def violation(self) -> float:
        """Energy [J] given back beyond all that had been put in, at the worst moment; 0 for a passive port."""
        return max(0.0, -self.minimum)

    @property
    def passive(self) -> bool:
        """True if there is no violation beyond rounding, 1e-9 of what was put in."""
        return self.violation <= ROUNDING * self.put_in

    @property
    def net(self) -> float:
        """Energy [J] absorbed over the whole recording."""
        return float(self.absorbed[-1])


@dataclass(frozen=True)
class Passivity:
    """Energy at the operator's port and, delivered to the environment, at the telerobot's.

    Attributes:
        operator: from the hand into the rendering, with `rendered_force_*` and `master_position_*`.
        telerobot: from the probe into the environment, with `force_*` and `position_*`.
    """

    operator: PortEnergy
    telerobot: PortEnergy

    @property
    def between(self) -> Array:
        """(n,) energy [J] the hand has put in, less what the environment took: stored or burnt in between.

        Where it is negative the telerobot's own drive has done the work.
        """
        return self.operator.absorbed - self.telerobot.absorbed

    def lines(self) -> list[str]:
        """Lines for a summary. Only the operator's port gets a verdict: the telerobot's force carries sensor noise."""
        hand, probe = self.operator, self.telerobot
        broken = f"NOT passive: {hand.violation:.3g} J more than was put in, at {hand.minimum_at:.3f} s"
        verdict = "passive" if hand.passive else broken
        return [
            f"energy at the operator's port: {verdict}; {_exchanged(hand)}",
            f"energy at the telerobot's port: least balance {probe.minimum:+.3g} J; {_exchanged(probe)}",
        ]

    def to_json(self) -> dict[str, dict[str, float]]:
        """`{"operator": {...}, "telerobot": {...}}`, all in joules, `minimum_at_s` in seconds."""
        return {
            name: {
                "put_in_j": port.put_in,
                "returned_j": port.returned,
                "net_j": port.net,
                "minimum_j": port.minimum,
                "minimum_at_s": port.minimum_at,
                "violation_j": port.violation,
                "worst_contact_j": port.worst_contact,
            }
            for name, port in (("operator", self.operator), ("telerobot", self.telerobot))
        }


def passivity(recording: Recording) -> Passivity:
    """Energy at both ends of a recorded run.

    Contacts are the stretches with rendered force at the operator's port and those of `in_contact` at the telerobot's
    (where the recording has it, since a noisy sensor never reads exactly zero).

    Raises:
        BadInput: `rendered_force_*`, `master_position_*`, `force_*` or `position_*` is missing or broken.
    """
    mean_step(recording)  # the clock must run forward
    contact = flag(recording, "in_contact") if "in_contact" in recording else None
    return Passivity(
        operator=_recorded(recording, "rendered_force", "master_position", None),
        telerobot=_recorded(recording, "force", "position", contact),
    )


def _recorded(recording: Recording, force: str, position: str, active: Flags | None) -> PortEnergy:
    """Energy into the port where these were recorded.

    The integral is taken over displacement, F dx with the mean force of each step: the same as F v dt, but no velocity
    has to be measured or derived, and a spring sampled at any rate gives back exactly what it took.
    """
    time = recording.time
    if active is None:
        active = np.logical_or.reduce([component(recording, force, axis) != 0.0 for axis in AXES])
    steps, absorbed = np.zeros(len(time) - 1), np.zeros(len(time))  # taken in from each sample to the next, and in all
    for axis in AXES:  # one at a time: an hour's run has to fit
        felt = component(recording, force, axis)
        step = felt[1:] + felt[:-1]
        step *= np.diff(component(recording, position, axis))
        steps += step
        del felt, step
    steps *= -0.5
    np.cumsum(steps, out=absorbed[1:])
    lowest = int(np.argmin(absorbed))
    return PortEnergy(
        time=time,
        absorbed=absorbed,
        put_in=float(np.sum(steps[steps > 0.0])),
        returned=float(-np.sum(steps[steps < 0.0])),
        minimum=float(absorbed[lowest]),
        minimum_at=float(time[lowest]),
        worst_contact=_worst_contact(absorbed, active),
    )


@dataclass(frozen=True)
class Returnable:
    """Energy that the hand has put into a rendered model, less what that could give back: at least 0 if nothing makes
    energy.

    Attributes:
        least: over the run [J].
        least_at: when that is [s].
        put_in: energy [J] of all steps in which the hand put some in.
    """

    least: float
    least_at: float
    put_in: float

    @property
    def holds(self) -> bool:
        """True if the model never held more than was put in, to rounding (1e-9 of what was put in)."""
        return self.least >= -ROUNDING * self.put_in

    def to_json(self) -> dict[str, float | bool]:
        """Plain numbers."""
        return {"holds": self.holds, "least_j": self.least, "least_at_s": self.least_at}


def returnable(recording: Recording) -> Returnable:
    """The energy that what is rendered could give back beside what was put in.

    A model with fixed, passive numbers gives back `stored_energy` at most. As long as the hand has put in that much
    more than it got back, it cannot get out energy that nobody put in, whatever comes. What it puts in is counted as
    with a device that holds each force until the next.

    Raises:
        BadInput: `rendered_force_*`, `master_position_*` or `stored_energy` is missing or broken.
    """
    force, position = vector(recording, "rendered_force"), vector(recording, "master_position")
    steps = -np.sum(force[:-1] * np.diff(position, axis=0), axis=1)
    balance = np.concatenate([[0.0], np.cumsum(steps)]) - column(recording, "stored_energy")
    lowest = int(np.argmin(balance))
    return Returnable(float(balance[lowest]), float(recording.time[lowest]), float(np.sum(steps[steps > 0.0])))


def _worst_contact(absorbed: Array, active: Flags) -> float:
    """The least energy balance [J] of any contact, each from 0 at the sample before it begins."""
    starts = ((max(first - 1, 0), last) for first, last in stretches(active))
    return min((float(np.min(absorbed[a : last + 2]) - absorbed[a]) for a, last in starts), default=0.0)


def _exchanged(port: PortEnergy) -> str:
    return f"{port.put_in:.3g} J in, {port.returned:.3g} J back, worst single contact {port.worst_contact:+.3g} J"
