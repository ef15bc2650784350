"""The diagnosis: how long it takes, what twice the recording costs, and whether a cluster finds the same."""

import json
import logging
import tempfile
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager
from importlib.util import find_spec
from statistics import median
from typing import Any

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagnosis.fit.workers import workers
from mmt_drake.diagrams.proof.bench.contacts import contacts, material_tests
from mmt_drake.diagrams.proof.studies.measurement import Measurement
from mmt_drake.diagrams.proof.trial.cases import Case
from mmt_drake.diagrams.proof.trial.real.preparation import beginning
from mmt_drake.diagrams.proof.trial.score import score
from mmt_drake.errors import MissingDependency
from mmt_drake.model_files import Model, parse_model
from mmt_drake.processors import processors
from mmt_drake.recording import Recording

_FIRST_S, _WARM_UP_S = 30.0, 10.0
_AT_MOST_S, _MEDIAN_AT_MOST_S, _AT_MOST_TWICE = 60.0, 10.0, 2.0
_RECORDINGS = 100
_CONTACT, _CONTACT_S = "Coulomb friction", 30.0


def measurements() -> Iterator[Measurement]:
    """Contacts of several kinds one by one, then many recordings over a cluster.

    Raises:
        MissingDependency: dask is not installed.
    """
    if find_spec("distributed") is None:  # said now, not after minutes of work
        raise MissingDependency("bench diagnosis: dask is not installed: pip install 'mmt_drake[cluster]'")
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
    yield Measurement("diagnosis of 30 s at 1 kHz, whole library: median", median(took), "s", _MEDIAN_AT_MOST_S)
    yield Measurement("the same contact for 60 s: median", median(ratios), "x", _AT_MOST_TWICE)
    name = f"of these {len(right)} diagnoses say what was concealed"
    yield Measurement(name, sum(right), "", len(right), at_least=True)


def _timed(case: Case, recording: Recording, executor: Executor) -> tuple[float, Mapping[str, Any]]:
    """Wall time [s] of a diagnosis, and its document."""
    model = parse_model(dict(case.nominal))
    start = time.perf_counter()
    found = diagnose([recording], model, executor=executor)
    return time.perf_counter() - start, found.diagnosis.to_json()


def cluster_measurements() -> Iterator[Measurement]:
    """Many diagnoses spread over workers, against one after another here; then the fits of one diagnosis."""
    tests = [(recording, parse_model(dict(case.nominal))) for case, recording in material_tests(_RECORDINGS)]
    start = time.perf_counter()
    here = [_by_one_thread(*test) for test in tests]
    alone = time.perf_counter() - start
    case = contacts()[_CONTACT]
    recording, model = beginning(case.recording(), _CONTACT_S), parse_model(dict(case.nominal))
    with workers() as executor:
        start = time.perf_counter()
        by_threads = _document(recording, model, executor)
        threads = time.perf_counter() - start
    with _local_cluster() as address, workers(cluster=address) as executor:
        start = time.perf_counter()
        there = list(executor.map(_by_one_thread, *zip(*tests, strict=True)))
        spread = time.perf_counter() - start
        start = time.perf_counter()
        by_workers = _document(recording, model, executor)
        fits = time.perf_counter() - start
    differ = sum(a != b for a, b in zip(here, there, strict=True))
    what = f"{_RECORDINGS} recordings over a dask cluster of {processors()} workers here"
    yield Measurement(f"{what}: diagnoses that differ from those in series", differ, "", 0.0)
    yield Measurement("the same: time in series against that over the cluster", alone / spread, "x")
    what = f"one diagnosis of {_CONTACT_S:g} s, its fits spread over that cluster"
    yield Measurement(f"{what}: documents that differ from that by threads", float(by_threads != by_workers), "", 0.0)
    yield Measurement("the same: time over the cluster against that by threads", fits / threads, "x")


def _by_one_thread(recording: Recording, model: Model) -> str:
    with workers(1) as executor:
        return _document(recording, model, executor)


def _document(recording: Recording, model: Model, executor: Executor) -> str:
    """The diagnosis of a recording without the time that it took, every digit of it."""
    document = diagnose([recording], model, executor=executor).diagnosis.to_json()
    return json.dumps({key: value for key, value in document.items() if key != "seconds"}, sort_keys=True)


@contextmanager
def _local_cluster() -> Iterator[str]:
    """Address of a scheduler with a worker, a process of its own, for every processor here."""
    from distributed import LocalCluster

    with (
        tempfile.TemporaryDirectory() as folder,
        LocalCluster(
            n_workers=processors(),
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address=None,
            local_directory=folder,
            silence_logs=logging.ERROR,
        ) as cluster,
    ):
        yield str(cluster.scheduler_address)
