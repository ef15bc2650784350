"""Kinds of fault that the emulated camera, its cable and its driver can have."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mmt_drake.diagrams.faults.realsense.eye import Eye
from mmt_drake.hw.realsense.faults import BLIND, FAILED, FROZEN, STALE, WELL
from mmt_drake.hw.realsense.worker import CloudWorker

#: Age from which on the trial's camera no longer counts [s].
OLDEST = 0.25


@dataclass(frozen=True)
class CameraFault:
    """One kind of fault, and what must come of it.

    Attributes:
        start: brings it about.
        told: on the camera's port; `WELL` where the run must go on.
        seen_after: how long it takes until it can be told [s], beside the time between two looks at the camera.
    """

    start: Callable[[Eye, CloudWorker], object]
    told: float
    seen_after: float = OLDEST


def _instead(show: Callable[[Eye], object]) -> Callable[[Eye, CloudWorker], object]:
    def start(eye: Eye, worker: CloudWorker) -> None:
        eye.instead = show

    return start


def _once(show: Callable[[Eye], object]) -> Callable[[Eye, CloudWorker], object]:
    def start(eye: Eye, worker: CloudWorker) -> None:
        def shown(eye: Eye) -> None:
            eye.instead = None
            show(eye)

        eye.instead = shown

    return start


def _dark(eye: Eye) -> None:
    eye.camera.show(np.zeros_like(eye.image))


def _not_a_number(eye: Eye) -> None:
    unit, eye.camera.unit = eye.camera.unit, math.nan
    eye.show()
    eye.camera.unit = unit


def _late(eye: Eye) -> None:
    """This frame does not come until the next one has."""
    eye.camera.number += 1
    image, number = eye.new_image(), eye.camera.number

    def both(eye: Eye) -> None:
        eye.instead = None
        eye.show()
        eye.camera.show_again(image, number)

    eye.instead = both


KINDS: dict[str, CameraFault] = {
    # Where the surface is not known any more nobody knows of contact: no force, and a person arms again, for the hand
    # may be deep in the object by the time it is seen again. It counts from the last frame that told something new.
    "no frames any more": CameraFault(_instead(lambda eye: None), STALE),
    "one frame over and over": CameraFault(
        _instead(lambda eye: eye.camera.show_again(eye.image, eye.camera.number)), FROZEN
    ),
    "image frozen, its number goes on": CameraFault(_instead(lambda eye: eye.camera.show(eye.image)), FROZEN),
    "no pixel with depth any more": CameraFault(_instead(_dark), BLIND),
    "unit of depth is not a number": CameraFault(_instead(_not_a_number), BLIND),
    # What the driver tells is known at once.
    "driver's error": CameraFault(
        lambda eye, worker: eye.fail(worker, error="uvc streamer: input/output error"), FAILED, 0.0
    ),
    "unplugged and back": CameraFault(lambda eye, worker: eye.fail(worker), FAILED, 0.0),
    # One bad frame of thirty a second hides nothing: the one before it still counts.
    "one frame without depth": CameraFault(_once(_dark), WELL),
    "one frame late": CameraFault(_instead(_late), WELL),
}
