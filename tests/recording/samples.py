"""Recordings made up for the tests of this folder."""

import numpy as np

from mmt_drake.recording import Recording
from mmt_drake.recording.signals import FLAGS, ORIENTATION, columns_of


def contact(seconds: float = 2.5, step: float = 1e-3, seed: int = 0, start: float = 0.0) -> Recording:
    """A contact recording with every column of the conventions: smooth motions, random forces, theta from 1 s on."""
    rng = np.random.default_rng(seed)
    time = start + np.arange(round(seconds / step)) * step
    columns = {name: rng.standard_normal(len(time)) for name in columns_of("contact")}
    for owner in ("", "master_"):
        for i, axis in enumerate("xyz"):
            phase = 2.0 * time + i
            columns[f"{owner}position_{axis}"] = 0.05 * np.sin(phase)
            columns[f"{owner}velocity_{axis}"] = 0.1 * np.cos(phase)
    turn = 0.2 * np.sin(time)
    columns |= zip(ORIENTATION, (0.0 * time, 0.0 * time, np.sin(turn), np.cos(turn)), strict=True)
    for name in FLAGS:
        columns[name] = (np.sin(3.0 * time) > 0.0).astype(float)
    for name in columns:
        if name.startswith("theta_") and name not in FLAGS:
            columns[name][time < start + 1.0] = np.nan
    return Recording(time, columns)


def same(a: Recording, b: Recording, *, clock: float = 0.0) -> None:
    """Equal columns, bit by bit, on equal clocks to `clock` seconds."""
    assert set(a.columns) == set(b.columns)
    assert np.abs(a.time - b.time).max() <= clock
    for name in a.columns:
        np.testing.assert_array_equal(a[name], b[name], err_msg=name)
