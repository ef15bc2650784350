"""The noise that is put on a rendered image is the noise that was asked for."""

import math
from dataclasses import replace

import numpy as np
import pytest
from realsense_samples import plane_depth
from scipy.spatial.transform import Rotation

from mmt_drake.errors import BadInput
from mmt_drake.hw.realsense.depth import Intrinsics
from mmt_drake.hw.realsense.extrinsics import Extrinsics
from mmt_drake.hw.realsense.noise import DepthNoise

SHAPE = (120, 160)


def errors(noise: DepthNoise, clean: np.ndarray, camera: Intrinsics, frame: int = 0) -> np.ndarray:
    """(height, width) told less true depth [m]; NaN where nothing was told."""
    told = noise.apply(clean.astype(np.float32), camera, frame) * noise.unit
    return np.where(told > 0, told, math.nan) - clean


@pytest.mark.parametrize("z", [0.4, 1.0, 2.0])
def test_axial_noise_of_structured_light_grows_as_the_paper_says(z: float, small_camera: Intrinsics) -> None:
    noise = DepthNoise(axial=0.0012, axial_z2=0.0019, axial_from=0.4, unit=5e-5)
    found = errors(noise, np.full(SHAPE, z), small_camera)
    assert found.std() == pytest.approx(0.0012 + 0.0019 * (z - 0.4) ** 2, rel=0.03)
    assert abs(found.mean()) < 4.0 * found.std() / math.sqrt(found.size)


@pytest.mark.parametrize("z", [0.3, 0.6])
def test_axial_noise_of_a_stereo_camera_is_that_of_its_disparity(z: float, small_camera: Intrinsics) -> None:
    noise = DepthNoise(axial_z2=0.08 / (600.0 * 0.055), unit=1e-5)
    disparity = 600.0 * 0.055 / (z + errors(noise, np.full(SHAPE, z), small_camera))
    assert disparity.std() == pytest.approx(0.08, rel=0.03)
    assert DepthNoise.stereo(600.0).axial_z2 == noise.axial_z2


def test_the_maker_s_subpixel_noise_is_that_of_a_camera_that_was_measured() -> None:
    """A D435, 0.4 to 3 m: sigma_z = 0.000611 + 0.003587 (z - 0.3515)² m, a measurement that `stereo` cites."""
    z = np.linspace(0.4, 3.0, 100)
    measured = 0.000611 + 0.003587 * (z - 0.3515) ** 2
    focal = 424.0  # of 848 px over 90 deg
    ratio = DepthNoise.stereo(focal, baseline=0.05).axial_z2 * z**2 / measured
    assert 0.95 < ratio.min() < ratio.max() < 1.9  # never better than what was measured, nor twice as bad


def test_lateral_noise_takes_the_depth_of_a_pixel_nearby(small_camera: Intrinsics) -> None:
    """On a ramp of slope s per pixel, an error of e pixels is s e of depth; rounding to whole pixels adds 1/12."""
    slope = 1e-3
    ramp = 0.5 + slope * np.tile(np.arange(160.0), (120, 1))
    found = errors(DepthNoise(lateral=1.5, unit=1e-5), ramp, small_camera)[:, 20:-20]
    assert found.std() == pytest.approx(slope * math.sqrt(1.5**2 + 1.0 / 12.0), rel=0.03)


def test_at_grazing_angles_noise_grows_as_the_paper_says(small_camera: Intrinsics) -> None:
    turned = Rotation.from_euler("X", 180.0 + 60.0, degrees=True).as_matrix()
    where = Extrinsics.from_matrix(turned, (0.0, 0.0, 0.35))
    flat = plane_depth(small_camera, where)
    angle = np.arccos(
        -(small_camera.rays() @ where.rotation().T)[..., 2] / np.linalg.norm(small_camera.rays(), axis=-1)
    )
    noise = DepthNoise(grazing=1e-4, unit=2e-5)
    found = np.stack([errors(noise, flat, small_camera, k) for k in range(60)])
    expected = 1e-4 / np.sqrt(flat) * angle**2 / (math.pi / 2.0 - angle) ** 2
    inner = (slice(30, 90), slice(40, 120))
    steep = angle[inner] > math.radians(61.0)
    ratio = found.std(axis=0)[inner][steep] / expected[inner][steep]
    assert steep.sum() > 100
    assert np.median(ratio) == pytest.approx(1.0, rel=0.05)
    flatter = angle[inner] < math.radians(59.0)
    assert found.std(axis=0)[inner][flatter].max(initial=0.0) < 1e-6


