"""The topology of every station: its parts, what each of them reads, and what is recorded.

A net (`mmt_drake.diagrams.stations.nets`) comes from the first of its sources that a station has. So a part that a
scenario does not ask for takes its nets along, and nothing else says what is connected to what: the builder, the
recorder, the live view, the replay of blocks, the cut between two machines and the picture all read this table.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from pydrake.systems.framework import System

from mmt_drake.diagrams.stations import carrying, parts
from mmt_drake.diagrams.stations.estimators import estimator
from mmt_drake.diagrams.stations.returned import RETURNED
from mmt_drake.diagrams.stations.site import Site
from mmt_drake.hw.link.options import OPERATOR, TELEROBOT, Role


@dataclass(frozen=True)
class Part:
    """One part of a station.

    Attributes:
        name: of its system.
        build: makes it from the options that say how; None: this station has no such part.
        side: where it stands on two machines; None: on each.
        at: column and row in the picture; None: it is left out.
        crosses: the output port by which it carries a signal to the other side; None: it is no network.
    """

    name: str
    build: Callable[[Site], System | None]
    side: Role | None = None
    at: tuple[int, int] | None = None
    crosses: str | None = None


AGES: Final = {"peer": "link.age", "camera": "camera_age.age", "arm": "arm_age.age"}
"""What the supervisor of a hand on a device may watch; joined as it asks for them they are the net `watched`."""

NETS: Final = {
    "commanded": "limiter.motion | to_telerobot.received",
    "probe": "telerobot.motion | commanded",
    "tip": "arm.motion | probe",
    "seen": "camera.point_cloud | environment.point_cloud",
    "surface": "touch.corrected | seen",
    "measurement": "compensation.measurement | environment.measurement",
    "local_measurement": "local_frame.measurement | touch.lowered | measurement",
    "measured_contact": "load.in_contact | compensation.in_contact | detector.in_contact",
    "detected": "while_well.signal | load.in_contact | detector.in_contact",
    "stamp": "measured_stamps.received | stamps_to_telerobot.received",
    "grip": "operator.grip | grip_script.grip",
    "felt": "to_renderer.received | operator.motion",
    "felt_force": "carried.force | renderer.force",
    "operator_contact": "operator_detector.in_contact | to_operator.in_contact",
    "touching": "arm_model.motion | felt",
    "told_model": "estimator.model if learner.model | to_operator.model",
}
"""Nets that are read more than once. `returned` is what crosses the network to the operator."""

PARTS: Final = (
    Part("operator", lambda site: site.person.system, OPERATOR, (0, 0)),
    Part("camera", lambda site: site.surface.camera, TELEROBOT, (3, 1)),
    Part("to_telerobot", parts.to_telerobot, OPERATOR, (1, 0), crosses="received"),
    Part("stamps_to_telerobot", parts.stamps_to_telerobot, OPERATOR, (1, 4), crosses="received"),
    Part("grip_script", carrying.grip_script, OPERATOR),
    Part("grip_to_telerobot", parts.grip_to_telerobot, OPERATOR, (1, 5), crosses="received"),
    Part("limiter", parts.limiter, TELEROBOT),
    Part("to_renderer", parts.to_renderer, OPERATOR, (0, 3)),
    Part("arm_model", parts.arm_model, OPERATOR),
    Part("arm", parts.arm, TELEROBOT, (3, 3)),
    Part("environment", lambda site: site.scenario.environment.build(site), TELEROBOT, (3, 0)),
    Part("scene", parts.scene, TELEROBOT, (4, 1)),
    Part("detector", parts.detector, TELEROBOT, (2, 1)),
    Part("compensation", parts.compensation, TELEROBOT, (2, 3)),
    Part("touch", parts.touch, TELEROBOT),
    Part("local_frame", parts.local_frame, TELEROBOT),
    Part("while_well", parts.while_well, TELEROBOT),
    Part("measured_stamps", parts.measured_stamps, TELEROBOT, (2, 4)),
    Part("estimator", estimator, TELEROBOT, (3, 2)),
    Part("learner", parts.learner, TELEROBOT, (3, 4)),
    Part("load", carrying.load, TELEROBOT, (3, 5)),
    Part("high_band", parts.high_band, TELEROBOT, (2, 2)),
    Part("telerobot", parts.passive_telerobot, TELEROBOT, (2, 0)),
    Part("renderer", lambda site: site.scenario.renderer.build(site), OPERATOR, (0, 2)),
    Part("carried", carrying.carried, OPERATOR, (0, 5)),
    Part("to_operator", parts.to_operator, TELEROBOT, (1, 2), crosses="received"),
    Part("clouds_to_operator", parts.clouds_to_operator, TELEROBOT, (1, 1), crosses="received"),
    Part("operator_detector", parts.operator_detector, OPERATOR, (0, 1)),
    Part("memory", parts.memory, OPERATOR, (1, 5)),
    Part("energy_to_telerobot", parts.energy_to_telerobot, OPERATOR, (1, 3), crosses="received"),
    # What only a recording asks for, and what runs in real time.
    Part("pull", parts.pull, TELEROBOT),
    Part("hand_age", parts.hand_age, OPERATOR),
    Part("arm_age", parts.arm_age, TELEROBOT),
    Part("camera_age", parts.camera_age, TELEROBOT, crosses="age"),
    Part("switch", parts.switch, TELEROBOT),
    Part("pace", parts.pace),
    Part("announcer", parts.announcer, OPERATOR),
    Part("arm_announcer", parts.arm_announcer, TELEROBOT),
    Part("live_view", parts.live_view),
)

_BESIDE: Final = ("carried", "scene", "told_thing")
"""What comes back for parts beside the renderer."""

READS: Final = {
    "operator.force": "felt_force",
    "operator.ages": "watched",
    "camera.body": "environment.body",
    "camera.bodies": "environment.bodies",
    "camera.probe": "tip[0:3]",
    "to_telerobot.sent": "operator.motion",
    "limiter.commanded": "to_telerobot.received",
    "to_renderer.sent": "operator.motion",
    "arm.commanded": "probe",
    "arm.force": "environment.force",
    "arm.age": "hand_age.age | link.age",
    "arm.switches": "operator.switches | switch.switches",
    "environment.motion": "tip",
    "environment.grip": "grip_to_telerobot.received",
    "grip_to_telerobot.sent": "grip",
    "detector.position": "tip[0:3]",
    "detector.point_cloud": "surface",
    "detector.scene": "scene.scene",
    "scene.position": "measurement[0:3]",
    "scene.point_cloud": "surface",
    "scene.thing": "detector.thing",
    "scene.held": "environment.held",
    "detector.grip": "grip_to_telerobot.received",
    "detector.has": "environment.held[0:1]",
    "compensation.raw_measurement": "arm.raw_measurement",
    "compensation.in_contact": "detector.in_contact",
    "compensation.clearance": "detector.clearance",
    "while_well.signal": "detector.in_contact",
    "while_well.device": "arm.device",
    "measured_stamps.sent": "stamps_to_telerobot.received",
    "touch.measurement": "measurement",
    "touch.point_cloud": "seen",
    "touch.clearance": "detector.clearance",
    "touch.force_lateness": "estimator.force_lateness",
    "touch.model_status": "estimator.model_status",
    "local_frame.raw_measurement": "measurement",
    "local_frame.facet": "detector.facet",
    "local_frame.estimated_force": "estimator.estimated_force",
    "local_frame.filtered_force": "estimator.filtered_force",
    "estimator.measurement": "local_measurement",
    "estimator.in_contact": "measured_contact",
    "estimator.reading": "compensation.reading",
    "estimator.stamp": "stamp",
    "estimator.model": "learner.model",
    "estimator.thing": "detector.thing",
    "estimator.scene": "scene.scene",
    "learner.measurement": "local_measurement",
    "learner.in_contact": "measured_contact",
    "learner.theta": "estimator.theta",
    "learner.model_status": "estimator.model_status",
    "learner.residual_ratio": "estimator.residual_ratio",
    "learner.force_lateness": "estimator.force_lateness",
    "load.measurement": "local_measurement",
    "load.held": "environment.held",
    "load.grip": "grip_to_telerobot.received",
    "load.in_contact": "compensation.in_contact | detector.in_contact",
    "load.theta": "estimator.theta",
    "carried.motion": "touching",
    "carried.force": "renderer.force",
    "carried.grip": "grip",
    "carried.in_contact": "operator_contact",
    "carried.theta": "memory.theta | to_operator.theta",
    "carried.facet": "operator_detector.facet",
    "carried.height": "operator_detector.height",
    "carried.thing": "operator_detector.thing",
    "carried.carried": "to_operator.carried",
    "high_band.measurement": "local_measurement",
    "high_band.in_contact": "measured_contact",
    "high_band.theta": "estimator.theta",
    "high_band.stable": "estimator.stable",
    "telerobot.commanded": "commanded",
    "telerobot.force": "measurement[6:9]",
    "telerobot.remote_energy": "energy_to_telerobot.received",
    **{
        f"renderer.{name}": f"to_operator.{name}" for name in RETURNED if name not in ("carried", "scene", "told_thing")
    },
    "renderer.theta": "memory.theta | to_operator.theta",
    "renderer.stable": "memory.stable | to_operator.stable",
    "renderer.model_status": "memory.model_status | to_operator.model_status",
    "renderer.thing": "operator_detector.thing",
    "memory.thing": "operator_detector.thing",
    **{f"memory.{name}": f"to_operator.{name}" for name in ("scene", "told_thing", "theta", "stable", "model_status")},
    "arm_model.commanded": "felt",
    "arm_model.force": "renderer.force",
    "renderer.motion": "touching",
    "renderer.hand": "felt if arm_model.motion",
    "renderer.in_contact": "carried.in_contact | operator_contact",
    "renderer.facet": "operator_detector.facet",
    "renderer.point_cloud": "clouds_to_operator.received",
    "to_operator.sent": "returned",
    "clouds_to_operator.sent": "surface",
    "operator_detector.position": "touching[0:3]",
    "operator_detector.point_cloud": "clouds_to_operator.received",
    "operator_detector.scene": "to_operator.scene",
    "operator_detector.grip": "grip",
    "operator_detector.has": "to_operator.carried[0:1]",
    "energy_to_telerobot.sent": "renderer.energy_in",
    "pull.u0": "probe + tip",
    "hand_age.status": "operator.status",
    "arm_age.device": "arm.device",
    "camera_age.camera": "camera.camera",
    "announcer.status": "operator.status",
    "arm_announcer.device": "arm.device",
    "live_view.motion": "operator.motion",
    "live_view.measurement": "measurement",
    "live_view.rendered_force": "felt_force",
    "live_view.in_contact": "detector.in_contact | operator_detector.in_contact | to_operator.in_contact",
    "live_view.proxy": "detector.proxy",
    "live_view.normal": "detector.facet[0:3]",
    "live_view.body_position": "environment.body[0:2]",
    "live_view.theta": "estimator.theta | to_operator.theta",
    "live_view.stable": "estimator.stable | to_operator.stable",
    "live_view.model_status": "estimator.model_status | to_operator.model_status",
    "live_view.model": "told_model",
    "live_view.learner_status": "learner.status",
    "live_view.carried": "load.carried | to_operator.carried",
    "live_view.estimated_force": "local_frame.estimated | estimator.estimated_force",
    "live_view.true_force": "environment.force",
    "live_view.scene": "scene.scene | to_operator.scene",
    "live_view.point_cloud": "surface",
}
"""Input ports of parts -> the nets that they read, if the system has such a port."""

RECORDED: Final = {
    "master_position": "operator.motion[0:3]",
    "master_velocity": "operator.motion[3:6]",
    # Beside the operator of two machines the only probe that is known is the one in the local model.
    "position": "measurement[0:3] | operator.motion[0:3]",
    "velocity": "measurement[3:6] | operator.motion[3:6]",
    "force": "measurement[6:9]",
    "true_force": "environment.force",
    "in_contact": "environment.in_contact",
    "body_position": "environment.body[0:2]",
    "body_height": "environment.held[3:4]",
    "grip": "grip if grip_to_telerobot.received",
    "grip_holds": "environment.held[0:1]",
    "carried": "load.carried[0:4] | to_operator.carried[0:4]",
    "carried_deviation": "load.deviation",
    "carried_status": "load.status",
    "carries": "carried.carries",
    "grip_slipped": "environment.held[2:3]",
    "command_force": "pull.y0",
    "detected_contact": "measured_contact | to_operator.in_contact",
    "proxy_position": "detector.proxy",
    "scene": "scene.scene | to_operator.scene",
    "told_thing": "estimator.thing | to_operator.told_thing",
    "remembered": "memory.remembered",
    "touched": "environment.touched if scene.scene",
    "places": "environment.places if scene.scene",
    "probe_zero": "compensation.zero",
    "surface_raised": "touch.surface_raised",
    "theta": "estimator.theta | to_operator.theta",
    "theta_stable": "estimator.stable | to_operator.stable",
    "estimated_force": "local_frame.estimated | estimator.estimated_force",
    "filtered_force": "local_frame.filtered | estimator.filtered_force",
    "theta_deviation": "estimator.deviation",
    "estimator_status": "estimator.status",
    "model_status": "estimator.model_status | to_operator.model_status",
    "residual_ratio": "estimator.residual_ratio",
    "force_lateness": "estimator.force_lateness",
    "model": "told_model",
    "learner_status": "learner.status",
    "held_body": "estimator.held_body | to_operator.held_body",
    "rendered_force": "felt_force",
    "renderer_status": "renderer.status if renderer.stored_energy",
    "update_jump": "renderer.update_jump",
    "stored_energy": "renderer.stored_energy",
    "operator_contact": "operator_detector.in_contact",
    "camera_fault": "camera.camera[0:1]",
    "camera_age": "camera.camera[1:2]",
    "camera_lost": "camera.camera[2:3]",
    "peer_alive": "link.alive",
    "link_clock": "link.clocks",
    "lateness": "pace.lateness",
    "overruns": "pace.overruns",
    "applied_force": "operator.applied_force",
    "safety_armed": "operator.status[0:1]",
    "safety_reason": "operator.status[2:3]",
    "telerobot_fault": "arm.device[0:1]",
    "telerobot_waits": "arm.device[2:3]",
}
"""Signals of a recording (`mmt_drake.recording.signals`) -> where they come from, as far as a station has them."""

OF_THE_MEASUREMENT: Final = frozenset(
    {
        *("position", "velocity", "force", "detected_contact", "theta", "theta_stable", "theta_deviation"),
        *("estimated_force", "filtered_force", "estimator_status", "model_status", "residual_ratio", "held_body"),
        *("force_lateness", "model", "learner_status"),
    }
)
"""Those that come late through a telerobot's compensation, and with it whatever is made of it; the others wait."""

SHOWN_BEFORE: Final = {
    "master_position": "operator.motion[0:3]",
    "proxy_position": "arm.motion[0:3]",
    "camera_fault": "camera.camera[0:1]",
    "telerobot_fault": "arm.device[0:1]",
    "telerobot_waits": "arm.device[2:3]",
}
"""What those that wait show in the meantime: the first of this; the others zeros."""

OUTPUTS: Final = {
    "motion": "operator.motion",
    "measurement": "measurement",
    "theta": "estimator.theta",
    "stable": "estimator.stable",
    "rendered_force": "felt_force",
    "in_contact": "environment.in_contact",
    "alive": "link.alive",
    "status": "link.status",
}
"""Outputs of a station's diagram."""
