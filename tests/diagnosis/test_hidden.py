"""What a law that nobody has named hides in a number is in its interval, though all blocks agree on the number."""

import numpy as np
import pytest
from residual_samples import PLAIN, leaving, strokes

from mmt_drake.diagnosis.fit.bootstrap import deviations
from mmt_drake.diagnosis.fit.hidden import hidden_variance, law_strengths
from mmt_drake.diagnosis.fit.nameless import nameless_laws
from mmt_drake.diagnosis.fit.validate import intervals
from mmt_drake.effects import LIBRARY

BLOCKS, LENGTH = 20, 50
NUMBERS = np.repeat(np.arange(BLOCKS), LENGTH)
SAMPLES = BLOCKS * LENGTH
V = np.tile(np.sin(2.0 * np.pi * (np.arange(LENGTH) + 0.5) / LENGTH), BLOCKS)  # the same strokes in every block


def unit(i: int) -> np.ndarray:
    return np.eye(SAMPLES)[:, [i]]


@pytest.mark.parametrize(("seen", "strength"), [(5.0, 24.0), (1.0, 0.0), (0.3, 0.0)])
def test_a_law_is_as_strong_as_what_it_leaves_beyond_the_noise_and_a_number_as_unsure_as_it_takes_on(seen, strength):
    # Of the law the number takes on 3 parts and leaves 1: with noise of 1 the likeliest variance is seen^2 - 1.
    number, law = unit(0), 3.0 * unit(0) + unit(1)
    residual = seen * unit(1)[:, 0]
    assert law_strengths(number, residual, SAMPLES, [law]) == pytest.approx([strength], abs=0.05)
    assert hidden_variance(number, residual, SAMPLES, [law]) == pytest.approx([9.0 * strength], abs=0.4)


def test_of_two_laws_the_one_that_what_is_left_looks_like_is_taken_to_be_there():
    number, one, other = unit(0), np.hstack([unit(0) + unit(1), unit(2)]), np.hstack([unit(0) + unit(3), unit(4)])
    residual = 10.0 * (unit(1) + unit(2))[:, 0]
    assert law_strengths(number, residual, SAMPLES, [one, other]) == pytest.approx([99.0, 0.0], abs=0.5)


def test_intervals_cover_beside_a_law_that_is_the_same_in_every_block():
    rng = np.random.default_rng(1)
    # Laws that vary over v as a Gaussian process does, of unknown strength; what is fitted is a damper.
    alike = np.exp(-np.abs(np.subtract.outer(V[:LENGTH], V[:LENGTH])))
    size, shapes = np.linalg.eigh(alike)
    law = np.tile(shapes * np.sqrt(np.maximum(size, 0.0)), (BLOCKS, 1))
    jacobian = -V[:, np.newaxis]
    resampled, allowed = [], []
    for _ in range(300):
        left = 3.0 * law @ rng.standard_normal(LENGTH) + rng.standard_normal(SAMPLES)
        error = float(V @ left / (V @ V))
        residual = left - error * V
        resampled.append(abs(error) <= deviations(jacobian, residual, NUMBERS, SAMPLES).half_width[0])
        allowed.append(abs(error) <= deviations(jacobian, residual, NUMBERS, SAMPLES, [law]).half_width[0])
    assert np.mean(resampled) < 0.3  # all blocks agree on what is wrong
    assert 0.90 <= np.mean(allowed) <= 0.98


def test_intervals_beside_laws_are_no_wider_where_only_noise_is_left_even_if_it_lasts():
    rng = np.random.default_rng(2)
    law = np.tile(np.column_stack([V[:LENGTH] ** i for i in (1, 3, 5)]), (BLOCKS, 1))
    jacobian, wider = -V[:, np.newaxis], []
    for _ in range(50):
        noise = np.convolve(rng.standard_normal(SAMPLES + 19), np.ones(20) / np.sqrt(20.0), mode="valid")
        residual = noise - V * float(V @ noise / (V @ V))
        with_law, without = (deviations(jacobian, residual, NUMBERS, SAMPLES, laws) for laws in ([law], []))
        wider.append(float(with_law.half_width[0] / without.half_width[0]))
    assert np.median(wider) < 1.3


def test_the_interval_of_a_damper_beside_a_drag_that_nobody_has_named_holds_the_damper():
    dragged = PLAIN.adding(LIBRARY["quadratic_drag"])
    model = dragged.model(dragged.vector({}, {"quadratic_drag": {"c": 5.0}}))
    problem = leaving(strokes(), model=model)
    fitted = problem.fit(PLAIN, PLAIN.base())
    i, true = PLAIN.free.index("b1"), PLAIN.nominal.parameter("b1")
    minimum = fitted.minimum
    resampled = deviations(minimum.jacobian, minimum.residual, problem.objective_blocks(), problem.samples())
    assert abs(fitted.x[i] - true) > 3.0 * resampled.half_width[i]
    low, high = intervals(problem, fitted)[i]
    assert low <= true <= high


def test_where_next_to_nothing_but_noise_is_left_there_is_no_room_for_a_law():
    problem = leaving(strokes())
    assert nameless_laws(problem, problem.fit(PLAIN, PLAIN.base())) == []
