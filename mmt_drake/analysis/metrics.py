"""Errors of rendered and of estimated force, by frequency band and around touches, as `experiment` prints."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import partial
from statistics import median
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from mmt_drake.analysis.lags import Lags, lags
from mmt_drake.analysis.signals import (
    BANDS,
    component,
    contact_time,
    delay_of,
    delayed,
    duration,
    flag,
    in_band,
    mean_step,
    on_even_clock,
    rising,
)
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import THETA
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording.recording import Recording, check_recordings
from mmt_drake.recording.signals import AXES

AFTER_S: Final = 5.0
"""Contact time [s] that passes before errors count: the thesis's wind-up phase."""

TELLING: Final = 0.05
"""Share of a force's RMS from which on a band says something about it."""

SWITCH_WINDOW_S: Final = 0.25
"""Half-width [s] of the window around a touch or release."""

FIRST_S: Final = 0.5
"""Contact time [s] of `error_first_0.5s`."""

TOUCH_S: Final = 0.05
"""Time [s] after each touch of `error_touches`."""

NO_FORCE_N: Final = 1e-6
"""RMS of a reference [N] up to which nothing was there to be rendered: rounding, and less than any sensor sees."""

STAGES: Final = ("error_first_0.5s", "error_rest", "error_touches")
"""Of the rendered force over the whole run: in the first `FIRST_S` of its contact, in all contact after it, and in
the first `TOUCH_S` of every touch."""

Ratios = Mapping[str, float | None]


@dataclass(frozen=True)
class ForceError:
    """RMS(force - reference) / RMS(reference) over some samples of a run.

    Attributes:
        tangential: name of band (`signals.BANDS`) -> ratio, x and y together; None where the reference is no force
            (`NO_FORCE_N`).
        normal: the same for z.
        reference_rms: name of band -> RMS of the reference [N], x and y together: what the ratio is relative to.
            A band that holds next to none of the signal has a ratio that says little.
        normal_reference_rms: the same for z.
        samples: how many samples it was taken over.
    """

    tangential: Ratios
    normal: Ratios
    reference_rms: dict[str, float]
    normal_reference_rms: dict[str, float]
    samples: int

    @property
    def telling(self) -> tuple[str, ...]:
        """Names of the bands that hold enough of the reference, `TELLING` of it, for their ratio to count."""
        whole = self.reference_rms["all"]
        return tuple(name for name, rms in self.reference_rms.items() if rms > 0.0 and rms >= TELLING * whole)

    def to_json(self) -> dict[str, Any]:
        """`{"all": ..., "below_0.3_hz": ..., ..., "z": {"all": ..., ...}}`, ratios as plain numbers or None."""
        return {**self.tangential, "z": dict(self.normal)}


