"""Diagnosis of an arm: from logs and a model to what its physics leaves out, joint by joint."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from mmt_drake.arms.arm_file import INERTIA, INERTIA_UNITS, ArmModel, JointEffect
from mmt_drake.arms.base_parameters import BaseStructure
from mmt_drake.arms.beliefs import AS_THE_FILE_SAYS, OTHER_LINKS, WHOLE_ARM, Believed, again, settled
from mmt_drake.arms.believed import check_places, of_the_plant, prepared, with_damping
from mmt_drake.arms.conclusion import notes_of, verdict_of, whole_budget, with_look_alikes
from mmt_drake.arms.consistency import nearest_consistent
from mmt_drake.arms.elasticity import Deflection, deflections
from mmt_drake.arms.forward import forward
from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.laws import ARM_EFFECTS
from mmt_drake.arms.motion import ArmMotion, gaps
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.arms.problem import Term, problem_of
from mmt_drake.arms.result import ArmDiagnosis, ArmEffectFound, JointReport, Number
from mmt_drake.arms.shared_fit import SharedFit
from mmt_drake.arms.signs import check_signs, check_units
from mmt_drake.arms.verdict import (
    LEAVES,
    Certainty,
    arm_certainty,
    certainty,
    forbidden,
    joint_budget,
    outstanding,
    without,
    without_idle_numbers,
)
from mmt_drake.arms.wording import summary
from mmt_drake.diagnosis.decide.budget import BudgetPart
from mmt_drake.diagnosis.search.watch import OnAnswer, OnStage, Watch
from mmt_drake.diagnosis.signals.noise import noise_of
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array

_SKEW_S = 1e-4
"""Of two encoders, that is told."""
SEARCHING = 0.6
"""Share of the time budget for the search; the rest is for how sure its names are."""


def diagnose_arm(
    logs: Sequence[JointLog],
    model: ArmModel,
    *,
    on_stage: OnStage = lambda _: None,
    on_answer: OnAnswer = lambda _: None,
    time_budget: float = math.inf,
) -> ArmDiagnosis:
    """Say whether a model explains logs of an arm, and if not, what physics it leaves out.

    Args:
        logs: of one arm.
        model: what the simulation believes in.
        on_stage: called with what is being done, and what comes after it.
        on_answer: called once, with what is known when every joint has been searched beside the links as they are.
        time_budget: how long it may look for effects [s]; what it had no time for is listed (`ArmDiagnosis.untried`).
            Every joint is searched beside the links as they are, however long that takes.

    Raises:
        BadInput: the logs are none of this arm, too short, nothing moves in them, or torques have the other sign.
        Interrupted: a KeyboardInterrupt, with what was known by then.
    """
    if not logs:
        raise BadInput("recordings", found="none", expected="one or more logs of joints")
    watch = Watch(_STAGES, on_stage, time_budget, on_answer)
    with threadpool_limits(limits=1, user_api="blas"):  # matrices are small: threads would only wait for each other
        try:
            return _diagnosed(logs, model, watch)
        except KeyboardInterrupt:
            raise watch.interrupted() from None


def _diagnosed(logs: Sequence[JointLog], model: ArmModel, watch: Watch) -> ArmDiagnosis:
    begun = time.perf_counter()
    arm = ArmPlant.of(model)
    check_places(arm, model)
    model = with_damping(arm, model)
    for log in logs:
        check_units(arm, log)
    watch.begin(_MOTION)
    prepared_logs = [prepared(arm, model, log) for log in logs]
    problem = problem_of(arm, model, prepared_logs)
    check_signs(problem, logs[0].source)
    noise = np.mean([_noise(log, model.band_hz) for log in logs], axis=0)
    with watch.within(SEARCHING):
        found, tried = settled(problem, watch, noise)
        if found.fit.numbers_of_links or any(of_the_plant(t.effect) for t, _ in found.fit.numbers_held):
            # What acts on the torque that moves the links is read on the links as they were found.
            links, whole = _consistent(found.fit, found.fit.fitted(problem.inner), problem.inner)
            moving = model.with_found(_merged(arm, model, found.fit, whole), links)
            problem = problem_of(arm, model, [one.moving(arm, moving, model) for one in prepared_logs], problem.delay)
            found = again(found, problem, watch)
    found = without_idle_numbers(found)
    every = list(range(len(problem.starts)))
    watch.begin(_CONSISTENT)
    links, whole = _consistent(found.fit, found.fit.fitted(every), every)
    while (idle := forbidden(found, whole)) is not None:  # beside links that a real arm can have
        found = without(found, *idle)
        links, whole = _consistent(found.fit, found.fit.fitted(every), every)
    x, half = found.fit.fitted(problem.inner), found.fit.deviations(found.fit.fitted(every), every)
    watch.begin(_SURE)
    told = {j: outstanding(found.fit, j, x, certainty(problem, found, j, watch), float(noise[j])) for j in found.sets}
    refits = [b for b in tried if b.fit.belief.name == "refit"]
    links_alone = replace(min(refits or tried, key=lambda b: b.cost).fit, sets={})
    refit = links_alone.errors(links_alone.fitted(problem.inner), problem.outer)
    joints = tuple(
        _joint(found.fit, x, j, told.get(j, []), float(refit[j]), float(noise[j])) for j in range(len(arm.joints))
    )
    joints = joints if refits else tuple(replace(joint, refit=None) for joint in joints)
    budget = whole_budget(joints)
    effects = _effects(arm, model, found, tried, told, whole, half, joints, budget)
    augmented = model.with_found(_merged(arm, model, found.fit, whole), links)
    verdict = verdict_of(found, joints, effects, budget)
    parameters, untold = _parameters(found.fit, links, whole, half, every)
    left = np.array([joint.augmented * joint.spread for joint in joints])
    base = BaseStructure.of(arm, problem.nominal).told([ArmMotion.of(log, model.band_hz) for log in logs], left)
    springs = _springs(arm, augmented, logs)
    effects, augmented = _with_springs(with_look_alikes(effects, problem), augmented, [effect for _, effect in springs])
    watch.begin(_AHEAD)
    held_out = [(a, b) for a, b, log in problem.starts[problem.outer] if log == 0.0]
    ahead = None
    if watch.is_late():
        watch.miss([_AHEAD])
    else:
        ahead = forward(model, logs[0], held_out), forward(augmented, logs[0], held_out)
    diagnosis = ArmDiagnosis(
        verdict,
        "",
        joints,
        effects,
        parameters,
        untold,
        budget,
        tuple((float(a), float(b), int(log)) for a, b, log in problem.starts[problem.outer]),
        augmented,
        tuple(log.source for log in logs),
        round(time.perf_counter() - begun, 2),
        ahead,
        found.fit.belief.name,
        (*notes_of(found, problem, effects, model.factor), *_encoders(arm, springs), *_gaps(logs, model.band_hz)),
        base,
        watch.missed,
    )
    return replace(diagnosis, summary=summary(diagnosis))


_MOTION, _CONSISTENT = "motion and regressor", "numbers that a real arm can have"
_SURE, _AHEAD = "how sure each name is", "windows of forward simulation"
_STAGES = (_MOTION, AS_THE_FILE_SAYS, OTHER_LINKS, WHOLE_ARM, _CONSISTENT, _SURE, _AHEAD)


def _noise(log: JointLog, band_hz: float) -> Array:
    """Mean squared noise of each joint's torque in the band, were it as loud there as just above it [(N m)^2]."""
    rate = 1.0 / float(np.median(np.diff(log.time)))
    even = np.arange(log.time[0], log.time[-1], 1.0 / rate)
    columns = [np.interp(even, log.time, column) for column in log.torque.T]
    return np.array([noise_of(column, rate).above(band_hz).density * band_hz for column in columns])


