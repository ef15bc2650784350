"""The transmission against closed forms."""

import numpy as np
import pytest
from scipy.signal import sawtooth

from mmt_drake.errors import BadInput
from mmt_drake.model.transmission import TransmissionModel
from mmt_drake.model_files import with_effects
from mmt_drake.recording import Recording
from mmt_drake.replay import replayed

TIME = np.arange(4000) * 1e-3
TRIANGLE = 0.3 * sawtooth(2.0 * np.pi * TIME, 0.5) + 0.3  # from 0 up, 1 Hz
SLOW = {"ratio": -0.5, "offset": 0.2}


def output(model, u=TRIANGLE, start=0.2, load=None, **effects):
    """(n,) where the output goes from a place at rest."""
    model = with_effects(model, [{"name": n, "parameters": p} for n, p in effects.items()], "test")
    columns = {"input": u, "output": np.full_like(TIME, start)} | ({} if load is None else {"load": load})
    return replayed(model, Recording(TIME, columns))["output"]


def play(target, half, start):
    """(n,) the play operator: the output is pushed along by whichever flank it meets."""
    x, result = start, []
    for place in target:
        x = min(max(x, place - half), place + half)
        result.append(x)
    return np.array(result)


def test_without_mass_play_and_friction_the_output_is_the_input_times_the_ratio():
    np.testing.assert_allclose(output(TransmissionModel(**SLOW)), 0.2 - 0.5 * TRIANGLE, rtol=0, atol=1e-11)


def test_with_play_a_slow_output_is_half_the_gap_behind_and_rests_while_the_input_crosses_it():
    x = output(TransmissionModel(**SLOW), gear_play={"gap": 0.02})
    np.testing.assert_allclose(x, play(0.2 - 0.5 * TRIANGLE, 0.01, 0.2), rtol=0, atol=1e-11)
    crossing = (TIME >= 0.5) & (TIME <= 0.5 + 0.02 / 0.6)  # the ratio times the input moves at 0.6 /s
    assert np.ptp(x[crossing]) < 1e-11 < np.ptp(x[np.roll(crossing, 2)])
    back, there = np.interp([0.75, 1.25], TIME, x)  # over one place of the input
    assert there - back == pytest.approx(0.02, abs=1e-11)


def test_without_mass_friction_is_play_of_twice_the_wind_up():
    rubs = output(TransmissionModel(**SLOW, k=4.0, Fc=0.04))
    plays = output(TransmissionModel(**SLOW, k=4.0), gear_play={"gap": 0.02})
    np.testing.assert_allclose(rubs, plays, rtol=0, atol=1e-9)
    both = output(TransmissionModel(**SLOW, k=4.0, Fc=0.02), gear_play={"gap": 0.01})
    np.testing.assert_allclose(both, plays, rtol=0, atol=1e-9)


@pytest.mark.parametrize("m", [0.0, 0.02])
def test_a_sine_comes_through_as_the_transfer_function_says(m):
    k, b, c, w = 40.0, 0.3, 0.9, 2.0 * np.pi * 2.0
    x = output(TransmissionModel(ratio=0.5, k=k, b=b, m=m, c=c), np.sin(w * TIME), 0.0)
    s = 1j * w
    exact = np.imag(0.5 * (k + b * s) / (m * s**2 + (b + c) * s + k) * np.exp(s * TIME))
    late = TIME > 3.0
    np.testing.assert_allclose(x[late], exact[late], rtol=0, atol=3e-5)  # the input is linear between samples


def test_a_light_mass_is_none():
    slow = 0.3 * (1.0 - np.cos(np.pi * TIME))
    common = {"ratio": 2.0, "k": 10.0, "c": 0.1, "Fc": 0.05}
    light = output(TransmissionModel(**common, m=1e-5, b=0.01), slow, 0.0)
    none = output(TransmissionModel(**common, b=0.01), slow, 0.0)
    np.testing.assert_allclose(light, none, rtol=0, atol=3e-5)


def test_a_drive_train_that_stiffens_winds_up_to_where_its_cubic_balances_the_drag():
    k, k3, c, rate = 4.0, 500.0, 0.5, 0.3
    x = output(TransmissionModel(ratio=2.0, k=k, c=c), rate * TIME, 0.0, nonlinear_stiffness={"k3": k3})
    (wound,) = (root.real for root in np.roots([k3, 0.0, k, -c * 2.0 * rate]) if abs(root.imag) < 1e-12)
    assert 2.0 * rate * TIME[-1] - x[-1] == pytest.approx(wound, rel=1e-6)


def test_a_load_winds_up_the_drive_train():
    load = 0.3 * TRIANGLE
    x = output(TransmissionModel(**SLOW, k=5.0, load=2.0), load=load)
    np.testing.assert_allclose(x, 0.2 - 0.5 * TRIANGLE + 2.0 * load / 5.0, rtol=0, atol=1e-11)


def test_a_load_that_only_presses_moves_nothing_but_makes_friction():
    load = np.full_like(TIME, 3.0)
    np.testing.assert_allclose(output(TransmissionModel(**SLOW), load=load), 0.2 - 0.5 * TRIANGLE, rtol=0, atol=1e-11)
    x = output(TransmissionModel(**SLOW, k=10.0), load=load, load_dependent_friction={"mu": 0.05})
    np.testing.assert_allclose(x, play(0.2 - 0.5 * TRIANGLE, 0.015, 0.2), rtol=0, atol=1e-9)


@pytest.mark.parametrize("m", [0.0, 1e-4])
def test_within_a_dead_band_the_output_rests(m):
    u = TRIANGLE - 0.3
    x = output(TransmissionModel(ratio=1.0, k=10.0, b=0.1, m=m), u, -0.25, dead_band={"width": 0.1})
    late = TIME > 0.2
    expected = np.sign(u) * np.maximum(np.abs(u) - 0.05, 0.0)
    np.testing.assert_allclose(x[late], expected[late], rtol=0, atol=2e-3 if m else 1e-12)


def test_friction_that_starts_higher_than_it_slides_lets_a_massless_output_jump():
    x = output(TransmissionModel(ratio=1.0, k=10.0), start=0.0, static_friction={"Fs": 0.3, "Fd": 0.1, "v_d": 0.0})
    at = np.argmax(x > 0.0)
    assert TRIANGLE[at - 1] <= 0.03 < TRIANGLE[at]  # held until the spring pulls by Fs
    np.testing.assert_allclose(x[at:500], TRIANGLE[at:500] - 0.01, rtol=0, atol=1e-9)


def test_a_transmission_that_transmits_nothing_is_refused():
    with pytest.raises(BadInput, match="ratio: found 0, expected a number other than 0"):
        TransmissionModel(ratio=0.0)


def test_a_recording_without_the_load_that_pushes_the_output_is_refused():
    with pytest.raises(BadInput, match="columns: found input, output, expected the column load"):
        output(TransmissionModel(**SLOW, load=1.0))
