"""The document `diagnosis.json`, as values that cannot be changed afterwards.

The order of fields is the order of keys. Keys that users may rely on come first; those with a default are the
diagnosis's own account of how it got there.
"""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Literal, get_args

from mmt_drake.diagnosis.checks.finding import Finding
from mmt_drake.diagnosis.decide.block_replay import BlockReplay
from mmt_drake.diagnosis.decide.budget import BudgetPart
from mmt_drake.diagnosis.decide.depth import Depth
from mmt_drake.diagnosis.decide.mismatch import Mismatch
from mmt_drake.diagnosis.decide.verdict import NAMING, Verdict
from mmt_drake.diagnosis.fit.errors import Interval
from mmt_drake.errors import BadInput

SCHEMA: Final = "mmt_drake.diagnosis/2"
TABULATED: Final = "tabulated_force"
_ROUNDING = 1e-9
_UNTOLD: Final[Mapping[str, bool]] = {"document": False}  # of a field that is not in the document

Status = Literal["accepted", "rejected", "ambiguous", "at a bound"]
Values = tuple[float, ...]


@dataclass(frozen=True)
class EffectParameter:
    """One number of an effect, as found.

    Attributes:
        value: SI units; a list for the columns `at` and `value` of a `tabulated_force`, text for its `of`.
        unit: of the value.
        ci95: 95 % interval (low, high), or a list of lows and one of highs; None where it is unknown.
    """

    value: float | str | Values
    unit: str
    ci95: tuple[float | Values, float | Values] | None = None

    @property
    def ends(self) -> Interval | None:
        """The interval of a single number; None where that is unknown, or the value is a list."""
        low, high = self.ci95 or (None, None)
        return (low, high) if isinstance(low, float) and isinstance(high, float) else None


@dataclass(frozen=True)
class NamedEffect:
    """Physics that the model left out.

    Attributes:
        name: in the library of effects.
        family: of laws that it belongs to.
        block: friction, contact, body, force_sensor or channel; for a learned table the block it was found in.
        certain: how deep the name holds: every explanation that is not ruled out has this law, one of its family, or
            one in its block. None where not even the block is sure, and for a learned table.
        parameters: symbol -> what was found.
        axis: z where it acts along the surface normal of an object that moves along others too; else nothing.
    """

    name: str
    family: str
    block: str
    certain: Depth | None
    parameters: Mapping[str, EffectParameter]
    axis: str = ""


@dataclass(frozen=True)
class Alternative:
    """Another explanation that was not ruled out, or an equal one that no such recording can rule out.

    Attributes:
        name: of the effect; a set of several is written `one + other`.
        heldout_nrmse: error on held-out data with this instead of `Diagnosis.effects`; None where it was not fitted.
        indistinguishable: whether the recording cannot tell it from `Diagnosis.effects`.
        reason: why not, or by how much it is behind, in a sentence.
    """

    name: str
    heldout_nrmse: float | None
    indistinguishable: bool
    reason: str = ""


@dataclass(frozen=True)
class FittedParameter:
    """A structural parameter whose interval excludes its nominal value; SI units."""

    nominal: float
    value: float
    unit: str
    ci95: Interval | None


@dataclass(frozen=True)
class FittedCurve:
    """A number that is a curve over something recorded beside the motion, or free per recording (`mmt_drake.over`).

    Attributes:
        number: symbol of the structure, or `effect.symbol`.
        over: the column, or `recording`.
        at: knots, in the unit of the column, or names of recordings.
        nominal: at each, as handed in; None for an effect that was found.
        value: at each.
        unit: of the values.
        ci95: lows and highs of the 95 % intervals; None where one is unknown.
    """

    number: str
    over: str
    at: tuple[float | str, ...]
    nominal: Values | None
    value: Values
    unit: str
    ci95: tuple[Values, Values] | None


