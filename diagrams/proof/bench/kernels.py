"""Compiled kernels, each beside a peer that does the same in the same minutes."""

import itertools
import statistics
import tempfile
import time
import timeit
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LinearSystem, VectorLogSink

from mmt_drake.cloud import Cloud, ProxySettings, plane
from mmt_drake.cloud.proxy import new_memory, step_proxy
from mmt_drake.diagrams.proof.studies.measurement import Measurement
from mmt_drake.diagrams.stations.environment import THESIS_FRICTION
from mmt_drake.effects import LIBRARY
from mmt_drake.model import flexible_box as box
from mmt_drake.model.linear import state_space
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.recording import McapWriter, load
from mmt_drake.recording.signals import columns_of, signals_in
from mmt_drake.systems.scripted_operator import ScriptedOperator

STEP = 1e-3
_PALPATION_SPEED = 0.2  # [m/s] of the hand that slides over the cloud


def median_seconds(call: Callable[[], object], times: int) -> float:
    """Median wall time of one call [s], after one that is not counted."""
    call()
    return statistics.median(timeit.repeat(call, number=1, repeat=times))


def measurements() -> Iterator[Measurement]:
    """Replay, contact detector, neighbour structure, recordings."""
    yield from _replay()
    yield from _detector(300_000)
    yield from _detector(30_000)
    yield from _neighbours()
    yield from _recording()


def _replay() -> Iterator[Measurement]:
    times = np.linspace(0.0, 60.0 - STEP, 60_000)
    position, velocity = scripted_motion("strokes").sample(times)
    nominal = FlexibleBoxModel(friction=THESIS_FRICTION)
    contact = np.full(len(times), box.CONTACT_BY_GEOMETRY)
    force, body = np.empty((len(times), 3)), np.empty((len(times), 4))

    def seconds(model: FlexibleBoxModel) -> float:
        p = model.kernel_vector()
        return median_seconds(lambda: box.replay(times, position, velocity, contact, p, force, body), 7)

    ours = seconds(nominal)
    yield Measurement("replay of 60 s at 1 kHz, both tangential axes", ours * 1e3, "ms", 10.0)
    for name, parameters in (("quadratic_drag", {"c": 5.0}), ("nonlinear_stiffness", {"k3": 1e5})):
        effect = LIBRARY[name]
        model = effect.apply(nominal, effect.checked(parameters, nominal, "bench"))
        yield Measurement(f"the same with the effect {name}", seconds(model) * 1e3, "ms", 32.0)
    peer = _linear_system_seconds(10.0) * 6.0
    yield Measurement(
        "the same, linear and one axis, as Drake's LinearSystem (C++, RK3): time against ours", peer / ours, "x"
    )


def _linear_system_seconds(duration: float) -> float:
    """Wall time of Drake's own integrator on the object's linear part, one axis [s]."""
    A, B, _, _ = state_space(BoxParameters())
    builder = DiagramBuilder()
    hand = builder.AddSystem(ScriptedOperator(scripted_motion("strokes")))
    # y and its rate out of (x, y, z, vx, vy, vz)
    pick = np.zeros((2, 6))
    pick[0, 1] = pick[1, 4] = 1.0
    system = builder.AddSystem(LinearSystem(A, B @ pick, np.eye(2), np.zeros((2, 6))))
    builder.Connect(hand.GetOutputPort("motion"), system.get_input_port())
    log = builder.AddSystem(VectorLogSink(2, STEP))
    builder.Connect(system.get_output_port(), log.get_input_port())
    simulator = Simulator(builder.Build())
    simulator.get_mutable_integrator().set_fixed_step_mode(True)
    simulator.get_mutable_integrator().set_maximum_step_size(STEP)
    simulator.Initialize()
    start = time.perf_counter()
    simulator.AdvanceTo(duration)
    return time.perf_counter() - start


def _detector(points: int) -> Iterator[Measurement]:
    """One tick while the hand slides pressed into the surface, and one free above it."""
    cloud = plane(points, layout="jittered", seed=1)
    target = 100.0 if points == 300_000 else None
    for name, height in (("sliding in contact", -0.005), ("free, 20 mm above", 0.02)):
        tick = 1e6 * _proxy_seconds(cloud, height)
        yield Measurement(f"contact detector, one tick, {points} points, {name}", tick, "us", target)


def _proxy_seconds(cloud: Cloud, height: float) -> float:
    """Median time of a tick of a hand that slides at this height."""
    settings, memory = ProxySettings(), new_memory()
    ticks = np.arange(3001) * settings.period
    hand = np.column_stack([0.1 * np.sin(_PALPATION_SPEED / 0.1 * ticks), 0.3 * ticks - 0.1 * ticks**2, 0 * ticks])
    hand[:, 1] -= hand[:, 1].mean()
    hand[:, 2] = height
    at, packed = iter(hand), settings.packed()
    return median_seconds(lambda: step_proxy(memory, next(at), cloud, packed), len(hand) - 1)


def _neighbours() -> Iterator[Measurement]:
    from scipy.spatial import cKDTree

    for points in (30_000, 300_000):
        xyz = plane(points, layout="jittered", seed=1).points()
        ours = median_seconds(partial(Cloud, xyz), 5)
        peer = median_seconds(partial(cKDTree, xyz), 3)
        yield Measurement(f"neighbour structure of {points} points, built once per cloud", ours * 1e3, "ms")
        yield Measurement(f"the same as scipy's k-d tree: time against ours, {points} points", peer / ours, "x")


def _recording() -> Iterator[Measurement]:
    """A minute of every signal of a contact at 1 kHz, in blocks of a second as the recorder writes them."""
    signals = signals_in(columns_of("contact"))
    random = np.random.default_rng(0)
    block = {signal.name: random.random((1000, signal.size)).round() for signal in signals}  # flags are 0 or 1
    block["orientation"] = np.tile([0.0, 0.0, 0.0, 1.0], (1000, 1))
    ticks, seconds = np.arange(1000) * STEP, itertools.count()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "minute.mcap"
        with McapWriter(path, [(signal.name, signal.size) for signal in signals]) as writer:
            encoding = median_seconds(lambda: writer.write_block(next(seconds) + ticks, block), 59)
        reading = median_seconds(lambda: load(path), 3)
    yield Measurement(f"recorder: encode 1000 ticks of {len(signals)} signals", encoding * 1e3, "ms")
    yield Measurement(f"reading a 60 s recording of {len(signals)} signals", reading * 1e3, "ms")
