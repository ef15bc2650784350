"""One way of using one engine: what it is given and what it gives."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mmt_drake.diagrams.experiments.engines.probe import Probe
from mmt_drake.model.linear import transfer_function
from mmt_drake.model.parameters import BoxParameters

Array = NDArray[np.float64]

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
    """

    engine: str
    name: str
    run: Callable[[Setting], Trace]
    package: str | None = None


@dataclass
class Stopwatch:
    """Measures processor time, which other work on the machine does not lengthen.

    Attributes:
        seconds: that were measured.
    """

    seconds: float = field(default=0.0, init=False)

    @contextmanager
    def running(self) -> Iterator[None]:
        """Counts the time spent inside."""
        start = time.process_time()
        yield
        self.seconds += time.process_time() - start
