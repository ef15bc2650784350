"""A located mismatch as values: blocks, times, band and the signals that the residual follows."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from mmt_drake.diagnosis.fit.errors import Interval


@dataclass(frozen=True)
class BlockShare:
    """The share, 0 to 1, of the mismatch that belongs to one block."""

    block: str
    share: float


@dataclass(frozen=True)
class Dependence:
    """How strongly the residual follows a signal.

    Attributes:
        signal: `sliding_velocity`, `deflection`, `load`, `position`, `time` ...
        score: share of the residual's variance that a smooth curve over the signal explains, 0 to 1.
        where: where along the signal it is concentrated, e.g. `|v| < 0.005 m/s`.
    """

    signal: str
    score: float
    where: str


@dataclass(frozen=True)
class Mismatch:
    """Where simulation and recording differ.

    Attributes:
        blocks: largest share first.
        intervals_s: when, (from, to) [s].
        band_hz: in which band of frequencies; None where there is no mismatch.
        depends_on: highest score first.
        axes: of several that are compared the share, 0 to 1, of the mismatch beyond the noise that shows along each,
            largest first. In the document `fit.by_axis` has them.
    """

    blocks: tuple[BlockShare, ...] = ()
    intervals_s: tuple[Interval, ...] = ()
    band_hz: Interval | None = None
    depends_on: tuple[Dependence, ...] = ()
    axes: Mapping[str, float] = field(default_factory=dict, metadata={"document": False})
