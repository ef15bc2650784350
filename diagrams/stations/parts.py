"""Parts of a station that no option builds: networks, detectors, and what goes with a device.

What goes with a device is imported where it is built: a simulation loads nothing of it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Diagram, DiagramBuilder, System
from pydrake.systems.primitives import MatrixGain, TrajectorySource, ZeroOrderHold
from pydrake.trajectories import PiecewisePolynomial

from mmt_drake.cloud import Cloud
from mmt_drake.diagrams.stations.nets import shown_first
from mmt_drake.diagrams.stations.returned import returned
from mmt_drake.diagrams.stations.site import Site
from mmt_drake.errors import BadInput
from mmt_drake.estimation.carried import GONE
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.hw.link.options import TELEROBOT
from mmt_drake.model.grasped_box import LOST
from mmt_drake.model_message import ModelMessage
from mmt_drake.network.config import ChannelConfig
from mmt_drake.realtime import PaceReport
from mmt_drake.systems.compliant_tip import CompliantTipSystem
from mmt_drake.systems.contact_detector import ContactDetector
from mmt_drake.systems.high_band_estimator import HighBandEstimator
from mmt_drake.systems.local_frame import LocalFrame
from mmt_drake.systems.network_channel import network_channel
from mmt_drake.systems.object_memory import ObjectMemory
from mmt_drake.systems.passivity_controlled_motion import PassivityControlledMotion
from mmt_drake.systems.probe_compensation import ProbeCompensation
from mmt_drake.systems.surface_contact_detector import SurfaceContactDetector
from mmt_drake.systems.touched_object import TouchedObject
from mmt_drake.systems.touched_surface import TouchedSurface

if TYPE_CHECKING:
    from mmt_drake.hw.safety.ages import CameraAge, DeviceAge, HandAge
    from mmt_drake.hw.safety.announcer import DeviceAnnouncer, SafetyAnnouncer
    from mmt_drake.hw.safety.rate_limiter import MotionRateLimiter
    from mmt_drake.hw.safety.while_well import WhileWell

# Seeds of the scenario's random streams lie apart, so that no two streams share numbers.
_TO_TELEROBOT_SEED, _TO_OPERATOR_SEED, _CLOUD_SEED, _TO_RENDERER_SEED = 211, 307, 401, 503
_WRIST_SEED = 601

_END = 2.0**30  # [s] of the clock's trajectory, 34 years


# ---------------------------------------------------------------------------------------------- to the telerobot
def to_telerobot(site: Site) -> System:
    """The network to the telerobot, which waits where the hand starts until the first packet arrives."""
    return _of_motion(site, _there(site))


def _there(site: Site) -> ChannelConfig:
    """The network to the telerobot: all that travels in its packets has its seed."""
    return site.seeded(site.scenario.to_telerobot, _TO_TELEROBOT_SEED)


def to_renderer(site: Site) -> System | None:
    """What is between the hand and the renderer beside it: nothing, if all is as it should be."""
    chosen = site.scenario.to_renderer
    return None if chosen == ChannelConfig() else _of_motion(site, site.seeded(chosen, _TO_RENDERER_SEED))


def _of_motion(site: Site, config: ChannelConfig) -> System:
    first = np.concatenate([site.start, np.zeros(3)])
    return network_channel(config, 6, site.step, initial=first, interpolation="motion")


def stamps_to_telerobot(site: Site) -> Diagram | None:
    """`received` (1): when the operator sent what the telerobot receives now [s].

    For an estimator that tells with it where friction holds the body. Stamps travel in the packets that carry the
    motion.
    """
    return stamps(_there(site), site.step) if "held_body" in returned(site.scenario) else None


def stamps(config: ChannelConfig, period: float) -> Diagram:
    """The time of the diagram that it is in, as a network shows it: `received` (1) [s].

    Args:
        config: of the network.
        period: of its ticks [s].
    """
    builder = DiagramBuilder()
    clock = builder.AddSystem(TrajectorySource(PiecewisePolynomial.FirstOrderHold([0.0, _END], [[0.0, _END]])))
    channel = builder.AddSystem(network_channel(config, 1, period, interpolation="linear"))
    builder.Connect(clock.get_output_port(), channel.GetInputPort("sent"))
    builder.ExportOutput(channel.GetOutputPort("received"), "received")
    return builder.Build()


def grip_to_telerobot(site: Site) -> System | None:
    """The grip, in the packets that carry the motion."""
    return None if site.scenario.carrying is None else network_channel(_there(site), 1, site.step)


def measured_stamps(site: Site) -> System | None:
    """The stamps of the measurement where it comes late: through a compensation."""
    if "compensation" not in site.parts or "held_body" not in returned(site.scenario):
        return None
    return network_channel(late(site), 1, site.step)


def late(site: Site) -> ChannelConfig:
    """By how much the measurement of a telerobot comes late."""
    return ChannelConfig(delay=site.parts["compensation"].ticks_late * site.step)


def passive_telerobot(site: Site) -> System | None:
    """The telerobot's end of a passivity control."""
    control = site.scenario.renderer.passivity
    return None if control is None else PassivityControlledMotion(period=site.step, control=control)


