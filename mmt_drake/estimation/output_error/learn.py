"""How new samples change what the estimator knows."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import ThreadpoolController

from mmt_drake.errors import MmtError, attempt
from mmt_drake.estimation.output_error.adequacy import TOO_MUCH, Adequacy, ModelStatus, is_unexcited, left_of_latest
from mmt_drake.estimation.output_error.along_normal import said_along_normal, with_normal_axis
from mmt_drake.estimation.output_error.beginning import Beginning
from mmt_drake.estimation.output_error.fit import Objective, comparable
from mmt_drake.estimation.output_error.knowledge import FIRST_NOISE, Knowledge
from mmt_drake.estimation.output_error.meeting import first_guess, put_away
from mmt_drake.estimation.output_error.options import OutputErrorOptions, check_told
from mmt_drake.estimation.output_error.sensor_error import corrected
from mmt_drake.estimation.output_error.smoothing import FilterBank, filter_bank
from mmt_drake.estimation.output_error.trials import better_stick, placed_anew, start_elsewhere
from mmt_drake.estimation.output_error.unknowns import (
    LATENESS,
    NORMAL_DEVIATION,
    OBJECT,
    SIZE,
    UNKNOWNS,
    Information,
    Stick,
    prior_information,
    unknowns,
)
from mmt_drake.estimation.output_error.unsure_touches import since_touch
from mmt_drake.estimation.output_error.window import MOTION_GOOD, STAMP, Window
from mmt_drake.model.held_body import NO_REPORT, report
from mmt_drake.model.message_layout import MESSAGE_NUMBER, OF_SENSOR
from mmt_drake.model.plane_call import planar
from mmt_drake.model.scene_layout import LOOKS
from mmt_drake.model_message import ModelMessage
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.least_squares import Minimum
from mmt_drake.told_laws import ALONG_NORMAL, told_by_bytes, without_effect

_FITS_PER_WINDOW = 75  # a window is fitted so often in the time that it covers, or each period: cost stays even
_DROPPED = 0.2  # share of a full window that is let go at once
_SHORT_S = 3.0  # a window is fitted with more steps at a time as long as it is shorter
_MOST_MOVED = 1.0  # of its size, by which an unknown is moved by the noise of the motion at most
_REST_S = 1.5  # is kept of samples that say nothing
_STICK_AFTER_S = 1.5  # of contact: static friction is not looked for before
_STICKS = 3  # that are tried with each fit
_PATIENCE = 6  # fits that a rival is given to become better
_ANEW = 8  # steps of a fit to what may be another object
_GOOD = 2.0  # times the noise, that another object must explain it to
_ENOUGH_S = 0.15  # of contact, from which on what the height of the surface makes unsure can be done without
_BEFORE_S = 0.2  # of what is fitted so that may still be of the one before
_BETTER, _FEWER = 0.97, 20.0  # what it has to bring the sum of squares down to


class Learner:
    """Makes knowledge of samples; itself it keeps nothing.

    Args:
        options: of the estimator.
    """

    def __init__(self, options: OutputErrorOptions) -> None:
        self.options = options
        self.h = options.interval
        self._bank: FilterBank = filter_bank(self.h, options.ticks)
        self._capacity = round(options.window / self.h)
        self._threads = ThreadpoolController()
        self._planar = planar(options.in_plane)

    def beginning(self) -> Knowledge:
        """Nothing but the prior."""
        prior = self.options.prior
        known = prior_information(prior, None)
        return Knowledge(
            window=Window.empty(),
            start=Beginning.at_rest(),
            x=known.mean(),
            stick=Stick(),
            normal=np.array([prior.normal_k, prior.normal_b]),
            memory=Information.none(),
            normal_memory=Information.none(2),
            noise=FIRST_NOISE,
            noise_slope=np.zeros(UNKNOWNS),
            noise_share=np.zeros(UNKNOWNS),
            covariance=known.covariance(),
            normal_covariance=np.diag(NORMAL_DEVIATION**2),
            held=NO_REPORT,
            model=self.options.model,
        )

    def learned(self, known: Knowledge, new: Array, broken: bool = False) -> Knowledge:
        """Knowledge with new samples.

        Args:
            known: what there is.
            new: (k, SAMPLE_SIZE), in their order.
            broken: whether time broke off between what was known and the new samples.
        """
        if broken:
            known = self._interrupted(known)
        if len(new) == 0:
            return known
        new = corrected(new, known.model)
        if len(known.window) == 0:
            if known.interrupted:
                new = new.copy()
                new[0, MOTION_GOOD] = 0.0  # as after any gap, the body has to settle
            else:
                known = replace(known, start=Beginning.at_rest(new[0, :2]))
        window = known.window.extended(new, self.h, self._bank)
        known = replace(known, window=window, fresh=known.fresh + len(new))
        capacity = self._capacity
        if known.rests:  # fits are quick without it
            capacity = min(capacity, round(_REST_S / self.h))
        if len(window) > capacity:
            known = self._shortened(known, round(_DROPPED * capacity) + len(window) - capacity - 1)
        if not known.window.weight[-known.fresh :].any() or known.fresh * _FITS_PER_WINDOW < len(known.window):
            return known
        with self._threads.limit(limits=1, user_api="blas"):  # a second one costs more than it brings
            return self._fitted(self._with_normal_axis(known))

    def met(self, known: Knowledge, thing: int, looks: Sequence[float]) -> Knowledge:
        """Knowledge where the probe is at an object: what there is of it, or else a first guess by its looks.

        What is known of the one before is kept without its samples, and taken up again when that is met again. `thing`
        is the object's identity, 0 where nobody knows and nothing changes; `looks` as `first_guess`.
        """
        if thing in (0, known.thing):
            return known
        left = self._shortened(known, len(known.window)) if len(known.window) else known
        others = {**known.others, known.thing: put_away(left)}
        if thing in others:
            return replace(others.pop(thing), others=others)
        nothing = self.beginning()
        return first_guess(nothing, self._prior(nothing), thing, looks, others)

    def retold(self, known: Knowledge, model: Array) -> Knowledge:
        """Knowledge where object or force sensor are told to be of other laws: the samples at hand are fitted anew.

        What older ones said was said of another model, and goes. An older message than that of `known` changes nothing,
        one (MESSAGE_SIZE,) that tells the same of both its number alone.

        Raises:
            BadInput: the message is none, or tells a law that is not known or that cannot stand beside what is sought.
        """
        message = ModelMessage.from_vector(model)
        if message is None or message.number <= known.model[MESSAGE_NUMBER]:
            return known
        check_told(message, "model message")
        if np.array_equal(model[OF_SENSOR.start :], known.model[OF_SENSOR.start :], equal_nan=True):
            return replace(known, model=model)
        samples = corrected(known.window.samples, model, known.model)
        window, start, memory = replace(known.window, samples=samples), known.start, known.memory
        if memory.matrix.any():  # where another model has left the body is not known that well
            window = window.not_compared(round(_BEFORE_S / self.h))
            start, memory = Beginning.known(start.of(known.x)), self._prior(known).plus(memory).only(LATENESS)
        x, stick, theta = known.x, Stick(), np.array(message.theta)
        if np.isfinite(theta).all():
            x, stick = np.concatenate([unknowns(theta)[OBJECT], x[LATENESS]]), Stick.of(theta)
        if message.sensor.tau > 0.0:
            x = np.concatenate([x[OBJECT], [message.sensor.tau, 1.0]])
        anew = known.of_another(
            window=window, start=start, x=x, stick=stick, memory=memory, adequacy=Adequacy(), trusted=None, model=model
        )
        if any(told_by_bytes(one.tobytes())[ALONG_NORMAL] for one in (model, known.model)):
            anew = replace(anew, normal_memory=Information.none(2))
        if len(window) == 0:
            return anew
        anew = self._with_normal_axis(anew)
        objective = self._objective(anew)
        starts = x, self._prior(anew).mean()  # the numbers so far may be those of an object that has no such law
        found = (attempt(placed_anew, objective, begun, anew.stick, _ANEW) for begun in starts)
        best = min((each for each in found if each is not None), key=lambda each: each[1].cost, default=None)
        if best is None:
            return anew
        start, minimum = best
        return replace(anew, start=start, x=minimum.x, noise=objective.noise_left(minimum), held=NO_REPORT)

    def _with_normal_axis(self, known: Knowledge) -> Knowledge:
        """With the normal axis of the samples at hand, as it was where a law along it is too fast for them."""
        return attempt(with_normal_axis, known, self.options.prior, self.h, self._surface(known.window)) or known

    def _with_held_body(self, known: Knowledge, objective: Objective) -> Knowledge:
        """With what the fit says of where friction holds the body at the last sample."""
        last = known.window.samples[-1]
        if known.window.contact[-1] == 0.0 or last[MOTION_GOOD] == 0.0 or not math.isfinite(last[STAMP]):
            return known
        end = attempt(objective.end, known.x, known.stick, len(known.window) - 1)
        return known if end is None else replace(known, held=report(known.held, end, last[STAMP]))

    def _interrupted(self, known: Knowledge) -> Knowledge:
        """Knowledge with which to go on after time broke off: what the samples said, and where they left the body."""
        count = len(known.window)
        if count == 0:
            return known
        end = self._beginning(known, count - 1)
        start = known.start if end is None else end
        known = self._shortened(known, count)
        return replace(known, window=Window.empty(), start=start, fresh=0, interrupted=True)

    def _beginning(self, known: Knowledge, count: int) -> Beginning | None:
        """Where the body is at sample `count`; None where that cannot be simulated."""
        deviation = np.sqrt(np.diag(known.covariance))
        return attempt(self._objective(known).beginning_after, known.x, known.stick, count, deviation)

    def compile(self) -> None:
        """Compile what a fit calls."""
        known = self.beginning()
        self._objective(known).difference(known.x, known.stick)
        since_touch(0.0, 0.0)
        self.met(known, 1, (1.0,) * LOOKS)

    def _surface(self, window: Window) -> float:
        """Standard deviation of the height of the surface [m]; 0 as long as nothing else is there to learn from."""
        return (self.options.surface or 0.0) if float(window.contact.sum()) * self.h > _ENOUGH_S else 0.0

    def _prior(self, known: Knowledge) -> Information:
        normal = known.normal if known.normal_covariance[0, 0] < 0.5 * NORMAL_DEVIATION[0] ** 2 else None
        return prior_information(self.options.prior, normal)

    def _objective(self, known: Knowledge) -> Objective:
        return Objective(
            known.window,
            self.h,
            self.options.ticks,
            known.start,
            self._prior(known).plus(known.memory),
            known.noise,
            self._planar,
            -float(np.count_nonzero(comparable(known.window, self.h)[:, :2])) / known.noise**2 * known.noise_slope,
            np.isfinite(known.noise_share) & known.rests,
            told_by_bytes(known.model.tobytes()),
            known.normal,
            (known.x, known.stick),
        )

    def _fitted(self, known: Knowledge) -> Knowledge:
        objective = self._objective(known)
        steps = 3 if len(known.window) < _SHORT_S / self.h else 1
        minimum = attempt(objective.step, known.x, known.stick, steps)
        if minimum is None:
            return self._with_held_body(replace(known, fresh=0), objective)
        numbers = range(known.fits * _STICKS, (known.fits + 1) * _STICKS)
        if objective.compared * self.h < 2.0 * _STICK_AFTER_S:
            numbers = range(0)
        stick, minimum = better_stick(objective, minimum, known.stick, numbers)
        found = replace(
            self._with_noise_of_motion(known, objective, minimum, stick),
            x=minimum.x,
            stick=stick,
            noise=objective.noise_left(minimum),
            covariance=self._covariance(known, objective, minimum, stick),
            fits=known.fits + 1,
            fresh=0,
        )
        found = self._judged(found, known.fresh, objective.left(minimum))
        if found.adequacy.may_have_changed and (other := self._of_another(found)) is not None:
            return self._with_held_body(other, self._objective(other))
        return self._with_held_body(self._challenged(found, minimum.cost, objective, steps), objective)

    def _covariance(self, known: Knowledge, objective: Objective, minimum: Minimum, stick: Stick) -> Array:
        found = objective.covariance(minimum)
        further = attempt(objective.unexcited_beside, minimum, stick, found, self._prior(known))
        return found if further is None else further

    def _with_noise_of_motion(
        self, known: Knowledge, objective: Objective, minimum: Minimum, stick: Stick
    ) -> Knowledge:
        """With what noise on the motion adds, found anew every second fit.

        Each time for the lateness and one number of the object; for all of these while the window is short. Stiff
        objects pass more noise on. So numbers that are too stiff as yet would become stiffer, fit by fit: while the
        window is short, no unknown is moved far by this.
        """
        if stick.speed > 0.0:  # a body that lets go at another time is no small noise
            return replace(known, noise_slope=np.zeros(UNKNOWNS), noise_share=np.zeros(UNKNOWNS))
        turn, other = divmod(known.fits, 2)
        if short := len(known.window) < _SHORT_S / self.h:
            numbers = [*range(UNKNOWNS)]
        else:
            numbers = [turn % LATENESS.start, *range(LATENESS.start, LATENESS.stop)]
        found = None if other else attempt(objective.slope_of_noise, minimum.x, stick, numbers)
        if found is None or objective.compared == 0:
            return known
        slope, share = known.noise_slope.copy(), known.noise_share.copy()
        slope[numbers], share[numbers] = found[0] / objective.compared, found[1]
        if short:
            moved = objective.inverse(minimum.jacobian) @ slope * objective.compared / objective.noise**2
            slope *= min(1.0, _MOST_MOVED / max(float(np.abs(moved / SIZE).max()), 1e-300))
        return replace(known, noise_slope=slope, noise_share=share)

    def _judged(self, known: Knowledge, fresh: int, difference: Array) -> Knowledge:
        """Knowledge of what is to be thought of it.

        Args:
            known: of a fit.
            fresh: how many samples are new.
            difference: that the fit leaves [N].
        """
        window = known.window
        left = left_of_latest(window, difference, known.theta, self.h)
        contact = float(np.count_nonzero(window.weight[-fresh:, :2].any(axis=1))) * self.h
        idle = without_effect(told_by_bytes(known.model.tobytes()))
        unexcited = is_unexcited(known.covariance, self._prior(known), idle)
        adequacy = known.adequacy.after(left, contact, unexcited)
        trusted = (known.x, known.stick) if left <= TOO_MUCH else known.trusted
        return replace(known, adequacy=adequacy, trusted=trusted)

    def _of_another(self, known: Knowledge) -> Knowledge | None:
        """Knowledge of the latest contact alone, if that explains it: the object is another one. Else None."""
        window = known.window
        doubted = np.cumsum(window.weight[::-1, :2].any(axis=1)) * self.h
        count = len(window) - int(np.searchsorted(doubted, known.adequacy.doubted)) - 1
        if known.trusted is None or count <= 0:
            return None
        x, stick = known.trusted
        before = self._objective(known)
        start = attempt(before.end, x, stick, count)  # where the object before has left the body
        said = attempt(before.said, x, stick, count)
        if start is None or said is None:
            return None
        part = window.shortened(count).not_compared(round(_BEFORE_S / self.h))  # when it was is not known that well
        alone = known.of_another(
            window=part,
            start=Beginning.known(start),
            stick=stick,
            memory=before.known.plus(said).only(LATENESS),  # the sensor is the same
            normal_memory=Information.none(2),
        )
        objective = self._objective(alone)
        starts = x, known.x, start_elsewhere(self._prior(alone), known.fits, part.largest_force())
        found = (attempt(objective.step, begun, stick, _ANEW) for begun in starts)
        best = min((minimum for minimum in found if minimum is not None), key=lambda m: m.cost, default=None)
        if best is None:
            return None
        alone = replace(alone, x=best.x, noise=objective.noise_left(best), covariance=objective.covariance(best))
        left = left_of_latest(part, objective.left(best), alone.theta, self.h)
        return replace(alone, adequacy=Adequacy(ModelStatus.CHANGED, left)) if left <= _GOOD else None

    def _challenged(self, known: Knowledge, cost: float, objective: Objective, steps: int) -> Knowledge:
        """Friction makes valleys in the least squares: as long as much is unexplained, another search goes on.

        It begins without static friction, which fits what is wrong otherwise and then keeps it there.
        """
        if known.rests or known.noise <= known.window.unexplained():
            return replace(known, rival=None)
        number, age = known.tried
        prior = self._prior(known)
        rival = known.rival
        if rival is None:
            rival = start_elsewhere(prior, number, known.window.largest_force())
        alone = replace(objective, known=prior, start=Beginning.known(known.start.of(known.x)))
        minimum, without = attempt(alone.step, rival, Stick(), steps + 1), replace(known, rival=None)
        if minimum is not None and minimum.cost < _BETTER * cost - _FEWER:
            noise, covariance = alone.noise_left(minimum), alone.covariance(minimum)
            without = replace(
                without,
                start=alone.start,
                x=minimum.x,
                stick=Stick(),
                memory=Information.none(),
                noise=noise,
                covariance=covariance,
            )
        elif minimum is not None and age < _PATIENCE:
            return replace(known, rival=minimum.x, tried=(number, age + 1))
        return replace(without, tried=(number + 1, 0))

    def _shortened(self, known: Knowledge, count: int) -> Knowledge:
        """Let the first `count` samples go and keep what they say."""
        fade = math.exp(-count * self.h / self.options.memory)
        memory, normal = known.memory.faded(fade), known.normal_memory.faded(fade)
        objective = self._objective(known)
        start = known.start
        try:
            memory = memory.plus(objective.said(known.x, known.stick, count))
            normal = normal.plus(said_along_normal(known, self.h, slice(count), self._surface(known.window)).numbers)
            if count < len(known.window):
                start = self._beginning(known, count) or start
        except MmtError:
            pass
        return replace(known, window=known.window.shortened(count), start=start, memory=memory, normal_memory=normal)
