"""The proxy algorithm once more, from thesis appendix C, over all points with numpy: to hold the kernel against.

`printed` names what is to be done as the appendix has it, to show what that leads to:
"eq12" the velocity estimate's only consistent solution, "eq22" the cases as printed, "eq29" the root as printed,
"length" no limit to steps along the surface, "one_period" a correction divided by one period whatever the time since
the last, "all_steps" every step counted in eq. 12.
"""

import math

import numpy as np

from mmt_drake.cloud import ProxySettings
from mmt_drake.cloud.proxy import new_memory, step_proxy

FREE, IN_CONTACT, ENTRENCHED = 0, 1, 2


def followed(hands, cloud_at, settings=ProxySettings()):
    """(ticks, memory) of the compiled proxy; `cloud_at` gives the cloud of a tick."""
    memory, packed, rows = new_memory(), settings.packed(), []
    for k, hand in enumerate(hands):
        step_proxy(memory, np.asarray(hand, float), cloud_at(k), packed)
        rows.append(memory.copy())
    return np.array(rows)


class ReferenceProxy:
    def __init__(self, settings, start, printed=()):
        self.s = settings
        self.printed = set(printed)
        self.position = np.array(start, float)
        self.normal = np.zeros(3)
        self.step = np.zeros(3)
        self.speed = 0.0
        self.since = 0
        self.state = FREE
        self.touching = False

    def roots(self, b, c):
        """(n,) first and last root of eq. 24 for each row of b; NaN where there is none."""
        a = 0.5 * (self.s.r1 + self.s.r2)
        bc = b @ c
        four = 1.0 if "eq29" in self.printed else 4.0
        with np.errstate(invalid="ignore"):
            root = np.sqrt(four * bc**2 - 4.0 * ((b**2).sum(axis=1) - a**2))
        return (2.0 * bc - root) / 2.0, (2.0 * bc + root) / 2.0

    def look(self, points):
        """Eq. 14 and 15 at where the proxy is: nearest distance and unit normal."""
        r1, r3 = self.s.r1, self.s.r3
        away = self.position - points
        r = np.linalg.norm(away, axis=1)
        near = r < r3
        if not near.any():
            return math.inf, np.zeros(3)
        t = np.clip((r[near] - r1) / (r3 - r1), 0.0, 1.0)
        weight = (1.0 - t) ** 4 * (4.0 * t + 1.0)
        normal = (weight[:, None] * away[near] / r[near, None]).sum(axis=0)
        return r.min(), normal / np.linalg.norm(normal)

    def tick(self, hand, points):
        s = self.s
        correction = self.normal @ self.step / s.period
        if "all_steps" in self.printed:
            self.speed += correction
        elif self.state == FREE:
            self.speed, self.since = 0.0, 0
        elif self.state == ENTRENCHED:
            self.speed += correction / (1 if "one_period" in self.printed else max(self.since, 1))
            self.since = 0
        if "eq12" in self.printed:
            self.speed = 0.0
        self.since += 1
        self.position = self.position + self.speed * s.period * self.normal

        nearest, normal = self.look(points)
        if nearest < s.r1 and normal @ self.normal < 0.0:
            normal = -normal
        self.normal = normal
        u = hand - self.position
        self.state = ENTRENCHED if nearest < s.r1 else IN_CONTACT if nearest < s.r2 else FREE
        self.step = np.zeros(3)
        if self.state == ENTRENCHED:
            inside = points[np.linalg.norm(points - self.position, axis=1) < 0.5 * (s.r1 + s.r2)]
            self.step = np.nanmax(self.roots(inside - self.position, normal)[1]) * normal
        elif self.state == IN_CONTACT:
            length = s.gamma * np.linalg.norm(u) if np.linalg.norm(u) < s.r1 else s.zeta * s.r1
            inward = normal @ u < 0.0
            if "eq22" in self.printed:
                inward = normal @ u > 0.0
            if inward:
                u = u - (normal @ u) * normal
                if "length" not in self.printed:
                    length = min(length, np.linalg.norm(u))
            if np.linalg.norm(u) > 0.0:
                self.step = length * u / np.linalg.norm(u)
        self.position = self.position + self.step

        def reached():
            return (np.linalg.norm(points - self.position, axis=1) < s.r2).any()

        self.touching = self.state != FREE and reached()
        if not self.touching:
            u = hand - self.position
            way = np.linalg.norm(u)
            if way > 0.0:
                first = self.roots(points - self.position, u / way)[0]
                first = first[first >= 0.0]
                blocked = min(first, default=math.inf) < way
                u = (first.min() if blocked else way) * u / way
                self.position = self.position + u
                if self.state == FREE:
                    self.step = u
            else:
                blocked = False
            self.touching = blocked or reached()
            if self.touching:
                self.normal = self.look(points)[1]
