"""Recordings whose figures are known."""

from collections.abc import Callable

import numpy as np
import pytest

from mmt_drake.recording.recording import Recording

Array = np.ndarray


def make_recording(time: Array, **signals: Array) -> Recording:
    """A recording from (n,) columns and (n, 3) vectors."""
    columns = {}
    for name, values in signals.items():
        values = np.asarray(values, dtype=float)
        if values.ndim == 2:
            columns |= {f"{name}_{axis}": values[:, i] for i, axis in enumerate("xyz")}
        else:
            columns[name] = values
    return Recording(time=time, columns=columns, source="test.csv")


@pytest.fixture
def recording_of() -> Callable[..., Recording]:
    return make_recording


@pytest.fixture(scope="session")
def stroke_run() -> Recording:
    """A minute of strokes on a spring-damper at 1 kHz, touched and left; rendered 400 ms ahead, 10 % too strong.

    Not a simulation of the loop: every signal is a formula, so that tests can say what a figure has to show.
    """
    rng = np.random.default_rng(5)
    time = np.arange(60_000) * 1e-3
    delay = 400

    def motion(t: Array) -> tuple[Array, Array]:
        envelope = 0.5 + 0.5 * np.sin(2 * np.pi * 0.05 * t)
        y = 0.03 * np.sin(2 * np.pi * 0.2 * t) + 0.006 * envelope * np.sin(2 * np.pi * 3.6 * t)
        z = -0.005 + 0.008 * (np.mod(t, 15.0) > 13.0) * np.sin(np.pi * (np.mod(t, 15.0) - 13.0) / 2) ** 2
        return y, z

    def force(t: Array) -> Array:
        y, z = motion(t)
        rate = (motion(t + 1e-6)[0] - motion(t - 1e-6)[0]) / 2e-6
        tangential = -(100.0 * y + 20.0 * rate)
        return np.where(z < 0.0, 1.0, 0.0)[:, None] * np.column_stack([0.1 * tangential, tangential, -500.0 * z])

    ahead = time + delay * 1e-3
    y, z = motion(time)
    master_y, master_z = motion(ahead)
    measured = force(time)
    in_contact = (z < 0.0).astype(float)
    known = np.where(time > 0.5, 1.0, np.nan)
    settling = 1.0 + np.exp(-time / 1.5) * np.cos(3 * time)
    rendering = np.concatenate([np.zeros(delay), in_contact])[: len(time)]  # the flag on its way back
    rendered = 1.1 * force(ahead)
    rendered[motion(ahead)[1] >= 0.0] = 1e-3  # pressed by the model until told of the release
    return make_recording(
        time,
        master_position=np.column_stack([0 * y, master_y, master_z]),
        position=np.column_stack([0 * y, y, z]),
        force=measured + 0.02 * rng.standard_normal((len(time), 3)),
        true_force=measured,
        rendered_force=rendered * rendering[:, None] * (time > 3.2)[:, None],
        filtered_force=measured,
        estimated_force=1.02 * measured,
        in_contact=in_contact,
        theta_stable=(time > 2.8).astype(float),
        theta_m=known * settling,
        theta_k1=known * 20 * (settling - 1),
        theta_k2=known * 500 * settling,
        theta_b1=known * 60 * settling,
        theta_b2=known * 60 * settling,
        theta_Fc=known * 0.05 * settling,
        theta_normal_k=known * 500 * settling,
        theta_normal_b=known * 60 * settling,
        theta_Fs=known * 0.1 * settling,
        theta_v_d=known * 0.005 * settling,
    )
