"""Possible causes of the errors of the thesis's figures, as changes of a scenario in which none of it is."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from mmt_drake.diagrams.proof.experiments.changes import (
    NOISE,
    Cause,
    at_once,
    estimating,
    forgetting,
    input_held,
    input_late,
    input_placed,
    sensing,
    sliding,
    stiffening,
    stroking,
    taken_up,
    together,
    unchanged,
)
from mmt_drake.diagrams.proof.experiments.thesis import SETTLE_S
from mmt_drake.diagrams.stations.scenario import Scenario
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model.regrouping import EQUATIONS
from mmt_drake.model.structure import Friction


def healthy(seconds: float | None = None, seed: int = 0) -> Scenario:
    """Experiment 1 of the thesis with its estimator as good as its options make it.

    It waits until its filters have forgotten what was before a touch, uses all of eq. 30, takes central differences and
    the sign of the body's velocity. The object keeps the thesis's stiction.

    Args:
        seconds: length of a run; the scenario's own by default.
        seed: of everything random.
    """
    scenario = replace(at_once("setup1"), seed=seed, clouds="none")
    scenario = estimating(settle=SETTLE_S, differences="central", friction_velocity="body")(scenario)
    return scenario if seconds is None else replace(scenario, duration=seconds)


def _as_the_thesis(scenario: Scenario) -> Scenario:
    """The estimator as the thesis describes it."""
    return replace(scenario, estimator=RlsOptions(step=scenario.step))


def _output_error(scenario: Scenario) -> Scenario:
    """The estimator that fits the free-running force in place of the thesis's."""
    return replace(scenario, estimator=OutputErrorOptions(step=scenario.step, in_plane="per_axis"))


def _causes() -> Iterator[Cause]:
    yield Cause("nothing", "none", unchanged)
    yield Cause("learns across the touch", "estimator", estimating(settle=0.0))
    for equations in EQUATIONS:
        if equations != "all":
            yield Cause(f"eq. 30 {equations.replace('_', ' ')}", "estimator", estimating(equations=equations))
    yield Cause("backward differences", "estimator", estimating(differences="backward"))
    yield Cause("sign of the probe's velocity", "estimator", estimating(friction_velocity="probe"))
    yield Cause("sign not filtered", "estimator", estimating(filter_friction=False))
    for memory_s in (10.0, 2.0, 1.0, 0.1):
        yield Cause(f"forgets after {memory_s:g} s", "estimator", forgetting(memory_s))
    yield Cause("output error, not equation error", "estimator", _output_error)
    yield Cause("sensor noise", "plant", sensing(NOISE))
    yield Cause("no stiction", "plant", sliding(Friction.coulomb(0.05)))
    yield Cause("stiction, ten times", "plant", sliding(Friction(Fs=1.0, Fd=0.5, v_d=0.005)))
    yield Cause("stiffness grows by 2 % a second", "plant", stiffening(0.02))
    yield Cause("velocity of the input lost", "renderer", input_placed)
    for milliseconds in (5, 20, 33):
        yield Cause(f"input held for {milliseconds} ms", "renderer", input_held(1e-3 * milliseconds))
    for milliseconds in (5, 20, 50):
        yield Cause(f"input {milliseconds} ms late", "renderer", input_late(1e-3 * milliseconds))
    yield Cause("parameters taken up over 5 s", "renderer", taken_up(5.0))
    slow_first = stroking(first="slow")
    yield Cause("slow strokes first", "hand", slow_first)
    yield Cause("the thesis's estimator", "together", _as_the_thesis)
    without_d, forgets = estimating(equations="without_d"), forgetting(2.0)
    for name, changes in (
        ("slow strokes first", (slow_first,)),
        ("without d", (without_d,)),
        ("forgets after 2 s", (forgets,)),
        ("forgets after 0.3 s", (forgetting(0.3),)),
        ("without d, forgets", (without_d, forgets)),
        ("velocity lost", (input_placed,)),
        ("velocity lost, without d", (input_placed, without_d)),
        ("velocity lost, forgets", (input_placed, forgets)),
        ("velocity lost, forgets, noise", (input_placed, forgets, sensing(NOISE))),
        ("velocity lost, slow strokes first", (input_placed, slow_first)),
        ("input 50 ms late", (input_late(0.05),)),
        ("input 50 ms late, forgets", (input_late(0.05), forgets)),
    ):
        yield Cause(f"the thesis's, {name}", "together", together(_as_the_thesis, *changes))


CAUSES: Final = tuple(_causes())
"""One at a time, then the likely ones together; groups: `estimator plant renderer hand together`, `none`."""
