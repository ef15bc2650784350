"""Compiled kernels, each beside a peer that does the same in the same minutes."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LinearSystem, VectorLogSink

from diagrams.bench.figure import Figure
from mmt_drake.cloud import Cloud, ProxySettings, plane
from mmt_drake.cloud.proxy import new_memory, step_proxy
from mmt_drake.model import flexible_box as box
from mmt_drake.model.parameters import FlexibleBoxModel, Friction
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.systems.scripted_operator import ScriptedOperator

Array = NDArray[np.float64]

STEP = 1e-3
_PALPATION_SPEED = 0.2  # [m/s] of the hand that slides over the cloud


def median_seconds(call: Callable[[], object], times: int) -> float:
    """Median wall time of one call [s], after one that is not counted."""
    call()
    samples = np.empty(times)
    for i in range(times):
        start = time.perf_counter()
        call()
        samples[i] = time.perf_counter() - start
    return float(np.median(samples))


def figures() -> Iterator[Figure]:
    """Replay, contact detector and neighbour structure."""
    yield from _replay()
    yield from _detector(300_000)
    yield from _detector(30_000)
    yield from _neighbours()


def _replay() -> Iterator[Figure]:
    times = np.arange(60_000) * STEP
    position, velocity = scripted_motion("strokes").sample(times)
    p = FlexibleBoxModel(friction=Friction(0.1, 0.05, 0.005)).kernel_vector()
    contact = np.full(len(times), box.CONTACT_BY_GEOMETRY)
    force, body = np.empty((len(times), 3)), np.empty((len(times), 4))
    ours = median_seconds(lambda: box.replay(times, position, velocity, contact, p, force, body), 7)
    yield Figure("replay of 60 s at 1 kHz, both tangential axes", ours * 1e3, "ms", 10.0)
    peer = _linear_system_seconds(10.0) * 6.0
    yield Figure(
        "the same, linear and one axis, as Drake's LinearSystem (C++, RK3): time against ours", peer / ours, "x"
    )


def _linear_system_seconds(duration: float) -> float:
    """Wall time of Drake's own integrator on the object's linear part, one axis [s]."""
    A = np.array([[0.0, 1.0], [-500.0, -120.0]])
    B = np.array([[0.0, 0.0], [500.0, 60.0]])
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


def _detector(points: int) -> Iterator[Figure]:
    """One tick while the hand slides pressed into the surface, and one free above it."""
    settings = ProxySettings()
    packed = settings.packed()
    cloud = plane(points, layout="jittered", seed=1)
    for name, height in (("sliding in contact", -0.005), ("free, 20 mm above", 0.02)):
        memory = new_memory()
        ticks = np.arange(3000) * settings.period
        hand = np.column_stack([0.1 * np.sin(_PALPATION_SPEED / 0.1 * ticks), 0.3 * ticks - 0.1 * ticks**2, 0 * ticks])
        hand[:, 1] -= hand[:, 1].mean()
        hand[:, 2] = height
        samples = np.empty(len(ticks))
        for i in range(len(ticks)):
            start = time.perf_counter()
            step_proxy(memory, hand[i], cloud, packed)
            samples[i] = time.perf_counter() - start
        target = 100.0 if points == 300_000 else None
        yield Figure(f"contact detector, one tick, {points} points, {name}", np.median(samples) * 1e6, "us", target)


def _neighbours() -> Iterator[Figure]:
    from scipy.spatial import cKDTree

    for points in (30_000, 300_000):
        xyz = plane(points, layout="jittered", seed=1).points()
        ours = median_seconds(lambda xyz=xyz: Cloud(xyz), 5)  # type: ignore[misc]
        peer = median_seconds(lambda xyz=xyz: cKDTree(xyz), 3)  # type: ignore[misc]
        yield Figure(f"neighbour structure of {points} points, built once per cloud", ours * 1e3, "ms")
        yield Figure(f"the same as scipy's k-d tree: time against ours, {points} points", peer / ours, "x")
