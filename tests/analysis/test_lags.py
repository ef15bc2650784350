"""Touches and releases, and the answers of the rendered force."""

import numpy as np
import pytest

from mmt_drake.analysis.lags import lags

TIME = np.arange(40_000) * 1e-3


def during(*spans: tuple[float, float]) -> np.ndarray:
    return np.any([(a - 1e-4 <= TIME) & (b - 1e-4 > TIME) for a, b in spans], axis=0).astype(float)


@pytest.fixture
def run(recording_of):
    def make(contact, rendered, **more):
        force = rendered[:, None] * np.array([0.0, 0.1, -2.0])
        return recording_of(TIME, in_contact=contact, rendered_force=force, **more)

    return make


def test_lag_is_counted_from_the_event_in_the_operators_time(run):
    contact = during((5.0, 10.0), (15.0, 20.0))
    rendered = during((5.2, 10.5), (15.2, 20.5))
    touch, release = lags(run(contact, rendered), delay_s=0.4)
    assert touch.events_s == pytest.approx((5.0, 15.0))
    assert touch.lags_s == pytest.approx((0.6, 0.6))  # touched by a motion at 4.6 s, answered at 5.2 s
    assert release.lags_s == pytest.approx((0.9, 0.9))
    assert (touch.median_s, release.median_s) == pytest.approx((0.6, 0.9))


def test_one_step_late_is_one_step(run):
    touch, release = lags(run(during((5.0, 10.0)), during((5.001, 10.001))))
    assert (touch.median_s, release.median_s) == pytest.approx((1e-3, 1e-3))


def test_an_early_answer_has_a_negative_lag(run):
    touch, release = lags(run(during((5.0, 10.0), (15.0, 20.0)), during((4.98, 10.0), (14.98, 20.0))))
    assert touch.lags_s == pytest.approx((-0.02, -0.02))
    assert release.lags_s == pytest.approx((0.0, 0.0))


def test_contacts_shorter_than_the_round_trip_keep_their_own_answers(run):
    spans = ((2.0, 2.3), (2.6, 2.9), (10.0, 13.0), (20.0, 23.0), (30.0, 33.0))
    late = tuple((a + 0.8, b + 0.8) for a, b in spans)
    touch, release = lags(run(during(*spans), during(*late)))
    assert touch.lags_s == pytest.approx((0.8,) * 5)
    assert release.lags_s == pytest.approx((0.8,) * 5)


def test_a_lost_answer_is_told_and_does_not_shift_the_others(run):
    spans = ((2.0, 4.0), (8.0, 8.2), (12.0, 16.0), (20.0, 24.0))
    answered = tuple((a + 0.1, b + 0.1) for i, (a, b) in enumerate(spans) if i != 1)
    touch, release = lags(run(during(*spans), during(*answered)))
    assert touch.lags_s[1] is None and release.lags_s[1] is None
    assert [lag for lag in touch.lags_s if lag is not None] == pytest.approx([0.1] * 3)
    assert touch.median_s == pytest.approx(0.1)
    assert (touch.lost, release.lost) == (1, 1)


def test_events_before_the_first_stable_theta_do_not_count(run):
    contact = during((2.0, 6.0), (10.0, 15.0))
    stable = during((4.0, 40.0))
    rendered = during((4.4, 6.4), (10.4, 15.4))  # the first onset answers the estimator, not a touch
    touch, release = lags(run(contact, rendered, theta_stable=stable))
    assert touch.events_s == pytest.approx((10.0,))
    assert touch.lags_s == pytest.approx((0.4,))
    assert release.lags_s == pytest.approx((0.4, 0.4))


def test_a_renderer_that_needs_no_theta_is_judged_at_every_touch(run):
    contact = during((2.0, 6.0), (10.0, 15.0))
    touch, _ = lags(run(contact, during((2.1, 6.1), (10.1, 15.1)), theta_stable=np.zeros_like(TIME)))
    assert touch.lags_s == pytest.approx((0.1, 0.1))


def test_a_renderer_that_never_answers_has_no_median(run):
    touch, release = lags(run(during((5.0, 10.0)), np.zeros_like(TIME)))
    assert touch.lags_s == (None,) and touch.median_s is None
    assert release.lags_s == (None,)


def test_contact_from_the_first_sample_is_no_touch(run):
    touch, release = lags(run(during((0.0, 10.0)), during((0.0, 10.3))))
    assert touch.events_s == ()
    assert release.lags_s == pytest.approx((0.3,))


def test_an_answer_that_the_recording_no_longer_saw_is_unanswered(run):
    contact = during((5.0, 10.0), (15.0, 20.0), (39.8, 40.0))
    touch, _ = lags(run(contact, during((5.8, 10.8), (15.8, 20.8))))
    assert touch.lags_s == pytest.approx((0.8, 0.8, None))
    assert (touch.unseen, touch.lost) == (1, 0)


def test_what_was_moved_before_the_first_parameters_came_over_the_network_cannot_be_answered(run):
    contact, rendered = during((0.5, 5.0), (10.0, 15.0)), during((0.4, 4.6), (9.6, 14.6))
    come = {"theta_stable": during((0.0, 40.0)), "renderer_status": during((0.4, 40.0))}
    touch, release = lags(run(contact, rendered, **come), delay_s=0.4)
    assert touch.events_s == pytest.approx((10.0,)) and touch.lags_s == pytest.approx((0.0,), abs=1e-9)
    assert release.events_s == pytest.approx((5.0, 15.0))
