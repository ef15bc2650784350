"""Two effects of which neither is any good alone are tried together, and windows are short enough to see that."""

from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from mmt_drake.diagnosis.fit.prepare import Prepared, prepare, scales_of
from mmt_drake.diagnosis.fit.problem import Fitted
from mmt_drake.diagnosis.search.base import MUCH, over_windows
from mmt_drake.diagnosis.search.starts import Seed, all_starts, together
from mmt_drake.effects import LIBRARY
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.recording import Recording

M, B_PLUS, B_MINUS, OFFSET, FC = 1.8, 22.0, 5.0, 3.3, 1.0
TRIED = ("asymmetric_viscous_friction", "constant_force", "quadratic_drag", "nonlinear_stiffness", "ground_spring")


def moved(noise: float) -> Recording:
    """A mass whose damper differs by direction, with an offset of its force, along a velocity in closed form."""
    time, random = np.arange(0.0, 24.0, 1e-3), np.random.default_rng(0)
    w, size = 2.0 * np.pi * np.array([0.35, 0.8, 1.7, 3.1]), np.array([0.5, 0.3, 0.2, 0.1])
    angle = np.outer(time, w) + random.uniform(0.0, 6.28, 4)
    x, v, a = -np.cos(angle) @ (size / w), np.sin(angle) @ size, np.cos(angle) @ (size * w)
    force = M * a + np.where(v > 0.0, B_PLUS, B_MINUS) * v + FC * np.sign(v) - OFFSET
    return Recording(time, {"output": x + noise * random.standard_normal(len(x)), "input": force}, "moved")


@pytest.fixture(scope="module")
def executor() -> Iterator[Executor]:
    with threadpool_limits(limits=1, user_api="blas"), ThreadPoolExecutor(1) as threads:
        yield threads


BELIEVED = DrivenBodyModel(m=1.0, b=8.0, Fc=1.0)


def base_of(recording: Recording, executor: Executor) -> tuple[Prepared, Prepared, Fitted]:
    """The recording as it is prepared, over the windows of the search, and the fit there."""
    prepared = prepare([recording], BELIEVED)
    return prepared, *over_windows([recording], BELIEVED, prepared, executor)


@pytest.fixture(scope="module")
def quiet(executor: Executor) -> tuple[Prepared, Prepared, Fitted]:
    return base_of(moved(1e-5), executor)


def test_pairs_are_known_by_what_they_promise_together(
    quiet: tuple[Prepared, Prepared, Fitted], executor: Executor
) -> None:
    _, prepared, fitted = quiet
    problem = prepared.problem
    assert problem is not None
    (seed,) = Seed.on_parts(problem.at(fitted.hypothesis, fitted.x), [problem])
    starts = [
        max(
            all_starts([seed], [LIBRARY[name].within(fitted.model)], scales_of(problem, fitted.model)),
            key=lambda s: s.promise(),
        )
        for name in TRIED
    ]
    promise, *pair = together(starts, executor)[0]
    alone = {start.effect.name: start.promise() for start in starts}
    assert {start.effect.name for start in pair} == {"asymmetric_viscous_friction", "constant_force"}
    assert promise > 0.8 and max(alone.values()) < 0.5, (promise, alone)


def test_windows_are_shorter_where_the_model_leaves_much(quiet: tuple[Prepared, Prepared, Fitted]) -> None:
    before, after, _ = quiet
    assert before.window_s is not None and after.window_s is not None
    assert after.window_s < 0.5 * before.window_s


def test_windows_stay_where_it_leaves_little(executor: Executor) -> None:
    before, after, fitted = base_of(moved(2e-3), executor)
    assert after is before and before.problem is not None and before.problem.left(fitted) < MUCH