def _consistent(fit: SharedFit, x: Array, blocks: Sequence[int]) -> tuple[dict[str, tuple[float, ...]], Array]:
    """The links' numbers as a real arm can have them, where they are not the file's, and all numbers with these.

    Of a payload the same: its own numbers are those of a body.
    """
    payload = [numbers for term, numbers in fit.numbers_held if ARM_EFFECTS[term.effect].place == "link"]
    at = payload[0] if payload else fit.numbers_of_links
    if not at:
        return {}, x
    matrix, right = fit.sums(blocks)
    rest = [i for i in range(fit.size) if i not in set(at)]
    hessian = matrix + np.diag(fit.prior)
    across = np.linalg.lstsq(hessian[np.ix_(rest, rest)], hessian[np.ix_(rest, at)], rcond=None)[0] if rest else None
    weight = hessian[np.ix_(at, at)] - (hessian[np.ix_(at, rest)] @ across if across is not None else 0.0)
    believed = np.zeros((1, 10)) if payload else fit.problem.nominal.reshape(-1, 10)
    numbers = nearest_consistent(believed + x[at].reshape(-1, 10), weight, x[at][None] if payload else believed)
    moved = x.copy()
    moved[at] = (numbers - believed).ravel()
    if rest:
        block = matrix[np.ix_(rest, rest)]
        moved[rest] = np.linalg.lstsq(block, right[rest] - matrix[np.ix_(rest, at)] @ moved[at], rcond=1e-10)[0]
    if payload:
        return {}, moved
    return dict(zip(fit.problem.links, (tuple(map(float, row)) for row in numbers), strict=True)), moved


