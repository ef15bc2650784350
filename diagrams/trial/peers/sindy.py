"""Sparse regression of the object's equation of motion with pysindy.

The body cannot be seen, so there are two ways to ask:

- `RECORDED`: eliminate it. What is left is a differential equation of the recorded force f (on the body) driven by
  the probe's motion; f'' is regressed on f, f', x, v, a, j and on sgn v, v|v|, f^3 and 1.
- `RECONSTRUCTED`: believe in the model's contact spring and damper and integrate d' = (f - k2 d) / b2; then the body is
  where the probe is less d. Its acceleration is regressed on f, v_m, x_m and on sgn v_m, v_m|v_m|, d^3 and 1.

pysindy is given the signals that the project's own fit has smoothed, every term over its RMS, so that one threshold
suits all. Of the thresholds tried, that of the fewest terms whose error on the last third of every touch is within 5 %
of the least is taken.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from mmt_drake.analysis.wording import percent, significant
from mmt_drake.diagrams.trial.peers.case import PeerCase, runs
from mmt_drake.diagrams.trial.peers.extra import peer
from mmt_drake.diagrams.trial.peers.result import SINDY, Estimate, PeerResult, Stopwatch
from mmt_drake.errors import BadInput

Array = NDArray[np.float64]
Signals = Mapping[str, Array]

RECORDED, RECONSTRUCTED = "equation of the force", "equation of the body"
THRESHOLDS: Final = tuple(float(t) for t in np.geomspace(0.01, 0.6, 20))
_AS_GOOD = 1.05
_SHORTEST_RUN = 30


@dataclass(frozen=True)
class Term:
    """A candidate term: `law` of a signal, and the effect that it stands for where the model has no such term."""

    text: str
    signal: str
    law: Callable[[Array], Array] = lambda z: z
    effect: str = ""
    unless: str = ""
    """The model's parameter that, not being 0, makes the term no news."""


def _drag(z: Array) -> Array:
    return np.asarray(z * np.abs(z))


def _cube(z: Array) -> Array:
    return np.asarray(z**3)


_RECORDED_TERMS = (
    Term("f'", "f'"),
    Term("f", "f"),
    Term("x", "x", effect="ground_spring", unless="k1"),
    Term("v", "v"),
    Term("a", "a"),
    Term("j", "j"),
    Term("sgn v", "v", np.sign, "coulomb_friction", "Fc"),
    Term("v|v|", "v", _drag, "quadratic_drag"),
    Term("f^3", "f", _cube, "nonlinear_stiffness"),
    Term("1", "f", np.ones_like, "constant_force"),
)
_BODY_TERMS = (
    Term("v_m", "v_m", effect="viscous_friction", unless="b1"),
    Term("f", "f"),
    Term("x_m", "x_m", effect="ground_spring", unless="k1"),
    Term("sgn v_m", "v_m", np.sign, "coulomb_friction", "Fc"),
    Term("v_m|v_m|", "v_m", _drag, "quadratic_drag"),
    Term("d^3", "d", _cube, "nonlinear_stiffness"),
    Term("1", "f", np.ones_like, "constant_force"),
)


@dataclass(frozen=True)
class Sparse:
    """A sparse equation.

    Attributes:
        coefficients: (k,) of the terms, in SI units; 0 where a term was dropped.
        error: RMS error of the derivative on the last third of every touch, over the derivative's RMS.
    """

    coefficients: Array
    error: float


def fit_sindy(case: PeerCase, *, setting: str) -> PeerResult:
    """Regress one of the two equations.

    Args:
        case: to be regressed.
        setting: `RECORDED` or `RECONSTRUCTED`.

    Raises:
        BadInput: a model without contact damper, whose body cannot be reconstructed; no touch long enough.
        MissingDependency: the extra `peers` is not installed.
    """
    rate, terms = ("f''", _RECORDED_TERMS) if setting == RECORDED else ("v_m'", _BODY_TERMS)
    signals = _signals(case, reconstructed=setting == RECONSTRUCTED)
    peer("pysindy")
    with Stopwatch() as taken:
        found = _sparsest(signals, 1.0 / case.track.smoothed.rate_hz, rate, terms)
    chosen = [(term, float(c)) for term, c in zip(terms, found.coefficients, strict=True) if c != 0.0]
    own = case.model.parameters
    equation = " ".join(f"{'+' if c > 0 else '-'} {significant(abs(c), 3)} {term.text}" for term, c in chosen) or "0"
    return PeerResult(
        tool=SINDY,
        version=version("pysindy"),
        setting=setting,
        rate_hz=case.track.smoothed.rate_hz,
        seconds=taken.seconds,
        cpu_seconds=taken.cpu_seconds,
        estimates=_body_estimates(chosen) if setting == RECONSTRUCTED else {},
        names=tuple(t.effect for t, _ in chosen if t.effect and not (t.unless and getattr(own, t.unless) != 0.0)),
        says=f"{rate} = {equation.removeprefix('+ ')}; off by {percent(found.error)} on data held out",
    )


