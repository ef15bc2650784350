"""Workers of a fit: threads of this process, or those of a dask cluster."""

import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, nullcontext

from threadpoolctl import threadpool_limits

from mmt_drake.errors import BadInput, MissingDependency
from mmt_drake.processors import processors

_PATIENCE_S = 10.0

_here = threading.local()
"""Of a thread of `workers`: `stop`, an event."""


@contextmanager
def workers(jobs: int | None = None, cluster: str | None = None) -> Iterator[Executor]:
    """An executor for the fits of a diagnosis; which one it is changes nothing in what is found.

    Args:
        jobs: threads; as many as there are processors unless given. The kernels hold no lock.
        cluster: address of a dask scheduler, whose workers are used instead.

    Raises:
        MissingDependency: a cluster, and dask is not installed.
        BadInput: no scheduler answers at the address.
    """
    if cluster is None:
        stop = threading.Event()
        with ThreadPoolExecutor(jobs or processors(), initializer=_stopped_by, initargs=(stop,)) as threads:
            try:
                yield threads
            except BaseException:
                stop.set()
                threads.shutdown(wait=False, cancel_futures=True)
                raise
        return
    try:
        from distributed import Client
    except ImportError:
        raise MissingDependency("--cluster: dask is not installed: pip install 'mmt_drake[cluster]'") from None
    try:
        client = Client(cluster, timeout=_PATIENCE_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise BadInput("--cluster", found=f"{cluster}: {error}", expected="the address of a dask scheduler") from None
    from mmt_drake.diagnosis.fit.cluster import ClusterExecutor  # needs dask

    with client, ClusterExecutor(client) as executor:
        client.run(_one_blas_thread)
        yield executor


def given_or_own(executor: Executor | None) -> AbstractContextManager[Executor]:
    """The executor of who calls; threads of one's own where there is none."""
    return workers() if executor is None else nullcontext(executor)


def _stopped_by(stop: threading.Event) -> None:
    _here.stop = stop


def check_stop() -> None:
    """To be called between replays.

    Raises:
        KeyboardInterrupt: this is a thread of `workers`, and what they work for has ended: by Ctrl-C, say.
    """
    stop: threading.Event | None = getattr(_here, "stop", None)
    if stop is not None and stop.is_set():
        raise KeyboardInterrupt


def _one_blas_thread() -> None:
    """Of a worker's process from now on, as `diagnose` has it of its own."""
    import scipy.linalg  # noqa: F401  # what is limited must be loaded

    threadpool_limits(limits=1, user_api="blas")
