"""A dask cluster on this machine: that it finds what is found without it, to the last digit, and what it costs."""

import json
import logging
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagnosis.fit.workers import workers
from mmt_drake.diagrams.bench.contacts import beginning, contacts, material_tests
from mmt_drake.diagrams.studies.measurement import Measurement
from mmt_drake.errors import MissingDependency
from mmt_drake.model_files import Model, parse_model
from mmt_drake.processors import processors
from mmt_drake.recording import Recording

_RECORDINGS = 100
_CONTACT, _CONTACT_S = "Coulomb friction", 30.0


def needed() -> None:
    """Nothing, where dask is installed.

    Raises:
        MissingDependency: it is not.
    """
    try:
        import distributed  # noqa: F401
    except ImportError:
        raise MissingDependency("bench diagnosis: dask is not installed: pip install 'mmt_drake[cluster]'") from None


def cluster_measurements() -> Iterator[Measurement]:
    """Many diagnoses spread over workers, against one after another here; then the fits of one diagnosis."""
    tests = [(recording, parse_model(dict(case.nominal))) for case, recording in material_tests(_RECORDINGS)]
    start = time.perf_counter()
    here = [_document(*test) for test in tests]
    alone = time.perf_counter() - start
    case = contacts()[_CONTACT]
    recording, model = beginning(case.recording(), _CONTACT_S), parse_model(dict(case.nominal))
    with workers() as executor:
        start = time.perf_counter()
        by_threads = _plain(diagnose([recording], model, executor=executor).diagnosis.to_json())
        threads = time.perf_counter() - start
    with _local_cluster() as address, workers(cluster=address) as executor:
        start = time.perf_counter()
        there = list(executor.map(_document, *zip(*tests, strict=True)))
        spread = time.perf_counter() - start
        start = time.perf_counter()
        by_workers = _plain(diagnose([recording], model, executor=executor).diagnosis.to_json())
        fits = time.perf_counter() - start
    differ = sum(a != b for a, b in zip(here, there, strict=True))
    what = f"{_RECORDINGS} recordings over a dask cluster of {processors()} workers here"
    yield Measurement(f"{what}: diagnoses that differ from those in series", differ, "", 0.0)
    yield Measurement("the same: time in series against that over the cluster", alone / spread, "x")
    what = f"one diagnosis of {_CONTACT_S:g} s, its fits spread over that cluster"
    yield Measurement(f"{what}: documents that differ from that by threads", float(by_threads != by_workers), "", 0.0)
    yield Measurement("the same: time over the cluster against that by threads", fits / threads, "x")


def _document(recording: Recording, model: Model) -> str:
    """The diagnosis of a recording by one thread."""
    with workers(1) as executor:
        return _plain(diagnose([recording], model, executor=executor).diagnosis.to_json())


def _plain(document: dict[str, object]) -> str:
    """A document without the time that it took, every digit of it."""
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