@dataclass(frozen=True)
class HeldoutNrmse:
    """Errors on held-out data, RMS over the measured signal's standard deviation; None where nothing was fitted."""

    nominal: float | None
    refit: float | None
    augmented: float | None


@dataclass(frozen=True)
class AxisFit:
    """The same as `Fit` says of all axes, of one alone, over the standard deviation of what was measured along it.

    Attributes:
        axis: x, y or z.
        noise_floor: see `Fit`.
        heldout_nrmse: see `Fit`.
        mismatch: its share, 0 to 1, of what a refit leaves beyond the noise; None where there is no mismatch.
    """

    axis: str
    noise_floor: float
    heldout_nrmse: HeldoutNrmse
    mismatch: float | None = None


@dataclass(frozen=True)
class Fit:
    """How well each model predicts what it was not fitted to.

    Attributes:
        axes: axes that moved, the one along the surface normal included; empty for a single axis or a driven body.
        heldout_s: held-out blocks (from, to) [s].
        noise_floor: what sensor noise alone leaves, in the unit of `heldout_nrmse`.
        heldout_nrmse: of the model handed in, of the same with parameters fitted, and of that with its effects; over
            windows from states fitted in lead-ins that are not scored.
        heldout_nrmse_free: the same free-running from the first sample; None each where that diverges.
        window_s: length of a window [s], its lead-in apart: the whole recording where the model allows.
        by_axis: noise and errors of each of the axes.
        spread: standard deviation of what was measured on those blocks, in `unit`: times an error of `heldout_nrmse` it
            is the RMS error; None where it is unknown. Not in the document, and neither is `unit`.
        unit: of the output.
    """

    axes: tuple[str, ...]
    heldout_s: tuple[Interval, ...]
    noise_floor: float | None
    heldout_nrmse: HeldoutNrmse
    heldout_nrmse_free: HeldoutNrmse | None = None
    window_s: float | None = None
    by_axis: tuple[AxisFit, ...] = ()
    spread: float | None = field(default=None, metadata=_UNTOLD)
    unit: str = field(default="", metadata=_UNTOLD)

    def rms(self, nrmse: float) -> float | None:
        """An error of `heldout_nrmse` as RMS in `unit`; None where the spread is unknown."""
        return None if self.spread is None else nrmse * self.spread


@dataclass(frozen=True)
class Candidate:
    """An explanation that was tried.

    Attributes:
        names: its effects.
        heldout_nrmse: error on held-out data; None where it was scored but not fitted.
        delta: by how much smaller that is than without it (than `HeldoutNrmse.refit`); negative is worse.
        p_value: probability that it is as good as the best and looks worse by chance; None where it was not compared.
        status: what became of it.
        reason: why, in a sentence.
    """

    names: tuple[str, ...]
    heldout_nrmse: float | None
    delta: float | None
    p_value: float | None
    status: Status
    reason: str = ""


