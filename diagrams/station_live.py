"""What a station that runs in real time tells beside its signals: its pace, and what its devices do."""

from __future__ import annotations

from collections.abc import Callable

from pydrake.systems.framework import DiagramBuilder, OutputPort, System

from mmt_drake.diagrams.cameras import Camera
from mmt_drake.diagrams.devices import Devices, Hand, RemoteArm
from mmt_drake.diagrams.ports import join, split
from mmt_drake.hw.franka import describe_fault
from mmt_drake.hw.realsense.age import CameraAge
from mmt_drake.hw.safety import DeviceAge, DeviceAnnouncer, HandAge, SafetyAnnouncer
from mmt_drake.realtime import Pace, PaceReport

Columns = tuple[tuple[OutputPort, tuple[str, ...]], ...]
"""Ports to be recorded, each with the base names of the signals that it carries."""


def live_signals(
    builder: DiagramBuilder, devices: Devices, pace: Pace | None, tell: Callable[[str], None] | None
) -> Columns:
    """Add what shows the pace and announces what devices do; gives what is to be recorded of it.

    Args:
        builder: of a diagram with the devices' systems in it.
        devices: of the run.
        pace: of the run to come, if it is paced.
        tell: called with a line for a person whenever a device or its supervisor has something new.
    """
    columns: Columns = ()
    if pace is not None:
        report = builder.AddNamedSystem("pace", PaceReport(pace))
        columns += tuple((report.GetOutputPort(name), (name,)) for name in ("lateness", "overruns"))
    if (hand := devices.hand) is not None:
        status = hand.system.GetOutputPort("status")
        armed, _, present = split(builder, status, (1, 1, 1))
        columns += (
            (hand.system.GetOutputPort("applied_force"), ("applied_force",)),
            (armed, ("safety_armed",)),
            (present, ("safety_reason",)),
        )
        if tell is not None:
            announcer = builder.AddNamedSystem("announcer", SafetyAnnouncer(tell, tuple(hand.watched)))
            builder.Connect(status, announcer.GetInputPort("status"))
    if (arm := devices.arm) is not None:
        device = arm.system.GetOutputPort("device")
        fault, _, waits = split(builder, device, (1, 1, 1))
        columns += ((fault, ("telerobot_fault",)), (waits, ("telerobot_waits",)))
        if tell is not None:
            about = builder.AddNamedSystem("arm_announcer", DeviceAnnouncer(tell, "arm", describe_fault))
            builder.Connect(device, about.GetInputPort("device"))
    return columns


def hand_age(builder: DiagramBuilder, hand: System) -> OutputPort:
    """The age of a supervised hand's motion, infinite while it is not to be believed."""
    age = builder.AddNamedSystem("hand_age", HandAge())
    builder.Connect(hand.GetOutputPort("status"), age.GetInputPort("status"))
    return age.GetOutputPort("age")


def wire_arm(builder: DiagramBuilder, arm: RemoteArm, age: OutputPort) -> None:
    """Give an arm without a hand beside it its own switches, and the age of what it is told."""
    switch = builder.AddNamedSystem("switch", arm.switch)
    builder.Connect(switch.GetOutputPort("switches"), arm.system.GetInputPort("switches"))
    builder.Connect(age, arm.system.GetInputPort("age"))


def wire_devices(builder: DiagramBuilder, hand: Hand, arm: RemoteArm | None, camera: Camera | None) -> None:
    """Let each side of a station know when the other stops, and give both the same switches.

    Args:
        builder: of a diagram with their systems in it.
        hand: on a device; watches the ages of those that are there, `arm` and `camera` by name.
        arm: that follows it.
        camera: that sees what it touches.
    """
    ages = {}
    if arm is not None:
        of_arm = builder.AddNamedSystem("arm_age", DeviceAge())
        builder.Connect(hand_age(builder, hand.system), arm.system.GetInputPort("age"))
        builder.Connect(hand.system.GetOutputPort("switches"), arm.system.GetInputPort("switches"))
        builder.Connect(arm.system.GetOutputPort("device"), of_arm.GetInputPort("device"))
        ages["arm"] = of_arm.GetOutputPort("age")
    if camera is not None:
        of_camera = builder.AddNamedSystem("camera_age", CameraAge())
        builder.Connect(camera.system.GetOutputPort("camera"), of_camera.GetInputPort("camera"))
        ages["camera"] = of_camera.GetOutputPort("age")
    watched = tuple(ages[name] for name in hand.watched if name in ages)
    if watched:
        builder.Connect(join(builder, watched), hand.system.GetInputPort("ages"))