@dataclass(frozen=True)
class Metrics:
    """The figures of one run. An entry is None where the recording lacks the columns it is made of, or nothing counts.

    Attributes:
        rendered_error: rendered force, delayed by the operator-to-telerobot delay, against the measured force.
        rendered_error_true: the same against the plant's force without sensor noise, `true_force_*`.
        estimated_error: psi' theta against `filtered_force_*`, the measured force as the estimator sees it. Both have
            passed the same causal filters.
        estimated_error_raw: psi' theta against the measured force; where that is `force_*`, mostly the filters' delay.
        switch_error: as `rendered_error`, over the samples within `SWITCH_WINDOW_S` of a touch or release, in contact
            or not, after the same contact time.
        between_switches_error: as `rendered_error`, without the samples from one window before a touch or release to
            one window after the rendered force has answered it (or to the next event, where it never did).
        time_to_stable_s: contact time [s] until all eigenvalues are stable and stay so to the end, or None.
        touch: lags of the rendered force at touches (see `lags.lags`).
        release: the same at releases.
        parameters: the last theta of the run, SI units; None per parameter that was never estimated.
        contact_s: contact time of the whole run [s].
        delay_s: the operator-to-telerobot delay [s] that was used.
        stages: name of `STAGES` -> error of the rendered force against the measured one, and, its name ending in
            `_true`, against the plant's force without sensor noise.
        each_touch: of every touch by itself, in the run's order: the ratio along x and y in its first `TOUCH_S`,
            against the plant's force without noise, or else the measured one; None where that is zero. An object
            that is touched for the first time is felt as what is believed beforehand.
    """

    rendered_error: ForceError
    rendered_error_true: ForceError | None
    estimated_error: ForceError | None
    estimated_error_raw: ForceError | None
    switch_error: ForceError | None
    between_switches_error: ForceError | None
    time_to_stable_s: float | None
    touch: Lags
    release: Lags
    parameters: Ratios
    contact_s: float
    delay_s: float
    stages: Mapping[str, ForceError] = field(default_factory=dict)
    each_touch: tuple[float | None, ...] = ()

    @property
    def median_touch_error(self) -> float | None:
        """The median of `each_touch` that are known; None where none is."""
        known = [error for error in self.each_touch if error is not None]
        return median(known) if known else None

    def to_json(self) -> dict[str, Any]:
        """The keys of one case of `experiment --json` that come from its recording; numbers, None, lists and dicts."""
        errors: dict[str, ForceError | None] = {
            field.name: getattr(self, field.name) for field in fields(self) if "_error" in field.name
        }
        errors |= {name + end: self.stages.get(name + end) for end in ("", "_true") for name in STAGES}
        return {
            "delay_s": self.delay_s,
            **{name: None if error is None else error.to_json() for name, error in errors.items()},
            "measured_rms_n": self.rendered_error.reference_rms | {"z": self.rendered_error.normal_reference_rms},
            "contact_s": self.contact_s,
            "time_to_stable_s": self.time_to_stable_s,
            "touch_errors": list(self.each_touch),
            "median_touch_error": self.median_touch_error,
            "touch_lag_s": self.touch.median_s,
            "release_lag_s": self.release.median_s,
            "touch_lags_s": list(self.touch.lags_s),
            "release_lags_s": list(self.release.lags_s),
            "parameters": dict(self.parameters),
        }


def measure(
    recording: Recording, *, delay_s: float | None = None, after_s: float = AFTER_S, measured: str = "force"
) -> Metrics:
    """All figures of one run.

    Errors count where the plant is in contact and has been for `after_s` in all. Bands are filtered over the whole run
    before samples are selected. A recording on an uneven clock is first put on an even one (`signals.on_even_clock`).

    Args:
        recording: needs `in_contact`, `force_*` and `rendered_force_*`; `estimated_force_*` with `filtered_force_*`,
            `true_force_*` and `theta_*` add the figures made of them.
        delay_s: operator-to-telerobot delay [s]; None: as the recording tells it, 0 where it does not.
        after_s: contact time before errors count [s].
        measured: what counts as the measured force: `force`, or `filtered_force`, which is late by the filters.

    Raises:
        BadInput: a needed column is missing or broken, there is no sample in contact after `after_s` of contact, or
            the rate is too low for the bands.
    """
    check_recordings("measure", [recording])
    delay_s = delay_of(recording, delay_s)
    even = on_even_clock(recording)
    step = mean_step(even)
    selected, wound_up = _counted(even, after_s)
    touch, release = lags(even, delay_s)
    near, unsettled = _around_switches(even, touch, release)
    near &= wound_up

    counting = {"counted": selected, **_stages(flag(even, "in_contact"), step)}

    def errors(force: _Force, reference: str, samples: Mapping[str, Flags]) -> dict[str, ForceError]:
        return _errors(force, partial(component, even, reference), samples, 1.0 / step, even.source)

    def rendered(axis: str) -> Array:
        return delayed(component(even, "rendered_force", axis), delay_s, step)

    rendered_errors = errors(rendered, measured, {**counting, "near": near, "settled": selected & ~unsettled})
    true_errors = errors(rendered, "true_force", counting) if even.has_vector("true_force") else {}
    filtered_errors, raw_errors = {}, {}
    if even.has_vector("estimated_force"):
        estimated = partial(component, even, "estimated_force")
        filtered_errors = errors(estimated, "filtered_force", {"counted": selected})
        raw_errors = errors(estimated, measured, {"counted": selected})
    return Metrics(
        rendered_error=rendered_errors["counted"],
        rendered_error_true=true_errors.get("counted"),
        estimated_error=filtered_errors.get("counted"),
        estimated_error_raw=raw_errors.get("counted"),
        switch_error=rendered_errors.get("near"),
        between_switches_error=rendered_errors.get("settled"),
        time_to_stable_s=time_to_stable(even) if "theta_stable" in even else None,
        touch=touch,
        release=release,
        parameters=final_parameters(even),
        contact_s=step * int(np.count_nonzero(flag(even, "in_contact"))),
        delay_s=delay_s,
        stages={name: rendered_errors[name] for name in STAGES if name in rendered_errors}
        | {f"{name}_true": true_errors[name] for name in STAGES if name in true_errors},
        each_touch=_of_each_touch(even, rendered, "true_force" if true_errors else measured, step),
    )


