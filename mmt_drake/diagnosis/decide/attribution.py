"""Attribution of an unnamed mismatch to a part of the system.

Every block is given what could act there, and its share grows with how much of the held-out mismatch that explains:

- effects and learned tables, simulated (`name`, `learn`);
- shapes that reach the output directly, so that least squares tells: what a sensor adds depends on its own reading,
  what a channel adds on the rate of it, what a slipping probe loses on force over load;
- where no shape explains anything: in free space and in dwells neither contact nor friction can do anything, so an
  error that goes on there is the sensor's, or while touching the body's.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

import numpy as np
from numba import njit

from mmt_drake.analysis.nrmse import rms
from mmt_drake.diagnosis.fit.box_tracks import NormalTrack
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.tracks import States, Track
from mmt_drake.diagnosis.search.learn import Learned
from mmt_drake.effects.tabulated_force import SIGNALS
from mmt_drake.errors import attempt
from mmt_drake.numeric.arrays import Array

_RIDGE = 1e-3
_DIFFERENCE = 1e-3
_KNOTS = 7
_TAIL = 0.01
_MOST = 0.999
_LITTLE = 0.08
"""Where the best shape explains less than this share of the mismatch, shapes say nothing."""
_PLAYS: Final = np.array([0.02, 0.05, 0.1, 0.2, 0.4, 0.8])
"""Half widths of play beside the standard deviation of what is measured."""
_STILL = 0.1  # of the RMS of the probe's speed
_GOES_ON = 0.25  # of the error's power while the probe moves


def shares(
    problem: Problem, refit: Fitted, singles: Sequence[Fitted], tables: Sequence[Learned]
) -> Mapping[str, float]:
    """Block -> its share of the mismatch, largest first; empty where no block explains any of it.

    Args:
        problem: with the recordings.
        refit: the fit without effects.
        singles: fits with one effect.
        tables: learned.
    """
    best: dict[str, float] = {}
    before = _beyond(problem, refit)
    for block, part in (
        *((f.hypothesis.effects[0].block, _explained(problem, before, f)) for f in singles),
        *((SIGNALS[t.values["of"]].block, _explained(problem, before, t.fitted)) for t in tables),
        *_direct(problem, refit),
    ):
        best[block] = max(best.get(block, 0.0), min(part, _MOST))
    if max(best.values(), default=0.0) < _LITTLE and (block_at_rest := _at_rest(problem, refit)) is not None:
        best[block_at_rest] = max(best.get(block_at_rest, 0.0), 0.5)
    odds = {block: part / (1.0 - part) for block, part in best.items() if part > 0.0}
    total = sum(odds.values())
    return {block: odds[block] / total for block in sorted(odds, key=lambda b: -odds[b])}


def _explained(problem: Problem, before: tuple[float, float], fitted: Fitted) -> float:
    """Share of the mismatch beyond noise that a fit takes off: of fitted or of held-out data, whichever is less."""
    after = attempt(_beyond, problem, fitted)
    if after is None:  # found on a coarser clock, and beyond this one's reach
        return 0.0
    return max(0.0, min(1.0 - b / max(a, 1e-300) for a, b in zip(before, after, strict=True)))


def _beyond(problem: Problem, fitted: Fitted) -> tuple[float, float]:
    """Variance beyond the noise, over it, of fitted and of held-out data."""
    fit, heldout = (problem.ratio(fitted.model, fitted.skew, heldout=heldout) ** 2 - 1.0 for heldout in (False, True))
    return fit, heldout


def _direct(problem: Problem, refit: Fitted) -> Iterable[tuple[str, float]]:
    """Blocks whose shapes reach the output directly, and what share of the held-out mismatch they explain."""
    blocks: list[str] = [b for b in ("force_sensor", "channel", "contact") if b in refit.hypothesis.nominal.BLOCKS]
    before, noise, after = 0.0, 0.0, defaultdict[tuple[str, int], float](float)
    for track in problem.tracks:
        residual = track.residual(refit.model, refit.skew, problem.coarse) / track.floor
        plain = list(_parameters(track, refit, residual, problem.coarse))
        without, replayed = _left(track, residual, plain), track.replay(refit.model, problem.coarse, refit.late)
        before += without
        noise += float(np.count_nonzero(track.heldout & (track.weight > 0.0)))
        for block in blocks:
            for family, shapes in enumerate(_shapes(track, *replayed, block)):
                columns = [track.smoothed.filter(shape) * track.weight for shape in shapes]
                after[block, family] += _left(track, residual, [*plain, *columns]) if columns else without
    for (block, _), left in after.items():
        yield block, max(0.0, (before - left) / max(before - noise, 1e-300))


def _shapes(track: Track, output: Array, states: States, block: str) -> Iterable[Sequence[Array]]:
    """Families of shapes (n,) that a block could add to the output, given the model's output and signals.

    Of every track as many, in the same order.
    """
    rate = np.gradient(output, track.time)
    if block == "force_sensor":
        over_time = _hats(track.time)
        along_normal = "depth" in states  # there what bends over the force, or makes a loop of it, is the contact's
        yield [] if along_normal else _hats(output)
        yield [*over_time, *(output * hat for hat in over_time[:-1])]
        yield [] if along_normal else [_played(output, half) for half in _PLAYS * np.std(output)]
    elif block == "channel":
        yield [rate * hat for hat in _hats(track.time)]
    elif block == "contact" and "depth" in states:
        yield [*_hats(states["depth"]), *(states["depth"] * hat for hat in _hats(states["depth_rate"]))]
    elif block == "contact":
        load = states.get("load", np.zeros_like(output))
        pressed = load > 0.1 * float(np.mean(load))
        slipping = _hats(np.where(pressed, output / np.maximum(load, 1e-9), 0.0))
        yield [hat * pressed for hat in slipping] if pressed.any() else []


@njit(cache=True)
def _played(values: Array, half: float) -> Array:
    """The play operator (Krasnosel'skii and Pokrovskii 1989): it keeps its value until either wall pushes it.

    Sums of it are the hysteresis of a sensor (Prandtl and Ishlinskii).
    """
    held, out = float(values[0]), np.empty_like(values)
    for i, value in enumerate(values):
        held = min(max(held, value - half), value + half)
        out[i] = held
    return out


def _hats(values: Array) -> list[Array]:
    """Piecewise linear functions of a signal that add up to one."""
    low, high = np.quantile(values, [_TAIL, 1.0 - _TAIL])
    if not high > low:
        return [np.ones_like(values)]
    at = np.clip((values - low) / (high - low), 0.0, 1.0) * (_KNOTS - 1)
    return [np.maximum(0.0, 1.0 - np.abs(at - k)) for k in range(_KNOTS)]


def _parameters(track: Track, refit: Fitted, here: Array, coarse: float) -> Iterable[Array]:
    """What the residual does when a parameter of the structure moves."""
    hypothesis, x = refit.hypothesis, refit.x
    _, _, scale = hypothesis.limits(x)
    for j, size in enumerate(scale):
        moved = x.copy()
        moved[j] += _DIFFERENCE * size
        there = attempt(lambda x: track.residual(hypothesis.model(x), hypothesis.skew_of(x), coarse), moved)
        if there is not None:  # else this way the model cannot go
            yield there / track.floor - here


def _left(track: Track, residual: Array, columns: Sequence[Array]) -> float:
    """Sum of squares on held-out data after a ridge regression on the others."""
    X = np.column_stack(columns)
    X = X / np.maximum(np.sqrt(np.mean(X**2, axis=0)), 1e-300)
    used = track.weight > 0.0
    fit, test = used & ~track.heldout, used & track.heldout
    A = X[fit]
    weights = np.linalg.solve(A.T @ A + _RIDGE * len(A) * np.eye(A.shape[1]), A.T @ residual[fit])
    r = residual[test] - X[test] @ weights
    return float(r @ r)


def _at_rest(problem: Problem, refit: Fitted) -> str | None:
    """The block that an error belongs to which goes on where nothing moves.

    In free space any error is the sensor's. In a dwell what friction holds is constant: what changes there is the
    body's. Of a structure that lacks the block nothing is said.
    """
    there = refit.hypothesis.nominal.BLOCKS
    tracks = [track for track in problem.tracks if not isinstance(track, NormalTrack)]
    powers = np.zeros((len(tracks), 4))
    for row, track in zip(powers, tracks, strict=True):
        s, used = track.smoothed, track.weight > 0.0
        if s.kind != "contact":
            return None
        speed = np.abs(s.input_rate[:, track.column])
        still = speed < _STILL * rms(speed)
        residual = track.residual(refit.model, refit.skew, problem.coarse) / track.floor
        rate, touching = np.gradient(residual), used & s.in_contact
        errors = ((residual, used & ~s.in_contact), (residual, touching & ~still))
        changes = ((rate, touching & still), (rate, touching & ~still))
        row[:] = [float(np.mean(r[chosen] ** 2)) if chosen.any() else 0.0 for r, chosen in (*errors, *changes)]
    free, moving, dwelling_rate, moving_rate = powers.mean(axis=0)
    if free > _GOES_ON * moving:
        return "force_sensor" if "force_sensor" in there else None
    return "body" if "body" in there and dwelling_rate > _GOES_ON * moving_rate else None
