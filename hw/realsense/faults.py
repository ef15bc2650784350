"""Fault codes of a depth camera."""

from typing import Final

WELL, NO_FRAME, STALE, FAILED, BLIND, FROZEN = 0.0, 1.0, 2.0, 3.0, 4.0, 5.0
FAULTS: Final = {
    WELL: "well",
    NO_FRAME: "no frame has come yet",
    STALE: "frames have stopped coming",
    FAILED: "the camera failed",
    BLIND: "frames come and show no surface",
    FROZEN: "frames come and repeat themselves",
}
"""What the first number of the port `camera` means."""
