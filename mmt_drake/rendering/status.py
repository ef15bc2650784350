"""The status of a renderer: what it does with the latest set of parameters, with laws, or with its input."""

WAITING, RENDERING, APPROACHING, UNSTABLE, NO_MODEL, TOO_STIFF, NOT_FINITE = map(float, range(7))
UNKNOWN_MODEL, NOT_FELT, TOO_FAST = map(float, range(7, 10))

STATUS_NAMES = {
    WAITING: "renders nothing yet",
    RENDERING: "renders the latest set",
    APPROACHING: "on its way to the latest set",
    UNSTABLE: "passes over a set that is not stable",
    NO_MODEL: "passes over a set with NaN or without mass",
    TOO_STIFF: "passes over a set too stiff to integrate",
    NOT_FINITE: "holds its force and lets go: a motion, contact or force that is not finite",
    UNKNOWN_MODEL: "passes over a model message of an unknown version or effect, broken or out of order",
    NOT_FELT: "passes over a law that is not passive, or none to be felt",
    TOO_FAST: "passes over a law too fast to integrate",
}
"""Status -> the same in words."""
