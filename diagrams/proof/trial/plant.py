"""A body with friction by time stepping: the physics of the trial, which shares no code with the model.

One tangential axis of the flexible object, or a servo: a controller of gains k2, b2 holds its body to the reference as
contact spring and damper hold the object's to the probe, and its command is the force of both.

Smooth forces are taken at the middle of a short step, the linear ones implicitly, and friction, which is set-valued at
rest, is solved for exactly at the end of the step: with the momentum r that the body would have without friction,
A v' = prox(r). This is the theta-method (theta = 1/2) of Moreau and Jean; see Jean,
"The non-smooth contact dynamics method", Comput. Methods Appl. Mech. Eng. 177 (1999) 235-257, and Acary and
Brogliato, "Numerical Methods for Nonsmooth Dynamical Systems", Springer 2008, chapter 10.

Touch starts the contact spring unstretched wherever probe and body are, and whatever remembers the deflection
forgets it; the body keeps its velocity and off contact moves on.

Everything compiled stands in this one file, so that numba's disk cache knows when to renew it; the numbers of the laws
stand in `physics`, and are a part of every kernel's signature.
"""

import math
from typing import NamedTuple

from numba import njit

from mmt_drake.diagrams.proof.trial.physics import Physics
from mmt_drake.numeric.arrays import Array

STEP_S = 1e-5
"""Longest time step of a recording [s]. Friction and edges of a clearance then cost a hundredth of a force noise."""
QUICK_STEP_S = 4e-5
"""Of a look at how large an effect is [s]."""


class Levels(NamedTuple):
    """Friction now [N]: what holds a body at rest against a push along - and +, and what acts on a sliding one."""

    low: float
    high: float
    slide_low: float
    slide_high: float


@njit(cache=True)
def _cubic(x0: float, v0: float, x1: float, v1: float, h: float) -> tuple[float, float, float, float]:
    """Coefficients in s of the cubic through both ends of an interval of length h with their slopes."""
    slope = (x1 - x0) / h
    return x0, v0, (3.0 * slope - 2.0 * v0 - v1) / h, (v0 + v1 - 2.0 * slope) / (h * h)


@njit(cache=True)
def _value(c: tuple[float, float, float, float], s: float) -> float:
    return c[0] + s * (c[1] + s * (c[2] + s * c[3]))


@njit(cache=True)
def _slope(c: tuple[float, float, float, float], s: float) -> float:
    return c[1] + s * (2.0 * c[2] + 3.0 * s * c[3])


@njit(cache=True)
def _clear(d: float, gap: float) -> float:
    """Deflection left of d once the clearance is taken up."""
    return math.copysign(max(abs(d) - 0.5 * gap, 0.0), d)


@njit(cache=True)
def _shift(q: float, v: float, level: float, sigma0: float, h: float) -> float:
    """LuGre bristles after a step h at the sliding velocity v, q' = v - sigma0 |v| q / level, implicit in q."""
    return (q + h * v) / (1.0 + h * sigma0 * abs(v) / level) if level > 0.0 else 0.0


@njit(cache=True)
def _stiffness(p: Physics, t: float, travel: float, load: float) -> float:
    """The contact stiffness now [N/m]: drift, running in with the distance slid, load, and a step."""
    k = p.k2 * (1.0 + p.drift_rate * t)
    if p.run_in != 0.0:
        k *= 1.0 - p.run_in * (1.0 - math.exp(-travel / p.run_in_distance))
    if p.load_gain != 0.0:
        k *= 1.0 + 0.5 * p.load_gain * (1.0 + math.tanh((load - p.load_at) / p.load_width))
    if t >= p.step_time:
        k *= 1.0 - p.step_loss
    return k


@njit(cache=True)
def _free_body_force(x: float, v: float, t: float, mode_x: float, mode_v: float, p: Physics) -> float:
    """Forces on the body beside spring, damper, friction and contact [N]."""
    force = p.F - p.c * v * abs(v) + p.mode_k * (mode_x - x) + p.mode_b * (mode_v - v)
    into = (x - p.stop_position) * p.stop_side
    if into > 0.0:
        force -= p.stop_side * p.stop_stiffness * into
    if p.body_k3 != 0.0:
        force -= p.body_k3 * x * x * x
    if p.pendulum != 0.0:
        force -= p.pendulum * math.sin(x)
    if p.drag != 0.0:
        force -= p.drag * v * math.sqrt(abs(v))
    if p.texture_F != 0.0:
        w = 2.0 * math.pi * x / p.texture_length
        force += p.texture_F * (math.sin(w + 1.0) + math.sin(1.618 * w + 2.0) + math.sin(2.871 * w)) / math.sqrt(1.5)
    if p.ripple_F != 0.0:
        force += p.ripple_F * math.sin(2.0 * math.pi * x / p.ripple_period + p.ripple_phase)
    return force


