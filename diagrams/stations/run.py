"""A station in simulation from Python: built, run, and what was recorded."""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from mmt_drake.diagrams.stations.hands import load_operator
from mmt_drake.diagrams.stations.own_parts import Make
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario
from mmt_drake.diagrams.stations.station import build_station, worth_spreading
from mmt_drake.errors import BadInput, check_number
from mmt_drake.recording import Recording, load, save
from mmt_drake.recording.files import check_target, kept_as_recorded, native_of
from mmt_drake.recording.mcap_writer import whole_or_none


def run(
    scenario: str | Path | Scenario,
    *,
    seconds: float | None = None,
    operator: str | Path | Recording | None = None,
    record: str | Path | None = None,
    estimator: str | Make | None = None,
    renderer: str | Make | None = None,
) -> Recording:
    """Run a station in simulation and give what was recorded.

    Args:
        scenario: or its file, or the name of a shipped one.
        seconds: how long; the scenario's duration by default, with an operator that of its motion.
        operator: replaces the scenario's hand by this recording's motion.
        record: keeps the recording: .mcap, .csv or .npz.
        estimator, renderer: of one's own, as for `build_station`.

    Raises:
        BadInput: as `build_station`; or no time to run; or the file cannot be written.
    """
    if seconds is not None:
        check_number("run", "seconds", seconds, least=0.0, open_interval=True)
    chosen = scenario if isinstance(scenario, Scenario) else load_scenario(scenario)
    hand = operator if operator is None or isinstance(operator, Recording) else load_operator(str(operator))
    if hand is not None:
        chosen = replace(chosen, duration=None)
    target = None if record is None else Path(record)
    if target is not None:
        check_target(target)
    with TemporaryDirectory(prefix="mmt-drake-") as folder:
        native = native_of(target, folder)
        spread = worth_spreading(chosen, seconds)
        station = build_station(
            chosen, record=native, operator=hand, spread=spread, estimator=estimator, renderer=renderer
        )
        assert station.recorder is not None  # it was asked for
        with whole_or_none(station.recorder.file, native):
            station.simulate(seconds)
        try:
            recording = load(native)
        except BadInput as refused:
            if native == target:
                raise
            told = refused.of(chosen.name) if target is None else kept_as_recorded(refused, native, target)
            raise told from None
        if target is not None and target != native:
            save(recording, target)
    return replace(recording, source=chosen.name if target is None else str(target))
