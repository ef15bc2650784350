"""Tracks of a flexible box: its tangential axes and the one along the surface normal."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from mmt_drake.diagnosis.fit.latest import Latest
from mmt_drake.diagnosis.fit.tracks import NOISY, Replayed, States, Track, coarsened
from mmt_drake.diagnosis.signals.smoother import Smoothed
from mmt_drake.errors import BadInput
from mmt_drake.model.flexible_box_replay import replay_axis, replay_plane
from mmt_drake.model.normal_axis import read_normal, replay_normal
from mmt_drake.model.parameters import NORMAL_AXIS, FlexibleBoxModel
from mmt_drake.model.structure import Structure
from mmt_drake.model.turned import TURN_SIZE
from mmt_drake.numeric.arrays import Array

NORMAL_COLUMN = 2
"""Of the outputs of a contact: the force along the surface normal."""

_STILL = 0.01
"""Of the motion along an axis of the plane: along the other one there is no more than this, which nobody feels."""

_latest = Latest()


class _Tangential(NamedTuple):
    """What tangential axes answer, (2, n) or (1, n) each: force [N], the body's displacement [m] and its rate [m/s].

    Of both, where the kernel vector says more of the normal axis, a third force is what the sensor feels along it.
    """

    force: Array
    body: Array
    rate: Array


def _box(model: Structure, s: Smoothed) -> FlexibleBoxModel:
    if not isinstance(model, FlexibleBoxModel):
        raise BadInput(s.source, found=f"a {model.NAME} model", expected="flexible_box")
    return model


def _height(s: Smoothed) -> tuple[Array, Array]:
    """(n,) of the probe [m], and its rate; of one axis alone just below the surface."""
    if s.kind == "contact":
        return np.ascontiguousarray(s.input[:, 2]), np.ascontiguousarray(s.input_rate[:, 2])
    return np.full(len(s.time), -1e-9), np.zeros(len(s.time))


def _spring(p: Array) -> Array:
    """The part of a kernel vector that is the normal axis."""
    return p[int(p[NORMAL_AXIS]) + TURN_SIZE :]


def _normal_force(s: Smoothed, model: FlexibleBoxModel, p: Array) -> Array:
    """(n,) along the normal as it is [N]."""
    height, rate = _height(s)
    if p[NORMAL_AXIS] == 0.0:
        return np.where(s.in_contact, -model.normal.k * height - model.normal.b * rate, 0.0)
    force = np.empty(len(height))
    replay_normal(s.time, height, rate, s.contact.starts_in, s.contact.changes, _spring(p), force)
    return force


def _tangential(s: Smoothed, columns: list[int], model: FlexibleBoxModel, p: Array) -> _Tangential:
    """Tangential axes, replayed together; the latest are kept, for the track of the other axis."""

    def replayed() -> _Tangential:
        probe, probe_rate = (np.ascontiguousarray(motion[:, columns].T) for motion in (s.input, s.input_rate))
        above, above_rate = _height(s)
        if p[NORMAL_AXIS] != 0.0:
            above = _normal_force(s, model, p)
            above_rate = np.gradient(above, s.time)
        rows = 3 if p[NORMAL_AXIS] != 0.0 and len(columns) == 2 else len(columns)
        found = _Tangential(np.empty((rows, len(s.time))), np.empty_like(probe), np.empty_like(probe))
        replay = replay_axis if len(columns) == 1 else replay_plane
        replay(s.time, probe, probe_rate, above, above_rate, s.contact.starts_in, s.contact.changes, p, *found)
        return found

    return _latest.of((s,), (columns, p.tobytes()), replayed)


@dataclass(frozen=True)
class _OfBox(Track):
    """An axis of a flexible box."""

    @cached_property
    def _is_noisy(self) -> bool:
        """Whether along the surface noise is a part of the force that the error of longer steps does not come near.

        One answer for the recording: its tracks share a replay.
        """
        s, along = self.smoothed, slice(2 if self.smoothed.kind == "contact" else 1)
        return bool(np.all(s.output_noise[along] > NOISY * np.std(s.output[s.weight > 0.0, along], axis=0)))


@dataclass(frozen=True)
class BoxTrack(_OfBox):
    """A tangential axis of a flexible box."""

    def _is_alone(self, model: FlexibleBoxModel) -> bool:
        """Whether there is no other axis, or nothing moves the body along it: it then does nothing to this one."""
        return self.smoothed.kind != "contact" or (self._stands_across and not model.pushed_at_rest)

    @cached_property
    def _stands_across(self) -> bool:
        """Whether along the other tangential axis the probe as good as stands still in contact."""
        way = np.std(self.smoothed.input[self.smoothed.in_contact, :2], axis=0)
        return bool(way[1 - self.column] < _STILL * way[self.column])

    def _replayed(self, model: Structure, coarse: float, late: float) -> Replayed:
        s, i, model = self.smoothed, self.column, _box(model, self.smoothed)
        p = coarsened(model.kernel_vector(), coarse, s.rate_hz, self._is_noisy)
        both = any(model.additions.turn) or (model.couples and not self._is_alone(model))
        force, body, body_rate = (
            values[i if both else 0] for values in _tangential(s, [0, 1] if both else [i], model, p)
        )
        probe, rate = s.input[:, i], s.input_rate[:, i]
        return force, lambda: {
            "sliding_velocity": body_rate,
            "deflection": self._since_touch(probe - body),
            "deflection_rate": rate - body_rate,
            "position": body,
            "load": np.where(s.in_contact, np.maximum(_normal_force(s, model, p), 0.0), 0.0),
        }

    def _since_touch(self, stretch: Array) -> Array:
        """Probe less body (n,), less what it was at the latest touch; 0 off contact."""
        time = self.smoothed.time
        return stretch - np.interp(time - self.smoothed.contact.since(time), time, stretch)


@dataclass(frozen=True)
class NormalTrack(_OfBox):
    """The axis of a flexible box along the surface normal."""

    def _replayed(self, model: Structure, coarse: float, late: float) -> Replayed:
        s, model = self.smoothed, _box(model, self.smoothed)
        p = coarsened(model.kernel_vector(), coarse, s.rate_hz, self._is_noisy)
        force = reading = _normal_force(s, model, p)
        if any(model.additions.turn):
            force = _tangential(s, [0, 1], model, p).force[2]
        if p[NORMAL_AXIS] != 0.0:
            reading = np.empty_like(force)
            read_normal(s.time, _height(s)[1], np.ascontiguousarray(force), _spring(p), reading)

        def states() -> States:
            depth, rate = (np.where(s.in_contact, -motion[:, 2], 0.0) for motion in (s.input, s.input_rate))
            return {"depth": depth, "depth_rate": rate}

        return reading, states
