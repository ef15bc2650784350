"""Where the tip of a tool is that a turning hand holds."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mmt_drake.motion.hand import HandOrientation, orientation_of
from mmt_drake.recording import Recording
from mmt_drake.recording.signals import ORIENTATION

TIME = np.arange(400) * 0.01
ANGLE = 0.4 * np.sin(1.3 * TIME)
ABOUT_X = Rotation.from_rotvec(np.outer(ANGLE, [1.0, 0.0, 0.0])).as_quat()


def test_a_tool_along_y_goes_round_the_x_axis():
    still = np.zeros((len(TIME), 3))
    position, velocity = HandOrientation.of(TIME, ABOUT_X).tip(still, still, (0.5, 0.02, 0.0))
    rate = 0.4 * 1.3 * np.cos(1.3 * TIME)
    circle = 0.02 * np.column_stack([0.0 * TIME + 25.0, np.cos(ANGLE), np.sin(ANGLE)])
    np.testing.assert_allclose(position, circle, atol=1e-15)
    around = 0.02 * rate[:, np.newaxis] * np.column_stack([0.0 * TIME, -np.sin(ANGLE), np.cos(ANGLE)])
    np.testing.assert_allclose(velocity, around, atol=1e-8)


def test_orientations_of_either_sign_are_one_hand():
    flipped = ABOUT_X * np.where(np.arange(len(TIME)) % 3 == 0, -1.0, 1.0)[:, np.newaxis]
    still = {f"position_{axis}": 0.0 * TIME for axis in "xyz"}
    one = orientation_of(Recording(TIME, still | dict(zip(ORIENTATION, flipped.T, strict=True))))
    assert np.abs(np.diff(one, axis=0)).max() < 0.01
    np.testing.assert_allclose(
        HandOrientation.of(TIME, flipped).turn, HandOrientation.of(TIME, ABOUT_X).turn, atol=1e-15
    )


def test_spread_is_the_angle_about_the_mean():
    assert HandOrientation.of(TIME, ABOUT_X).spread == pytest.approx(np.std(ANGLE), rel=1e-3)
