"""Which block a mismatch without a name is in: shapes that only one block can make are found in that block."""

from concurrent.futures import ThreadPoolExecutor
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_samples import MODEL
from residual_samples import PLAIN, leaving, plain, strokes

from mmt_drake.diagnosis.decide import attribution
from mmt_drake.diagnosis.decide.attribution import shares
from mmt_drake.diagnosis.fit.problem import Problem
from mmt_drake.diagnosis.search.learn import tables
from mmt_drake.effects import LIBRARY


@cache
def measured() -> Problem:
    return strokes()


def stops(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A probe that goes to and fro in two seconds and then waits for two."""
    phase = np.pi * np.minimum(t % 4.0, 2.0)
    return 0.03 * np.sin(phase) ** 2, 0.03 * np.pi * np.sin(2.0 * phase)


def of_output(track) -> np.ndarray:
    """A sensor that reads a tenth too much one way, and right the other."""
    force = track.simulated(MODEL)
    return 0.1 * force * (force > 0.0)


def plays(track) -> np.ndarray:
    """A sensor that follows only what pushes it by 0.15 N, either way."""
    force = track.simulated(MODEL)
    read = np.empty_like(force)
    held = 0.0
    for i, value in enumerate(force):
        read[i] = held = np.clip(held, value - 0.15, value + 0.15)
    return read - force


def late(track) -> np.ndarray:
    """A delay that comes and goes, 4 ms at most."""
    return 0.004 * np.sin(0.5 * track.time) * np.gradient(track.simulated(MODEL), track.time)


def slips(track) -> np.ndarray:
    """A probe that holds no more than half of its load."""
    force, states = track.replay(MODEL)
    held = np.clip(force, -0.5 * states["load"], 0.5 * states["load"])
    return np.where(states["load"] > 0.5, held - force, 0.0)


def hum(track) -> np.ndarray:
    """An error that goes on wherever the probe is."""
    return 0.05 * np.sin(2 * np.pi * 11.0 * track.time)


def hum_while_touching(track) -> np.ndarray:
    """The same of what is touched."""
    return hum(track) * track.smoothed.in_contact


@pytest.mark.parametrize(
    ("shape", "block"),
    [
        (of_output, "force_sensor"),
        (plays, "force_sensor"),
        (late, "channel"),
        (slips, "contact"),
        (hum, "force_sensor"),
    ],
)
def test_what_only_one_block_can_do_to_a_force_is_found_in_that_block(shape, block):
    problem = leaving(measured(), shape)
    found = shares(problem, plain(problem), [], [])
    assert next(iter(found)) == block
    assert sum(found.values()) == pytest.approx(1.0) and list(found.values()) == sorted(found.values(), reverse=True)


def test_a_block_s_share_is_by_the_odds_of_what_its_effect_takes_off_the_variance_beyond_the_noise(monkeypatch):
    """Of 8 beyond the noise's 1 one effect leaves 3, the other 6: odds of 5 to 3 and of 1 to 3."""
    problem = SimpleNamespace(ratio=lambda variance, skew, heldout: np.sqrt(variance))
    monkeypatch.setattr(attribution, "_direct", lambda *_: ())

    def leaves(variance: float, *names: str) -> SimpleNamespace:
        effects = [LIBRARY[name] for name in names]
        return SimpleNamespace(model=variance, skew=0.0, hypothesis=SimpleNamespace(effects=effects))

    singles = [leaves(4.0, "coulomb_friction"), leaves(7.0, "nonlinear_stiffness")]
    found = shares(problem, leaves(9.0), singles, [])
    assert found == {"friction": pytest.approx(5 / 6), "contact": pytest.approx(1 / 6)}


def test_an_error_that_goes_on_in_dwells_but_not_in_free_space_is_the_body_s():
    problem = leaving(strokes(motion=stops), hum_while_touching)
    assert shares(problem, plain(problem), [], [])["body"] > 0.99


def test_the_block_of_an_effect_or_table_that_explains_the_mismatch_has_nearly_all_of_it():
    drag, other = (PLAIN.adding(LIBRARY[name]) for name in ("quadratic_drag", "nonlinear_stiffness"))
    problem = leaving(measured(), model=drag.model(drag.vector({}, {"quadratic_drag": {"c": 5.0}})))
    refit = problem.fit(PLAIN, PLAIN.base())
    starts = ({"quadratic_drag": {"c": 1.0}}, {"nonlinear_stiffness": {"k3": 1e3}})
    singles = [problem.fit(h, h.vector({}, start)) for h, start in zip((drag, other), starts, strict=True)]
    by_effect = shares(problem, refit, singles, [])
    assert next(iter(by_effect)) == "friction" and by_effect["friction"] > 0.95
    with ThreadPoolExecutor(1) as executor:
        by_table = shares(problem, refit, [], tables(problem, refit, executor))
    assert next(iter(by_table)) == "friction" and by_table["friction"] > 0.8
