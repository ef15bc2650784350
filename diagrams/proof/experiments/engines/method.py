"""One way of using one engine: what it is given, a sine known inside the step or only sampled, and what it gives."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Final, Literal

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from mmt_drake.errors import MissingDependency
from mmt_drake.model.linear import transfer_function
from mmt_drake.model.parameters import BoxParameters
from mmt_drake.numeric.arrays import Array

_INSTALL = "install the project with its extra: pip install -e '.[engines]' -c constraints.txt"


def missing(package: str) -> str | None:
    """Why an engine cannot be run, in one line; None if it can."""
    return f"{package} not found; {_INSTALL}" if find_spec(package) is None else None


def engine_package(package: str) -> Any:
    """A package of the extra, imported.

    Raises:
        MissingDependency: it is not installed.
    """
    reason = missing(package)
    if reason is not None:
        raise MissingDependency(f"engines: {reason}")
    return import_module(package)


Input = Literal["inside_step", "sampled"]

STEP: Final = 1e-3
"""Of every engine [s]."""

_BACKWARD: Final = np.array([11.0, -18.0, 9.0, -2.0]) / 6.0
"""Third-order backward difference, the latest sample first; off by (omega STEP)^3 / 4 of the velocity."""


@dataclass(frozen=True)
class Probe:
    """A probe at x(t) = sin(omega t) [m].

    Attributes:
        omega: [rad/s].
        steps: made from time 0 on.
        input: `inside_step`: position and velocity are known at all times. `sampled`: only poses are known, one a step
            and none ahead. The velocity at a sample is then the third-order difference of the latest four, which
            multiplies their noise by 3.8 / STEP, and between two samples the probe moves on the cubic through both
            ends: the force at a sample needs none that comes later.
        lead: steps made before time 0.
    """

    omega: float
    steps: int
    input: Input
    lead: int = 0

    @property
    def times(self) -> Array:
        """Of the samples, (lead + steps + 1,) [s]."""
        return self._times(self.lead)

    def at_samples(self) -> tuple[Array, Array]:
        """Position and velocity at `times`, [m], [m/s]."""
        if self.input == "inside_step":
            return self._at(self.times)
        older = len(_BACKWARD) - 1
        poses, _ = self._at(self._times(self.lead + older))
        return poses[older:], np.convolve(poses, _BACKWARD / STEP, mode="valid")

    def at_middles(self) -> tuple[Array, Array]:
        """Position and velocity in the middle of each step, (lead + steps,) each [m], [m/s]."""
        if self.input == "inside_step":
            return self._at(self.times[:-1] + 0.5 * STEP)
        x, v = self.at_samples()
        path, middles = CubicHermiteSpline(self.times, x, v), self.times[:-1] + 0.5 * STEP
        return path(middles), path(middles, 1)

    def _times(self, lead: int) -> Array:
        return np.arange(-lead, self.steps + 1, dtype=np.float64) * STEP

    def _at(self, times: Array) -> tuple[Array, Array]:
        return np.sin(self.omega * times), self.omega * np.cos(self.omega * times)


OURS: Final = "ours"


@dataclass(frozen=True)
class Setting:
    """What an engine has to simulate: one tangential axis of the object, in contact, without friction.

    Attributes:
        parameters: of the object.
        probe: what moves the contact spring and damper.
    """

    parameters: BoxParameters
    probe: Probe

    def body_at_start(self) -> tuple[float, float]:
        """The body's position and velocity at time 0 once the sine has lasted for ever [m], [m/s]."""
        s = 1j * self.probe.omega
        contact = self.parameters.k2 + self.parameters.b2 * s
        body = 1.0 - complex(transfer_function(self.parameters, s)) / contact  # of a probe at exp(s t)
        return body.imag, (s * body).imag

    def force(self, body_position: Array, body_velocity: Array) -> Array:
        """That pushes the probe along, from the body's motion at the probe's samples, (n,) each [N]."""
        x, v = self.probe.at_samples()
        p = self.parameters
        return p.k2 * (x - body_position) + p.b2 * (v - body_velocity)


@dataclass(frozen=True)
class Trace:
    """What an engine made of a setting.

    Attributes:
        force: that pushes the probe along, at every sample from time 0 on (n,) [N].
        us_per_step: processor time of one step, everything built and loaded [us].
    """

    force: Array
    us_per_step: float


@dataclass(frozen=True)
class Method:
    """One way of using one engine.

    Attributes:
        engine: its short name, `ours` for the renderer.
        name: of the way, in a few words.
        run: simulates a setting.
        package: of the extra `engines`; None where no extra is needed.
        from_python: whether Python makes each step; costs are compared among those that are alike in this.
    """

    engine: str
    name: str
    run: Callable[[Setting], Trace]
    package: str | None = None
    from_python: bool = False


def stepped(setting: Setting, advance: Callable[[int, float, float], tuple[float, float]]) -> Trace:
    """A body that Python moves on, one step after the other.

    Args:
        setting: what is simulated.
        advance: number of a step, the body's position and velocity before it -> both after it, [m], [m/s].
    """
    motion = np.empty((setting.probe.steps + 1, 2))
    motion[0] = q, u = setting.body_at_start()
    start = time.process_time()
    for k in range(setting.probe.steps):
        q, u = advance(k, q, u)
        motion[k + 1, 0], motion[k + 1, 1] = q, u
    us = us_per_step(start, setting.probe.steps)
    return Trace(setting.force(motion[:, 0], motion[:, 1]), us)


def us_per_step(start: float, steps: int) -> float:
    """Processor time of a step since `start` (`time.process_time`) [us], which other work does not lengthen."""
    return 1e6 * (time.process_time() - start) / steps
