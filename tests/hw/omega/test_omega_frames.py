"""Device frame to table frame and back: scale, offset, rotation, clutch."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mmt_drake.errors import BadInput
from mmt_drake.hw.omega import frames
from mmt_drake.hw.omega.faults import HandFault
from mmt_drake.hw.omega.settings import OmegaSettings


class Frames:
    """The driver's state and what it is told."""

    def __init__(self, settings: OmegaSettings) -> None:
        self.frame = frames.frame_vector(settings)
        self.motion, self.device, self.clutch = np.zeros(6), np.zeros(3), np.zeros(5)
        self.now = 0.0

    def read(self, position: np.ndarray, velocity: np.ndarray, *, clutched: bool = False, fault: int = 0) -> np.ndarray:
        self.now += 1e-3
        reading = np.concatenate([position, velocity])
        frames.take_reading(self.motion, self.device, self.clutch, reading, fault, clutched, self.now, self.frame)
        return self.motion.copy()

    def force(self, force: np.ndarray) -> np.ndarray:
        out = np.full(3, np.nan)
        self.said = frames.force_on_hand(self.device, self.clutch, force, self.frame, out)
        return out

    def settle(self) -> None:
        for _ in range(60):
            self.read(np.zeros(3), np.zeros(3))


TURNED = OmegaSettings(
    scale=2.5, rotation=(20.0, -35.0, 110.0), centre=(0.01, -0.02, 0.03), origin=(0.1, 0.2, 0.05), force=12.0
)


def test_position_and_velocity_follow_the_formula() -> None:
    rotation = Rotation.from_euler("xyz", TURNED.rotation, degrees=True).as_matrix()  # about fixed axes: Rz Ry Rx
    np.testing.assert_allclose(TURNED.rotation_matrix(), rotation, atol=1e-15)
    p, v = np.array([0.03, 0.01, -0.02]), np.array([0.2, -0.1, 0.3])
    motion = Frames(TURNED).read(p, v)
    np.testing.assert_allclose(motion[:3], TURNED.origin + 2.5 * rotation @ (p - TURNED.centre), atol=1e-15)
    np.testing.assert_allclose(motion[3:], 2.5 * rotation @ v, atol=1e-15)


def test_the_hand_gets_work_over_scale_whatever_the_rotation() -> None:
    """Power on the table is `scale` times power at the hand: F . R v = R'F . v."""
    mapped, v, force = Frames(TURNED), np.array([0.2, -0.1, 0.3]), np.array([1.0, 2.0, -3.0])
    mapped.settle()
    on_table = force @ mapped.read(np.zeros(3), v)[3:]
    assert mapped.force(force) @ v == pytest.approx(on_table / 2.5, rel=1e-13)


def test_the_clutch_moves_the_hand_without_moving_the_probe_and_without_a_jump() -> None:
    mapped = Frames(TURNED)
    mapped.settle()
    before = mapped.read(np.array([0.01, 0.0, 0.0]), np.array([0.1, 0.0, 0.0]))
    for x in np.linspace(0.01, -0.04, 30):
        held = mapped.read(np.array([x, 0.0, 0.0]), np.array([-1.0, 0.0, 0.0]), clutched=True)
        np.testing.assert_array_equal(held, [*before[:3], 0.0, 0.0, 0.0])
        assert not mapped.force(np.array([0.0, 0.0, 4.0])).any(), "a hand that repositions feels nothing"
        assert mapped.device[2] == 1.0
    after = mapped.read(np.array([-0.04, 0.0, 0.0]), np.zeros(3))
    np.testing.assert_allclose(after[:3], before[:3], atol=1e-15)
    moved = mapped.read(np.array([-0.03, 0.0, 0.0]), np.zeros(3))
    np.testing.assert_allclose(moved[:3] - before[:3], 2.5 * TURNED.rotation_matrix()[:, 0] * 0.01, atol=1e-15)


def test_after_the_clutch_the_force_comes_back_over_50_ms() -> None:
    mapped = Frames(OmegaSettings())
    mapped.settle()
    mapped.read(np.zeros(3), np.zeros(3), clutched=True)
    felt = []
    for _ in range(60):
        mapped.read(np.zeros(3), np.zeros(3))
        felt.append(mapped.force(np.array([0.0, 0.0, 5.0]))[2])
    np.testing.assert_allclose(felt, 5.0 * np.minimum(1.0, np.arange(1, 61) / 50), atol=1e-9)


def test_no_force_is_greater_than_the_settings_say() -> None:
    mapped = Frames(OmegaSettings(force=8.0, force_scale=2.0))
    mapped.settle()
    np.testing.assert_allclose(mapped.force(np.array([1.0, 0.0, 0.0])), [2.0, 0.0, 0.0])
    np.testing.assert_allclose(mapped.force(np.array([30.0, 40.0, 0.0])), [4.8, 6.4, 0.0], rtol=1e-14)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_force_that_is_not_a_number_is_none(bad: float) -> None:
    mapped = Frames(OmegaSettings())
    mapped.settle()
    assert not mapped.force(np.array([0.0, bad, 1.0])).any() and mapped.said == HandFault.BAD_FORCE


@pytest.mark.parametrize("fault, value", [(2, 0.0), (0, np.nan), (0, np.inf)])
def test_a_reading_that_failed_leaves_the_probe_where_it_was_and_the_hand_without_force(
    fault: int, value: float
) -> None:
    mapped = Frames(OmegaSettings())
    mapped.settle()
    before = mapped.read(np.array([0.01, 0.02, 0.0]), np.array([0.1, 0.0, 0.0]))
    after = mapped.read(np.full(3, value), np.zeros(3), fault=fault)
    np.testing.assert_array_equal(after, [*before[:3], 0.0, 0.0, 0.0])
    assert mapped.device[0] == (fault or HandFault.BAD_READING)
    assert not mapped.force(np.array([0.0, 0.0, 4.0])).any()


@pytest.mark.parametrize(
    "setting",
    [
        {"scale": 0.0},
        {"force": np.inf},
        {"watchdog": 0.05},
        {"velocity_window": 0.0},
        {"rotation": (0.0, np.nan, 0.0)},
        {"device": -1},
    ],
)
def test_settings_out_of_range_are_refused_by_name(setting: dict[str, object]) -> None:
    with pytest.raises(BadInput, match=next(iter(setting))):
        OmegaSettings(**setting)  # type: ignore[arg-type]