def test_correlated_noise_keeps_its_size_and_reaches_over_its_window(small_camera: Intrinsics) -> None:
    white = DepthNoise(axial=1e-3, unit=1e-5)
    for width in (1.0, 3.0):
        found = errors(replace(white, correlation=width), np.full(SHAPE, 0.5), small_camera)
        assert found.std() == pytest.approx(1e-3, rel=0.1)
        beside = np.corrcoef(found[:, :-2].ravel(), found[:, 2:].ravel())[0, 1]
        assert beside == pytest.approx(math.exp(-1.0 / width**2), abs=0.05)  # two pixels: exp(-2²/(4 width²))


def test_holes_are_blobs_of_the_share_that_was_asked_for(small_camera: Intrinsics) -> None:
    noise = DepthNoise(holes=0.1, hole_size=4.0)
    lost = np.stack([np.isnan(errors(noise, np.full(SHAPE, 0.5), small_camera, k)) for k in range(20)])
    assert lost.mean() == pytest.approx(0.1, abs=0.01)
    assert (lost[:, :, 1:] & lost[:, :, :-1]).mean() > 0.5 * lost.mean()  # by chance a tenth


def test_flying_pixels_lie_between_the_two_surfaces_of_an_edge_and_nowhere_else(small_camera: Intrinsics) -> None:
    step = np.full(SHAPE, 0.5)
    step[:, 80:] = 0.4
    told = step + errors(DepthNoise(flying=0.6, unit=1e-5), step, small_camera)
    between = (told > 0.401) & (told < 0.499)
    assert between[:, 79:81].mean() == pytest.approx(0.6 * 0.98, abs=0.1)
    assert not between[:, :79].any()
    assert not between[:, 81:].any()


def test_the_strip_that_one_imager_cannot_see_is_as_wide_as_the_disparities_differ(small_camera: Intrinsics) -> None:
    step = np.full(SHAPE, 0.8)
    step[:, 90:130] = 0.4
    baseline = 0.05
    lost = np.isnan(errors(DepthNoise(baseline=baseline), step, small_camera))
    width = 150.0 * baseline * (1.0 / 0.4 - 1.0 / 0.8)
    assert abs(lost[60].sum() - width) <= 1.0
    assert np.flatnonzero(lost[60]).max() == 89
    assert not lost[:, 90:].any()


def test_a_frame_s_number_decides_its_errors(small_camera: Intrinsics) -> None:
    noise = DepthNoise.stereo(150.0, seed=4)
    clean = np.full(SHAPE, 0.5, np.float32)
    first = noise.apply(clean, small_camera, 3)
    np.testing.assert_array_equal(first, noise.apply(clean, small_camera, 3))
    assert (first != noise.apply(clean, small_camera, 4)).mean() > 0.5
    assert (first != replace(noise, seed=5).apply(clean, small_camera, 3)).mean() > 0.5


def test_what_is_not_seen_stays_unseen(small_camera: Intrinsics) -> None:
    clean = np.full(SHAPE, math.inf, np.float32)
    clean[:, :80] = 0.0
    assert not DepthNoise.stereo(150.0).apply(clean, small_camera, 0).any()


@pytest.mark.parametrize(
    "changes", [{"axial": -1.0}, {"unit": 0.0}, {"holes": 1.0}, {"flying": math.nan}, {"seed": -1}]
)
def test_noise_without_meaning_is_refused_by_name(changes: dict) -> None:
    with pytest.raises(BadInput, match=next(iter(changes))):
        DepthNoise(**changes)
