"""Trust in the estimator's model over a run: when it explained the force, and when the object was another one."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from mmt_drake.analysis.signals import column, flag, mean_step
from mmt_drake.estimation.output_error.adequacy import ModelStatus
from mmt_drake.recording.recording import Recording


@dataclass(frozen=True)
class ModelTrust:
    """The states of `model_status` over a run.

    Attributes:
        contact: in all [s].
        seconds: of contact in each state [s].
        misfit_at: when the model first did not explain the force [s]; None: it always did.
        changed_at: when the object was found to be another one [s].
    """

    contact: float
    seconds: dict[ModelStatus, float]
    misfit_at: float | None
    changed_at: tuple[float, ...]

    def line(self) -> str:
        """For a terminal."""
        parts = []
        if self.misfit_at is not None:
            misfit = self.seconds[ModelStatus.MISFIT]
            parts.append(
                f"DOES NOT EXPLAIN the force in {misfit:.2f} of {self.contact:.2f} s of contact, first at "
                f"{self.misfit_at:.2f} s: what is rendered there is not to be trusted"
            )
        if self.changed_at:
            parts.append(f"another object than before at {', '.join(f'{t:.2f}' for t in self.changed_at)} s")
        if unknown := self.seconds[ModelStatus.UNEXCITED]:
            parts.append(f"not every number known in {unknown:.2f} s of contact")
        agrees = "explains the force" if self.contact else "not tested, there was no contact"
        return f"model: {'; '.join(parts) or agrees}"

    def to_json(self) -> dict[str, Any]:
        """The same as data."""
        times = {f"{status.name.lower()}_s": seconds for status, seconds in self.seconds.items()}
        return {**times, "contact_s": self.contact, "misfit_at_s": self.misfit_at, "changed_at_s": [*self.changed_at]}


def model_trust(recording: Recording) -> ModelTrust | None:
    """What `model_status` of a recording shows; None where that is missing: another estimator knows nothing of it."""
    if "model_status" not in recording:
        return None
    touching = "in_contact" if "in_contact" in recording else "detected_contact"  # of a real object
    states, step, contact = column(recording, "model_status"), mean_step(recording), flag(recording, touching)
    seconds = {status: step * int(np.count_nonzero(contact & (states == status))) for status in ModelStatus}
    misfit = np.flatnonzero(states == ModelStatus.MISFIT)
    changed = np.flatnonzero(np.diff(np.asarray(states == ModelStatus.CHANGED, dtype=np.int8), prepend=0) == 1)
    return ModelTrust(
        step * int(np.count_nonzero(contact)),
        seconds,
        float(recording.time[misfit[0]]) if len(misfit) else None,
        tuple(float(t) for t in recording.time[changed]),
    )
