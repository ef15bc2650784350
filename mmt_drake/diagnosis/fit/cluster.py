"""The workers of a dask cluster as an executor to which problems and fits travel once, not with every call.

A problem is as large as its recordings, and a search has hundreds of calls on the same one, or on the same fit.
"""

import io
import pickle
import time
import warnings
import weakref
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError, Executor, Future
from typing import Any

import cloudpickle
from distributed import Client

from mmt_drake.diagnosis.fit.problem import Fitted, Problem

_SHARED = (Problem, Fitted)

Call = tuple[Any, ...]
"""A function and its arguments."""


class ClusterExecutor(Executor):
    """Runs calls on the workers of a dask cluster.

    What of `_SHARED` a call is given, anywhere in its arguments, is sent ahead and stays on the cluster for as long as
    it lives here. A call that lost it, because a worker went away, is made again with all that it needs.

    Args:
        client: connected to the cluster's scheduler.
    """

    def __init__(self, client: Client) -> None:
        self._client = client
        self._plain = client.get_executor()
        self._sent: dict[int, Any] = {}  # id -> dask's future

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """See `Executor.submit`; one call shares nothing."""
        submitted: Future[Any] = self._plain.submit(fn, *args, **kwargs)
        return submitted

    def map(
        self, fn: Callable[..., Any], *iterables: Iterable[Any], timeout: float | None = None, chunksize: int = 1
    ) -> Iterator[Any]:
        """See `Executor.map`."""
        calls = [(fn, *arguments) for arguments in zip(*iterables, strict=False)]
        packed = [_packed(call) for call in calls]
        self._send([whole for _, wholes in packed for whole in wholes])
        contents = [content for content, _ in packed]
        parts = [[self._sent[id(whole)] for whole in wholes] for _, wholes in packed]
        with warnings.catch_warnings():  # what many calls need beside what is shared is theirs alone
            warnings.filterwarnings("ignore", "Sending large graph", UserWarning)
            futures = self._client.map(_run, contents, parts)
        return self._results(calls, futures, None if timeout is None else time.monotonic() + timeout)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """See `Executor.shutdown`."""
        self._plain.shutdown(wait=wait and not cancel_futures)
        self._sent.clear()

    def _send(self, wholes: Iterable[object]) -> None:
        """Send what is not on the cluster, all at once."""
        new = {id(whole): whole for whole in wholes if not self._is_there(id(whole))}
        if not new:
            return
        for key in new.keys() - self._sent.keys():
            weakref.finalize(new[key], self._sent.pop, key, None).atexit = False
        self._sent |= zip(new, self._client.scatter(list(new.values()), hash=False), strict=True)

    def _is_there(self, key: int) -> bool:
        return key in self._sent and self._sent[key].status == "finished"

    def _results(self, calls: Sequence[Call], futures: Sequence[Any], deadline: float | None) -> Iterator[Any]:
        """The results in order; what nobody waits for any more is cancelled."""
        try:
            for call, future in zip(calls, futures, strict=True):
                left = None if deadline is None else deadline - time.monotonic()
                try:
                    yield future.result(left)
                except CancelledError:
                    yield self._plain.submit(*call).result(left)
        finally:
            self._client.cancel(futures)


def _packed(call: Call) -> tuple[bytes, list[object]]:
    """A call as bytes, and what was left out of them because it is sent ahead."""
    buffer = io.BytesIO()
    packer = _Packer(buffer)
    packer.dump(call)
    return buffer.getvalue(), list(packer.parts.values())


class _Packer(cloudpickle.Pickler):
    """Pickles all but what is shared, which it gathers in order."""

    def __init__(self, file: io.BytesIO) -> None:
        super().__init__(file)
        self.parts: dict[int, object] = {}

    def persistent_id(self, item: object) -> int | None:
        """The index of what is shared among `parts`; None of everything else."""
        if not isinstance(item, _SHARED):
            return None
        self.parts.setdefault(id(item), item)
        return list(self.parts).index(id(item))


class _Unpacker(pickle.Unpickler):
    """Puts what was shared back where it was."""

    def __init__(self, file: io.BytesIO, parts: Sequence[object]) -> None:
        super().__init__(file)
        self._parts = parts

    def persistent_load(self, index: int) -> object:
        """See `_Packer.persistent_id`."""
        return self._parts[index]


def _run(content: bytes, parts: Sequence[object]) -> Any:
    """On a worker: the call."""
    fn, *arguments = _Unpacker(io.BytesIO(content), parts).load()
    return fn(*arguments)
