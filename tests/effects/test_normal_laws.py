"""Laws along the surface normal: those of the contact spring, on the depth, in contact alone."""

import numpy as np
import pytest
from responses import MODELS, SOME, applied
from scipy.interpolate import PchipInterpolator

from mmt_drake.diagnosis.fit.prepare import prepare
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model import kelvin_voigt
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import NORMAL_AXIS
from mmt_drake.recording import Recording
from mmt_drake.replay import replayed
from mmt_drake.simulation import simulate

TWINS = [name for name, effect in LIBRARY.items() if effect.twin_of]
BOX = MODELS["flexible_box"]
TIME = np.arange(3000) * 1e-3
PRESSED = PchipInterpolator([0, 0.3, 0.9, 1.2, 2.0, 2.4, 3.0], [-1e-3, -6e-3, -2e-3, -7e-3, -4e-3, -8e-3, -1e-3])
LIFTED = PchipInterpolator(
    [0, 0.4, 0.6, 1.2, 1.4, 1.6, 2.2, 3.0], [5e-3, 5e-3, -6e-3, -4e-3, 5e-3, -6e-3, -6e-3, -2e-3]
)


def recording(height, shake=0.0):
    """A probe that strokes along y at a height, without forces."""
    columns = {f"{kind}_{axis}": np.zeros(len(TIME)) for kind in ("position", "velocity", "force") for axis in "xyz"}
    columns |= {"position_y": 0.03 * np.sin(4.0 * TIME), "velocity_y": 0.12 * np.cos(4.0 * TIME)}
    columns |= {"position_z": height(TIME), "velocity_z": height(TIME, 1)}
    return Recording(TIME, columns, "pressed")


@pytest.mark.parametrize("name", TWINS)
def test_along_the_normal_a_law_is_that_of_a_spring_whose_deflection_is_the_height(name):
    spring = applied(KelvinVoigt(k=BOX.normal.k, b=BOX.normal.b), LIBRARY[name].twin_of, SOME[name])
    expected = np.empty(len(TIME))
    still = np.zeros(len(TIME))
    kelvin_voigt.replay(TIME, PRESSED(TIME), PRESSED(TIME, 1), still, spring.kernel_vector(), expected)
    found = replayed(applied(BOX, name), recording(PRESSED))["force_z"]
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


def test_a_power_of_the_depth_and_the_damper_beside_it():
    found = replayed(applied(BOX, "power_law_stiffness"), recording(PRESSED))["force_z"]
    k, p = SOME["power_law_stiffness"].values()
    np.testing.assert_allclose(found, k * (-PRESSED(TIME)) ** p - BOX.normal.b * PRESSED(TIME, 1), rtol=1e-12)


def test_at_a_touch_the_last_press_is_forgotten_and_off_contact_there_is_no_force():
    model = applied(BOX, "normal_viscoelastic_relaxation", {"k_maxwell": 800.0, "tau": 1.0})
    found = replayed(model, recording(LIFTED))["force_z"]
    assert not found[LIFTED(TIME) >= 0.0].any()
    again = np.flatnonzero(np.diff((LIFTED(TIME) < 0.0).astype(int)) == 1)[1] + 1
    alone = recording(LIFTED)
    rest = Recording(TIME[again - 1 :], {n: v[again - 1 :] for n, v in alone.columns.items()}, "second press")
    np.testing.assert_allclose(found[again:], replayed(model, rest)["force_z"][1:], rtol=1e-6, atol=1e-9)


def test_friction_feels_the_load_that_the_law_makes():
    rubbing = applied(BOX, "load_dependent_friction", {"mu": 0.3})
    stiffer = applied(rubbing, "power_law_stiffness", {"k": BOX.normal.k * 3.0, "p": 1.0})
    found, expected = (
        replayed(model, recording(PRESSED))
        for model in (stiffer, rubbing.with_parameters(**{"normal.k": 3.0 * BOX.normal.k}))
    )
    # Between samples the load of a law is a line, that of a spring and a damper the motion's own.
    for name, values in expected.items():
        np.testing.assert_allclose(found[name], values, atol=2e-4)
    plain = replayed(rubbing, recording(PRESSED))
    assert np.abs(plain["force_y"] - found["force_y"]).max() > 0.5


@pytest.mark.parametrize("name", ["power_law_stiffness", "normal_hysteresis", "force_lag", "frame_misalignment"])
def test_drake_the_replay_and_the_track_of_a_fit_agree(name):
    model = applied(BOX, name)
    moved = recording(LIFTED)
    rng = np.random.default_rng(0)
    answered = Recording(
        TIME,
        {n: v + 1e-6 * rng.standard_normal(len(TIME)) for n, v in {**moved.columns, **replayed(model, moved)}.items()},
        "answered",
    )
    for axis in "xyz":
        found, expected = simulate(model, moved)[f"force_{axis}"], replayed(model, moved)[f"force_{axis}"]
        np.testing.assert_allclose(found, expected, atol=1e-6)
    tracks = {track.axis: track for track in prepare([answered], model).problem.tracks}
    for track in tracks.values():
        assert np.abs(track.residual(model, coarse=1.0)).max() < 0.02 * np.abs(track.measured).max()


def test_a_model_without_laws_along_the_normal_pays_nothing_for_them():
    assert BOX.kernel_vector()[NORMAL_AXIS] == 0.0
    assert applied(BOX, "nonlinear_stiffness").kernel_vector()[NORMAL_AXIS] == 0.0
    assert applied(BOX, "power_law_stiffness").kernel_vector()[NORMAL_AXIS] > 0.0


def test_a_spring_that_is_itself_the_normal_axis_has_no_twin_of_its_laws():
    spring = MODELS["kelvin_voigt"]
    for name in TWINS:
        assert not LIBRARY[name].acts_on(spring)
        with pytest.raises(BadInput, match="without a normal axis of its own"):
            LIBRARY[name].checked(SOME[name], spring, "test")
    power = LIBRARY["power_law_stiffness"]
    assert power.acts_on(spring) and (power.within(spring).axis, power.within(BOX).axis) == ("", "z")
