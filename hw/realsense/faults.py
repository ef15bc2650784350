"""Fault codes of a depth camera: what the first number of the port `camera` means.

Well; no frame has come yet; frames have stopped coming; the camera failed; frames come and show no surface; frames come
and repeat themselves.
"""

WELL, NO_FRAME, STALE, FAILED, BLIND, FROZEN = map(float, range(6))