def _joint(fit: SharedFit, x: Array, j: int, told: Sequence[Certainty], refit: float, noise: float) -> JointReport:
    """What is said of a joint; `refit` is the mean squared error with other links alone, of outer blocks."""
    problem, outer = fit.problem, fit.problem.outer
    spread, name = problem.rows[j].spread(outer), problem.arm.joints[j]
    if not spread > 0.0 or j not in problem.moving:
        return JointReport(name, j in problem.moving, spread, 0.0, 0.0, 0.0, 0.0, ())
    nominal, links, augmented = (
        float(np.sqrt(square)) / spread
        for square in (fit.errors(np.zeros_like(x), outer)[j], refit, fit.errors(x, outer)[j])
    )
    floor = min(float(np.sqrt(noise)) / spread, augmented)
    budget = joint_budget(fit, j, x, told, noise)
    return JointReport(name, True, spread, nominal, min(links, nominal), augmented, floor, budget)


def _effects(
    arm: ArmPlant,
    model: ArmModel,
    found: Believed,
    tried: Sequence[Believed],
    told: Mapping[int, Sequence[Certainty]],
    x: Array,
    half: Array,
    joints: Sequence[JointReport],
    budget: Sequence[BudgetPart],
) -> tuple[ArmEffectFound, ...]:
    known = {(e.name, e.where) for e in model.effects}
    effects = []
    for term, at in found.fit.numbers_held:
        share = next((part.share for part in budget if part.part == term.effect), 0.0)
        effects.append(_effect(arm, term, x[at], half[at], arm_certainty(term, found, tried), share, ()))
    for j, certainties in told.items():
        for (term, at), sure in zip(found.fit.numbers_of(j), certainties, strict=True):
            if term.key in known:
                continue  # a value of the model that is another: it is told with the parameters
            share = next((part.share for part in joints[j].budget if part.part == term.effect), 0.0)
            effects.append(_effect(arm, term, x[at], half[at], sure.depth, share, sure.instead))
    return tuple(sorted(effects, key=lambda e: e.certain is None))


def _effect(
    arm: ArmPlant, term: Term, x: Array, half: Array, depth: str | None, share: float, instead: tuple[str, ...]
) -> ArmEffectFound:
    law = ARM_EFFECTS[term.effect]
    values = law.values(x, term.shape)
    low, high = (law.values(x + side * half, term.shape) for side in (-1.0, 1.0))
    turns = not (term.where in arm.joints and arm.slides[arm.joints.index(term.where)])
    numbers: dict[str, Number | str] = {}
    for symbol, unit in zip(law.symbols, law.units, strict=True):
        if symbol == "joint":
            numbers[symbol] = arm.joints[int(str(values[symbol]))]
            continue
        unit = unit if turns else unit.replace("N m", "N").replace("rad", "m").replace("kg m^2", "kg")
        a, b = sorted((float(low[symbol]), float(high[symbol])))
        value = float(values[symbol])
        numbers[symbol] = Number(value, unit, (a, b) if a < value < b and math.isfinite(b - a) else None)
    return ArmEffectFound(law.name, law.family, law.block, term.where, depth, numbers, share, instead)


def _springs(arm: ArmPlant, model: ArmModel, logs: Sequence[JointLog]) -> list[tuple[Deflection, ArmEffectFound]]:
    """Elasticity of joints that have a second encoder behind the gear; it is no part of the torque's error.

    What passes the spring is the torque that was logged, less what the drive's own friction and rotor take: masses of
    links may have been guessed.

    Args:
        model: with what was found.
    """
    drive = [e for e in model.effects if ARM_EFFECTS[e.name].block == "friction" or e.name == "rotor_inertia"]
    own = [*drive, *(e for e in model.effects if of_the_plant(e.name))]
    every = [prepared(arm, replace(model, effects=tuple(own)), log) for log in logs if log.link is not None]
    torques = [one.motion.torque - one.motion.filtered(one.believed - one.rigid) for one in every]
    law, found = ARM_EFFECTS["joint_elasticity"], []
    for one in deflections([log for log in logs if log.link is not None], model.band_hz, torques):
        gained = (one.left[0] / one.left[1]) ** 2
        depth = next((d for d in ("law", "family", "block") if gained > LEAVES[d]), None)
        k = Number(one.stiffness, law.units[0], one.interval)
        where = arm.joints[one.joint]
        found.append((one, ArmEffectFound(law.name, law.family, law.block, where, depth, {"k": k}, 0.0)))
    return found


