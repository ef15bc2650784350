"""The thesis's own mismatch: the rendered force is off the measured one. Which block is to blame?

Experiment 1 as it comes out of the simulation, and the same with one cause after the other put in that could be behind
the errors of the thesis's figures. Each recording is then held against the station one believes in, block by block
(`mmt_drake.diagnosis.decide.blocks`): a cause that was put into one block must be found in that block and in no other.
"""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mmt_drake.analysis.metrics import AFTER_S, measure
from mmt_drake.analysis.signals import BAND_NAMES, contact_time, flag, mean_step
from mmt_drake.analysis.table import Table
from mmt_drake.analysis.wording import in_percent
from mmt_drake.diagnosis.decide.blocks import BlockReplay, differing, replay_blocks
from mmt_drake.diagrams.proof.experiments.changes import (
    Cause,
    estimating,
    input_held,
    input_late,
    input_placed,
    unchanged,
)
from mmt_drake.diagrams.proof.experiments.thesis import SETTLED, thesis_cases
from mmt_drake.diagrams.stations.blocks import station_blocks
from mmt_drake.diagrams.stations.scenario import Scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import TANGENTIAL_THETA, THETA, BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.network.parameters import usual_delay
from mmt_drake.recording import Recording, load

LATE_S: Final = 0.02
"""By how much the late causes are late, and how long the held one holds [s]."""
NO_BLOCK: Final = "none"
"""Where a cause sits that is none."""
SECONDS: Final = 20.0
"""Length of a run [s]."""


@dataclass(frozen=True)
class TriedCause:
    """A recording with one cause in it, held against the station without it.

    Attributes:
        cause: what was put in.
        recording: of the run.
        replays: of every block, over the samples after `AFTER_S` of contact.
        rendered_error: name of a band -> RMS of rendered less measured force over that of the measured one.
    """

    cause: Cause
    recording: Recording
    replays: tuple[BlockReplay, ...]
    rendered_error: Mapping[str, float | None]

    @property
    def named(self) -> tuple[str, ...]:
        """The blocks that the replay names."""
        return differing(self.replays)

    @property
    def right(self) -> bool:
        """Whether that is the block with the cause, and no other."""
        return self.named == (() if self.cause.group == NO_BLOCK else (self.cause.group,))


def estimated_object(
    recording: Recording, at_s: float | None = None, *, absent: Collection[str] = ()
) -> FlexibleBoxModel:
    """The object that the estimator of a run believed in.

    Estimates scatter about zero where the truth is 0, and no model has a spring or friction that pushes: those below 0
    are 0 here.

    Args:
        recording: with `theta_*` and `theta_stable`.
        at_s: when [s]; at the end by default. The latest estimate that was stable by then counts.
        absent: parameters that the object is known not to have, whatever scatter about zero was estimated.

    Raises:
        BadInput: there was none by then, or a column is missing.
    """
    by_then = recording.time <= (np.inf if at_s is None else at_s)
    stable = np.flatnonzero(flag(recording, "theta_stable") & by_then)
    if not stable.size:
        raise BadInput(recording.source, at="theta_stable", found="no stable estimate", expected="one")
    theta = {name: max(float(recording[f"theta_{name}"][stable[-1]]), 0.0) for name in THETA}
    theta |= dict.fromkeys(absent, 0.0)
    tangential = BoxParameters(**{name: theta[name] for name in TANGENTIAL_THETA})
    return FlexibleBoxModel(tangential, NormalContact(theta["normal_k"], theta["normal_b"]))


def _with_latency(scenario: Scenario) -> Scenario:
    return replace(scenario, to_telerobot=replace(scenario.to_telerobot, delay=LATE_S))


CAUSES: Final = (
    Cause("none", NO_BLOCK, unchanged),
    Cause("eq. 30 solved without d", "estimator", estimating(equations="without_d")),
    Cause("network 20 ms late", "to_telerobot", _with_latency),
    Cause("renderer's input 20 ms late", "renderer", input_late(LATE_S)),
    Cause("renderer's input held for 20 ms", "renderer", input_held(LATE_S)),
    Cause("renderer's input without velocity", "renderer", input_placed),
)


def believed(seconds: float = SECONDS) -> Scenario:
    """Experiment 1 with the estimator waiting after each touch, so that no cause hides behind a wrong estimate."""
    return thesis_cases(1, seconds=seconds)[SETTLED]


def try_causes(
    folder: str | Path, causes: tuple[Cause, ...] = CAUSES, *, scenario: Scenario | None = None
) -> tuple[TriedCause, ...]:
    """Put each cause in, record a run, and hold the recording against the station without it.

    Args:
        folder: for the recordings, which are written only to be read; it must exist.
        causes: one after the other.
        scenario: the station without any cause, `believed()` by default.

    Raises:
        BadInput: the scenario cannot be built, a recording not be written, or a run has too little contact.
    """
    scenario = believed() if scenario is None else scenario
    tried: list[TriedCause] = []
    for cause in causes:
        changed = cause.change(scenario)
        recording = next((each.recording for each in tried if each.cause.change(scenario) == changed), None)
        if recording is None:
            file = Path(folder) / f"cause_{len(tried)}.mcap"
            build_station(changed, record=file).simulate()
            recording = load(file)
        tried.append(_tried(cause, recording, scenario))
    return tuple(tried)


def _tried(cause: Cause, recording: Recording, scenario: Scenario) -> TriedCause:
    # A simulation without sensor noise: what differs, differs.
    replays = replay_blocks(recording, station_blocks(scenario), counts=after_wind_up(recording), noise={})
    delay = usual_delay(scenario.to_telerobot, scenario.step)  # as it is believed; the recording tells its own
    return TriedCause(cause, recording, replays, measure(recording, delay_s=delay).rendered_error.tangential)


def after_wind_up(recording: Recording) -> NDArray[np.bool_]:
    """The samples (n,) after `AFTER_S` of contact, in contact or not: those of the errors, and releases between."""
    counts: NDArray[np.bool_] = contact_time(flag(recording, "in_contact"), mean_step(recording)) >= AFTER_S
    return counts


def error_table(tried: Iterable[TriedCause]) -> Table:
    """One row per cause: the error of the rendered force by band [%], and the blocks that the replay names."""
    rows = [
        [
            each.cause.name,
            "no block" if each.cause.group == NO_BLOCK else each.cause.group,
            *(in_percent(each.rendered_error[band]) for band in BAND_NAMES),
            ", ".join(each.named) or "no block",
        ]
        for each in tried
    ]
    return Table(["cause", "put into", *BAND_NAMES.values(), "named"], rows, "Error of the rendered force [%]")