def _stages(contact: Flags, step: float) -> dict[str, Flags]:
    """The samples of each of `STAGES`, (n,)."""
    first: Flags = contact & (contact_time(contact, step) < FIRST_S - step / 2)
    touches = np.zeros(len(contact), dtype=bool)
    for chosen in _touches(contact, step):
        touches[chosen] = True
    return dict(zip(STAGES, (first, contact & ~first, touches), strict=True))


def _touches(contact: Flags, step: float) -> list[NDArray[np.intp]]:
    """Of every touch the samples in contact within its first `TOUCH_S`."""
    starts = np.concatenate([np.flatnonzero(contact[:1]), rising(contact)])
    return [start + np.flatnonzero(contact[start : start + round(TOUCH_S / step)]) for start in starts]


def counted(recording: Recording) -> Flags:
    """The samples that count, (n,): in contact, after `AFTER_S` of accumulated contact, on an even clock.

    Raises:
        BadInput: there is none.
    """
    return _counted(recording, AFTER_S)[0]


def _counted(recording: Recording, after_s: float) -> tuple[Flags, Flags]:
    """The samples that count, and all after as much accumulated contact, (n,) each."""
    after_s = duration(after_s, "after_s")
    step = mean_step(recording)
    contact = flag(recording, "in_contact")
    wound_up: Flags = contact_time(contact, step) >= after_s - step / 2
    selected: Flags = contact & wound_up
    if not selected.any():
        found = f"{step * np.count_nonzero(contact):.4g} s of contact"
        expected = f"more than the {after_s:g} s after which errors count"
        raise BadInput(recording.source, at="in_contact", found=found, expected=expected)
    return selected, wound_up


def time_to_stable(recording: Recording) -> float | None:
    """Contact time [s] until `theta_stable` is set and stays so to the end, on an even clock; None if it never does.

    Raises:
        BadInput: a column is missing or broken.
    """
    unstable = np.flatnonzero(~flag(recording, "theta_stable"))
    first = 0 if unstable.size == 0 else int(unstable[-1]) + 1
    if first == len(recording):
        return None
    return float(contact_time(flag(recording, "in_contact"), mean_step(recording))[first])


def final_parameters(recording: Recording) -> dict[str, float | None]:
    """The last value of every `theta_*` parameter the recording has, SI units; None where it is still NaN."""
    last = {name: float(recording[f"theta_{name}"][-1]) for name in THETA if f"theta_{name}" in recording}
    return {name: None if np.isnan(value) else value for name, value in last.items()}


_Force = Callable[[str], Array]
"""The component of a force, (n,) [N], along an axis, x, y or z. One at a time: an hour's run has to fit."""


