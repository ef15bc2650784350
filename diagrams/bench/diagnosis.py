"""The diagnosis: how long it takes, what twice the recording costs, and whether a cluster finds the same."""

import time
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor
from statistics import median
from typing import Any

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagnosis.fit.workers import workers
from mmt_drake.diagrams.bench.cluster import cluster_measurements, needed
from mmt_drake.diagrams.bench.contacts import beginning, contacts
from mmt_drake.diagrams.studies.measurement import Measurement
from mmt_drake.diagrams.trial.cases import Case
from mmt_drake.diagrams.trial.score import score
from mmt_drake.model_files import parse_model
from mmt_drake.recording import Recording

_FIRST_S, _WARM_UP_S = 30.0, 10.0
_AT_MOST_S, _AT_MOST_TWICE = 30.0, 2.0


def measurements() -> Iterator[Measurement]:
    """Contacts of several kinds one by one, then many recordings over a cluster.

    Raises:
        MissingDependency: dask is not installed.
    """
    needed()  # told now, not after minutes of work
    yield from _speed()
    yield from cluster_measurements()


def _speed() -> Iterator[Measurement]:
    took, ratios, right = [], [], []
    with workers() as executor:
        cases = contacts()
        case, recording = next((case, case.recording()) for case in cases.values() if case.effects)
        _timed(case, beginning(recording, _WARM_UP_S), executor)  # compiles
        for kind, case in cases.items():
            whole = case.recording()
            (short, first), (long, second) = (_timed(case, r, executor) for r in (beginning(whole, _FIRST_S), whole))
            took.append(short)
            ratios.append(long / short)
            right += [score(case.truth(), answer, 0.0).correct for answer in (first, second)]
            yield Measurement(f"diagnosis of 30 s at 1 kHz, whole library: {kind}", short, "s", _AT_MOST_S)
            yield Measurement(f"the same contact for 60 s: {kind}", long / short, "x", _AT_MOST_TWICE)
    yield Measurement("diagnosis of 30 s at 1 kHz, whole library: median", median(took), "s", _AT_MOST_S)
    yield Measurement("the same contact for 60 s: median", median(ratios), "x", _AT_MOST_TWICE)
    told = f"of these {len(right)} diagnoses say what was concealed"
    yield Measurement(told, sum(right), "", len(right), at_least=True)


def _timed(case: Case, recording: Recording, executor: Executor) -> tuple[float, Mapping[str, Any]]:
    """Wall time [s] of a diagnosis, and its document."""
    model = parse_model(dict(case.nominal))
    start = time.perf_counter()
    found = diagnose([recording], model, executor=executor)
    return time.perf_counter() - start, found.diagnosis.to_json()
