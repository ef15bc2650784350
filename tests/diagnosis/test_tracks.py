"""What makes a replay fast is off by far less than the noise: longer steps, and an axis without the other."""

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
from trial_samples import COULOMB, beside, model, recorded

from mmt_drake.diagnosis.fit import box_tracks
from mmt_drake.diagnosis.fit.box_tracks import BoxTrack
from mmt_drake.diagnosis.fit.prepare import prepare
from mmt_drake.diagnosis.fit.tracks import COARSE, MAX_STEP, NOISY, coarsened
from mmt_drake.errors import MmtError

VECTOR = replace(model(Fc=0.4), in_plane="vector")
SMOOTH = replace(model(), in_plane="vector")


@pytest.mark.parametrize(
    ("plain", "effects"),
    [
        (VECTOR, {}),
        (VECTOR, {"stribeck_friction": {"Fs": 0.6, "v_s": 0.02}}),
        (VECTOR, {"nonlinear_stiffness": {"k3": 1e6}}),
        (SMOOTH, {"smooth_coulomb_friction": {"Fc": 0.3, "v_s": 0.01}}),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, dict) else "",
)
def test_longer_steps_beside_friction_in_the_plane_are_off_by_a_tenth_of_the_noise_at_most(plain, effects, monkeypatch):
    hypothesis = beside(*effects, nominal=plain)
    what = hypothesis.model(hypothesis.vector({}, effects))
    prepared = prepare([recorded(COULOMB, seed=3)], plain)
    monkeypatch.setattr(box_tracks, "_STILL", 0.0)  # the probe moves along one axis: replay the other one, too
    assert prepared.fine is not None and prepared.problem is not None
    for problem, coarse in ((prepared.problem, COARSE), (prepared.fine, 1.0)):
        track = max((t for t in problem.tracks if isinstance(t, BoxTrack)), key=lambda t: float(np.std(t.measured)))
        with monkeypatch.context() as noiseless:
            noiseless.setattr(box_tracks, "NOISY", np.inf)  # without noise no step is longer
            accurate = replace(track).replay(what, 1.0)[0]
        assert track.floor > NOISY * float(np.std(track.measured[track.weight > 0.0]))
        longer = track.replay(what, coarse)[0]
        error = np.sqrt(np.mean((longer - accurate) ** 2))
        assert error < 0.1 * track.floor and (error > 0.0 or plain is SMOOTH)  # they are longer where a body may stick


@pytest.mark.parametrize(("step", "admitted"), [(5e-5, True), (2e-5, False)])
def test_what_a_search_can_follow_a_finer_clock_follows_too(step, admitted):
    vector = model().kernel_vector()
    vector[MAX_STEP] = step
    for coarse in (COARSE, 1.0):
        with nullcontext() if admitted else pytest.raises(MmtError, match="too stiff"):
            coarsened(vector.copy(), coarse, 1000.0)


@pytest.mark.parametrize(
    ("effects", "aside"),
    [
        ({}, False),
        ({"stribeck_friction": {"Fs": 0.6, "v_s": 0.02}}, False),
        ({"dahl_friction": {"Fc": 0.3, "sigma": 3e3}}, False),
        ({"hunt_crossley_damping": {"lambda": 2e3}}, False),
        ({"constant_force": {"F": 0.5}}, True),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, dict) else "",
)
def test_an_axis_is_replayed_without_the_other_where_the_probe_stands_along_it_and_nothing_pushes(
    effects, aside, monkeypatch
):
    plain = SMOOTH if "dahl_friction" in effects else VECTOR
    hypothesis = beside(*effects, nominal=plain)
    what = hypothesis.model(hypothesis.vector({}, effects))
    problem = prepare([recorded(COULOMB, seed=3)], plain).problem
    assert problem is not None
    track = max((t for t in problem.tracks if isinstance(t, BoxTrack)), key=lambda t: float(np.std(t.measured)))
    planes = []
    plane = box_tracks.replay_plane
    monkeypatch.setattr(box_tracks, "replay_plane", lambda *a: planes.append(plane(*a)))
    force, _ = track.replay(what, 1.0)
    assert bool(planes) == aside
    monkeypatch.setattr(box_tracks, "_STILL", 0.0)
    before, slightly = len(planes), replace(what, normal=replace(what.normal, k=what.normal.k * (1.0 + 1e-12)))
    with_other, _ = replace(track).replay(slightly, 1.0)  # the very same is kept from before
    assert len(planes) == before + 1
    assert np.sqrt(np.mean((force - with_other) ** 2)) < 0.1 * track.floor
