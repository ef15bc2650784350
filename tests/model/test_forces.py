"""The equation of motion with laws, against its formula written out."""

import itertools

import numpy as np
import pytest
from numba import njit

from mmt_drake.model.body import short_at_edge
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.forces import ALONE, BodyMotion, Surroundings, constants, forces, level_spring
from mmt_drake.model.hermite import Cubic
from mmt_drake.model.laws import ActiveLaw, Slot, law
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact

BODY = BodyMotion(0.012, -0.07, -1.0, (0.3, -0.2, 0.5, 0.1))
PROBE, HEIGHT, ANCHOR = Cubic(0.02, 0.1, -3.0, 5.0), Cubic(-0.004, 0.02, 0.0, 0.0), 0.003
START, S = 2.0, 4e-4


@law(Slot.BODY, remembers=True)
def pulls(at, q, p):
    return p[0] * at.x + q[0], at.v - q[0], 2.0 * q[1], 7.0


@law(Slot.CONTACT, remembers=True)
def stretches(at, q, p):
    return p[0] * at.d + at.d_rate, q[0] * p[0], at.t, 9.0


@law(Slot.FRICTION)
def rubs(at, q, p):
    return p[0] * at.load, p[1] * at.direction, 0.0, 0.0


@law(Slot.INERTIA)
def weighs(at, q, p):
    return p[0], 0.0, 0.0, 0.0


@law(Slot.SENSOR, remembers=True)
def misreads(at, q, p):
    return 1e9, 1e9, 1e9, 1e9


LAWS = (
    ActiveLaw(misreads, ()),
    ActiveLaw(rubs, (0.2, 0.6)),
    ActiveLaw(pulls, (11.0,)),
    ActiveLaw(weighs, (0.25,)),
    ActiveLaw(stretches, (30.0,)),
)


@njit
def on_level(around, p):
    probe, height, anchor, contact, start = around
    return Surroundings(probe, height, anchor, contact, start, level_spring(constants(p)))


@njit
def evaluated(body, s, around, p):
    return forces(body, s, on_level(around, p), constants(p), ALONE)


def acting(model, laws, contact):
    p = model.with_additions(laws=laws).kernel_vector()
    return evaluated(BODY, S, (PROBE, HEIGHT, ANCHOR, contact, START), p)


def at_s(c):
    return np.polyval((c.c3, c.c2, c.v0, c.x0), S), np.polyval((3 * c.c3, 2 * c.c2, c.v0), S)


@pytest.mark.parametrize("contact", [True, False])
def test_every_law_acts_in_its_slot_whatever_the_order_of_the_laws(contact):
    m, k1, k2, b1, b2, Fc = 0.8, 20.0, 400.0, 5.0, 3.0, 0.3
    model = FlexibleBoxModel(BoxParameters(m=m, k1=k1, k2=k2, b1=b1, b2=b2, Fc=Fc), NormalContact(600, 20))
    x, v, _, (q0, q1, q2, _) = BODY  # the law that pulls has the first two, the one that stretches the others
    (position, rate), (z, vz) = at_s(PROBE), at_s(HEIGHT)
    d, d_rate = position - x - ANCHOR, rate - v
    load = -600 * z - 20 * vz if contact else 0.0
    drive = -b1 * v - k1 * x + 11.0 * x + q0
    if contact:
        drive += k2 * d + b2 * d_rate + 30.0 * d + d_rate
    for laws in itertools.permutations(LAWS):
        found = acting(model, laws, contact)
        expected = (drive, Fc + 0.2 * load, Fc - 0.6, 1 / (m + 0.25), 9.0 if contact else 7.0)
        assert (*found[:4], found.decay) == pytest.approx(expected, rel=1e-12)
        stretching = (q2 * 30.0, START + S) if contact else (0.0, 0.0)
        assert found.rates == pytest.approx((v - q0, 2.0 * q1, *stretching), rel=1e-12)


def test_a_law_in_the_contact_of_a_driven_body_pulls_as_its_spring_does():
    model = DrivenBodyModel(m=0.5, b=2.0, k=40.0)
    with_law = acting(model, (ActiveLaw(stretches, (30.0,)),), contact=True)
    without = acting(model, (), contact=True)
    d, d_rate = BODY.x - ANCHOR, BODY.v
    assert with_law.drive - without.drive == pytest.approx(-(30.0 * d + d_rate), rel=1e-9)
    assert without.drive == pytest.approx(at_s(PROBE)[0] - 2.0 * BODY.v - 40.0 * d, rel=1e-12)


@law(Slot.BODY)
def numbers(at, q, p):
    return p[0] + 10.0 * p[1] + 100.0 * p[2] + 1e3 * p[3] + 1e4 * p[4] + 1e5 * p[5], 0.0, 0.0, 0.0


def test_a_law_is_given_all_of_its_six_numbers():
    with_law = ActiveLaw(numbers, (6.0, 5.0, 4.0, 3.0, 2.0, 1.0))
    drives = [acting(DrivenBodyModel(m=0.5), laws, contact=True).drive for laws in ((), (with_law,))]
    assert drives[1] - drives[0] == pytest.approx(123456.0, rel=1e-12)


@njit
def shortened(h, body, around, p):
    return short_at_edge(h, body, 0.0, on_level(around, p), constants(p), ALONE) < h


@pytest.mark.parametrize(("away", "short"), [(0, True), (1.8e-4, True), (-1.8e-4, True), (4e-4, False), (-4e-4, False)])
def test_steps_of_1_ms_at_200_mm_s_are_short_only_where_they_may_reach_the_edge_of_a_clearance(away, short):
    p, still = FlexibleBoxModel().with_additions(gap=0.002).kernel_vector(), BodyMotion(0.01, 0.0, 0.0, BODY.q)
    for edge in (0.001, -0.001):
        probe = Cubic(0.01 + ANCHOR + edge + away, 0.2, 0.0, 0.0)
        assert shortened(1e-3, still, (probe, HEIGHT, ANCHOR, True, START), p) == short
        assert not shortened(1e-3, still, (probe, HEIGHT, ANCHOR, False, START), p)


@law(Slot.BODY)
def leans(at, q, p):
    return p[0] * at.load, 0.0, 0.0, 0.0


@law(Slot.BODY)
def begins(at, q, p):
    return (p[0] if at.t > p[1] else 0.0), 0.0, 0.0, 0.0


@law(Slot.BODY)
def divides(at, q, p):
    return p[0] * at.v / abs(at.v), 0.0, 0.0, 0.0


@pytest.mark.parametrize(
    ("active", "pushes"),
    [
        (ActiveLaw(leans, (0.2,)), True),
        (ActiveLaw(begins, (0.2, 5.0)), True),
        (ActiveLaw(divides, (0.2,)), True),  # nobody can say
        (ActiveLaw(pulls, (11.0,)), False),
        (ActiveLaw(stretches, (30.0,)), False),
        (ActiveLaw(rubs, (0.2, 0.6)), False),
        (ActiveLaw(misreads, ()), False),
    ],
)
def test_a_law_pushes_at_rest_if_it_does_so_at_any_time_under_a_load(active, pushes):
    assert active.pushes_at_rest == pushes
