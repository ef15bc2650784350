"""Restoring force over deflection and friction over sliding velocity, read off a recording.

What is read off is what the model has, plus what the recording says beyond it: the residual, turned from the measured
output into the force that would explain it (force-state mapping, Masri and Caughey 1979, J. Applied Mechanics 46(2)).
For a flexible box with F the force on the probe, P = -F that on the body and x_m = x - d its displacement,

    friction    = P - m x_m'' - k1 x_m           all that resists the body's sliding, b1 included
    restoring   = P - b2 d'                      what the contact spring, and laws beside it, push back with

A residual e of F is a deflection -e / (k2 + b2 s) of the contact, hence a displacement of the body, and a friction of
-e (1 + (m s^2 + k1) / (k2 + b2 s)) to first order. Laws that act on the body show in its friction.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from mmt_drake.diagnosis.fit.box_tracks import BoxTrack
from mmt_drake.diagnosis.fit.tracks import States, Track
from mmt_drake.diagnosis.tell.evidence import Curve, Series
from mmt_drake.effects import LIBRARY
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.laws import Slot
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.structure import PositionOut, Structure
from mmt_drake.numeric.arrays import Array, Flags

Complex = NDArray[np.complex128]

_ABOVE_TOP = 4.0  # a driven body's residual is differentiated twice: beyond so many times its top frequency it is noise


@dataclass(frozen=True)
class _Read:
    """A force on the clock of the fit, (n,) each.

    Attributes:
        simulated: in the model.
        beyond: what the recording says beyond it.
        known: where it can be told from the other forces; None: everywhere.
    """

    simulated: Array
    beyond: Array
    known: Flags | None = None


def curves_of(
    track: Track, refit: Structure, augmented: Structure | None, blocks: frozenset[str], skew: float = 0.0
) -> tuple[Curve | None, Curve | None]:
    """Restoring force and friction of one track; None where model and effects do not say which force is which.

    Args:
        track: what was measured.
        refit: the model without the effects found.
        augmented: with them; None where there are none.
        blocks: that the effects found act in.
        skew: of the output's clock in the model shown last [s].
    """
    shown = refit if augmented is None else augmented
    output, states = track.replay(without_sensor(shown), coarse=1.0)
    early = shown.additions.delay + skew
    residual = track.residual(shown, skew, coarse=1.0)
    residual = np.interp(track.time + early, track.time, residual)
    used = track.weight > 0.0
    refit, shown = track.own(refit), track.own(shown)
    if isinstance(shown, FlexibleBoxModel) and isinstance(track, BoxTrack):
        restoring, friction = _of_box(track, shown, output, states, residual)
    else:
        restoring, friction = _of_one_axis(track, shown, output, states, residual, blocks)
    over = Series("deflection", shown.unit("m"), states["deflection"])
    along = Series("sliding velocity", shown.unit("m/s"), states["sliding_velocity"])
    d, v = over.values, along.values
    rubs = refit.value("b") * v + refit.value("Fc") * np.sign(v)
    return (
        _curve(over, "restoring force", restoring, refit.value("k2") * d, used, refit, augmented),
        _curve(along, "friction", friction, rubs, used, refit, augmented),
    )


def without_sensor(model: Structure) -> Structure:
    """The model with a perfect force sensor and no delay."""
    laws = tuple(active for active in model.additions.laws if active.law.slot != Slot.SENSOR)
    handed = model.handed
    if handed is not None:
        kept = (e for e in handed.effects if LIBRARY[e[0]].block not in ("force_sensor", "channel", "geometry"))
        handed = replace(handed, effects=tuple(kept))
    bare = replace(model.with_additions(laws=laws, delay=0.0, turn=(0.0, 0.0, 0.0)), handed=handed)
    if isinstance(bare, FlexibleBoxModel):
        own = tuple(active for active in bare.along_normal.laws if active.law.slot != Slot.SENSOR)
        bare = replace(bare, along_normal=replace(bare.along_normal, laws=own))
    return bare


def _curve(
    over: Series,
    label: str,
    read: _Read | None,
    before: Array,
    used: Flags,
    refit: Structure,
    augmented: Structure | None,
) -> Curve | None:
    if read is None:
        return None
    if read.known is not None:
        used = used & read.known
    return Curve(
        over=Series(over.label, over.unit, over.values[used]),
        force=Series(label, refit.unit("N"), (read.simulated + read.beyond)[used]),
        models={"refit": before[used]} | ({} if augmented is None else {"augmented": read.simulated[used]}),
    )


def _of_box(
    track: Track, model: FlexibleBoxModel, force: Array, states: States, residual: Array
) -> tuple[_Read | None, _Read | None]:
    p, cleared = model.parameters, model.additions.gap > 0.0
    d_rate, body = states["deflection_rate"], states["position"]
    engaged = (force != 0.0) | (not cleared)  # within a clearance the damper is dead, too
    restoring = _Read(-force - p.b2 * d_rate * engaged, -residual)
    if p.k2 == 0.0:
        return restoring, None
    acceleration = np.gradient(states["sliding_velocity"], track.time)

    def response(s: Complex) -> Complex:
        return -(1.0 + (p.m * s**2 + p.k1) / (p.k2 + p.b2 * s))

    return restoring, _Read(-force - p.m * acceleration - p.k1 * body, _through(response, residual, track))


def _of_one_axis(
    track: Track, model: Structure, output: Array, states: States, residual: Array, blocks: frozenset[str]
) -> tuple[_Read | None, _Read | None]:
    """A Kelvin-Voigt contact, a driven body or a transmission, whose spring and friction act at one point.

    What effects add goes to the friction if one of them is friction, else to the spring.
    """
    d, v = states["deflection"], states["sliding_velocity"]
    if isinstance(model, PositionOut):
        resisting, beyond = _resisting(track, model, states["position"], v, states["input"], residual)
    else:
        assert isinstance(model, KelvinVoigt)  # there is no fifth structure
        resisting, beyond = model.F0 - output, -residual
    spring, rubbing = model.value("k2") * d, model.value("b") * v + model.value("Fc") * np.sign(v)
    if not blocks & {"friction", "contact", "body"}:
        return _Read(spring, beyond), _Read(rubbing, beyond)
    pulled = model.value("ratio") != 0.0  # a transmission's spring drives its output, it does not resist
    if "friction" in blocks:
        return None, _Read(resisting if pulled else resisting - spring, beyond)
    if pulled:
        return None, None
    # While the body sticks, friction is whatever holds it; a sample more to each side, for the jump in acceleration.
    sticks = np.convolve(v == 0.0, np.ones(3), mode="same") > 0.0
    return _Read(resisting - rubbing, beyond, ~sticks), None


def _resisting(track: Track, model: PositionOut, x: Array, v: Array, u: Array, residual: Array) -> tuple[Array, Array]:
    """All that resists a body whose output is recorded, and what a residual of x adds to it."""
    top = _ABOVE_TOP * float(track.smoothed.top_hz[track.column])

    def response(s: Complex) -> Complex:
        low_pass = 1.0 / (1.0 + (np.abs(s) / (2.0 * math.pi * top)) ** 8) if top > 0.0 else 1.0
        return -(model.value("m") * s**2) * low_pass

    resisting = model.resisting(u, x, np.gradient(v, track.time))
    return resisting, _through(response, residual, track) - model.slope(x) * residual


def _through(response: Callable[[Complex], Complex], values: Array, track: Track) -> Array:
    """Values (n,) on the clock of the fit through a linear system; the ends are mirrored."""
    n = len(values)
    s = 2j * math.pi * fft.rfftfreq(2 * n, 1.0 / track.smoothed.rate_hz)
    both = np.concatenate([values, values[::-1]])
    result: Array = fft.irfft(fft.rfft(both) * response(s), 2 * n)[:n]
    return result
