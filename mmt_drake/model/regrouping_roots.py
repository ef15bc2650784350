"""Closed forms behind `regrouping`: eq. 30 of the thesis with one of its equations a ... f left out, compiled.

With S = k1 + k2, u = 1/S, beta = b2 and kappa = k2 the six equations read

    (a) beta e = a                                  (c) kappa f - 2 kappa beta u + beta = c
    (b) kappa e + beta f - beta^2 u = b             (d) kappa - kappa^2 u = d
    (e) m = e S                                     (f) b1 = f S - beta

K = k2 + b2 s divides the numerator, so rho = k2/b2 is a root of a rho^3 - b rho^2 + c rho - d; the quotient,
(b2/S) (m s^2 + b1 s + k1), has r = b - a rho for its second and n = c - b rho + a rho^2 for its last coefficient. Hence

| left out | root of | in | then |
| --- | --- | --- | --- |
| a | e kappa^3 - (b + 4de + df^2 - cf) kappa^2 + (4d^2 e + 4bd - c^2) kappa + d(c^2 - 4bd) | kappa | u by (b) - (d) |
| b | f kappa^2 - (beta + c) kappa + 2 beta d | kappa | u by (c), (d) |
| c | q^2 u^3 + 2pq u^2 + (p^2 - q) u + d - p | u | kappa = p + q u |
| d | 2 beta q u^2 + (2 beta p - q f) u + c - beta - p f | u | kappa = p + q u |
| e | a rho^3 - b rho^2 + c rho - d | rho | gamma = beta u = (n f - r)/(n - rho r) |
| f | the same | rho | u = (beta - n)/(kappa beta) |

with p = (b - beta f)/e, q = beta^2/e, and beta = a/e, but for a left out beta = kappa (c - kappa f)/(2d - kappa), for e
beta = gamma/u. Not to be found, being whole families of solutions: k2 = 0 with f left out, or with b left out if b1 =
b2 too; k1/b1 = k2/b2 with e left out.
"""

import numpy as np
from numba import njit

from mmt_drake.numeric.arrays import Array

ALL, A, B, C, D, E, F = range(7)
"""Equation left out of eq. 30, or none."""


@njit(cache=True, error_model="numpy")
def quadratic_roots(c2: float, c1: float, c0: float, nearest: bool, out: Array) -> int:
    """Real roots of c2 x^2 + c1 x + c0 into `out` (2); returns how many.

    A pair that is complex within rounding counts as a double root; with `nearest` every complex pair does.
    """
    disc = c1 * c1 - 4.0 * c2 * c0
    if disc < -1e-12 * c1 * c1 and not nearest:
        return 0
    w = -0.5 * (c1 + np.copysign(np.sqrt(max(disc, 0.0)), c1))  # the sum that does not cancel
    n = 0
    if c2 != 0.0:
        out[0] = w / c2
        n = 1
    if w != 0.0 and not (disc < 0.0 and nearest):
        out[n] = c0 / w
        n += 1
    elif w == 0.0 and n == 1:  # c1 = c0 = 0: a double root at 0
        out[1] = 0.0
        n = 2
    return n


@njit(cache=True, error_model="numpy")
def _polish(c3: float, c2: float, c1: float, c0: float, x: float) -> float:
    """Newton on a root of a cubic, as long as its steps are corrections; at a multiple root they are not."""
    for _ in range(3):
        slope = (3.0 * c3 * x + 2.0 * c2) * x + c1
        step = (((c3 * x + c2) * x + c1) * x + c0) / slope if slope != 0.0 else 0.0
        if abs(step) > 1e-3 * abs(x):
            break
        x -= step
    return x


@njit(cache=True, error_model="numpy")
def cubic_roots(c3: float, c2: float, c1: float, c0: float, out: Array) -> int:
    """Real roots of c3 x^3 + c2 x^2 + c1 x + c0, c3 != 0, into `out` (3); returns how many (1 or 3)."""
    shift = c2 / (3.0 * c3)
    p = c1 / c3 - 3.0 * shift * shift
    q = 2.0 * shift**3 - shift * c1 / c3 + c0 / c3
    disc = 0.25 * q * q + p**3 / 27.0
    if disc > 0.0:  # Cardano
        w = np.cbrt(-0.5 * q - np.copysign(np.sqrt(disc), q))
        root = w - p / (3.0 * w) - shift
    else:  # Viete; of the three the largest, which the shift cannot spoil
        r = np.sqrt(max(-p / 3.0, 0.0))
        angle = np.arccos(min(1.0, max(-1.0, -0.5 * q / r**3))) if r > 0.0 else 0.0
        root = 0.0
        for i in range(3):
            x = 2.0 * r * np.cos((angle - 2.0 * np.pi * i) / 3.0) - shift
            root = x if abs(x) > abs(root) else root
    root = _polish(c3, c2, c1, c0, root)
    out[0] = root
    if abs(c3 * root**3) > abs(c0):  # divide the root out from the end where that loses no digits
        q0 = -c0 / root
        q1 = (q0 - c1) / root
    else:
        q1 = c2 + c3 * root
        q0 = c1 + q1 * root
    n = quadratic_roots(c3, q1, q0, False, out[1:])
    for i in range(1, n + 1):
        out[i] = _polish(c3, c2, c1, c0, out[i])
    return n + 1


