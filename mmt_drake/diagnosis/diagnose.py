"""The diagnosis from end to end: from recordings and a believed model to a verdict."""

import math
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from typing import cast

from threadpoolctl import threadpool_limits

from mmt_drake.diagnosis.fit.prepare import Prepared, prepare
from mmt_drake.diagnosis.fit.problem import Fitted
from mmt_drake.diagnosis.fit.workers import given_or_own
from mmt_drake.diagnosis.law_session import LawSession
from mmt_drake.diagnosis.on_surface import SurfaceSession
from mmt_drake.diagnosis.search.base import fit_base, over_windows
from mmt_drake.diagnosis.search.in_plane import said
from mmt_drake.diagnosis.search.polish import Polish
from mmt_drake.diagnosis.search.watch import OnAnswer, OnStage, Watch
from mmt_drake.diagnosis.session import PARAMETERS, DiagnosisSession
from mmt_drake.diagnosis.tell.outcome import Outcome, refused
from mmt_drake.diagnosis.tell.result import TABULATED
from mmt_drake.effects import LIBRARY
from mmt_drake.effects.effect import Effect
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.model_files import Model, check_model, compared, model_data
from mmt_drake.over import with_knots
from mmt_drake.recording import Recording
from mmt_drake.recording.recording import check_recordings


def diagnose(
    recordings: Sequence[Recording],
    model: Model,
    *,
    library: Iterable[Effect] | None = None,
    executor: Executor | None = None,
    on_stage: OnStage = lambda _: None,
    on_answer: OnAnswer = lambda _: None,
    time_budget: float = math.inf,
    next_motion: bool = True,
) -> Outcome:
    """Say whether a model explains recordings, and if not, what physics it leaves out.

    Args:
        recordings: of the same system.
        model: what the simulation believes in.
        library: effects that may be missing; by default all there are.
        executor: runs the fits; by default as many threads as there are processors.
        on_stage: called with what is being done, how far it is and what may come after it.
        on_answer: called once in the search, with what is known when the likeliest effects have been fitted.
        time_budget: how long it may look for effects [s]; what it had no time for is listed (`Diagnosis.untried`).
        next_motion: whether to seek the motion that would tell apart what these recordings leave open, which takes as
            long as the rest.

    Raises:
        BadInput: the recordings are none that a model of this structure can be held against, or the model has
            additions that no file holds: no file could hold the result.
        Interrupted: a KeyboardInterrupt, with what was known by then.
    """
    begun = time.perf_counter()
    check_recordings("diagnose", recordings)
    check_model("diagnose", model)
    bare = model if model.handed is None else cast(Model, model.handed.bare)
    model_data(bare)  # refuses what no file could hold, before the work
    model = with_knots(model, recordings)
    prepared = prepare(recordings, model)
    if prepared.problem is None:
        return _timed(refused(prepared, compared(model, prepared.window_s, prepared.initial)), begun)
    every = LIBRARY.values() if library is None else library
    stages = SurfaceSession.STAGES if isinstance(model, SurfaceContact) else LawSession.STAGES
    watch = Watch(stages, on_stage, time_budget, on_answer)
    # The fits run beside each other already, and sums come out the same wherever they are formed.
    with given_or_own(executor) as workers, threadpool_limits(limits=1, user_api="blas"):
        try:
            watch.begin(PARAMETERS)
            searched, refit = prepared, None
            if model.window_s is None and prepared.window_s is not None:
                searched, refit = over_windows(recordings, model, prepared, workers)
            return _timed(_session(prepared, searched, model, every, workers, watch, refit, next_motion).run(), begun)
        except KeyboardInterrupt:
            raise watch.interrupted() from None


def _session(
    prepared: Prepared,
    searched: Prepared,
    model: Model,
    library: Iterable[Effect],
    workers: Executor,
    watch: Watch,
    refit: Fitted | None,
    next_motion: bool,
) -> DiagnosisSession:
    problem, fine = searched.problem, prepared.fine
    assert problem is not None and fine is not None  # of recordings that were not refused
    model = compared(model, prepared.window_s, prepared.initial)

    def fitted(friction: Model) -> Fitted:
        return fit_base(problem, friction, prepared.skew, workers)[1]

    handed, (model, begun) = model, said(problem, model, fitted)
    effects = [e.within(model) for e in library if e.name != TABULATED]
    if isinstance(model, SurfaceContact):
        return SurfaceSession(prepared, problem, problem, model, effects, workers, watch, refit)
    common = prepared, problem, fine, model, effects, workers, watch, begun or refit
    return LawSession(*common, Polish(workers), next_motion, model is not handed)


def _timed(outcome: Outcome, begun: float) -> Outcome:
    seconds = round(time.perf_counter() - begun, 2)
    return replace(outcome, diagnosis=replace(outcome.diagnosis, seconds=seconds))
