"""A model of a hand at work on an object, and the operator recording made with it.

The hand repeats a bout: it reaches to a place above the object, presses, rubs to and fro, fast in the
first bouts and slower later, lifts. What it *plans* is smooth; what it *does* is not:

- Plan: minimum-jerk movements (Flash and Hogan, J. Neurosci. 5(7), 1985), overlapping in reciprocal
  strokes as submovements do (Flash and Henis, J. Cogn. Neurosci. 3(3), 1991), along slightly curved
  paths (Atkeson and Hollerbach, J. Neurosci. 5(9), 1985), of durations after Fitts (J. Exp. Psychol.
  47(6), 1954).
- Signal-dependent noise: white noise whose standard deviation is proportional to the motor command,
  here the planned acceleration, disturbs the limb, and feedback brings it back with the time constant
  of a visually guided correction (Harris and Wolpert, "Signal-dependent noise determines motor
  planning", Nature 394, 1998).
- Pressing: the depth wanders by a fixed share of itself, below 1.5 Hz, as the variability of an
  isometric force is proportional to that force (Jones, Hamilton and Wolpert, "Sources of
  signal-dependent noise during isometric force production", J. Neurophysiol. 88(3), 2002).
- Physiological tremor of 8 to 12 Hz, all the time (Elble and Koller, "Tremor", Johns Hopkins, 1990;
  0.1 mm peak to peak in a steady hand: Riviere, Ang and Khosla, "Toward active tremor canceling in
  handheld microsurgical instruments", IEEE Trans. Robot. Autom. 19(5), 2003).
- Drift of the unsupported hand below 0.1 Hz.

`python scripts/hand_recording.py` writes the shipped recording again.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import butter, lfilter, sosfilt

from mmt_drake.motion.analytic import AnalyticMotion, Row, step
from mmt_drake.motion.reaching import fitts_duration, reach
from mmt_drake.motion.sampled import SampledMotion
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording, save

#: The operator recording that the package ships.
SHIPPED = Path(__file__).resolve().parents[1] / "mmt_drake" / "data" / "hand_reaching.npz"

_DIGITS = 7  # decimals kept of positions and velocities: 0.1 um; makes the file small and portable


@dataclass(frozen=True)
class HandModel:
    """A hand's habits and imperfections.

    Args:
        duration: [s], 12 s or more.
        rate: samples a second [Hz], 100 or more.
        seed: of every random choice.
        workspace: half-width of the square in which places are chosen [m].
        target_width: how exactly it aims [m] (Fitts).
        clearance: height above the object between bouts [m].
        press: least and greatest planned depth [m].
        rub: least and greatest length of a rubbing stroke [m].
        stroke_time: shortest and longest rubbing stroke [s].
        bow: sideways excursion of a reach, as a share of its length.
        command_noise: signal-dependent noise: disturbance per planned acceleration [sqrt(s)].
        press_variability: standard deviation of the depth, as a share of it.
        tremor: root mean square in each axis [m].
        drift: root mean square in each tangential axis [m].
    """

    duration: float = 60.0
    rate: float = 250.0
    seed: int = 1
    workspace: float = 0.05
    target_width: float = 0.008
    clearance: float = 0.012
    press: tuple[float, float] = (0.003, 0.006)
    rub: tuple[float, float] = (0.015, 0.04)
    stroke_time: tuple[float, float] = (0.16, 1.2)
    bow: float = 0.06
    command_noise: float = 0.06
    press_variability: float = 0.06
    tremor: float = 3e-5
    drift: float = 1e-3


def hand_plan(model: HandModel) -> AnalyticMotion:
    """What the hand intends: bouts of reach, press, rub, lift, and home again at the end."""
    random = np.random.RandomState(model.seed)
    here, now = np.zeros(2), 0.5
    steps: list[Row] = []
    home = 1.5 + fitts_duration(3.0 * model.workspace, model.target_width)  # [s] to lift and return
    while now + 4.0 + home < model.duration:
        there = random.uniform(-model.workspace, model.workspace, 2)
        now, here = _reach(steps, model, now, here, there)
        depth = random.uniform(*model.press)
        touch_time = random.uniform(0.35, 0.6)
        steps.append(step(2, now, now + touch_time, -(model.clearance + depth)))
        now += touch_time
        now, here = _rub(steps, model, random, now, here, until=min(now + 10.0, model.duration - home - 0.7))
        steps.append(step(2, now, now + 0.4, model.clearance + depth))
        now += 0.4
    _reach(steps, model, now, here, np.zeros(2))
    return AnalyticMotion((0.0, 0.0, model.clearance), steps=steps, cycle=model.duration)


def _reach(steps: list[Row], model: HandModel, now: float, here: Array, there: Array) -> tuple[float, Array]:
    move = there - here
    distance = math.hypot(*move)
    end = now + fitts_duration(distance, model.target_width)
    steps += reach(now, end, (move[0], move[1]), bow=model.bow * distance)
    return end + 0.1, there


def _rub(
    steps: list[Row], model: HandModel, random: np.random.RandomState, now: float, here: Array, until: float
) -> tuple[float, Array]:
    """Reciprocal strokes, mostly along y, speeding up or slowing down within the bout."""
    angle = math.radians(90.0 + random.normal(0.0, 12.0))
    along = np.array([math.cos(angle), math.sin(angle)])
    if here @ along > 0.0:
        along = -along  # the first stroke goes towards the middle
    shortest, longest = model.stroke_time
    first, last = shortest * (longest / shortest) ** random.uniform(0.0, 1.0, 2)
    if now < 5.0:
        first, last = shortest, 2.0 * shortest  # begins fast, as in the thesis's figure 8
    length = random.uniform(*model.rub)
    began, sign = now, 1.0
    offset = 0.0
    while True:
        stroke_time = first * (last / first) ** min((now - began) / 10.0, 1.0) * random.uniform(0.9, 1.1)
        if now + stroke_time > until:
            break
        target = length * random.normal(1.0, 0.05) if sign > 0.0 else 0.0
        move = (target - offset) * along
        steps += reach(now, now + stroke_time, (move[0], move[1]))
        offset, sign = target, -sign
        now += 0.75 * stroke_time  # the next stroke begins before this one has ended
    return now + 0.5 * longest, here + offset * along


def hand_motion(model: HandModel | None = None) -> SampledMotion:
    """What the hand does: the plan, disturbed as the module describes.

    The numbers are rounded to 0.1 um and 0.1 um/s, and the random stream is one that numpy has frozen
    (RandomState), so that a model gives the same motion on every machine.
    """
    model = model or HandModel()
    n = round(model.duration * model.rate)
    dt = 1.0 / model.rate
    time = np.arange(n, dtype=np.float64) / model.rate
    plan, planned_velocity = hand_plan(model).sample(time)
    random = np.random.RandomState(model.seed + 1_000_000)  # apart from the plan's

    command = np.gradient(planned_velocity, dt, axis=0)
    position = plan + _corrected(model.command_noise * np.abs(command) * random.standard_normal((n, 3)), dt)
    slow = butter(2, 1.5, fs=model.rate, output="sos")
    variation = model.press_variability * _coloured(slow, random.standard_normal((n, 1)))[:, 0]
    position[:, 2] += np.minimum(plan[:, 2], 0.0) * variation
    tremor = butter(4, (8.0, 12.0), btype="bandpass", fs=model.rate, output="sos")
    position += model.tremor * _coloured(tremor, random.standard_normal((n, 3)))
    drift = butter(2, 0.1, fs=model.rate, output="sos")
    position[:, :2] += model.drift * _coloured(drift, random.standard_normal((n, 2)))
    position = np.round(position, _DIGITS)
    smooth = SampledMotion.from_positions(time, position)
    return SampledMotion(
        time, position, np.round(smooth.velocity, _DIGITS), "hand model", notes=(f"generated by {model}",)
    )


def _corrected(noise: Array, dt: float) -> Array:
    """Displacement x of a limb that feedback corrects: x'' + 2 w x' + w^2 x = noise / sqrt(dt).

    Discretised exactly for noise held over a step; w = 2 pi 1 Hz.
    """
    omega = 2.0 * math.pi
    decay = math.exp(-omega * dt)
    b1 = 1.0 - decay * (1.0 + omega * dt)
    b2 = decay * (decay + omega * dt - 1.0)
    return lfilter([0.0, b1, b2], [1.0, -2.0 * decay, decay * decay], noise / math.sqrt(dt), axis=0) / omega**2


def _coloured(sos: Array, white: Array) -> Array:
    """White noise through a filter, scaled to unit variance in the long run."""
    impulse = np.zeros(200_000)
    impulse[0] = 1.0
    return sosfilt(sos, white, axis=0) / math.sqrt(float(np.sum(sosfilt(sos, impulse) ** 2)))


if __name__ == "__main__":
    hand = hand_motion()
    written = {"position": hand.position, "velocity": hand.velocity}
    columns = {f"{name}_{axis}": values[:, i] for name, values in written.items() for i, axis in enumerate("xyz")}
    save(Recording(hand.time, columns, hand.source), SHIPPED)
