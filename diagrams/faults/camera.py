"""Faults of the depth camera that sees the surface, with an emulated device in the operator's hand."""

from __future__ import annotations

import json
import random
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from mmt_drake.diagrams.faults.emulated import emulated_omega
from mmt_drake.diagrams.faults.realsense.eye import Eye
from mmt_drake.diagrams.faults.realsense.kinds import KINDS, OLDEST, CameraFault
from mmt_drake.diagrams.faults.row import Row
from mmt_drake.diagrams.faults.session import CHANGES, PERIOD, Session, telerobot_record
from mmt_drake.diagrams.faults.tally import Tally
from mmt_drake.diagrams.stations.cameras import Camera
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.surfaces import DepthCamera
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.realsense.camera import LOOK
from mmt_drake.hw.realsense.faults import WELL
from mmt_drake.hw.realsense.reopened import ReopenedStream
from mmt_drake.hw.safety import STOP_WITHIN, Reason
from mmt_drake.recording import load

_LONGER = 0.1  # [s] that are watched once it can be told
_AFTER = 150  # ticks with a camera that is well again
_STROKE = 500  # ticks of one stroke of the hand
APART = ("no frames any more", "unplugged and back")
"""Kinds that are tried with the camera at the other side of a link too."""


def try_camera(moments: int, folder: Path) -> Iterator[Row]:
    """Every kind of fault that an emulated camera can have."""
    omega = emulated_omega(folder)
    for name, kind in KINDS.items():
        yield try_kind(name, kind, omega, moments, folder / "camera.mcap")
    for name in APART:
        yield try_kind(f"{name}, apart", KINDS[name], omega, moments, folder / "camera.mcap", apart=True)


def try_kind(
    name: str, kind: CameraFault, omega: EmulatedOmega, moments: int, record: Path, *, apart: bool = False
) -> Row:
    """One kind, in one session, with a person who arms again where the force went to zero.

    Args:
        name: told, and seed of the moments.
        kind: what happens.
        omega: the operator's device.
        moments: how many.
        record: file for the (operator's) recording.
        apart: the camera is at the telerobot's side of two.
    """
    draw, must = random.Random(name), kind.told != WELL
    allowed = kind.seen_after + LOOK + STOP_WITHIN + (PERIOD if apart else 0.0)  # by the next packet
    reason = Reason.STALE + apart  # the peer's age comes first
    omega.reset()
    clock = partial(omega.get, "clock")
    eye = Eye(record.parent, clock, PERIOD)
    keys = {"extrinsics": str(eye.place), "stale": OLDEST, "settings": {"voxel": None}}
    scenario = load_scenario("setup1", [*CHANGES, f"environment.cloud=!DepthCamera {json.dumps(keys)}"])
    chosen = scenario.environment.cloud
    assert isinstance(chosen, DepthCamera)
    camera = Camera(chosen, ReopenedStream(eye.usb.open, clock), clock)
    each = partial(eye.tick, camera.worker)
    with Session(omega, record, scenario=scenario, camera=camera, each=each, apart=apart) as session:
        omega.set(swing_z=0.004)  # it hardly leaves the object: a force that came back by itself would be felt
        tally = Tally(session)
        for moment in range(moments):
            if not tally.armed(moment):
                break
            session.go(draw.randrange(60))
            for _ in range(_STROKE):  # a moment at which there is a force
                if omega.vector("applied").any():
                    break
                session.go(1)
            start = tally.begin()
            kind.start(eye, camera.worker)
            session.go(round((allowed + _LONGER) / PERIOD))
            on_for = tally.force_for(moment, start)
            stopped = not session.armed and session.status[1] == reason and on_for <= allowed + 1e-9
            if not (stopped if must else session.armed):
                tally.surprise(moment, on_for)
            eye.mend()
            if must:
                tally.must_stay_off(moment, _AFTER)
        tally.armed("at the end")
        if tally.felt < moments:
            tally.wrong.append(f"a force was felt at {tally.felt} moments alone")
    recorded = tally.recorded(record)
    faults = load(telerobot_record(record), forces=False) if apart else recorded
    if must and kind.told not in faults["camera_fault"]:
        tally.wrong.append(f"the recording tells of the faults {np.unique(faults['camera_fault'])}")
    return tally.row(name, "camera", moments, recorded, allowed if must else None)
