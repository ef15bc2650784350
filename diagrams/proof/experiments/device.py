"""Rendered force with a haptic device in the hand: an emulated one, tick by tick on its own clock."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Final

from pydrake.systems.analysis import Simulator

from mmt_drake.diagrams.proof.experiments.comparison import Comparison
from mmt_drake.diagrams.proof.experiments.comparisons.plants import judge, station_on
from mmt_drake.diagrams.proof.experiments.runs import Cases, MeasuredRun, run_case
from mmt_drake.diagrams.proof.studies.processes import results_of
from mmt_drake.diagrams.proof.studies.study import Asked, Progress, unheard
from mmt_drake.diagrams.stations.devices import Hand
from mmt_drake.diagrams.stations.scenario import Scenario
from mmt_drake.diagrams.stations.site import Devices
from mmt_drake.diagrams.stations.station import Station
from mmt_drake.hw.omega.emulator import EmulatedOmega, load_emulated
from mmt_drake.recording.atomic import writing

_ARMED_AT: Final = 20  # ticks after the start, when a person presses the switch
_DEVICE: Final = ("operator_device.device=0", "operator_device.watchdog=null")  # no pause of the program counts
_HAND: Final = {
    **{"soft_start": 1.0, "hand_stiffness": 600.0, "hand_damping": 8.0, "target_z": -0.015},
    **{"swing_y": 0.02, "swing_hz": 0.7, "sway_z": 0.025, "sway_hz": 0.2},
    **{"tremor_x": 0.008, "tremor_y": 0.003, "tremor_hz": 2.3},
}
"""Strokes along both axes, and a touch every five seconds; see `mmt_drake.hw.omega.emulator.emulated.FIELDS`."""
_CASES: Final = (
    "own",
    "foreign",
    "own, 0.5 N",
    "foreign, 0.5 N",
    "foreign, force 2 ms late",
    "foreign, 0.5 N, positions to 10 um, force 2 ms late, surface 0.2 mm higher",
)


@dataclass(frozen=True)
class OnDevice(Comparison):
    """Runs with the emulated device in the hand."""

    def run(self, asked: Asked, progress: Progress = unheard) -> Cases:
        """Run every case into a recording; no real device can be opened by this process from then on.

        Raises:
            BadInput: a folder that cannot be made.
            MissingDependency: the extra `omega` or a C compiler is not installed.
        """
        with writing(asked.out):
            asked.out.mkdir(parents=True, exist_ok=True)
        tasks: list[Callable[[], MeasuredRun]] = [
            partial(run_on_device, name, scenario, asked.out / f"device_{number}.mcap")
            for number, (name, scenario) in enumerate(self.scenarios(asked).items())
        ]
        return {case.name: case for case in results_of(tasks, asked.jobs, progress, compile_first=True)}


def run_on_device(name: str, scenario: Scenario, file: Path) -> MeasuredRun:
    """Run a scenario with the emulated device in the hand, as `run --hardware` would on a machine that is never late.

    Raises:
        BadInput: as `run_case`.
        MissingDependency: the extra `omega` or a C compiler is not installed.
    """
    omega = EmulatedOmega(load_emulated(Path(_folder().name)))
    omega.reset()
    omega.set(**_HAND)
    with Hand(scenario.operator_device, scenario.step, clock=lambda: omega.get("clock")) as hand:
        devices, play = Devices(hand), partial(_play, omega=omega, hand=hand)
        return run_case(name, scenario, file, devices=devices, play=play)


@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    """For the library, of which a process has one as long as it lives."""
    return tempfile.TemporaryDirectory(prefix="emulated-")


def _play(station: Station, omega: EmulatedOmega, hand: Hand) -> None:
    step = station.scenario.step
    with station:
        simulator = Simulator(station.diagram)
        simulator.Initialize()
        for tick in range(round(station.duration / step)):
            if tick == _ARMED_AT:
                hand.switch.arm()
            simulator.AdvanceTo((tick + 0.5) * step)  # up to the next tick and not into it
            omega.advance(step)


def cases(asked: Asked) -> Mapping[str, Scenario]:
    """The plants under the device's motion."""
    return {name: station_on(name, asked, *_DEVICE) for name in _CASES}


ON_DEVICE: Final = OnDevice(
    name="device",
    title="Is the rendered force right with a haptic device in the hand?",
    lead=(
        "`setup1-free-running` with the emulated Omega.7 in the hand, tick by tick on its own clock: encoders of 5 um, "
        "a person's arm that yields to what it feels, limits and supervisor of the device. The object is simulated. "
        "Friction of 0.1 N that holds and 0.05 N that slides unless a case says otherwise."
    ),
    cases=cases,
    judge=judge,
    takes=("seconds", "seed"),
    file=lambda number, name: str(number),
)
STUDIES: Final = {ON_DEVICE.name: ON_DEVICE.study}
