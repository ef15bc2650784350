"""What the refined instrumental variable knows, and how new samples change it.

The sums of `instrumental_step` say that Z'(y - Phi rho) is noise with covariance s^2 Z'Z, rho being a ... g. That is
minimised over the object's own parameters, together with the prior (generalised method of moments, Hansen 1982): no
back-solve of eq. 30 with its several roots, and what the motion does not excite stays where it was.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from threadpoolctl import ThreadpoolController

from mmt_drake.errors import MmtError
from mmt_drake.estimation.output_error.fit import rest
from mmt_drake.estimation.output_error.learn import at_rest
from mmt_drake.estimation.output_error.normal import NormalAxis
from mmt_drake.estimation.output_error.unknowns import (
    HIGH,
    LOW,
    SIZE,
    UNKNOWNS,
    Information,
    Stick,
    derivatives,
    prior_information,
    theta_of,
)
from mmt_drake.estimation.recursive.instrumental_step import (
    BANK,
    REGRESSORS,
    Prefilter,
    Sums,
    add_samples,
    misfit,
)
from mmt_drake.estimation.recursive.options import InstrumentalOptions
from mmt_drake.estimation.recursive.samples import samples_of, write_parameters
from mmt_drake.estimation.recursive.stream import Stream, short_bank
from mmt_drake.model.body import MODE, VELOCITY
from mmt_drake.model.held_body import NOT_TOLD
from mmt_drake.model.parameters import KERNEL_SIZE, THETA
from mmt_drake.model.regrouping_equations import regroup
from mmt_drake.numeric.least_squares import minimise

Array = NDArray[np.float64]

_LEAST_SHARE = 1e-10  # of the largest of the instruments' sums: what is no larger is rounding
_STEPS = 2  # towards the minimum with each fit
_RUN_IN_S = 0.5  # for which the next prefilter runs beside the one in use
_FASTEST = 0.5  # samples: a prefilter is not faster
_STICK = (0.0, 0.0)


@dataclass(frozen=True)
class InstrumentalKnowledge:
    """All that is known after some samples; never changed.

    Attributes:
        stream: the samples at hand.
        x: (UNKNOWNS,) as in `mmt_drake.estimation.output_error.unknowns`.
        covariance: of x.
        axes: (2, AXIS_SIZE) the auxiliary body.
        prefilters: the one in use, and the next one, which runs in.
        bank: (2, 2, BANK) what is in both, of each axis.
        run_in: samples for which the next one has done so.
        sums: of all samples.
        normal: the normal axis.
    """

    stream: Stream
    x: Array
    covariance: Array
    axes: Array
    prefilters: tuple[Prefilter, Prefilter]
    bank: Array
    sums: Sums
    normal: NormalAxis
    run_in: int = 0

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    @property
    def theta(self) -> Array:
        """What is handed over, in the order of `mmt_drake.model.parameters.THETA`."""
        return theta_of(self.x, Stick(), self.normal.values)

    @property
    def deviation(self) -> Array:
        """Standard deviations of theta."""
        own = derivatives(self.theta) * np.sqrt(np.diag(self.covariance))
        return np.array([*own, *self.normal.deviation, own[-1], 0.0])

    @property
    def held(self) -> Array:
        """Where friction holds the body is not told."""
        return NOT_TOLD


class InstrumentalLearner:
    """Makes knowledge of samples; itself it keeps nothing.

    Args:
        options: of the estimator.
    """

    def __init__(self, options: InstrumentalOptions) -> None:
        self.options = options
        self.h = options.interval
        self._bank = short_bank(self.h, options.ticks)
        self._threads = ThreadpoolController()
        self._noise = options.force_noise / math.sqrt(options.ticks)

    def beginning(self) -> InstrumentalKnowledge:
        """Nothing but the prior."""
        known = prior_information(self.options.prior, None)
        square = np.zeros((REGRESSORS, REGRESSORS))
        return InstrumentalKnowledge(
            stream=Stream.empty(),
            x=known.mean(),
            covariance=known.covariance(),
            axes=rest(),
            prefilters=(self._prefilter(known.mean()),) * 2,
            bank=np.zeros((2, 2, BANK)),
            sums=Sums(square, square, square[0], np.zeros(3)),
            normal=NormalAxis.believed(self.options.prior),
        )

    def learned(self, known: InstrumentalKnowledge, new: Array, broken: bool = False) -> InstrumentalKnowledge:
        """Knowledge with new samples (k, SAMPLE_SIZE); `broken`: time broke off before them."""
        if broken and len(known.stream.window):
            axes = known.axes.copy()
            axes[:, [VELOCITY, MODE]] = 0.0
            known = replace(known, stream=known.stream.broken(), axes=axes, bank=np.zeros((2, 2, BANK)))
        if len(new) == 0:
            return known
        if len(known.stream.window) == 0 and not known.stream.interrupted:
            known = replace(known, axes=at_rest(new[0]))
        stream = known.stream.extended(new, self.h, self._bank)
        ready = stream.ready(self._bank)
        first = max(ready.start, 1)
        known = replace(known, stream=replace(stream, done=ready.stop))
        if first >= ready.stop:
            return known
        normal = known.normal.learned(stream.window, ready, self._noise)
        known = replace(known, normal=normal)
        taken = self._taken(known, (first, ready.stop))
        if taken is None:
            return known
        return self._fitted(taken) if stream.window.weight[first : ready.stop, :2].any() else taken

    def compile(self) -> None:
        """Compile what learning calls."""
        known = self.beginning()
        self._taken(known, (0, 0))
        square, vector = np.zeros((REGRESSORS, REGRESSORS)), np.zeros(REGRESSORS)
        misfit(known.x, square, vector, np.zeros((UNKNOWNS, UNKNOWNS)), known.x)

    def _prefilter(self, x: Array) -> Prefilter:
        _, _, _, _, e, f, _ = regroup(*theta_of(x, Stick(), np.ones(2))[:UNKNOWNS])
        return prefilter(max(e, (_FASTEST * self.h) ** 2), f, self.h)

    def _taken(self, known: InstrumentalKnowledge, span: tuple[int, int]) -> InstrumentalKnowledge | None:
        """With samples in the sums; None where the auxiliary body cannot follow."""
        p = np.zeros(KERNEL_SIZE)
        write_parameters(known.x, _STICK, np.ones(len(THETA)), p)
        rho = np.array(regroup(*known.theta[:UNKNOWNS]))
        axes, bank, sums = known.axes.copy(), known.bank.copy(), Sums(*(each.copy() for each in known.sums))
        samples, share, longest = samples_of(known.stream.window, self.h), self.options.growth, self.options.memory
        try:
            add_samples(samples, span, p, rho, known.prefilters, share, longest, axes, bank, sums)
        except RuntimeError:  # the body would stick and slide without end
            return None
        if not all(np.isfinite(part).all() for part in (axes, bank, *sums)):
            return None
        if known.run_in * self.h < _RUN_IN_S:
            return replace(known, axes=axes, bank=bank, sums=sums, run_in=known.run_in + span[1] - span[0])
        prefilters = known.prefilters[1], self._prefilter(known.x)
        return replace(known, axes=axes, bank=bank[[1, 1]], sums=sums, prefilters=prefilters, run_in=0)

    def _fitted(self, known: InstrumentalKnowledge) -> InstrumentalKnowledge:
        """The unknowns that the sums and the prior make most likely."""
        count, missed, _ = known.sums.counts
        believed = prior_information(self.options.prior, known.normal.values if known.normal.known else None)
        if count == 0.0 or not known.sums.instruments.any():
            return replace(known, x=believed.mean(), covariance=believed.covariance())
        noise = max(self._noise, math.sqrt(missed / count))
        whiten = _whitening(known.sums.instruments) / noise
        root, mean = np.ascontiguousarray(np.linalg.cholesky(believed.matrix).T), believed.mean()
        cross, target = whiten @ known.sums.cross, whiten @ known.sums.target

        try:
            with self._threads.limit(limits=1, user_api="blas"):  # a second one costs more than it brings
                minimum = minimise(
                    lambda x: misfit(x, cross, target, root, mean), known.x, LOW, HIGH, SIZE, steps=_STEPS
                )
        except MmtError:
            return known
        covariance = Information.of(minimum.jacobian, minimum.residual, minimum.x).covariance()
        return replace(known, x=minimum.x, covariance=covariance)


def _whitening(instruments: Array) -> Array:
    """(7, 7) that makes noise with this covariance white; directions that only rounding has told are left out."""
    size = np.sqrt(np.maximum(np.diag(instruments), np.finfo(float).tiny))
    value, vector = np.linalg.eigh(instruments / np.outer(size, size))
    kept = value > _LEAST_SHARE * value[-1]
    scale = np.where(kept, 1.0 / np.sqrt(np.where(kept, value, 1.0)), 0.0)
    return np.asarray(scale[:, np.newaxis] * vector.T / size, dtype=np.float64)


def prefilter(e: float, f: float, h: float) -> Prefilter:
    """1 / (e p^2 + f p + 1) from sample to sample, h [s] apart."""
    system = np.zeros((4, 4))
    system[0, 1] = 1.0
    system[1] = -1.0 / e, -f / e, 1.0 / e, 0.0
    system[2, 3] = 1.0
    whole = expm(system * h)
    after = whole[:2, 3] / h
    return Prefilter(float(e), float(f), np.ascontiguousarray(whole[:2, :2]), whole[:2, 2] - after, after)
