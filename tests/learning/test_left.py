"""What is left along the normal, of forces that a formula makes."""

import numpy as np
import pytest
from scipy import signal

from mmt_drake.learning.answer import ROW
from mmt_drake.learning.left import Left, left_along_normal
from mmt_drake.model_message import UNKNOWN_THETA, ModelMessage, ToldEffect
from mmt_drake.numeric.arrays import Array
from mmt_drake.told_laws import NO_LAWS, told_by

SAMPLE = 0.002
CUBIC = ToldEffect("normal_nonlinear_stiffness", {"k3": 2e7})
GROWS = ToldEffect("normal_hunt_crossley_damping", {"lambda": 500.0})


def pressed(k3: float = 0.0, growth: float = 0.0, higher: float = 0.0, fast: float = 0.0, noise: float = 1.0) -> Array:
    """(n, ROW) presses 4 mm deep and lifts, on a spring of 500 N/m and a damper of 60 N s/m, with sensors' noise."""
    t = np.arange(round(8.0 / SAMPLE)) * SAMPLE
    z = -0.002 - 0.003 * np.sin(5.0 * t) + fast * np.sin(40.0 * t)
    v = -0.015 * np.cos(5.0 * t) + 40.0 * fast * np.cos(40.0 * t)
    depth = np.maximum(higher - z, 0.0)
    force = (500.0 * depth + k3 * depth**3 - 60.0 * (1.0 + growth * depth) * v) * (depth > 0.0)
    rows, random = np.zeros((len(t), ROW)), np.random.default_rng(0)
    rows[:, 2], rows[:, 5], rows[:, 8], rows[:, 9] = z, v, force, depth > 0.0
    rows[:, :9] += noise * np.repeat([1e-5, 5e-4, 0.02], 3) * random.standard_normal((len(t), 9))
    return rows


def told(effect: ToldEffect) -> Array:
    return told_by(ModelMessage(UNKNOWN_THETA, (effect,)))


@pytest.mark.parametrize("higher", [0.0, 5e-4])
def test_of_a_spring_and_a_damper_noise_alone_is_left_wherever_the_surface_is(higher: float) -> None:
    assert left_along_normal(pressed(higher=higher), SAMPLE, NO_LAWS) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(
    ("rows", "law"), [(pressed(k3=2e7), CUBIC), (pressed(growth=500.0), GROWS)], ids=["spring", "damper"]
)
def test_a_law_leaves_more_until_it_is_told(rows: Array, law: ToldEffect) -> None:
    assert left_along_normal(rows, SAMPLE, NO_LAWS) > 2.0
    assert left_along_normal(rows, SAMPLE, told(law)) < 1.3


@pytest.mark.parametrize(("delay", "lag"), [(0.012, 0.0), (0.0, 0.012), (0.006, 0.006)])
def test_of_a_force_that_is_late_and_told_to_be_noise_alone_is_left(delay: float, lag: float) -> None:
    rows, random = pressed(fast=5e-4), np.random.default_rng(1)
    force, fine = pressed(fast=5e-4, noise=0.0)[:, 8], np.arange(0.0, 8.0, SAMPLE / 20.0)
    behind = np.interp(fine - delay, np.arange(len(force)) * SAMPLE, force)
    if lag > 0.0:
        kept = np.exp(-SAMPLE / 20.0 / lag)
        behind = signal.lfilter([1.0 - kept], [1.0, -kept], behind, zi=[kept * behind[0]])[0]
    rows[:, 8] = behind[::20] + 0.02 * random.standard_normal(len(rows))
    assert left_along_normal(rows, SAMPLE, NO_LAWS) > 1.3
    late = np.array([delay, lag])
    assert left_along_normal(rows, SAMPLE, NO_LAWS, late) == pytest.approx(1.0, abs=0.2)
    assert left_along_normal(pressed(fast=5e-4), SAMPLE, NO_LAWS, late) == pytest.approx(1.0, abs=0.1), "it is not late"


def test_without_contact_nothing_is_left() -> None:
    assert left_along_normal(np.zeros((500, ROW)), SAMPLE, NO_LAWS) == 0.0


def test_what_is_not_known_on_one_axis_hides_no_doubt_on_the_other() -> None:
    assert Left(np.nan, 9.0).doubts(1.3) and Left(9.0, np.nan).doubts(1.3) and not Left(1.0, np.nan).doubts(1.3)