@dataclass(frozen=True)
class Diagnosis:
    """The verdict and what it rests on; see each field's class.

    Attributes:
        verdict: one of `Verdict`.
        summary: one paragraph a person can act on.
        budget: what the error of the model handed in is made of; empty where nothing was fitted.
        next_recording: what to record so that what is still ambiguous is settled.
        model: the augmented model's file, beside the document; None where there is none.
        curves: numbers that are free over something recorded, whether they differ from nominal or not.
        preflight: what the check before the diagnosis saw.
        candidates: the best of what was tried, best first.
        tried: how many sets of effects were tried.
        untried: effects, and sets of so many effects, that there was no time for; `further_NAME` is one
            more of the kind of NAME.
        recordings: names of the recordings.
        further_fits: of the recordings after the first, in their order, what `fit` says of the first.
        replays: of every block of a whole station, if that was asked for, how far it is from its replay.
        first_model: file of the model handed in, where that was fitted to the recordings first.
        seconds: what it took.
        at_bounds: parameters that the fit without effects drove as far as it may; not in the document.

    Raises:
        BadInput: the verdict contradicts the effects: a name without a verdict that names (but for a learned table),
            none with one of these, no alternative to an `ambiguous` one; or the shares of the budget are no shares.
    """

    verdict: Verdict
    summary: str
    budget: tuple[BudgetPart, ...] = ()
    effects: tuple[NamedEffect, ...] = ()
    alternatives: tuple[Alternative, ...] = ()
    parameters: Mapping[str, FittedParameter] = field(default_factory=dict)
    mismatch: Mismatch = field(default_factory=Mismatch)
    fit: Fit | None = None
    next_recording: str | None = None
    model: str | None = None
    curves: tuple[FittedCurve, ...] = ()
    preflight: tuple[Finding, ...] = ()
    candidates: tuple[Candidate, ...] = ()
    tried: int = 0
    untried: tuple[str, ...] = ()
    recordings: tuple[str, ...] = ()
    further_fits: tuple[Fit, ...] = ()
    replays: tuple[BlockReplay, ...] = ()
    first_model: str | None = None
    seconds: float | None = None
    at_bounds: tuple[str, ...] = field(default=(), metadata=_UNTOLD)

    def __post_init__(self) -> None:
        if self.verdict not in get_args(Verdict):
            raise BadInput("diagnosis", at="verdict", found=self.verdict, expected=", ".join(get_args(Verdict)))
        names = [effect.name for effect in self.effects]
        shown = ", ".join(names) or "none"
        if self.verdict in NAMING:
            if not names:
                raise BadInput("diagnosis", at="effects", found="none", expected=f"one or more for {self.verdict}")
        elif self.verdict == "unexplained":
            if set(names) - {TABULATED}:
                raise BadInput("diagnosis", at="effects", found=shown, expected=f"none or {TABULATED} for unexplained")
        elif names:
            raise BadInput("diagnosis", at="effects", found=shown, expected=f"none for {self.verdict}")
        if self.verdict == "ambiguous" and not self.alternatives:
            raise BadInput("diagnosis", at="alternatives", found="none", expected="one or more for ambiguous")
        shares = [part.share for part in self.budget]
        if shares and (min(shares) < 0.0 or abs(math.fsum(shares) - 1.0) > _ROUNDING):
            found = ", ".join(f"{part.part} {part.share:g}" for part in self.budget)
            raise BadInput("diagnosis", at="budget", found=found, expected="shares of 0 or more that sum to 1")

    def __repr__(self) -> str:
        names = " + ".join(effect.name for effect in self.effects)
        return f"Diagnosis({self.verdict}{': ' if names else ''}{names})"

    def _repr_html_(self) -> str:
        from mmt_drake.diagnosis.tell.in_notebook import as_html  # which reads this class

        return as_html(self)

    def to_json(self) -> dict[str, Any]:
        """The document as plain data, keys in the order of the contract.

        Raises:
            BadInput: a number is not finite.
        """
        return {"schema": SCHEMA, **_plain(self, "diagnosis")}


def _plain(value: object, source: str, at: str = "") -> Any:
    """What `json.dump` takes: dataclasses and mappings as dictionaries in their order, tuples as lists.

    Raises:
        BadInput: a number is not finite, or a value is of a kind that JSON does not have.
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        names = (one.name for one in dataclasses.fields(value) if one.metadata.get("document", True))
        return {name: _plain(getattr(value, name), source, _below(at, name)) for name in names}
    if isinstance(value, Mapping):
        return {str(key): _plain(item, source, _below(at, str(key))) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(item, source, f"{at}[{i}]") for i, item in enumerate(value)]
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, int | float) and math.isfinite(value):
        return int(value) if isinstance(value, int) else float(value)  # numpy's float64 is a float
    raise BadInput(source, at=at or None, found=repr(value), expected="a finite number, text, a flag or null")


def _below(at: str, key: str) -> str:
    return f"{at}.{key}" if at else key
