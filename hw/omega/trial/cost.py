"""What a tick of the haptic path costs, against the emulated device."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, System
from pydrake.systems.primitives import ConstantVectorSource, Demultiplexer

from mmt_drake.hw.haptic_path import HapticPath
from mmt_drake.hw.omega.device import OmegaDevice
from mmt_drake.hw.omega.driver import OmegaDriver
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.omega.operator import OmegaOperator
from mmt_drake.hw.omega.settings import OmegaSettings
from mmt_drake.hw.safety import OperatorSwitch, supervised
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.systems.impedance_reflection import ImpedanceReflection

_PERIOD = 1e-3
_SETTINGS = OmegaSettings(device=0, watchdog=None)  # nothing is paced here
_SPIN = 2e-4  # [s] before a tick is due in which nothing sleeps
_BATCH = 100  # ticks; the machine may do something else between two batches


def tick_costs(omega: EmulatedOmega, batches: int = 50) -> dict[str, float]:
    """Median over batches of the time a tick takes [s].

    Args:
        omega: an emulated device; it runs in real time meanwhile.
        batches: of 100 ticks each.

    Returns:
        `device`: the four calls of the vendor's library; `modular`: driver, supervisor and renderer as three systems;
        `grouped`: the same as one, `HapticPath`.
    """
    costs: dict[str, float] = {}
    omega.reset()
    omega.set(real_time=1.0, target_z=-0.02)
    with OmegaDevice(_SETTINGS) as device:
        device.start()
        zero = np.zeros(3)

        def calls(ticks: int) -> None:
            for _ in range(ticks):
                device.read()
                device.set_force(zero)

        costs["device"] = _median(calls, batches)
    with OmegaOperator(_SETTINGS) as hand:
        costs["modular"] = _of_diagram(_modular(hand), batches)
    with HapticPath(OmegaDriver(_SETTINGS)) as path:
        costs["grouped"] = _of_diagram(_grouped(path), batches)
    return costs


def answer_times(omega: EmulatedOmega, ticks: int = 5000, period: float = _PERIOD) -> NDArray[np.float64]:
    """How long after each reading of the hand the force that answers it was with the library, paced in real time.

    Args:
        omega: an emulated device.
        ticks: how many.
        period: of a tick [s].

    Returns:
        (ticks) [s], by the library's own clock.
    """
    omega.reset()
    omega.set(real_time=1.0, target_z=-0.02)
    answered = np.empty(ticks)
    with HapticPath(OmegaDriver(_SETTINGS), period=period) as path:
        simulator = Simulator(_grouped(path))
        simulator.Initialize()
        simulator.AdvanceTo(period)
        start = time.perf_counter()
        for i in range(ticks):
            due = start + i * period
            time.sleep(max(0.0, due - time.perf_counter() - _SPIN))
            while time.perf_counter() < due:
                pass
            simulator.AdvanceTo((i + 2) * period)
            answered[i] = omega.get("answered_after")
    return answered


def _median(run: Callable[[int], None], batches: int) -> float:
    run(_BATCH)
    took = []
    for _ in range(batches):
        start = time.perf_counter()
        run(_BATCH)
        took.append(time.perf_counter() - start)
    return float(np.median(took)) / _BATCH


def _of_diagram(diagram: Diagram, batches: int) -> float:
    simulator = Simulator(diagram)
    simulator.Initialize()
    return _median(lambda ticks: simulator.AdvanceTo(simulator.get_context().get_time() + ticks * _PERIOD), batches)


def _modular(hand: OmegaOperator) -> Diagram:
    builder = DiagramBuilder()
    safe = builder.AddSystem(supervised(hand))
    renderer = builder.AddSystem(ImpedanceReflection())
    _feed(builder, renderer)
    builder.Connect(safe.GetOutputPort("motion"), renderer.GetInputPort("motion"))
    readout = renderer.GetOutputPort("readout")
    parts = builder.AddSystem(Demultiplexer([3, readout.size() - 3]))
    builder.Connect(readout, parts.get_input_port())
    builder.Connect(parts.get_output_port(0), safe.GetInputPort("force"))
    return builder.Build()


def _grouped(path: HapticPath) -> Diagram:
    builder = DiagramBuilder()
    builder.AddSystem(path)
    _feed(builder, path)
    switch = builder.AddSystem(OperatorSwitch())
    builder.Connect(switch.get_output_port(), path.GetInputPort("switches"))
    return builder.Build()


def _feed(builder: DiagramBuilder, user: System) -> None:
    """A model that is known, stable and touched."""
    for name, value in (("theta", FlexibleBoxModel().theta()), ("stable", [1.0]), ("in_contact", [1.0])):
        source = builder.AddSystem(ConstantVectorSource(value))
        builder.Connect(source.get_output_port(), user.GetInputPort(name))
