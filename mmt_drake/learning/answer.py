"""One look at a contact: what the diagnosis names there, and what of that may be felt."""

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import astuple, dataclass, replace
from functools import partial
from typing import Final

import numpy as np

from mmt_drake.diagnosis.decide.verdict import NAMING, Verdict
from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagnosis.tell.outcome import Outcome
from mmt_drake.diagnosis.tell.result import NamedEffect
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput, MmtError
from mmt_drake.estimation.output_error.options import Prior, check_told
from mmt_drake.learner_status import LearnerStatus
from mmt_drake.model.message_layout import SENSOR
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model_message import NO_ERROR, UNKNOWN_THETA, ModelMessage, SensorError, ToldEffect, box_of
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import AXES, Recording

FREE_S: Final = 0.3
"""Of free space before a contact that is looked at with it [s]."""
ROW: Final = 10
"""Numbers of a sample: position [m], velocity [m/s], force [N] and contact (0 or 1)."""

_COLUMNS = [*(f"{name}_{axis}" for name in ("position", "velocity", "force") for axis in AXES), "in_contact"]
_LEAST: Final = {"m": 0.05, "k1": 5.0, "k2": 20.0, "b1": 1.0, "b2": 1.0, "Fc": 0.05, "k": 20.0, "b": 1.0}
"""What a number is taken for where less was found of it: one of 0 is left out of a fit."""
_NUMBERS: Final = "static_friction"
"""An effect that is numbers of theta."""
_OF_95: Final = 2.0 * 1.96
"""Standard deviations in an interval of 95 %."""
_WHOLE: Final[Verdict] = "missing_physics"
"""The verdict whose laws are felt: one that explains a part may stand in the place of one that the library lacks."""
_TOO_LITTLE: Final[Verdict] = "insufficient_data"
_ENOUGH: Final[tuple[Verdict, ...]] = "no_mismatch", "parameters"
"""Verdicts that need no law."""


@dataclass(frozen=True)
class LookResult:
    """What one look has come to.

    Attributes:
        verdict: of the diagnosis.
        laws: that are named and may be felt.
        theta: (10,) the numbers beside them; NaN where nothing is to be said of them.
        refused: why others that are named are not felt, a line each.
        sensor: what the force sensor adds, from the time 0 of what was looked at on.
    """

    verdict: Verdict
    laws: tuple[ToldEffect, ...] = ()
    theta: tuple[float, ...] = UNKNOWN_THETA
    refused: tuple[str, ...] = ()
    sensor: SensorError = NO_ERROR

    @property
    def tells(self) -> bool:
        """Whether it names what may be told."""
        return bool(self.laws) or any(self.sensor)

    @property
    def settled(self) -> bool:
        """Whether it says which laws act, be it none; else those that were told before stay."""
        return self.tells or self.verdict in _ENOUGH

    @property
    def status(self) -> LearnerStatus:
        """What a learner shows of it."""
        if self.tells:
            return LearnerStatus.TOLD
        if self.settled:
            return LearnerStatus.WATCHING
        return LearnerStatus.NOT_FELT if self.refused else LearnerStatus.CANNOT_TELL


def look(rows: Array, sample: float, theta: Array, begun: float, executor: Executor) -> LookResult:
    """Hold a contact against the library of effects.

    Args:
        rows: (n, ROW) samples in the table frame.
        sample: time between them [s].
        theta: (10,) numbers of the object, as an estimator without laws has them: whence fits begin.
        begun: time of the first sample, by the clock of who takes off what the sensor adds [s].
        executor: runs the fits.

    Raises:
        MmtError: the contact is none that could be diagnosed.
    """
    # Free space shows the sensor's offset; a moment of it, or a touch by a law that nobody thinks of, would pass for
    # clocks that differ, which here is one.
    touched = int(np.argmax(rows[:, -1] > 0.5))
    found = _looked(rows, sample, theta, begun, executor) if touched * sample >= FREE_S else LookResult(_TOO_LITTLE)
    if found.verdict == _TOO_LITTLE:
        found = _looked(rows[touched:], sample, theta, begun + touched * sample, executor)
    return found