def _with_springs(
    effects: Sequence[ArmEffectFound], model: ArmModel, springs: Sequence[ArmEffectFound]
) -> tuple[tuple[ArmEffectFound, ...], ArmModel]:
    """Effects and model with what second encoders tell, in the place of what the torque tells of the same."""
    keys = {(spring.name, spring.where) for spring in springs}
    kept = [effect for effect in model.effects if (effect.name, effect.where) not in keys]
    known = {(effect.name, effect.where) for effect in model.effects} - {(e.name, e.where) for e in effects}
    new = [s for s in springs if (s.name, s.where) not in known]  # else it is a value that the model has already
    sure = [JointEffect(s.name, s.where, {"k": s.value("k")}) for s in springs if s.certain]
    found = (*(effect for effect in effects if (effect.name, effect.where) not in keys), *new)
    return found, replace(model, effects=(*kept, *sure))


def _encoders(arm: ArmPlant, springs: Sequence[tuple[Deflection, ArmEffectFound]]) -> tuple[str, ...]:
    """When the second encoders are read."""
    late = [(arm.joints[one.joint], 1e3 * one.late) for one, _ in springs if abs(one.late) >= _SKEW_S]
    if not late:
        return ()
    said = ", ".join(f"{joint} ({ms:.2g} ms)" for joint, ms in late)
    return (f"Second encoders are read later than the drives': {said}.",)


def _gaps(logs: Sequence[JointLog], band_hz: float) -> tuple[str, ...]:
    """Where logs have no samples."""
    lost = [(log, length) for log in logs if (length := float(gaps(log.time, band_hz)[:, 1].sum())) > 0.0]
    return tuple(f"{log.source} lacks {length:.2g} s of its {log.duration:.3g} s: left out." for log, length in lost)


def _merged(arm: ArmPlant, model: ArmModel, fit: SharedFit, x: Array) -> list[JointEffect]:
    """The model's effects with what was found of them on top, and those that are new."""
    found = [*fit.numbers_held, *(pair for j in fit.sets for pair in fit.numbers_of(j))]
    fresh = {term.key: (term, x[at]) for term, at in found}
    merged = []
    for effect in model.effects:
        key = (effect.name, effect.where)
        if key in fresh and ARM_EFFECTS[effect.name].place != "link":
            term, step = fresh.pop(key)
            numbers = ARM_EFFECTS[effect.name].at_bounds(step, fit.problem.known(key))
            merged.append(_written(arm, term, numbers))
        else:
            merged.append(effect)
    return [*merged, *(_written(arm, term, step) for term, step in fresh.values())]


def _written(arm: ArmPlant, term: Term, x: Array) -> JointEffect:
    values = ARM_EFFECTS[term.effect].values(x, term.shape)
    return JointEffect(
        term.effect, term.where, {s: arm.joints[int(str(v))] if s == "joint" else float(v) for s, v in values.items()}
    )


def _parameters(
    fit: SharedFit, links: Mapping[str, tuple[float, ...]], x: Array, half: Array, blocks: Sequence[int]
) -> tuple[dict[str, dict[str, Number]], dict[str, tuple[str, ...]]]:
    """Inertial numbers whose interval excludes what was believed, and those that the motion does not tell."""
    at, parameters, untold = fit.numbers_of_links, dict[str, dict[str, Number]](), dict[str, tuple[str, ...]]()
    if not at:
        return {}, {}
    told = fit.are_told(blocks)
    for k, (link, numbers) in enumerate(links.items()):
        own = range(10 * k, 10 * k + 10)
        untold[link] = tuple(INERTIA[i] for i, number in enumerate(own) if not told[number])
        sure = {
            INERTIA[i]: Number(numbers[i], INERTIA_UNITS[i], (numbers[i] - half[number], numbers[i] + half[number]))
            for i, number in enumerate(own)
            if told[number] and abs(x[number]) > half[number]
        }
        if sure:
            parameters[link] = sure
    return parameters, {link: symbols for link, symbols in untold.items() if symbols}
