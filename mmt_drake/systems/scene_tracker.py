"""Who is who on the table, from one cloud to the next, as a system on the slow path."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, State

from mmt_drake.beside import Apart, Later, at_once
from mmt_drake.cloud.seen import SeenScene
from mmt_drake.cloud.tracking import load_tracking, tracked
from mmt_drake.cloud.tracking_options import Tracking
from mmt_drake.errors import check_number
from mmt_drake.model.grasped_box import HOLDS
from mmt_drake.model.scene_layout import SCENE_SIZE
from mmt_drake.systems.leaf import LeafSystem


class SceneTracker(LeafSystem):
    """Segments each cloud of a table and says which object is which, where it is and what is seen of it.

    See `mmt_drake.cloud.tracking`.

    .. pydrake_system::

        name: SceneTracker
        input_ports:
        - position
        - point_cloud
        - thing
        - held
        output_ports:
        - scene
        - objects

    Ports (table frame):

    - `position` (3): of the probe's tip [m], to tell it from an object and to know what it hides.
    - `point_cloud` (abstract, `Cloud`): the table and what stands on it; or the tops alone.
    - `thing` (1): identity of what the tip holds or is over [1]; there only with `grips`.
    - `held` (4): what the grip has, as its own sensors tell it [1], [m]; there only with `grips`.
    - `scene` (72): a row for each object that is or was there, as `mmt_drake.model.scene_layout.ENTRY` [SI]; zeros: no
      more.
    - `objects` (abstract, `mmt_drake.cloud.seen.SeenScene`): the same, with the points of each.

    Both outputs are states, and tell of a cloud `Tracking.latency` after it was looked at: in the meantime it is made
    out. A cloud that has been seen already is not seen again.

    Args:
        table: height of the table's top in the table frame [m].
        options: how objects are told apart.
        period: between clouds [s].
        offset: of the first look [s], after a cloud is there.
        grips: the probe has a grip.
        apart: how clouds are made out: in a process of its own, where a run has one.
        waits: for that; else, in real time, what is not there in time is told a period later, and the clouds in the
            meantime are passed over.

    Raises:
        BadInput: a period that is not positive, or a latency as long as that.
    """

    def __init__(
        self,
        table: float,
        options: Tracking | None = None,
        *,
        period: float = 1.0 / 30.0,
        offset: float = 0.0,
        grips: bool = False,
        apart: Apart = at_once,
        waits: bool = True,
    ) -> None:
        super().__init__()
        check_number("tracking", "period", period, least=0.0, open_interval=True)
        chosen = options or Tracking()
        chosen.refuse_period(period)
        self._table, self._options, self._waits = table, chosen, waits
        self._tracked = apart(tracked, load_tracking)
        self.declare_inputs("position", "point_cloud", thing=1 if grips else 0, held=4 if grips else 0)
        self._scene = self.DeclareDiscreteState(SCENE_SIZE)
        self._last = self.DeclareDiscreteState(np.array([-np.inf]))
        self._objects = self.DeclareAbstractState(AbstractValue.Make(SeenScene()))
        self._looked = self.DeclareAbstractState(AbstractValue.Make(Later.known(SeenScene())))
        self.DeclareStateOutputPort("scene", self._scene)
        self.DeclareStateOutputPort("objects", self._objects)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, offset, self._look)
        if chosen.latency > 0.0:
            self.DeclarePeriodicUnrestrictedUpdateEvent(period, offset + chosen.latency, self._show)

    def _look(self, context: Context, state: State) -> None:
        looked = state.get_mutable_abstract_state(int(self._looked))
        if not (self._waits or looked.get_value().is_there):
            return
        position, cloud, thing, held = self.inputs_at(context)
        last = state.get_mutable_discrete_state().get_mutable_value(self._last)
        if cloud is None or not np.isfinite(position).all() or cloud.stamp <= last[0]:
            return
        last[0] = cloud.stamp
        before: SeenScene = looked.get_value().value
        if len(cloud) == 0 and not before.things:
            return
        gripped = 0 if held is None or held[0] != HOLDS else int(thing[0])
        seen = before, cloud, position.copy(), context.get_time(), self._table, self._options, gripped
        looked.set_value(self._tracked(*seen))
        if self._options.latency == 0.0:
            self._show(context, state)

    def _show(self, context: Context, state: State) -> None:
        looked: Later[SeenScene] = state.get_mutable_abstract_state(int(self._looked)).get_value()
        if not (self._waits or looked.is_there):
            return
        seen = looked.value
        state.get_mutable_abstract_state(int(self._objects)).set_value(seen)
        state.get_mutable_discrete_state().get_mutable_value(self._scene)[:] = seen.vector(context.get_time())
