"""What was carried in a run, as it was told and as it was felt."""

from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np

from mmt_drake.analysis.signals import delay_of, stretches, vector
from mmt_drake.model.grasped_box import LEAST_GRIP, LOST
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.recording import Recording

LIFTED: Final = 1e-4
"""Height from which on an object is off the table [m]."""


@dataclass(frozen=True)
class CarriedObject:
    """What the last thing that was carried weighs, and how it was felt.

    Attributes:
        m, centre: told in the end: mass [kg], how far the centre is below the grip [m]; None: not told.
        m_deviation, centre_deviation: standard deviations [kg], [m].
        seconds: how long it was off the table, the operator's copy too [s].
        force: error of the rendered force meanwhile, RMS over that of the true one.
        across: the same along x and y alone, where only its swing is felt; None: nothing acts there.
        slipped: how often it slipped out of the grip.
    """

    m: float
    m_deviation: float
    centre: float | None
    centre_deviation: float | None
    seconds: float
    force: float
    across: float | None
    slipped: int

    def line(self) -> str:
        """For a terminal."""
        centre = "centre not told"
        if self.centre is not None and self.centre_deviation is not None:
            centre = f"centre {1e3 * self.centre:.1f} +- {1e3 * self.centre_deviation:.1f} mm below the grip"
        felt = f"force {100 * self.force:.2g} % off"
        felt += "" if self.across is None else f", {100 * self.across:.2g} % along x and y"
        mass = f"{1e3 * self.m:.4g} +- {1e3 * self.m_deviation:.1g} g"
        return f"carried for {self.seconds:.1f} s: {mass}, {centre}; {felt}{_slips(self.slipped)}"

    def to_json(self) -> dict[str, Any]:
        """The same as data."""
        units = {"seconds": "off_table_s", "m": "mass_kg", "m_deviation": "mass_deviation_kg", "centre": "centre_m"}
        units |= {"centre_deviation": "centre_deviation_m", "force": "force_error", "across": "force_error_across"}
        return {units.get(name, name): value for name, value in asdict(self).items()}


@dataclass(frozen=True)
class NothingCarried:
    """A grip that closed and lifted nothing off the table.

    Attributes:
        closed: how often.
        slipped: how often what it had slipped out.
    """

    closed: int
    slipped: int

    def line(self) -> str:
        """For a terminal."""
        times = "once" if self.closed == 1 else f"{self.closed} times"
        return f"carried: nothing; the grip closed {times} and lifted nothing off the table{_slips(self.slipped)}"

    def to_json(self) -> dict[str, Any]:
        """The same as data."""
        return {"closed": self.closed, "slipped": self.slipped}


def carried_errors(recording: Recording, ticks: int) -> tuple[Array, Array]:
    """Errors of the rendered force while an object is carried, and the true one, both (n, 3) [N].

    Args:
        recording: of a run.
        ticks: by which the plant is later than the operator.
    """
    there, here = slice(ticks, None), slice(None, len(recording.time) - ticks)
    both = (recording["body_height"][there] > LIFTED) & (recording["carries"][here] > 0.0)
    true = vector(recording, "true_force")[there][both]
    return vector(recording, "rendered_force")[here][both] - true, true


def carried_object(recording: Recording, delay_s: float | None = None) -> CarriedObject | None:
    """What a recording says of it; None: nothing was carried, or one side of two does not know.

    Args:
        recording: of a run.
        delay_s: from the hand to the probe [s]; None: as the recording tells it, 0 where it does not.

    Raises:
        BadInput: a delay that is no time.
    """
    wanted = ("body_height", "carries", "carried_m", "carried_deviation_m", "true_force_x", "rendered_force_x")
    if not all(name in recording for name in wanted):
        return None
    step = float(np.median(np.diff(recording.time)))
    off, true = carried_errors(recording, round(delay_of(recording, delay_s) / step))
    told = np.flatnonzero((recording["carried_m"] > 0.0) & (recording["body_height"] > LIFTED))
    if not len(off) or not len(told):
        return None
    end = int(told[-1])
    m, centre, of_m, of_centre = (
        float(recording[f"carried_{name}"][end]) for name in ("m", "centre", "deviation_m", "deviation_centre")
    )
    where, within = (centre, of_centre) if centre > 0.0 else (None, None)
    force, across = share_of(off, true), share_of(off[:, :2], true[:, :2])
    if force is None:
        return None
    return CarriedObject(m, of_m, where, within, len(off) * step, force, across, _slipped(recording))


def nothing_lifted(recording: Recording) -> NothingCarried | None:
    """Of a recording whose grip closed in vain; None: it never closed, or something was off the table."""
    if "grip" not in recording or "body_height" not in recording or (recording["body_height"] > LIFTED).any():
        return None
    closed = len(stretches(recording["grip"] >= LEAST_GRIP))
    return NothingCarried(closed, _slipped(recording)) if closed else None


def _slipped(recording: Recording) -> int:
    """How often something slipped out of the grip."""
    return len(stretches(recording["grip_holds"] == LOST)) if "grip_holds" in recording else 0


def _slips(count: int) -> str:
    return f"; SLIPPED out of the grip {'once' if count == 1 else f'{count} times'}" if count else ""


def share_of(off: Array, true: Array) -> float | None:
    """RMS of the one over that of the other; None where the other is nothing."""
    return float(np.sqrt(np.mean(off**2) / np.mean(true**2))) if true.any() else None