def limiter(site: Site) -> MotionRateLimiter | None:
    """What comes between a hand on sliders and a real arm."""
    if site.side != TELEROBOT or site.devices.arm is None or not site.sliders_move_hardware:
        return None
    from mmt_drake.hw.safety.rate_limiter import MotionRateLimiter

    return MotionRateLimiter(site.start, period=site.step)


def arm_model(site: Site) -> System | None:
    """The telerobot's arm, as the operator's side models it between the hand and the object.

    Raises:
        BadInput: the telerobot that is here yields otherwise.
    """
    arm, scenario = site.scenario.renderer.arm, site.scenario
    if arm is None:
        return None
    here = scenario.telerobot if site.devices.arm is None else scenario.telerobot_device
    if here is not None and (here.impedance.stiffness, here.impedance.damping) != (arm.stiffness, arm.damping):
        expected = f"the telerobot's, {here.impedance.stiffness:g} N/m and {here.impedance.damping:g} N s/m"
        found = f"{arm.stiffness:g} N/m and {arm.damping:g} N s/m"
        raise BadInput(scenario.name, at="renderer.arm", found=found, expected=expected)
    return CompliantTipSystem(arm.tip, site.start, period=site.step)


def energy_to_telerobot(site: Site) -> System | None:
    """Its energy, in the packets that carry the motion."""
    return None if site.scenario.renderer.passivity is None else network_channel(_there(site), 3, site.step)


# ------------------------------------------------------------------------------------------------- at the object
def arm(site: Site) -> System | None:
    """What holds the probe: an arm, a simulated one, or nothing."""
    if site.devices.arm is not None:
        return site.devices.arm.system
    chosen = site.scenario.telerobot
    return None if chosen is None else chosen.build(site.start, site.step, site.scenario.seed + _WRIST_SEED)


def compensation(site: Site) -> ProbeCompensation | None:
    """What clears the force of what holds the probe."""
    holder = site.devices.arm or site.scenario.telerobot
    if holder is None:
        return None
    return ProbeCompensation(replace(holder.compensation, step=site.step), shown_first(site.parts["arm"], "motion")[:3])


def detector(site: Site) -> ContactDetector | TouchedObject:
    """The telerobot's contact detector."""
    if site.scenario.several is not None:
        return TouchedObject(period=site.step, lost=None if site.scenario.carrying is None else LOST)
    by_plane = site.scenario.touch is not None
    return ContactDetector(site.surface.looking_ahead(site.proxy) if by_plane else site.proxy, by_plane=by_plane)


def scene(site: Site) -> System | None:
    """What sees which of several objects is which."""
    several = site.scenario.several
    return None if several is None else several.tracker(site)


def local_frame(site: Site) -> LocalFrame | None:
    """What an estimator reads on a surface that is not level."""
    level = site.scenario.shape is None and site.scenario.several is None
    return None if level else LocalFrame(period=site.step)


def touch(site: Site) -> TouchedSurface | None:
    """What corrects the surface by touches."""
    chosen = site.scenario.touch
    return None if chosen is None else TouchedSurface(chosen, period=site.step, radius=site.proxy.r3)


def while_well(site: Site) -> WhileWell | None:
    """No contact is shown of an arm that has stopped."""
    if site.devices.arm is None:
        return None
    from mmt_drake.hw.safety.while_well import WhileWell

    return WhileWell()


def learner(site: Site) -> System | None:
    """What names physics that the estimator's numbers leave out."""
    chosen = site.scenario.estimator
    if site.scenario.learner is None or not isinstance(chosen, OutputErrorOptions):
        return None
    from mmt_drake.learning.law_learner import LawLearner  # and with it the diagnosis

    first = ModelMessage.from_vector(chosen.model)
    return LawLearner(site.scenario.learner, step=site.step, worker=site.worker, first=first)


def high_band(site: Site) -> HighBandEstimator | None:
    """What fits a renderer's second model."""
    chosen = site.scenario.renderer.high_band
    with site.refusals_named("renderer"):
        return None if chosen is None else HighBandEstimator(chosen, period=site.step)