def _errors(
    force: _Force, reference: _Force, samples: Mapping[str, Flags], rate: float, source: str
) -> dict[str, ForceError]:
    """Error of a force against a reference, over every selection of samples that is not empty."""
    samples = {name: chosen for name, chosen in samples.items() if chosen.any()}

    def difference(axis: str) -> Array:
        return force(axis) - reference(axis)

    error, scale = (_band_rms(part, samples, rate, source) for part in (difference, reference))
    found = {}
    for name, chosen in samples.items():
        tangential, normal = (_ratios(*pair) for pair in zip(error[name], scale[name], strict=True))
        found[name] = ForceError(tangential, normal, *scale[name], int(np.count_nonzero(chosen)))
    return found


def _band_rms(
    force: _Force, samples: Mapping[str, Flags], rate: float, source: str
) -> dict[str, tuple[dict[str, float], dict[str, float]]]:
    """RMS of a force by band, tangential and normal, over each selection of samples."""
    squares: dict[str, dict[str, dict[str, float]]] = {name: {} for name in samples}
    for axis in AXES:
        values = force(axis)
        for band, edges in BANDS.items():
            part = in_band(values, edges, rate, source)
            for name, chosen in samples.items():
                counted = part[chosen]
                squares[name].setdefault(band, {})[axis] = float(np.mean(np.square(counted, out=counted)))
            del part, counted  # room for the next one
    return {
        name: (
            # The two tangential axes are one signal: their squares are summed, not averaged.
            {band: math.sqrt(mean["x"] + mean["y"]) for band, mean in by_band.items()},
            {band: math.sqrt(mean["z"]) for band, mean in by_band.items()},
        )
        for name, by_band in squares.items()
    }


def _ratios(error: Mapping[str, float], scale: Mapping[str, float]) -> Ratios:
    return {band: error[band] / rms if rms > NO_FORCE_N else None for band, rms in scale.items()}


def _of_each_touch(recording: Recording, rendered: _Force, reference: str, step: float) -> tuple[float | None, ...]:
    """`Metrics.each_touch`, of forces along x and y."""
    forces = [(rendered(axis), component(recording, reference, axis)) for axis in "xy"]
    found: list[float | None] = []
    for chosen in _touches(flag(recording, "in_contact"), step):
        error, size = (
            math.sqrt(sum(float(np.mean(np.square(part))) for part in parts))
            for parts in zip(*((f[chosen] - true[chosen], true[chosen]) for f, true in forces), strict=True)
        )
        found.append(error / size if size > NO_FORCE_N else None)
    return tuple(found)


def _around_switches(recording: Recording, touch: Lags, release: Lags) -> tuple[Flags, Flags]:
    """Samples within a window of a switch; those from a window before it to a window after its answer: (n,) each."""
    time, contact = recording.time, flag(recording, "in_contact")
    lag_of = dict(zip(touch.events_s + release.events_s, touch.lags_s + release.lags_s, strict=True))
    events = time[np.sort(np.concatenate([rising(contact), rising(~contact)]))]
    near, unsettled = np.zeros(len(time), dtype=bool), np.zeros(len(time), dtype=bool)
    for event, following in zip(events, np.append(events, np.inf)[1:], strict=True):
        lag = lag_of.get(float(event), 0.0)  # what came before the first stable theta asked for no answer
        first = event + min(lag or 0.0, 0.0) - SWITCH_WINDOW_S
        last = following if lag is None else event + max(lag, 0.0) + SWITCH_WINDOW_S
        around = slice(*np.searchsorted(time, [event - 2 * SWITCH_WINDOW_S, event + 2 * SWITCH_WINDOW_S]))
        near[around] |= np.abs(time[around] - event) <= SWITCH_WINDOW_S
        unsettled[np.searchsorted(time, first) : np.searchsorted(time, last, side="right")] = True
    return near, unsettled