def _looked(rows: Array, sample: float, theta: Array, begun: float, executor: Executor) -> LookResult:
    time: Array = np.arange(len(rows), dtype=np.float64) * sample
    recording = Recording(time, dict(zip(_COLUMNS, rows.T, strict=True)), source="contact")
    held_against = partial(diagnose, [recording], executor=executor, next_motion=False)
    try:
        outcome = held_against(_model(theta))
    except MmtError:  # numbers of a few samples, of what was taken for another object, need not be those of any
        outcome = held_against(_model(np.array(astuple(Prior()))))
    found = answer_of(outcome)
    bias, rate = found.sensor.bias, found.sensor.rate
    return replace(found, sensor=found.sensor._replace(bias=bias - rate * begun))


def _model(theta: Array) -> FlexibleBoxModel:
    """Whence fits begin."""
    m, k1, k2, b1, b2, Fc, k, b = np.fmax(theta[: len(_LEAST)], list(_LEAST.values())).tolist()
    return FlexibleBoxModel(BoxParameters(m, k1, k2, b1, b2, Fc), NormalContact(k, b))


def answer_of(outcome: Outcome) -> LookResult:
    """What may be felt of a diagnosis."""
    found = outcome.diagnosis
    if outcome.best is None or found.verdict not in (*NAMING, *_ENOUGH):
        return LookResult(found.verdict)
    values = outcome.best.hypothesis.effect_values(outcome.best.x)
    sure = [e for e in found.effects if e.certain == "law" and e.name in values] if found.verdict in NAMING else []
    numbers = _numbers(outcome, values.get(_NUMBERS))
    laws: tuple[ToldEffect, ...] = ()
    refused: list[str] = []
    sensor = NO_ERROR
    for effect in sure:
        name = effect.name
        if name == _NUMBERS:
            continue
        more, other = laws, sensor
        try:
            if name in SENSOR:
                other = sensor._replace(**values[name])
            else:  # all its numbers: another message may not know those of the object, by which some are meant
                whole = LIBRARY[name].checked(values[name], box_of(numbers), "learner")
                more = (*laws, ToldEffect(name, whole, _deviations(effect)))
            if found.verdict != _WHOLE:
                raise BadInput("learner", found=f"verdict {found.verdict}", expected=f"{_WHOLE}, which explains it all")
            check_told(ModelMessage(numbers, more, sensor=other), "learner")
            laws, sensor = more, other
        except BadInput as error:
            refused.append(f"{name}: found {error.found}, expected {error.expected}")
    return LookResult(found.verdict, laws, numbers, tuple(refused), sensor)


def _deviations(effect: NamedEffect) -> dict[str, float]:
    """Standard deviations of an effect's numbers, by their 95 % intervals."""
    ends = {symbol: np.ravel(number.ci95) for symbol, number in effect.parameters.items() if number.ci95 is not None}
    return {symbol: float(np.ptp(both)) / _OF_95 for symbol, both in ends.items()}


def _numbers(outcome: Outcome, static: Mapping[str, float] | None) -> tuple[float, ...]:
    """theta of the fit that is delivered, and of the static friction that it may have."""
    assert outcome.best is not None  # as its caller has asked
    bare = outcome.best.hypothesis.handed(outcome.best.x).bare
    assert isinstance(bare, FlexibleBoxModel)  # as it was handed in
    own, normal = bare.parameters, bare.normal
    Fc, Fs, v_d = (own.Fc, own.Fc, 0.0) if static is None else (static["Fd"], static["Fs"], static["v_d"])
    theta = (own.m, own.k1, own.k2, own.b1, own.b2, Fc, normal.k, normal.b, Fs, v_d)
    return tuple(map(float, theta))
