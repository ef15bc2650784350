"""How long a hand waits: set-up 1 on an emulated haptic device, from a reading to the force that answers it."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mmt_drake.diagrams.bench.measurement import Measurement
from mmt_drake.diagrams.bench.pacing import bare_loop
from mmt_drake.diagrams.devices import Devices, Hand
from mmt_drake.diagrams.scenario import load_scenario
from mmt_drake.diagrams.station import build_station
from mmt_drake.hw.omega.emulator import EmulatedOmega, load_emulated
from mmt_drake.hw.omega.trial.cost import tick_costs
from mmt_drake.realtime import Pace, ProcessOptions, real_time_process
from mmt_drake.recording import load

_SECONDS = 20.0
_TICK_US = 20.0  # target of the whole haptic path
_TICKS = 1.0  # target of the time from a reading to the force that answers it
_ARMED_AT = 100  # ticks after the start, when a person presses the switch
# A machine that is busy elsewhere must not end the run.
_PATIENT = ("operator_device.device=0", "operator_device.watchdog=null", "operator_device.limits.gap=2.0")


def measurements(seconds: float = _SECONDS, batches: int = 50) -> Iterator[Measurement]:
    """Cost of a tick of the haptic path, and latency of set-up 1 at 1 kHz, on the emulated vendor library.

    Args:
        seconds: of the run in real time.
        batches: of 100 ticks, of which the median is taken.

    Raises:
        MissingDependency: the extra `omega` or a C compiler is not installed.
    """
    with tempfile.TemporaryDirectory(prefix="emulated-") as folder:
        omega = EmulatedOmega(load_emulated(Path(folder)))
        names = {"device": "vendor's calls alone", "modular": "three systems", "grouped": "one system"}
        for which, cost in tick_costs(omega, batches).items():
            target = _TICK_US if which == "grouped" else None
            yield Measurement(f"haptic path, {names[which]}: a tick", 1e6 * cost, "us", target)
        yield from _latency(omega, seconds, Path(folder) / "out.mcap")


def _latency(omega: EmulatedOmega, seconds: float, record: Path) -> Iterator[Measurement]:
    scenario = load_scenario("setup1", _PATIENT)
    omega.reset()
    omega.set(real_time=1.0, soft_start=1.5, target_z=-0.03, swing_y=0.02, swing_hz=0.5)
    omega.set(hand_stiffness=1500.0, hand_damping=30.0)
    with Hand(scenario.operator_device, scenario.step) as hand:
        pace = _Answers(omega, hand)
        station = build_station(scenario, record=record, worker=True, devices=Devices(hand), pace=pace)
        with real_time_process(ProcessOptions()):
            station.simulate(seconds, pace=pace)
    answered, late, run = np.array(pace.answered), pace.late_s, f"set-up 1 on an emulated omega, {pace.steps} ticks"
    armed = load(record).columns["safety_armed"]
    yield Measurement(f"{run}: armed", 100.0 * float(armed.mean()), "%")
    for name, quantile, target in (("median", 0.5, None), ("99th percentile", 0.99, _TICKS), ("worst", 1.0, None)):
        waited = float(np.quantile(answered, quantile)) / scenario.step
        yield Measurement(f"{run}: reading to the force that answers it, {name}", waited, "ticks", target)
    bare = bare_loop(min(seconds, 6.0)).late_s
    for name, times in ((run, late), ("bare loop right after it", bare)):
        yield Measurement(f"{name}: lateness of a tick, 99th percentile", 1e6 * float(np.quantile(times, 0.99)), "us")


class _Answers(Pace):
    """Takes down, too, how long each reading waited for the force that answers it, by the library's own clock."""

    def __init__(self, omega: EmulatedOmega, hand: Hand) -> None:
        super().__init__()
        self.answered: list[float] = []
        self._omega, self._hand = omega, hand

    def done(self, behind: float) -> None:
        super().done(behind)
        self.answered.append(self._omega.get("answered_after"))
        if len(self.answered) == _ARMED_AT:
            self._hand.switch.arm()
