"""What a renderer does with the latest set of parameters: the port `status` of every renderer."""

from __future__ import annotations

WAITING, RENDERING, APPROACHING, UNSTABLE, NO_MODEL, TOO_STIFF = map(float, range(6))

STATUS_NAMES = {
    WAITING: "renders nothing yet",
    RENDERING: "renders the latest set",
    APPROACHING: "on its way to the latest set",
    UNSTABLE: "passes over a set that is not stable",
    NO_MODEL: "passes over a set with NaN or without mass",
    TOO_STIFF: "passes over a set too stiff to integrate",
}
"""Status -> the same in words."""
