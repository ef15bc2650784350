"""Recordings by the trial's engine that figures on the diagnosis are taken of, in each something else concealed."""

from dataclasses import replace
from typing import Final, cast

import numpy as np

from mmt_drake.diagrams.proof.trial.cases import Case, draw_plain, draw_single
from mmt_drake.diagrams.proof.trial.other_cases import draw_material
from mmt_drake.diagrams.proof.trial.real.preparation import beginning
from mmt_drake.diagrams.proof.trial.session import ContactSession
from mmt_drake.recording import Recording

KINDS: Final[dict[str, str | None]] = {
    "nothing concealed": None,
    "Coulomb friction": "coulomb_friction",
    "a cubic spring": "nonlinear_stiffness",
    "stick-slip": "static_friction",
    "a law outside the library": "rough_patch",
}
"""Sort of contact -> what is concealed in it."""

_SEED, _SIZE = 3, 0.6  # a size that a person would notice
_DURATION_S, _RATE_HZ = 60.0, 1000.0
_TEST_S = 5.0
_TESTS: Final = (None, "coulomb_friction", "nonlinear_stiffness", "hysteresis")


def contacts() -> dict[str, Case]:
    """A minute of a hand on a flexible box at 1 kHz, one of each of `KINDS`."""
    return {kind: _contact(number, kind, effect) for number, (kind, effect) in enumerate(KINDS.items())}


def _contact(number: int, kind: str, effect: str | None) -> Case:
    rng = np.random.default_rng((_SEED, number))
    case = draw_plain(rng, kind, wrong=False) if effect is None else draw_single(rng, kind, effect, _SIZE)
    session = replace(
        cast(ContactSession, case.session), duration=_DURATION_S, rate_hz=_RATE_HZ, velocity=True, in_contact=True
    )
    return replace(case, session=session)


def material_tests(count: int) -> list[tuple[Case, Recording]]:
    """So many tests of a spring and a damper, each another one, and the few seconds of each that are recorded."""
    found = []
    for number in range(count):
        effect = _TESTS[number % len(_TESTS)]
        rng = np.random.default_rng((_SEED, number))
        case = draw_material(rng, f"test {number}", effect, _SIZE, wrong=number % 2 == 1)
        found.append((case, beginning(case.recording(), _TEST_S)))
    return found
