"""Force sensor and channel in the trial's own physics: what they make of the true force."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from mmt_drake.numeric.arrays import Array


@dataclass(frozen=True)
class Sensor:
    """A sensor chain: what it carries, its frame, lag, delay, then what is added, then play and clipping.

    The defaults change nothing.

    Attributes:
        turn: of the force frame against that of positions, about x, y and z [rad].
        carried: mass between the sensor and the tip [kg].
        lag: time constant of a first-order filter [s], on every axis.
        delay: force later than position [s], on every axis.
        delay_rate: growth of the delay, a clock that runs slow [s/s]; outside the library.
        bias, drift: added to tangential forces [N], [N/s].
        crosstalk: tangential force reads this much of the normal force.
        amplitude, frequency, phase: of a sine added to tangential forces [N], [Hz], [rad].
        flicker, flicker_seed: RMS of noise with a spectrum 1/f added to tangential forces [N]; outside the library.
        play: width of the sensor's mechanical play [N]: the reading follows when it is pushed; outside the library.
        limit: readings are clipped there [N], on every axis.
    """

    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)
    carried: float = 0.0
    lag: float = 0.0
    delay: float = 0.0
    delay_rate: float = 0.0
    bias: float = 0.0
    drift: float = 0.0
    crosstalk: float = 0.0
    amplitude: float = 0.0
    frequency: float = 0.0
    phase: float = 0.0
    flicker: float = 0.0
    flicker_seed: float = 0.0
    play: float = 0.0
    limit: float = math.inf

    def arrival(self, fine_time: Array, force: Array, time: Array) -> Array:
        """What arrives at `time` (n,) of a true force (k,) at the even times `fine_time` (k,): lagged, delayed."""
        if self.lag > 0.0:
            # Exact for a force that is linear within a step.
            ratio = (fine_time[1] - fine_time[0]) / self.lag
            pole = math.exp(-ratio)
            late = (1.0 - pole) / ratio
            force, _ = lfilter([1.0 - late, late - pole], [1.0, -pole], force, zi=[late * force[0]])
        since = time - time[0]
        return np.interp(time - self.delay - self.delay_rate * since, fine_time, force)

    def turned(self, force: Array) -> Array:
        """A force (3, n) in the position frame as it is in the frame of the sensor."""
        return np.asarray(Rotation.from_euler("xyz", self.turn).inv().apply(force.T)).T if any(self.turn) else force

    def tangential(self, time: Array, arrived: Array, normal: Array) -> Array:
        """The reading (n,) of a tangential axis before clipping, from what `arrival` gave of both forces (n,)."""
        since = time - time[0]
        read = arrived + self.bias + self.drift * since + self.crosstalk * normal
        read += self.amplitude * np.sin(2.0 * np.pi * self.frequency * since + self.phase)
        if self.flicker > 0.0:
            read += self.flicker * _flicker(since, int(self.flicker_seed))
        return _played(read, 0.5 * self.play) if self.play > 0.0 else read

    def clipped(self, reading: Array) -> Array:
        """The reading within the sensor's range."""
        return np.clip(reading, -self.limit, self.limit)


_FLICKER_HZ = (0.05, 20.0)


def _flicker(time: Array, seed: int) -> Array:
    """Noise (n,) with a spectral density that falls with the frequency, its RMS 1."""
    frequency = np.fft.rfftfreq(len(time), time[1] - time[0])
    low, high = _FLICKER_HZ
    size = np.where((frequency >= low) & (frequency <= high), np.maximum(frequency, low) ** -0.5, 0.0)
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, len(frequency))
    noise = np.fft.irfft(size * np.exp(1j * phase), len(time))
    return np.asarray(noise / noise.std())


def _played(reading: Array, half: float) -> Array:
    """The play operator (Krasnosel'skii and Pokrovskii 1989): it keeps its value until pushed by either wall."""
    out = np.empty_like(reading)
    held = 0.0
    for i, value in enumerate(reading):
        held = min(max(held, value - half), value + half)
        out[i] = held
    return out
