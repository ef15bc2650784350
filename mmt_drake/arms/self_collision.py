"""Whether an arm meets itself: distances of the collision geometry of its file, by Drake's SceneGraph."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from mmt_drake.arms.arm_file import ArmModel
from mmt_drake.arms.plant import ArmPlant, plant_from_file
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array

CLEARANCE_M: Final = 0.01
"""Links that are nearer to one another than this [m] count as touching."""
_POSES = 50


class SelfCollision:
    """The collision geometry of an arm. Links that one joint holds together are not compared: they always touch.

    Args:
        model: of an arm.
        arm: of that model.

    Raises:
        BadInput: the robot's file has no collision geometry that can be compared, or Drake cannot read it.
    """

    def __init__(self, model: ArmModel, arm: ArmPlant) -> None:
        if model.function:
            raise BadInput(model.source, found="a plant made by a function", expected="a robot's file")
        builder = DiagramBuilder()
        plant, scene = AddMultibodyPlantSceneGraph(builder, 0.0)
        plant_from_file(model, plant)
        plant.Finalize()
        self._plant, self._at = plant, ArmPlant(plant, arm.joints, arm.links).position_index
        self._diagram = builder.Build()
        self._context = self._diagram.CreateDefaultContext()
        self._query = scene.get_query_output_port()
        self._inside, self._seen = (part.GetMyMutableContextFromRoot(self._context) for part in (plant, scene))
        self._rest = plant.GetPositions(self._inside).copy()
        self._always = frozenset[tuple[str, str]]()
        inspector: Any = self._query.Eval(self._seen).inspector()
        candidates = inspector.GetCollisionCandidates()
        self._link = {g: plant.GetBodyFromFrameId(inspector.GetFrameId(g)).name() for pair in candidates for g in pair}
        if not candidates:
            raise BadInput(model.robot, found="no collision geometry of links apart", expected="some")
        low, high = (np.clip(limit, -np.pi, np.pi) for limit in arm.position_limits)
        # Links that touch in every pose, as those of a coarse geometry do, say nothing.
        poses = np.random.default_rng(0).uniform(low, high, (_POSES, len(low)))
        try:
            self._always = frozenset.intersection(*(frozenset(self._near(q)) for q in poses))
        except RuntimeError as error:  # shapes between which Drake knows no distance
            raise BadInput(model.robot, found="shapes that Drake cannot compare", expected="others") from error

    @property
    def left_out(self) -> tuple[tuple[str, str], ...]:
        """Pairs of links that touch in every pose that was tried: of them nothing is said."""
        return tuple(sorted(self._always))

    def depths(self, q: Array) -> Array:
        """By how much links of each pose (n, joints) are nearer than `CLEARANCE_M`, added up over pairs, (n,) [m]."""
        return np.array(
            [sum(depth for pair, depth in self._near(row).items() if pair not in self._always) for row in q]
        )

    def _near(self, q: Array) -> dict[tuple[str, str], float]:
        """Pairs of links that are too near in a pose (joints,), and by how much."""
        self._rest[self._at] = q
        self._plant.SetPositions(self._inside, self._rest)
        query: Any = self._query.Eval(self._seen)
        found = dict[tuple[str, str], float]()
        for one in query.ComputeSignedDistancePairwiseClosestPoints(CLEARANCE_M):
            first, second = sorted((self._link[one.id_A], self._link[one.id_B]))
            found[first, second] = found.get((first, second), 0.0) + CLEARANCE_M - float(one.distance)
        return found
