"""The status of a renderer: what it does with the latest set of parameters, or with its input; port `status` of all."""

WAITING, RENDERING, APPROACHING, UNSTABLE, NO_MODEL, TOO_STIFF, NOT_FINITE = map(float, range(7))

STATUS_NAMES = {
    WAITING: "renders nothing yet",
    RENDERING: "renders the latest set",
    APPROACHING: "on its way to the latest set",
    UNSTABLE: "passes over a set that is not stable",
    NO_MODEL: "passes over a set with NaN or without mass",
    TOO_STIFF: "passes over a set too stiff to integrate",
    NOT_FINITE: "holds its force and lets go: a motion, contact or force that is not finite",
}
"""Status -> the same in words."""
