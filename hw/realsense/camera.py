"""A depth camera as a block of a diagram, with the ports of its simulated twin."""

import time
from collections.abc import Callable

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, State

from mmt_drake.cloud import Cloud
from mmt_drake.errors import check_number
from mmt_drake.hw.realsense.faults import FAILED, NO_FRAME, STALE, WELL
from mmt_drake.hw.realsense.worker import CloudWorker
from mmt_drake.systems.leaf import LeafSystem

LOOK = 0.005
"""Between two looks at the worker [s]."""
STALE_S = 0.25
"""Age from which on a frame no longer counts, if nobody says another [s]."""


class DepthCameraSystem(LeafSystem):
    """The surface as a depth camera sees it.

    All work is done in the worker's thread; a tick here takes over a reference. Frames that stop coming, or go on and
    tell nothing new, turn into *no surface* after `stale`, never into one that stays for ever: a renderer that follows
    it lets go. `CameraAge` has a supervisor hold the force at zero then until a person arms again.

    .. pydrake_system::

        name: DepthCameraSystem
        input_ports: []
        output_ports:
        - point_cloud
        - camera

    Ports:

    - `point_cloud` (abstract, `Cloud`): the surface, table frame, stamped with the diagram's time less the frame's age;
      empty before the first frame and after a fault.
    - `camera` (3): fault code (0: well; else `mmt_drake.hw.realsense.faults`), age of the latest frame [s], share of
      its pixels that had no depth (0 to 1).

    Both are states. The camera is outside the Context: a cloned Context shares it.

    Args:
        worker: whose clouds these are; not closed here.
        period: between two looks at it [s].
        stale: age at which a frame no longer counts [s].
        clock: of frames' arrivals [s].

    Raises:
        BadInput: a time that is not above 0.
    """

    def __init__(
        self,
        worker: CloudWorker,
        *,
        period: float = LOOK,
        stale: float = STALE_S,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__()
        check_number("camera", "period", period, least=0.0, open_interval=True)
        check_number("camera", "stale", stale, least=0.0, open_interval=True)
        self._worker, self._stale, self._clock = worker, stale, clock
        self._cloud, self._camera = declare_camera_ports(self)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._look)

    def _look(self, context: Context, state: State) -> None:
        latest = self._worker.latest
        camera = state.get_mutable_discrete_state(self._camera).get_mutable_value()
        shown = state.get_mutable_abstract_state(self._cloud)
        if latest is None:
            camera[:] = self._fault(NO_FRAME), 0.0, 1.0
            return
        age = self._clock() - latest.arrival
        failed = self._worker.failure is not None
        fault = self._fault(STALE) if failed or age > self._stale else WELL
        camera[:] = fault, age, latest.lost
        if fault != WELL:
            if len(shown.get_value()):
                shown.set_value(Cloud.empty(context.get_time()))
            return
        shown.set_value(latest.cloud.moved(latest.cloud.translation, context.get_time() - age))

    def _fault(self, nothing_comes: float) -> float:
        """Why there is no cloud of now."""
        return FAILED if self._worker.failure is not None else self._worker.passed_over or nothing_comes


def declare_camera_ports(system: LeafSystem) -> tuple[int, int]:
    """Declare the ports that every camera has, as states; their indices: cloud, camera."""
    cloud = system.DeclareAbstractState(AbstractValue.Make(Cloud.empty()))
    camera = system.DeclareDiscreteState(np.array([NO_FRAME, 0.0, 1.0]))
    system.DeclareStateOutputPort("point_cloud", cloud)
    system.DeclareStateOutputPort("camera", camera)
    return cloud, camera
