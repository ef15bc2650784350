"""An independent integration of one tangential axis: scipy, adaptive, every mode change event-located.

It shares no code with the package and takes the probe's motion as functions of time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]


@dataclass(frozen=True)
class _Ending:
    """An event of `solve_ivp` that ends the integration where it falls through zero."""

    value: Callable[[float, Array], float]
    terminal: bool = True
    direction: float = -1.0

    def __call__(self, s: float, y: Array) -> float:
        return self.value(s, y)


def integrate_axis(
    x: Callable[[float], float],
    v: Callable[[float], float],
    times: Array,
    *,
    m: float,
    k1: float,
    k2: float,
    b1: float,
    b2: float,
    Fs: float = 0.0,
    Fd: float = 0.0,
    v_d: float = 0.0,
) -> tuple[Array, NDArray[np.bool_]]:
    """Force on the probe and whether the body sticks, at `times`, in contact throughout, at rest first."""
    x_start = x(times[0])

    def push(t: float, q: float, w: float) -> float:
        return k2 * (x(t) - x_start - q) + b2 * (v(t) - w)

    def drive(t: float, q: float, w: float) -> float:
        return push(t, q, w) - k1 * q - b1 * w

    force, stuck = np.empty(len(times)), np.zeros(len(times), dtype=bool)
    t, q, w = times[0], 0.0, 0.0
    mode = 0 if Fs > 0 else 1
    frictionless = Fs == 0.0 and Fd == 0.0
    end = times[-1]
    while True:
        if mode == 0:
            grid = np.linspace(t, end, max(2, int((end - t) / 2e-4) + 2))
            over = np.array([abs(drive(s, q, 0.0)) > Fs for s in grid])
            if not over.any():
                t_next = end
            elif over[0]:
                t_next = t
            else:
                i = int(np.argmax(over))
                low, high = grid[i - 1], grid[i]
                for _ in range(60):
                    mid = 0.5 * (low + high)
                    low, high = (low, mid) if abs(drive(mid, q, 0.0)) > Fs else (mid, high)
                t_next = high
            inside = (times >= t) & (times <= t_next)
            force[inside] = [-push(s, q, 0.0) for s in times[inside]]
            stuck[inside] = True
            t = t_next
            if t >= end:
                return force, stuck
            mode, w = int(np.sign(drive(t, q, 0.0))), 0.0

        def rhs(s: float, y: Array, sign: int = mode) -> list[float]:
            return [y[1], (drive(s, y[0], y[1]) - sign * Fd) / m]

        def turns(s: float, y: Array, sign: int = mode) -> float:
            return y[1] * sign + 1e-13

        def in_band(s: float, y: Array) -> float:
            # Negative where the stick condition holds: both |w| < v_d and |drive at rest| < Fs.
            # The margin keeps a body that has just broken away from meeting the condition by rounding.
            return max(abs(y[1]) / v_d - 1.0, abs(drive(s, y[0], 0.0)) / Fs - 1.0) + 1e-9 if v_d > 0 else 1.0

        events = [] if frictionless else [_Ending(turns), _Ending(in_band)]
        run = solve_ivp(
            rhs,
            (t, end),
            [q, w],
            method="DOP853",
            rtol=1e-10,
            atol=1e-13,
            events=events,
            dense_output=True,
            max_step=2e-3,
        )
        inside = (times >= t) & (times <= run.t[-1])
        if inside.any():
            y = run.sol(times[inside])
            force[inside] = [-push(s, a, b) for s, a, b in zip(times[inside], y[0], y[1], strict=True)]
        t, (q, w) = run.t[-1], run.y[:, -1]
        if t >= end:
            return force, stuck
        held = drive(t, q, 0.0)
        if abs(held) <= Fs:
            mode, w = 0, 0.0
        else:
            mode, w = int(np.sign(held)), 0.0
