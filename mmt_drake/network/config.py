"""Parameters of one direction of a network, and delay traces read from a file."""

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from mmt_drake.errors import BadInput
from mmt_drake.quantities import Checked, Delay, Quantity, Seed, Share

_LARGEST = 1 << 26  # bytes of a trace: an hour at 1 kHz

JitterLaw = Literal["uniform", "normal", "gamma"]
JITTER_LAWS = get_args(JitterLaw)


@dataclass(frozen=True)
class ChannelConfig(Checked):
    """What happens to packets in one direction; the default is a wire without delay.

    One packet leaves per tick of the channel. It becomes available at the first tick at or after its
    arrival, so a delay that is no multiple of the tick is rounded up to one.

    Args:
        delay: of every packet [s].
        jitter: of the delay, independent from packet to packet [s]; its meaning depends on the law.
        jitter_law: "uniform": delay + U(-jitter, jitter). "normal": delay + N(0, jitter^2). "gamma": delay
            + a gamma variable of shape 2 and standard deviation jitter, which is never negative and has
            the long tail of measured networks. Draws of a probability below 1e-6 are cut off (4.9 and 11.8
            jitter). A sum below zero counts as zero: a packet cannot arrive before it was sent.
        loss: probability that a packet, or a copy of one, never arrives.
        duplication: probability that the network makes a copy, which then travels on its own.
        reordering: probability that a packet is held back by `reordering_delay`, so that later ones overtake it.
        reordering_delay: [s].
        rate_limit: packets that the link takes in a second; None: as many as are sent.
        queue: packets that may wait for the link to be free; one that finds the queue full is lost.
        trace: CSV file of measured delays, see `load_trace`, in place of delay and jitter.
        playout: time from sending to playing of a play-out buffer at the receiver [s], at least the delay.
            Packets wait there for their turn, gaps are bridged by interpolation, and jitter below playout
            - delay leaves no trace. 0: no buffer, what arrives is applied at once unless it is stale.
        seed: of everything random; channels that shall not err alike need different ones.

    Raises:
        BadInput: a value that is no number, not finite or out of range, or two that contradict each other.
    """

    delay: Delay = 0.0
    jitter: Delay = 0.0
    jitter_law: JitterLaw = "uniform"
    loss: Share = 0.0
    duplication: Share = 0.0
    reordering: Share = 0.0
    reordering_delay: Delay = 0.02
    rate_limit: Annotated[float | None, Quantity("1/s", 1e-9)] = None
    queue: Annotated[int, Quantity("", 0, 10**6, whole=True)] = 0
    trace: str | None = None
    playout: Delay = 0.0
    seed: Seed = 0

    CALLED: ClassVar = "network channel"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.trace is not None and not isinstance(self.trace, (str, Path)):
            raise _bad("trace", self.trace, "the name of a file")
        if self.trace is not None and (self.delay > 0.0 or self.jitter > 0.0):
            raise _bad("trace", self.trace, "no delay and no jitter beside it: the trace gives them")
        if 0.0 < self.playout < self.delay:
            raise _bad("playout", f"{self.playout} s", f"0, or at least the delay of {self.delay} s")

    @property
    def is_constant(self) -> bool:
        """Whether all this does is to delay, every packet alike."""
        chances = self.jitter, self.loss, self.duplication, self.reordering, self.playout
        return not any(chances) and self.rate_limit is None and self.trace is None


def load_trace(path: str | Path) -> NDArray[np.float64]:
    """Reads measured delays from a CSV file with the columns `time` and `delay`, both in seconds.

    A packet takes the delay of the last row at or before the time it is sent, counted from the first
    row and from the first tick. `nan`, or nothing, as delay means that packets sent then are lost.
    After the last row, which lasts as long as the row before it, the trace begins again.

    Returns:
        (n + 1, 2): times from 0 and delays; the last row holds the length of the trace.

    Raises:
        BadInput: no such file, other columns, fewer than two rows, times that do not increase, a delay
            that is negative or no number, or nothing but losses.
    """
    lines = _lines(path)
    rows = _rows(lines, path)
    header = [name.strip() for name in next(rows, (1, []))[1]]
    if header != ["time", "delay"]:
        raise BadInput(path, at="row 1", found=",".join(header) or "nothing", expected="the header time,delay")
    trace, count = np.empty((len(lines), 2)), 0
    for n, row in rows:
        try:
            time, delay = float(row[0]), float(row[1].strip() or "nan")
        except (ValueError, IndexError):
            raise BadInput(path, at=f"row {n}", found=",".join(row), expected="two numbers") from None
        if not math.isfinite(time) or (count > 0 and time <= trace[count - 1, 0]):
            raise BadInput(path, at=f"row {n}", found=f"time {row[0]}", expected="a time after the row before")
        if delay < 0.0 or math.isinf(delay):
            raise BadInput(path, at=f"row {n}", found=f"delay {row[1]}", expected="seconds >= 0, or nan for a loss")
        trace[count], count = (time, delay), count + 1
    if count < 2:
        raise BadInput(path, found=f"{count} rows of data", expected="two or more")
    trace = trace[: count + 1].copy()
    if np.isnan(trace[:-1, 1]).all():
        raise BadInput(path, found="losses alone", expected="a delay in some row")
    trace[-1] = 2.0 * trace[-2, 0] - trace[-3, 0], trace[-2, 1]
    trace[:, 0] -= trace[0, 0]
    return trace


def _lines(path: str | Path) -> list[str]:
    expected = "a CSV file of columns time, delay"
    try:
        with Path(path).open("rb") as file:
            content = file.read(_LARGEST + 1)
        if len(content) > _LARGEST:
            raise BadInput(path, found=f"more than {_LARGEST >> 20} MiB", expected=expected)
        return content.decode("utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(path, found=error, expected=expected) from None


def _rows(lines: list[str], path: str | Path) -> Iterator[tuple[int, list[str]]]:
    """Those that are not empty, with their numbers."""
    try:
        yield from ((n, row) for n, row in enumerate(csv.reader(lines), start=1) if row)
    except csv.Error as error:
        raise BadInput(path, found=error, expected="rows of two numbers") from None


def _bad(name: str, found: object, expected: str) -> BadInput:
    return BadInput("network channel", at=name, found=found, expected=expected)
