"""The figures of a long run take little memory beside its recording, and little time per event."""

from dataclasses import replace

import numpy as np
import pytest
from memory import peak_of

from mmt_drake.analysis.lags import lags
from mmt_drake.analysis.metrics import measure
from mmt_drake.analysis.passivity import passivity
from mmt_drake.recording.recording import Recording


def peak_columns(compute, recording: Recording) -> float:
    """Memory that a computation takes beside the recording at its peak, in columns of it."""
    compute(recording)
    return peak_of(lambda: compute(recording))[1] / recording.time.nbytes


@pytest.mark.parametrize("compute", [lambda run: measure(run, delay_s=0.4), passivity], ids=["errors", "energy"])
def test_figures_take_room_for_a_few_columns_of_a_full_recording_s_43(compute, stroke_run):
    assert peak_columns(compute, stroke_run) < 8


def test_an_uneven_clock_is_evened_column_by_column(stroke_run):
    kept = np.sort(np.random.default_rng(0).choice(len(stroke_run), len(stroke_run) * 9 // 10, replace=False))
    uneven = replace(
        stroke_run,
        time=stroke_run.time[kept],
        columns={name: values[kept] for name, values in stroke_run.columns.items()},
    )
    assert peak_columns(lambda run: measure(run, delay_s=0.4), uneven) < 8 + 4  # the clock, and what is looked at


def test_answers_are_paired_as_a_table_of_all_distances_pairs_them(recording_of):
    rng = np.random.default_rng(3)
    time = np.arange(60_000) * 1e-3
    for _ in range(20):
        changes = np.sort(rng.choice(np.arange(100, 59_000), size=40, replace=False))
        answers = np.sort(np.clip(changes + rng.integers(-30, 900, size=40), 1, 59_999))
        answers = np.unique(np.concatenate([answers[rng.random(40) < 0.8], rng.integers(1, 59_999, size=6)]))
        contact, rendering = toggled(time, changes), toggled(time, answers)
        force = rendering[:, None] * np.array([0.0, 0.1, -2.0])
        found = lags(recording_of(time, in_contact=contact, rendered_force=force), delay_s=0.4)
        for got, offset in zip(found, (0, 1), strict=True):
            before = np.concatenate([[-np.inf], time[changes[:-1]]])[offset::2]
            assert got.lags_s == pytest.approx(paired(time[changes[offset::2]], before, time[answers[offset::2]] + 0.4))


def toggled(time, samples):
    flips = np.zeros(len(time), dtype=int)
    flips[samples] = 1
    return (np.cumsum(flips) % 2).astype(float)


def paired(events, before, responses):
    """Mutually nearest pairs of event and response, the typical lag taken off, by way of all distances."""
    earliest = (before + events) / 2
    late = responses[None, :] - events[:, None]
    allowed = responses[None, :] >= earliest[:, None]
    firsts = [late[i, allowed[i]][0] for i in range(len(events)) if allowed[i].any()]
    distance = np.where(allowed, np.abs(late - np.median(firsts)), np.inf)
    answer = []
    for i, row in enumerate(distance):
        j = int(np.argmin(row))
        mutual = np.isfinite(row[j]) and np.argmin(distance[:, j]) == i
        answer.append(float(late[i, j]) if mutual else None)
    return answer
