"""Preparation of public recordings for a model that starts at rest."""

from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares

from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording
from mmt_drake.recording.check import completed

_FEWEST = 10
_GRAVITY = 9.81  # [m/s^2]
_EARLY_S = 1.2  # a ball's flight from which its release is estimated
_SOONEST_S = 1e-3  # the first sample after the release


def between(recording: Recording, start: float, end: float) -> Recording:
    """The samples with start <= time < end [s], their clock unchanged.

    Raises:
        BadInput: fewer than ten of them.
    """
    kept = (recording.time >= start) & (recording.time < end)
    if kept.sum() < _FEWEST:
        span = f"{recording.time[0]:g} to {recording.time[-1]:g} s"
        expected = f"at least {_FEWEST} samples from {start:g} to {end:g} s"
        raise BadInput(recording.source, at="time", found=span, expected=expected)
    columns = {name: values[kept] for name, values in recording.columns.items()}
    return replace(recording, time=recording.time[kept], columns=columns, clouds=())


def beginning(recording: Recording, seconds: float) -> Recording:
    """The first seconds of a recording; raises as `between`."""
    start = float(recording.time[0])
    return between(recording, start, start + seconds)


def loaded_by_gravity(recording: Recording) -> Recording:
    """A servo that holds up a pendulum, with `load`: the torque of gravity that its gears carry, as measured [N m].

    This is m g l abs(sin q) with the mass and length recorded beside the data.

    Raises:
        BadInput: no mass_kg or length_m, or no driven body.
    """
    for name in ("mass_kg", "length_m"):
        if name not in recording.constants:
            found = ", ".join(recording.constants) or "no constants"
            raise BadInput(recording.source, found=found, expected=f"a constant {name}")
    torque = recording.constants["mass_kg"] * _GRAVITY * recording.constants["length_m"]
    load = torque * np.abs(np.sin(recording["output"]))
    note = "load: the torque of gravity at the angle measured [N m]"
    return replace(recording, columns={**recording.columns, "load": load}, notes=(*recording.notes, note))


def from_horizontal(recording: Recording) -> Recording:
    """A joint whose angle is 0 when its link is horizontal, with an output that is 0 when it hangs down."""
    columns = {**recording.columns, "output": recording["output"] - np.pi / 2.0}
    return replace(recording, columns=columns, notes=(*recording.notes, "output: counted from hanging down"))


def from_release(recording: Recording) -> Recording:
    """A ball's flight from the moment it was let go, which becomes the first sample.

    A camera does not start with the ball: the speed at the first sample of a drop is anything from 1 m/s upwards to
    1 m/s downwards. At the release t0 nothing but gravity acts, and whatever drag there is comes in at third order::

        h(t) = h0 - g (t - t0)^2 / 2 + j (t - t0)^3

    so t0 and h0 follow from the first 1.2 s by least squares, without a word on the law of drag. Samples before t0 are
    left out.

    Raises:
        BadInput: too few samples in that time.
    """
    time, height = recording.time, recording["output"]
    early = time < time[0] + _EARLY_S
    if early.sum() < _FEWEST:
        found = f"{int(early.sum())} samples in the first {_EARLY_S:g} s"
        raise BadInput(recording.source, at="time", found=found, expected=f"at least {_FEWEST}")

    def misfit(guess: Array) -> Array:
        fallen = np.maximum(time[early] - guess[0], 0.0)
        modelled = guess[1] - 0.5 * _GRAVITY * fallen**2 + guess[2] * fallen**3
        return np.asarray(modelled - height[early])

    starts = [np.array([time[0] + late, height[0], 0.0]) for late in (-0.1, 0.0, 0.1, 0.2)]
    t0, h0, _ = min((least_squares(misfit, start) for start in starts), key=lambda fit: float(fit.cost)).x
    after = time > t0 + _SOONEST_S
    note = f"released at {t0:.3f} s from {h0:.2f} m, estimated from the first {_EARLY_S:g} s"
    columns = {
        "input": np.concatenate([[0.0], recording["input"][after]]),
        "output": np.concatenate([[h0], height[after]]),
    }
    clock = np.concatenate([[t0], time[after]])
    return completed(clock, columns, recording.source, notes=(*recording.notes, note), constants=recording.constants)