@njit(cache=True, error_model="numpy")
def inverse_stiffness(t: Array, kappa: float, beta: float, omega: float, with_b: bool) -> float:
    """u = 1/(k1 + k2) [m/N] from (c), (d) and, if asked, (b), linear in u: least squares of the force at `omega`."""
    gc, gd = 2.0 * kappa * beta * omega, kappa * kappa
    total = gc * gc + gd * gd
    u = gc * (kappa * t[5] + beta - t[2]) * omega + gd * (kappa - t[3])
    if with_b:
        gb = (beta * omega) ** 2
        total += gb * gb
        u += gb * (kappa * t[4] + beta * t[5] - t[1]) * omega * omega
    return u / total if total > 0.0 else np.nan


@njit(cache=True, error_model="numpy")
def _fill(row: Array, m: float, k2: float, b1: float, b2: float, S: float) -> None:
    row[0], row[1], row[2], row[3], row[4] = m, S - k2, k2, b1, b2


@njit(cache=True, error_model="numpy")
def closed_forms(t: Array, left_out: int, omega: float, rows: Array, x: Array) -> int:
    """Solutions of eq. 30 with one equation left out; with none left out, starts for its least squares.

    Args:
        t: a ... g (7, of which 6 are read; a and e not 0 unless left out).
        left_out: `ALL` for none, or `A` to `F`.
        omega: frequency at which redundant equations are weighed [rad/s].
        rows: receives m, k1, k2, b1, b2 (at least 3 x 5); a degenerate root leaves a row that is not finite.
        x: work space (3).

    Returns:
        The number of rows written.
    """
    a, b, c, d, e, f = t[0], t[1], t[2], t[3], t[4], t[5]
    if left_out in (E, F):
        n = cubic_roots(a, -b, c, -d, x)
        for i in range(n):
            rho = x[i]
            r, rest = b - a * rho, c - b * rho + a * rho * rho
            if left_out == E:
                gamma = (rest * f - r) / (rest - rho * r)
                g1, g0 = (f - gamma) * gamma * omega, (1.0 - rho * gamma) * gamma
                S = (g1 * r * omega + g0 * rest) / (g1 * g1 + g0 * g0)
                _fill(rows[i], a / gamma, rho * gamma * S, f * S - gamma * S, gamma * S, S)
            else:
                beta = a / e
                kappa = rho * beta
                S = kappa * beta / (beta - rest)
                _fill(rows[i], e * S, kappa, r * S / beta, beta, S)
        return n
    if left_out == A:
        c2, c1, c0 = -(b + d * (4.0 * e + f * f) - c * f), 4.0 * d * (d * e + b) - c * c, d * (c * c - 4.0 * b * d)
        n = cubic_roots(e, c2, c1, c0, x)
        for i in range(n):
            kappa, gap = x[i], 2.0 * d - x[i]
            beta = kappa * (c - kappa * f) / gap if abs(gap) > 1e-9 * abs(kappa) else c
            S = 1.0 / inverse_stiffness(t, kappa, beta, omega, True)
            _fill(rows[i], e * S, kappa, f * S - beta, beta, S)
        return n
    beta = a / e
    if left_out in (C, D):
        p, q = (b - beta * f) / e, beta * beta / e
        if left_out == C:
            n = cubic_roots(q * q, 2.0 * p * q, p * p - q, d - p, x)
        else:
            n = quadratic_roots(2.0 * beta * q, 2.0 * beta * p - q * f, c - beta - p * f, False, x)
        for i in range(n):
            S = 1.0 / x[i]
            _fill(rows[i], e * S, p + q * x[i], f * S - beta, beta, S)
        return n
    n = quadratic_roots(f, -(beta + c), 2.0 * beta * d, left_out == ALL, x)
    for i in range(n):
        S = 1.0 / inverse_stiffness(t, x[i], beta, omega, left_out == ALL)
        _fill(rows[i], e * S, x[i], f * S - beta, beta, S)
    return n