def pull(site: Site) -> MatrixGain | None:
    """F_com = K (x_d - x) + D (v_d - v), by which a simulated arm's controller pulls the tip [N]."""
    chosen = site.scenario.telerobot
    if chosen is None or site.devices.arm is not None:
        return None
    towards = np.hstack([chosen.impedance.stiffness * np.eye(3), chosen.impedance.damping * np.eye(3)])
    return MatrixGain(np.hstack([towards, -towards]))


# ---------------------------------------------------------------------------------------------- to the operator
def to_operator(site: Site) -> System:
    """The network back."""
    config = site.seeded(site.scenario.to_operator, _TO_OPERATOR_SEED)
    size = sum(returned(site.scenario).values())
    return network_channel(config, size, site.step, interpolation=site.scenario.renderer.between)


def clouds_to_operator(site: Site) -> System | None:
    """The network back as clouds see it, which cross it like everything else.

    Between two of its ticks a channel shows what is due at the second. Who looks a thousand times a second would see a
    cloud a frame too early, so it is read shortly before each of the channel's ticks: not at the tick, in the midst of
    which a flag that depends on the cloud would then change.
    """
    seen = site.scenario.seen_by_operator and site.scenario.several is None  # several are told one by one
    if not site.scenario.renderer.sees and not seen:
        return None
    config = site.seeded(site.scenario.to_operator, _CLOUD_SEED)
    frame, empty = 1.0 / site.scenario.environment.cloud.rate, AbstractValue.Make(Cloud.empty())
    channel = network_channel(config, empty, frame)
    if frame <= site.step or (config.is_constant and config.delay == 0.0):
        return channel
    builder = DiagramBuilder()
    builder.AddSystem(channel)
    shown = builder.AddSystem(ZeroOrderHold(frame, empty, frame - 0.5 * site.step))
    builder.Connect(channel.GetOutputPort("received"), shown.get_input_port())
    builder.ExportInput(channel.GetInputPort("sent"), "sent")
    builder.ExportOutput(shown.get_output_port(), "received")
    return builder.Build()


def operator_detector(site: Site) -> SurfaceContactDetector | TouchedObject | None:
    """A second detector, beside the operator."""
    if not site.scenario.seen_by_operator:
        return None
    if site.scenario.several is not None:
        return TouchedObject(period=site.step, lost=None if site.scenario.carrying is None else GONE)
    return SurfaceContactDetector(site.surface.looking_ahead(site.proxy))


def memory(site: Site) -> ObjectMemory | None:
    """What the operator's side remembers of several objects."""
    told = returned(site.scenario)
    return ObjectMemory(period=site.step) if {"told_thing", "model_status"} <= told.keys() else None


# ------------------------------------------------------------------------------------------------- of a run
def hand_age(site: Site) -> HandAge | None:
    """The age of a supervised hand's motion, infinite while it is not to be believed."""
    if site.devices.hand is None:
        return None
    from mmt_drake.hw.safety.ages import HandAge

    return HandAge()


def arm_age(site: Site) -> DeviceAge | None:
    """The age of an arm's readings."""
    if site.devices.arm is None:
        return None
    from mmt_drake.hw.safety.ages import DeviceAge

    return DeviceAge()


def camera_age(site: Site) -> CameraAge | None:
    """The age of a real camera's frames."""
    if not site.scenario.environment.cloud.real:
        return None
    from mmt_drake.hw.safety.ages import CameraAge

    return CameraAge()


def switch(site: Site) -> System | None:
    """The switches of an arm without a hand beside it."""
    return None if site.devices.arm is None or site.devices.hand is not None else site.devices.arm.switch


def pace(site: Site) -> PaceReport | None:
    """How a paced run keeps to the clock."""
    return None if site.pace is None else PaceReport(site.pace)


def announcer(site: Site) -> SafetyAnnouncer | None:
    """Tells what the supervisor of a hand does."""
    if site.devices.hand is None or site.tell is None:
        return None
    from mmt_drake.hw.safety.announcer import SafetyAnnouncer

    return SafetyAnnouncer(site.tell, site.devices.watched)


def arm_announcer(site: Site) -> DeviceAnnouncer | None:
    """Tells what an arm does."""
    if site.devices.arm is None or site.tell is None:
        return None
    from mmt_drake.hw.franka.faults import describe_fault
    from mmt_drake.hw.safety.announcer import DeviceAnnouncer

    return DeviceAnnouncer(site.tell, "arm", describe_fault)


def live_view(site: Site) -> System | None:
    """Shows the run in a browser."""
    if site.meshcat is None:
        return None
    from mmt_drake.systems.live_view import LiveView  # and with it the viewer's pages

    return LiveView(site.meshcat, site.scenario.detector)
