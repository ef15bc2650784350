"""Cost of `run setup1 --hardware`, and of set-up 4 wired like that: at 1 kHz on an emulated haptic device."""

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mmt_drake.diagrams.proof.bench.kernels import median_seconds
from mmt_drake.diagrams.proof.bench.pacing import bare_loop, loop_priority
from mmt_drake.diagrams.proof.faults.patient_clock import PatientClock
from mmt_drake.diagrams.proof.studies.measurement import Measurement
from mmt_drake.diagrams.stations.devices import Hand
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.site import Devices
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.hw.omega.device import OmegaDevice
from mmt_drake.hw.omega.emulator import EmulatedOmega, load_emulated
from mmt_drake.hw.omega.settings import OmegaSettings
from mmt_drake.realtime import Pace, ProcessOptions, real_time_process
from mmt_drake.recording import load

_SECONDS = 20.0
_TICKS = 1.0  # target of the time from a reading to the force that answers it
_CALLS = 5000  # of the vendor's library, of which the median is taken
_ARMED_AT = 100  # ticks after the start, when a person presses the switch
# A machine that is busy elsewhere must not end the run.
_PATIENT = ("operator_device.device=0", "operator_device.watchdog=null")
_MOTIONS = {"setup1": {"target_z": -0.03}, "setup4": {"target_x": -0.01, "target_z": -0.005}}
"""Where the hand of each set-up presses: in set-up 4 on the brick, whose scene a simulated camera sees."""


def measurements(seconds: float = _SECONDS) -> Iterator[Measurement]:
    """The vendor's calls by themselves, and ticks of set-ups 1 and 4 at 1 kHz, on the emulated vendor library.

    Args:
        seconds: of each run in real time.

    Raises:
        MissingDependency: the extra `omega` or a C compiler is not installed.
    """
    with tempfile.TemporaryDirectory(prefix="emulated-") as folder:
        omega = EmulatedOmega(load_emulated(Path(folder)))
        yield Measurement("reading the device and setting its force, median", 1e6 * _calls(omega), "us")
        yield loop_priority()
        for name in _MOTIONS:
            yield from _ticks(omega, name, seconds, Path(folder) / "out.mcap")


def _calls(omega: EmulatedOmega) -> float:
    """Median time of the calls of a tick [s]."""
    omega.reset()
    omega.set(real_time=1.0, target_z=-0.02)
    zero = np.zeros(3)
    with OmegaDevice(OmegaSettings(device=0, watchdog=None)) as device:  # nothing is paced here
        device.start()
        return median_seconds(lambda: (device.read(), device.set_force(zero)), _CALLS)


def _ticks(omega: EmulatedOmega, name: str, seconds: float, record: Path) -> Iterator[Measurement]:
    scenario = load_scenario(name, _PATIENT)
    omega.reset()
    omega.set(real_time=1.0, soft_start=1.5, swing_y=0.02, swing_hz=0.5, hand_stiffness=1500.0, hand_damping=30.0)
    omega.set(**_MOTIONS[name])
    with Hand(scenario.operator_device, scenario.step, supervisor_clock=PatientClock()) as hand:
        pace = _Answers(omega, hand)
        station = build_station(scenario, record=record, worker=True, devices=Devices(hand), pace=pace)
        with real_time_process(ProcessOptions()):
            station.simulate(seconds, pace=pace)
    answered, late = np.array(pace.answered), pace.late_s
    run = f"{name} on an emulated omega, {len(late)} ticks"
    armed = load(record).columns["safety_armed"]
    yield Measurement(f"{run}: armed", 100.0 * float(armed.mean()), "%")
    quantiles = (("median", 0.5, None), ("99th percentile", 0.99, _TICKS), ("worst", 1.0, None))
    for name, quantile, target in quantiles:
        waited = float(np.quantile(answered, quantile)) / scenario.step
        yield Measurement(f"{run}: reading to the force that answers it, {name}", waited, "ticks", target)
    for name, quantile, _ in quantiles[:2]:
        took = 1e6 * float(np.quantile(pace.took, quantile))
        yield Measurement(f"{run}, recorded: processor time of a tick, emulator included, {name}", took, "us")
    bare = bare_loop(min(seconds, 6.0)).late_s
    for name, times in ((run, late), ("bare loop right after it", bare)):
        yield Measurement(f"{name}: lateness of a tick, 99th percentile", 1e6 * float(np.quantile(times, 0.99)), "us")


class _Answers(Pace):
    """Takes down, too, processor time, and how long each reading waited for its force, by the library's own clock."""

    def __init__(self, omega: EmulatedOmega, hand: Hand) -> None:
        super().__init__()
        self.answered: list[float] = []
        self.took: list[float] = []
        self._omega, self._hand, self._start = omega, hand, 0.0

    def began(self, late: float) -> None:
        super().began(late)
        self._start = time.thread_time()

    def done(self, behind: float) -> None:
        self.took.append(time.thread_time() - self._start)
        super().done(behind)
        self.answered.append(self._omega.get("answered_after"))
        if len(self.answered) == _ARMED_AT:
            self._hand.switch.arm()