@njit(cache=True)
def _slide(r: float, forward: bool, inertia: float, h: float, levels: Levels) -> tuple[float, bool]:
    """Sliding velocity at the end of a step of a body that was sliding, or let go, and whether it has stopped.

    Args:
        r: momentum that it would have at the end without friction.
        forward: direction of sliding.
        inertia: A of A v' = r - h friction(v').
        h: step [s].
        levels: of friction.
    """
    end = (r - h * (levels.slide_high if forward else -levels.slide_low)) / inertia
    if end != 0.0 and (end > 0.0) == forward:
        return end, False
    # It comes to rest within the step, and stays there unless what drives it beats friction the other way.
    if -h * levels.low <= r <= h * levels.high:
        return 0.0, True
    end = (r + h * levels.slide_low) / inertia if forward else (r - h * levels.slide_high) / inertia
    if end == 0.0 or (end > 0.0) == forward:
        return 0.0, True
    return end, False


@njit(cache=True)
def run_axis(
    time: Array, probe: Array, probe_v: Array, z: Array, vz: Array, p: Physics, substeps: int, force: Array, body: Array
) -> None:
    """Run one tangential axis from rest at the first sample.

    Args:
        time: (n,) [s], increasing; motion between samples is the cubic through positions and velocities.
        probe, probe_v: (n,) of the probe along the axis [m], [m/s].
        z, vz: (n,) of the probe along the surface normal; contact is z < 0.
        p: the laws.
        substeps: steps per sample.
        force: ((n - 1) * substeps + 1,) to be filled with the force on the probe at every step [N].
        body: (n, 2) to be filled with the body's displacement and velocity [m], [m/s].
    """
    x = v = travel = heat = bristle = maxwell = bouc = 0.0
    mode_x = mode_v = loose_x = loose_v = 0.0
    age = 1.0
    anchor = probe[0]
    stuck, touching = True, z[0] < 0.0
    force[0], body[0, 0], body[0, 1] = 0.0, 0.0, 0.0
    if touching and p.gap == 0.0:
        force[0] = -p.b2 * probe_v[0]
    for i in range(len(time) - 1):
        span = time[i + 1] - time[i]
        h = span / substeps
        along = _cubic(probe[i], probe_v[i], probe[i + 1], probe_v[i + 1], span)
        height = _cubic(z[i], vz[i], z[i + 1], vz[i + 1], span)
        for j in range(substeps):
            s = (j + 0.5) * h
            t = time[i] - time[0] + s
            hand, hand_v = _value(along, s), _slope(along, s)
            load = 0.0
            if touching:
                load = max(-p.normal_k * _value(height, s) - p.normal_b * _slope(height, s), 0.0)
            mass = p.m + (p.dm if t >= p.mass_time else 0.0)
            table_x = table_v = 0.0
            if p.table_amplitude != 0.0:
                rate = 2.0 * math.pi * (p.table_from + p.table_rate * t)
                phase = 2.0 * math.pi * (p.table_from + 0.5 * p.table_rate * t) * t
                table_x, table_v = p.table_amplitude * math.sin(phase), p.table_amplitude * rate * math.cos(phase)

            # Stiffness and damping of this step, and the forces that are not linear in x and v, ahead by half a step.
            x_half = x + 0.5 * h * v
            sliding = v - table_v
            b1 = p.b_plus if sliding >= 0.0 else p.b_minus
            b1 *= math.exp(-heat)
            constant = _free_body_force(x_half, v, t, mode_x, mode_v, p) + p.k1 * table_x + b1 * table_v
            k2 = b2 = 0.0
            rest = hand - anchor  # where the contact spring pulls nothing
            if touching:
                d = _clear(rest - x_half, p.gap)
                if p.gap == 0.0 or d != 0.0:
                    k2 = _stiffness(p, t, travel, load)
                    b2 = p.b2 * (1.0 + p.hunt_crossley * abs(d))
                    rest -= rest - x_half - d
                constant += p.k3 * d * d * d + p.alpha * bouc
                constant += p.k_maxwell * (d - maxwell) * (1.0 - 0.5 * h / p.tau)
            low = high = slide_low = slide_high = 0.0
            dip = math.exp(-((sliding / p.v_s) ** 2)) if p.v_s > 0.0 else 0.0
            if p.sigma0 > 0.0:
                level = p.Fd_plus + (p.Fs_plus - p.Fd_plus) * dip
                after = _shift(bristle, sliding, level, p.sigma0, h)
                constant -= p.sigma0 * 0.5 * (bristle + after) + p.sigma1 * (after - bristle) / h
            else:
                low, high = p.Fs_minus, p.Fs_plus
                slide_low = p.Fd_minus + (p.Fs_minus - p.Fd_minus) * dip
                slide_high = p.Fd_plus + (p.Fs_plus - p.Fd_plus) * dip
            more = p.mu * load
            if p.patch_F != 0.0:
                inside = math.tanh((x - p.patch_from) / p.patch_edge) - math.tanh((x - p.patch_to) / p.patch_edge)
                more += 0.5 * p.patch_F * inside
            if p.wander_F != 0.0:
                w = 2.0 * math.pi * t / p.wander_period
                more += p.wander_F * (1.0 + 0.5 * math.sin(w) + 0.5 * math.sin(2.7 * w + 1.0))
            if p.ageing_F != 0.0:
                more += p.ageing_F * math.log(1.0 + age / p.ageing_time)
            levels = Levels(low + more, high + more, slide_low + more, slide_high + more)

            # A v' = r - h friction(v'), from m (v' - v) / h = force at the middle of the step.
            k, b = p.k1 + k2, b1 + b2
            inertia = mass + 0.5 * h * b + 0.25 * h * h * k
            at_rest = -p.k1 * x + k2 * (rest - x) + b2 * hand_v + constant
            r = h * at_rest + (2.0 * mass - inertia) * v
            held = -levels.low <= at_rest - b1 * table_v <= levels.high
            if (stuck or abs(sliding) < p.v_d) and held:
                slid_end, stuck = 0.0, True
            else:
                forward = at_rest > 0.0 if stuck else sliding > 0.0
                slid_end, stuck = _slide(r - inertia * table_v, forward, inertia, h, levels)
            v_end = table_v + slid_end
            w = 0.5 * (v + v_end)
            x_before, x, v = x, x + h * w, v_end

            # Memories.
            slid = w - table_v
            travel += h * abs(slid)
            if p.heat_power < math.inf:
                heat += h / p.heat_tau * (b1 * slid * slid / p.heat_power - heat)
            if p.ageing_F != 0.0:
                age = (age + h) / (1.0 + h * abs(slid) / p.ageing_distance)
            if p.sigma0 > 0.0:
                bristle = _shift(bristle, slid, p.Fd_plus + (p.Fs_plus - p.Fd_plus) * dip, p.sigma0, h)
            if p.mode_m > 0.0:
                pull = p.mode_k * (0.5 * (x_before + x) - mode_x) + p.mode_b * (w - mode_v)
                mode_v += h * pull / p.mode_m
                mode_x += h * mode_v
            if p.loose_m > 0.0:
                loose_x += h * loose_v
                apart = loose_x - x
                if abs(apart) >= p.loose_clearance and (loose_v - v) * apart > 0.0:
                    impulse = (1.0 + p.loose_restitution) * (loose_v - v) * mass * p.loose_m / (mass + p.loose_m)
                    v += impulse / mass
                    loose_v -= impulse / p.loose_m
                    stuck = False
            s = (j + 1.0) * h
            hand_end, z_end = _value(along, s), _value(height, s)
            if touching:
                d_rate = 0.0
                d = _clear(hand - 0.5 * (x_before + x) - anchor, p.gap)
                if p.gap == 0.0 or d != 0.0:
                    d_rate = hand_v - w
                bouc += h * (d_rate - p.beta * abs(d_rate) * bouc - p.gamma * d_rate * abs(bouc))
                maxwell = d + (maxwell - d) * math.exp(-h / p.tau)
                if p.slip_mu < math.inf:
                    most = p.slip_mu * load / p.k2
                    stretched = hand_end - x - anchor
                    if abs(stretched) > most:
                        anchor += stretched - math.copysign(most, stretched)

            # Touch and release, and the force at the end of the step.
            if touching != (z_end < 0.0):
                touching = not touching
                if touching:
                    z_start = _value(height, s - h)
                    part = z_start / (z_start - z_end)
                    anchor = _value(along, s - h + part * h) - (x_before + part * (x - x_before))
                    bouc = maxwell = 0.0
            felt = 0.0
            if touching:
                d = _clear(hand_end - x - anchor, p.gap)
                if p.gap == 0.0 or d != 0.0:
                    load = max(-p.normal_k * z_end - p.normal_b * _slope(height, s), 0.0)
                    felt = _stiffness(p, t + 0.5 * h, travel, load) * d
                    felt += p.b2 * (1.0 + p.hunt_crossley * abs(d)) * (_slope(along, s) - v)
                felt += p.k3 * d * d * d + p.alpha * bouc + p.k_maxwell * (d - maxwell)
            force[i * substeps + j + 1] = -felt
        body[i + 1, 0], body[i + 1, 1] = x, v
