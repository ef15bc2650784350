"""From a depth camera's point cloud to a cloud for the proxy."""

from __future__ import annotations

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.perception import PointCloud
from pydrake.systems.framework import Context, LeafSystem, State

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.errors import BadInput, check_number


class PointCloudToCloud(LeafSystem):
    """Turns Drake's `PointCloud` (from `DepthImageToPointCloud`, say) into a `Cloud`, at a rate of its own.

    Building the neighbour structure of a new cloud costs milliseconds; done here, at the camera's rate, it stays off
    the detector's tick. Pixels without depth (NaN or infinite) are dropped and counted.

    .. pydrake_system::

        name: PointCloudToCloud
        input_ports:
        - camera_points
        output_ports:
        - point_cloud
        - dropped

    - ``camera_points`` (abstract, `pydrake.perception.PointCloud`): positions [m], in the camera's frame.
    - ``point_cloud`` (abstract, `mmt_drake.cloud.Cloud`): the latest cloud, table frame, stamped with the time it was
      taken; empty before the first.
    - ``dropped`` (1): how many points of it had no finite position.

    Both outputs are states, updated once in every period.

    Args:
        period: time between two clouds [s].
        camera_pose: the camera's frame in the table frame; the identity if the points already are in the table frame.

    Raises:
        BadInput: a period that is not above 0; in an update, a point cloud without positions.
    """

    def __init__(self, period: float = 1.0 / 30.0, camera_pose: RigidTransform | None = None) -> None:
        super().__init__()
        check_number("point cloud converter", "period", period, least=0.0, open_interval=True)
        pose = camera_pose or RigidTransform()
        self._rotation = pose.rotation().matrix()
        self._origin = pose.translation()
        self._camera_points = self.DeclareAbstractInputPort("camera_points", AbstractValue.Make(PointCloud(0)))
        self._cloud = self.DeclareAbstractState(AbstractValue.Make(Cloud.empty()))
        self._dropped = self.DeclareDiscreteState(1)
        self.DeclareStateOutputPort("point_cloud", self._cloud)
        self.DeclareStateOutputPort("dropped", self._dropped)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._update)
        Cloud(np.eye(3))  # compiles before the clock starts

    def _update(self, context: Context, state: State) -> None:
        camera_points = self._camera_points.Eval(context)
        if not camera_points.has_xyzs():
            raise BadInput("camera_points", found="a PointCloud without positions", expected="the field xyzs")
        with np.errstate(invalid="ignore"):  # lost pixels stay lost: infinity turns into infinity or NaN
            points = camera_points.xyzs().T @ self._rotation.T + self._origin
        cloud, dropped = Cloud.cleaned(points, stamp=context.get_time())
        state.get_mutable_abstract_state(self._cloud).set_value(cloud)
        state.get_mutable_discrete_state(self._dropped).get_mutable_value()[0] = dropped
