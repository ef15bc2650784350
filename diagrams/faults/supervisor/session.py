"""A supervisor's kernel driven tick by tick by an ordinary session, into which a trial puts what goes wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mmt_drake.hw.safety import kernel
from mmt_drake.hw.safety.limits import SafetyLimits

Array = NDArray[np.float64]

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
        kernel.supervise(
            self.memory,
            inputs.t,
            inputs.command,
            inputs.motion,
            inputs.device,
            inputs.ages,
            inputs.switches,
            self.limits.kernel_vector(),
            OLDEST,
            out,
        )
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
