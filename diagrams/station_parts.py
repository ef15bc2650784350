"""The systems of a station, each by its name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import DiagramBuilder, LeafSystem, System
from pydrake.systems.primitives import ZeroOrderHold

from mmt_drake.cloud import Cloud, ProxySettings, contact_offset
from mmt_drake.diagrams import scenario as options
from mmt_drake.diagrams.devices import Devices
from mmt_drake.diagrams.ports import shown_first
from mmt_drake.diagrams.scenario import Scenario
from mmt_drake.diagrams.station_cloud import Surface, surface_of
from mmt_drake.diagrams.station_person import ORIGIN, person, told_of
from mmt_drake.diagrams.station_return import returned, stamps_to_telerobot, tells_held_body
from mmt_drake.diagrams.telerobots import (
    rests_at,
    simulated_telerobot,
    still_surface,
)
from mmt_drake.estimation.kinds import EstimatorOptions
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.network.config import ChannelConfig
from mmt_drake.recording import Recording
from mmt_drake.systems.contact_detector import ContactDetector
from mmt_drake.systems.direct_force import DirectForce
from mmt_drake.systems.flexible_box import FlexibleBox
from mmt_drake.systems.fused_reflection import FusedReflection
from mmt_drake.systems.high_band_estimator import HighBandEstimator
from mmt_drake.systems.impedance_reflection import ImpedanceReflection
from mmt_drake.systems.network_channel import network_channel
from mmt_drake.systems.output_error_estimator import OutputErrorEstimator
from mmt_drake.systems.passivity_controlled_force import PassivityControlledForce
from mmt_drake.systems.passivity_controlled_motion import PassivityControlledMotion
from mmt_drake.systems.probe_compensation import ProbeCompensation
from mmt_drake.systems.proxy_spring import ProxySpring
from mmt_drake.systems.rls_estimator import RlsEstimator
from mmt_drake.systems.surface_contact_detector import SurfaceContactDetector
from mmt_drake.viewer.viewer import Viewer

_ENDLESS_DURATION = 60.0  # [s] of a run whose operator has no end

# Seeds of the scenario's random streams lie apart, so that no two streams share numbers.
_NOISE_SEED, _TO_TELEROBOT_SEED, _TO_OPERATOR_SEED, _CLOUD_SEED, _TO_RENDERER_SEED = 101, 211, 307, 401, 503
_WRIST_SEED = 601


def station_parts(
    scenario: Scenario,
    *,
    operator: Recording | None = None,
    meshcat: Viewer | None = None,
    worker: bool = False,
    devices: Devices = Devices(),
) -> tuple[dict[str, System], float]:
    """The systems of a scenario by name, not yet wired, and how long a run lasts [s].

    Arguments and errors are those of `build_station`.
    """
    dt, world = scenario.step, scenario.environment
    hand, arm = devices.hand, devices.arm
    holder, length, middle = person(scenario, operator, meshcat) if hand is None else (hand.system, None, ORIGIN)
    start = shown_first(holder, "motion")
    with told_of(scenario, "environment.cloud"):
        surface = surface_of(scenario, middle, devices)
    proxy = replace(scenario.detector, period=dt)
    if proxy.surface_offset is None:
        proxy = replace(proxy, surface_offset=surface.offset)
    make: dict[str, Callable[[], System]] = {
        "to_telerobot": lambda: network_channel(
            _seeded(scenario.to_telerobot, scenario.seed + _TO_TELEROBOT_SEED),
            6,
            dt,
            # Until the first packet arrives the telerobot waits where the hand starts.
            initial=np.concatenate([start[:3], np.zeros(3)]),
            interpolation="motion",
        ),
        "to_renderer": lambda: network_channel(
            _seeded(scenario.to_renderer, scenario.seed + _TO_RENDERER_SEED),
            6,
            dt,
            initial=np.concatenate([start[:3], np.zeros(3)]),
            interpolation="motion",
        ),
        "environment": lambda: (
            still_surface(surface.shown)
            if arm is not None
            else FlexibleBox(
                world.object,
                period=dt,
                noise=replace(world.noise, seed=world.noise.seed + scenario.seed + _NOISE_SEED),
                surface=surface.shown,
                cloud_period=1.0 / world.cloud.rate,
                cloud_noise=surface.noise,
            )
        ),
        "detector": lambda: ContactDetector(proxy),
        "estimator": lambda: _estimator(replace(scenario.estimator, step=dt), worker),
        "to_operator": lambda: _to_operator(scenario),
        "renderer": lambda: _renderer(scenario, proxy),
    }
    if scenario.to_renderer == ChannelConfig():
        del make["to_renderer"]
    if tells_held_body(scenario) and scenario.to_telerobot != ChannelConfig():
        make["stamps_to_telerobot"] = lambda: stamps_to_telerobot(
            _seeded(scenario.to_telerobot, scenario.seed + _TO_TELEROBOT_SEED), dt
        )
    if isinstance(scenario.renderer, options.FusedReflection):
        second_model = scenario.renderer.high_band
        make["high_band"] = lambda: HighBandEstimator(second_model, period=dt)
    if scenario.switching == "operator":
        make["operator_detector"] = lambda: SurfaceContactDetector(_looking_ahead(proxy, surface))
    if isinstance(scenario.renderer, options.ProxySpring) or scenario.switching == "operator":
        make["clouds_to_operator"] = lambda: _clouds_to_operator(scenario)
    if isinstance(scenario.renderer, options.DirectForce) and scenario.renderer.passivity is not None:
        control = scenario.renderer.passivity
        make["telerobot"] = lambda: PassivityControlledMotion(period=dt, control=control)
        # The same seed: it travels in the packets that carry the motion.
        make["energy_to_telerobot"] = lambda: network_channel(
            _seeded(scenario.to_telerobot, scenario.seed + _TO_TELEROBOT_SEED), 3, dt
        )
    known, wrist = None, scenario.seed + _WRIST_SEED
    if arm is not None:
        make["arm"], known = (lambda: arm.system), arm.compensation
    elif (held := scenario.telerobot) is not None:
        make["arm"], known = (lambda: simulated_telerobot(held, start[:3], dt, wrist)), held.compensation
    if known is not None:
        of_probe = replace(known, step=dt)
        make["compensation"] = lambda: ProbeCompensation(of_probe, rests_at(parts["arm"]))
    parts: dict[str, System] = {"operator": holder}
    if surface.camera is not None:
        parts["camera"] = surface.camera
    for name, build in make.items():
        with told_of(scenario, name):
            parts[name] = build()
    return parts, scenario.duration or length or _ENDLESS_DURATION


def _estimator(chosen: EstimatorOptions, worker: bool) -> LeafSystem:
    if isinstance(chosen, RlsOptions):
        return RlsEstimator(chosen)
    return OutputErrorEstimator(chosen, worker=worker)


def _renderer(scenario: Scenario, proxy: ProxySettings) -> LeafSystem:
    chosen, dt = scenario.renderer, scenario.step
    if isinstance(chosen, options.ProxySpring):
        return ProxySpring(chosen.k, proxy)
    if isinstance(chosen, options.ImpedanceReflection):
        return ImpedanceReflection(period=dt, substeps=chosen.substeps, updates=chosen.updates, probe=chosen.probe)
    if isinstance(chosen, options.FusedReflection):
        return FusedReflection(chosen.high_band, period=dt, substeps=chosen.substeps, updates=chosen.updates)
    if chosen.passivity is None:
        return DirectForce(period=dt)
    return PassivityControlledForce(period=dt, control=chosen.passivity)


def _to_operator(scenario: Scenario) -> System:
    """The network back. Flags and parameters keep their value between packets, a force moves on."""
    config = _seeded(scenario.to_operator, scenario.seed + _TO_OPERATOR_SEED)
    interpolation = "linear" if isinstance(scenario.renderer, options.DirectForce) else "hold"
    return network_channel(config, sum(returned(scenario).values()), scenario.step, interpolation=interpolation)


def _clouds_to_operator(scenario: Scenario) -> System:
    """The network back as clouds see it, which cross it like everything else.

    Between two of its ticks a channel shows what is due at the second. Who looks a thousand times a second would see a
    cloud a frame too early, so it is read shortly before each of the channel's ticks: not at the tick, in the midst of
    which a flag that depends on the cloud would then change.
    """
    config = _seeded(scenario.to_operator, scenario.seed + _CLOUD_SEED)
    frame, empty = 1.0 / scenario.environment.cloud.rate, AbstractValue.Make(Cloud.empty())
    channel = network_channel(config, empty, frame)
    if frame <= scenario.step or (config.is_constant and config.delay == 0.0):
        return channel
    builder = DiagramBuilder()
    builder.AddSystem(channel)
    shown = builder.AddSystem(ZeroOrderHold(frame, empty, frame - 0.5 * scenario.step))
    builder.Connect(channel.GetOutputPort("received"), shown.get_input_port())
    builder.ExportInput(channel.GetInputPort("sent"), "sent")
    builder.ExportOutput(shown.get_output_port(), "received")
    return builder.Build()


def _looking_ahead(proxy: ProxySettings, surface: Surface) -> ProxySettings:
    """Settings of a proxy that touches before the hand does, wherever between the points it comes down.

    On a square lattice a sphere of radius r comes down spacing²/(4 r) lower in a gap than on a point; noise lifts it.
    """
    if surface.spacing == 0.0:
        return proxy
    ahead = surface.spacing**2 / (4.0 * proxy.r2) + 3.0 * surface.noise
    offset = proxy.surface_offset
    if offset is None:
        offset = contact_offset(proxy.r2, surface.spacing, surface.noise)
    return replace(proxy, surface_offset=offset - ahead)


def _seeded(config: ChannelConfig, seed: int) -> ChannelConfig:
    return replace(config, seed=config.seed + seed)
