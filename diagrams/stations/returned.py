"""Signals that cross the network from the telerobot to the operator."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from mmt_drake.model.held_body import HELD_SIZE
from mmt_drake.model.message_layout import MESSAGE_SIZE
from mmt_drake.model.parameters import THETA
from mmt_drake.model.scene_layout import SCENE_SIZE

if TYPE_CHECKING:
    from mmt_drake.diagrams.stations.scenario import Scenario


class Returned(NamedTuple):
    """Something that crosses the network to the operator.

    Attributes:
        net: where it comes from.
        size: how many numbers.
        kept: it stays what it was while the telerobot of two machines is lost; else it falls to zero.
        may_be_nan: NaN is a value of it, 'not known yet'.
    """

    net: str
    size: int
    kept: bool = False
    may_be_nan: bool = False


RETURNED: Final = {
    "theta": Returned("estimator.theta", len(THETA), kept=True, may_be_nan=True),
    "stable": Returned("estimator.stable", 1),
    "in_contact": Returned("detected", 1),
    "high_band": Returned("high_band.high_band", 3),
    "held_body": Returned("estimator.held_body", HELD_SIZE),
    "model_status": Returned("estimator.model_status", 1),
    "model": Returned("estimator.model", MESSAGE_SIZE, kept=True, may_be_nan=True),
    "carried": Returned("load.carried", 5),
    "scene": Returned("scene.scene", SCENE_SIZE, kept=True),
    "told_thing": Returned("estimator.thing", 1, kept=True),
    "remote_force": Returned("measurement[6:9]", 3),
    "remote_energy": Returned("telerobot.energy_in", 3, kept=True),
}
"""What a renderer may ask for, by its input ports, and what stands beside it where there are several objects."""
_OF_SEVERAL: Final = ("scene", "told_thing")


def returned(scenario: Scenario) -> dict[str, int]:
    """What crosses in a scenario but clouds, and sizes.

    It is what the renderer asks for, as far as the estimator knows it and no detector beside the operator does.
    """
    missing = {name for name in ("held_body", "model_status") if name not in scenario.estimator.tells}
    missing |= {"told_thing"} if "thing" not in scenario.estimator.tells else set()
    missing |= {"model"} if scenario.learner is None else set()
    missing |= {"in_contact"} if scenario.seen_by_operator else set()
    missing |= set() if scenario.shape is None else {"held_body"}  # it counts along another frame
    beside = _OF_SEVERAL if scenario.several is not None and scenario.renderer.switched else ()
    beside = (*beside, "carried") if scenario.carrying is not None else beside
    return {name: RETURNED[name].size for name in (*scenario.renderer.receives, *beside) if name not in missing}
