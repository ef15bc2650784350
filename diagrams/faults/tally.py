"""What comes of the moments at which one kind of fault is brought about in a session."""

from __future__ import annotations

import math
from pathlib import Path

from mmt_drake.diagrams.faults.row import Row
from mmt_drake.diagrams.faults.session import FORCE, PERIOD, Session
from mmt_drake.recording import Recording, load


class Tally:
    """Moment by moment: the force that the hand felt, and what was not as it must be.

    Attributes:
        felt: moments at which there was a force.
        wrong: a line each.
    """

    def __init__(self, session: Session) -> None:
        self.felt, self.wrong = 0, list[str]()
        self._session, self._greatest, self._slowest = session, 0.0, 0.0

    def armed(self, moment: int | str) -> bool:
        """Have a person arm; whether that came to anything."""
        if self._session.arm():
            return True
        self.wrong.append(f"{moment}: cannot be armed: {self._session.told()}")
        return False

    def begin(self) -> float:
        """The moment is now; its time by the device's clock [s]."""
        self.felt += bool(self._session.omega.vector("applied").any())
        return self._session.begin_moment()

    def force_for(self, moment: int, start: float) -> float:
        """How long there was a force after the moment [s]; it must have been within its limit."""
        omega = self._session.omega
        force, on_for = omega.get("greatest_force"), omega.get("last_force_at") - start
        self._greatest, self._slowest = max(self._greatest, force), max(self._slowest, on_for)
        if force > FORCE * (1 + 1e-9) or omega.get("not_finite"):
            self.wrong.append(f"{moment}: {force:.3g} N")
        return on_for

    def surprise(self, moment: int, on_for: float) -> None:
        """The supervisor did not do what it must."""
        self.wrong.append(f"{moment}: {self._session.told()}, a force for {1e3 * on_for:.1f} ms")

    def must_stay_off(self, moment: int, ticks: int) -> None:
        """Once all is well again, no force comes back in so many ticks."""
        self._session.begin_moment()
        self._session.go(ticks)
        if self._session.omega.get("greatest_force"):
            self.wrong.append(f"{moment}: it went on by itself")

    def recorded(self, record: Path) -> Recording:
        """The operator's recording, which must have every tick."""
        recording = load(record, forces=False)
        if len(recording) != self._session.tick:
            self.wrong.append(f"{self._session.tick} ticks, of which {len(recording)} were recorded")
        return recording

    def row(self, kind: str, where: str, moments: int, recording: Recording, allowed: float | None) -> Row:
        """The line of the table; `allowed` [s] is None where the run goes on."""
        return Row(
            kind=kind,
            where=where,
            moments=moments,
            greatest_force=self._greatest,
            force_limit=FORCE,
            zero_after=math.nan if allowed is None else self._slowest,
            allowed=math.nan if allowed is None else allowed,
            unreadable=(self._session.tick - 1) * PERIOD - float(recording.time[-1]),
            wrong=tuple(self.wrong),
        )