def _body_estimates(chosen: Sequence[tuple[Term, float]]) -> dict[str, Estimate]:
    """The model's parameters in m v_m' = f - k1 x_m - b1 v_m - Fc sgn v_m; none without f."""
    by_text = {term.text: c for term, c in chosen}
    if "f" not in by_text:
        return {}
    m = 1.0 / by_text["f"]
    symbols = {"x_m": "k1", "v_m": "b1", "sgn v_m": "Fc"}
    return {"m": Estimate(m)} | {s: Estimate(-m * by_text[t]) for t, s in symbols.items() if t in by_text}


def _signals(case: PeerCase, *, reconstructed: bool) -> list[Signals]:
    """Every stretch of every touch where filtered signals can be trusted, in SI units."""
    s, column, p = case.track.smoothed, case.track.column, case.model.parameters
    if reconstructed and p.b2 == 0.0:
        raise BadInput(case.recording.source, found="a model with b2 = 0", expected="b2 > 0 to find the body")
    h = 1.0 / s.rate_hz
    result: list[Signals] = []
    for first, last in runs(s.in_contact):
        touch = slice(first, last)
        x, v, f = s.input[touch, column], s.input_rate[touch, column], -s.output[touch, column]
        if last - first < _SHORTEST_RUN:
            continue
        x = x - x[0]
        signals = {"x": x, "v": v, "a": np.gradient(v, h), "f": f, "f'": np.gradient(f, h)}
        signals |= {"j": np.gradient(signals["a"], h), "f''": np.gradient(signals["f'"], h)}
        if reconstructed:
            pole = np.exp(-p.k2 / p.b2 * h)
            d = lfilter([(1.0 - pole) / p.k2], [1.0, -pole], f) if p.k2 > 0.0 else np.cumsum(f) * h / p.b2
            v_m = v - (f - p.k2 * d) / p.b2
            signals |= {"d": d, "x_m": x - d, "v_m": v_m, "v_m'": np.gradient(v_m, h)}
        for a, b in runs(s.weight[touch] > 0.0):
            if b - a >= _SHORTEST_RUN:
                result.append({name: values[a:b] for name, values in signals.items()})
    if not result:
        raise BadInput(
            case.recording.source, found="no touch long enough", expected=f"{_SHORTEST_RUN * h:g} s at least"
        )
    return result


def _sparsest(signals: Sequence[Signals], h: float, rate: str, terms: Sequence[Term]) -> Sparse:
    """The equation `rate` = terms, with the threshold chosen as the module says; the first term is the state."""
    columns = [np.column_stack([term.law(stretch[term.signal]) for term in terms]) for stretch in signals]
    rates = [stretch[rate] for stretch in signals]
    size, size_of_rate = _rms(np.concatenate(columns)), float(_rms(np.concatenate(rates)))
    size[size == 0.0] = 1.0
    scaled = [column / size for column in columns], [r / size_of_rate for r in rates]
    early, late = ([[part(values) for values in both] for both in scaled] for part in (_early, _late))
    found = [_regressed(early, late, h, threshold) for threshold in THRESHOLDS]
    least = min(sparse.error for sparse in found)
    best = min(
        (sparse for sparse in found if sparse.error <= _AS_GOOD * least),
        key=lambda sparse: (np.count_nonzero(sparse.coefficients), sparse.error),
    )
    return Sparse(best.coefficients * size_of_rate / size, best.error)


def _regressed(early: Sequence[list[Array]], late: Sequence[list[Array]], h: float, threshold: float) -> Sparse:
    """Terms (n, k) and rates (n,) of every stretch: fitted to the early parts, tried on the late ones, all scaled."""
    pysindy = peer("pysindy")
    # The terms are computed already: the first is the state, the others are inputs, the library takes them as they are.
    model = pysindy.SINDy(
        optimizer=pysindy.STLSQ(threshold=threshold, alpha=1e-6), feature_library=pysindy.IdentityLibrary()
    )
    columns, rates = early
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a threshold that leaves nothing is one of those tried
        model.fit(
            [c[:, :1] for c in columns], t=h, x_dot=[r[:, np.newaxis] for r in rates], u=[c[:, 1:] for c in columns]
        )
    coefficients = np.asarray(model.coefficients(), dtype=np.float64)[0]
    tried, true = (np.concatenate(values) for values in late)
    return Sparse(coefficients, float(_rms(tried @ coefficients - true) / _rms(true)))


def _early(values: Array) -> Array:
    return values[: 2 * len(values) // 3]


def _late(values: Array) -> Array:
    return values[2 * len(values) // 3 :]


def _rms(values: Array) -> Array:
    """Of (n,) or of each column of (n, k)."""
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))
