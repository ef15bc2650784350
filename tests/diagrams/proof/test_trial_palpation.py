"""The trial's tip on a surface: closed forms of what simulates it, and what is drawn."""

import numpy as np
import pytest

from mmt_drake.diagrams.proof.trial.palpation import EFFECTS, RATE_HZ, SUBSTEPS, ball, draw_palpation, level, palpated
from mmt_drake.diagrams.proof.trial.palpation import wave as waves
from mmt_drake.diagrams.proof.trial.run import draw_trial
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.motion.hand import HandOrientation, orientation_of

TIME = np.arange(4000) / (RATE_HZ * SUBSTEPS)
WAY = np.column_stack([0.01 * np.sin(2.0 * TIME), 0.01 * TIME - 0.02])
DEPTH = 0.003 + 0.001 * np.sin(6.0 * TIME)
K = np.full(len(TIME), 400.0)


def test_on_a_level_surface_the_load_is_k_times_the_depth_and_b_times_its_rate():
    tip = palpated(level, WAY, DEPTH, K, b=2.0)
    load = 400.0 * DEPTH + 2.0 * 0.006 * np.cos(6.0 * TIME)
    np.testing.assert_allclose(tip.force[1:-1, 2], load[1:-1], atol=1e-6)
    np.testing.assert_allclose(tip.force[:, :2], 0.0, atol=1e-15)
    np.testing.assert_allclose(tip.place, np.column_stack([WAY, -DEPTH]), atol=1e-15)


def test_under_a_ball_the_tip_is_at_its_depth_along_the_radius_and_so_is_the_force():
    tip = palpated(ball(0.08), WAY, DEPTH, K)
    from_centre = tip.place + np.array([0.0, 0.0, 0.08])
    np.testing.assert_allclose(np.linalg.norm(from_centre, axis=1), 0.08 - DEPTH, rtol=1e-12)
    np.testing.assert_allclose(np.cross(from_centre, tip.force), 0.0, atol=1e-12)


def test_friction_is_mu_times_the_load_along_the_way_where_it_slips_and_a_spring_where_it_does_not():
    slides = np.column_stack([0.03 * TIME, 0.04 * TIME])
    tip = palpated(level, slides, DEPTH, K, mu=0.3)
    np.testing.assert_allclose(tip.force[1000:, :2], -0.3 * 400.0 * DEPTH[1000:, None] * [0.6, 0.8], rtol=1e-9)
    sways = np.column_stack([1e-4 * np.sin(TIME), 0.0 * TIME])
    np.testing.assert_allclose(palpated(level, sways, DEPTH, K, mu=0.3).force[:, 0], -0.8 * 400.0 * sways[:, 0])


def test_slopes_of_a_wave_are_those_of_its_heights():
    wave = waves(0.001, 0.03, 0.7, 0.2)
    x, y, step = WAY[:, 0], WAY[:, 1], 1e-7
    for i, slope in enumerate(wave(x, y)[1:]):
        moved = wave(x + step * (i == 0), y + step * (i == 1))[0]
        np.testing.assert_allclose((moved - wave(x, y)[0]) / step, slope, atol=1e-5)


def test_a_tool_that_is_off_is_back_at_the_tip_by_the_recorded_orientation():
    case = draw_palpation(np.random.default_rng(5), "case", ("tool_offset",), 1.0, wrong=False)
    recording = case.recording()
    still = np.zeros((len(recording), 3))
    tool = tuple(case.effects[0].parameters[axis] for axis in "xyz")
    hand = HandOrientation.of(recording.time, orientation_of(recording))
    way, depth = case.session.way()
    tip, _ = hand.tip(recording.vector("position"), still, tool)
    np.testing.assert_allclose(tip, np.column_stack([way, -depth])[::SUBSTEPS], atol=2e-5)


def test_cases_are_drawn_alike_for_a_seed_and_say_where_each_effect_acts():
    cases, again = (draw_trial(3, 1, plant="palpation") for _ in range(2))
    assert [case.truth() for case in cases] == [case.truth() for case in again]
    kinds = [case.kind for case in cases]
    assert (kinds.count("single"), kinds.count("pair"), kinds.count("none"), kinds.count("parameters")) == (4, 2, 1, 1)
    for case in cases:
        truth = case.truth()
        assert truth["structure"] == "surface_contact" and truth["visibility"] >= 0.0
        assert truth["blocks"] == [LIBRARY[name].block for name in truth["truth"]]
    assert {name for case in cases for name in case.truth()["truth"]} == set(EFFECTS)


def test_a_remainder_beneath_palpation_is_refused():
    with pytest.raises(BadInput, match=r"remainder: found 0\.2 with palpation"):
        draw_trial(0, 1, 0.2, "palpation")
