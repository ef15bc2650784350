"""Shows a running diagram in the browser."""

import math
import time
import warnings

from pydrake.systems.framework import Context

from mmt_drake.cloud import ProxySettings
from mmt_drake.systems.leaf import LeafSystem
from mmt_drake.viewer.charts import sample
from mmt_drake.viewer.scene import Scene
from mmt_drake.viewer.viewer import Viewer

SAMPLE_PERIOD = 0.01
"""Between two samples of the charts [s of simulation]."""

FRAME_INTERVAL = 0.03
"""Between two pictures at least [s of wall clock]."""

_SHOWN = (
    *("motion", "measurement", "rendered_force", "in_contact", "proxy", "normal", "body_position", "theta", "stable"),
    *("model_status", "model", "learner_status", "carried", "estimated_force", "true_force", "scene", "point_cloud"),
)


class LiveView(LeafSystem):
    """Draws the latest values in the scene, and sends them to the charts beside it.

    .. pydrake_system::

        name: LiveView
        input_ports:
        - motion
        - measurement
        - rendered_force
        - in_contact
        - proxy
        - normal
        - body_position
        - theta
        - stable
        - model_status
        - model
        - learner_status
        - carried
        - estimated_force
        - true_force
        - scene
        - point_cloud

    Inputs (table frame); each is optional, and what is not connected is not shown:

    - `motion` (6): position [m] and velocity [m/s] of the operator's hand.
    - `measurement` (9): the probe's position [m], velocity [m/s] and force [N] as measured.
    - `rendered_force` (3): what the operator feels [N].
    - `in_contact` (1): the contact detector's, 0.0 or 1.0.
    - `proxy` (3): the contact detector's proxy [m].
    - `normal` (3): outward unit normal of the surface there [1], 0 where there is none.
    - `body_position` (2): displacement of the object's body [m].
    - `theta` (10): estimated parameters, eq. 7 and 8.
    - `stable` (1): 0 or 1, whether they are.
    - `model_status` (1): 0 where they explain the force; what else there is, see `OutputErrorEstimator`.
    - `model` (44): the message that theta goes with [SI]; its laws are told in words.
    - `learner_status` (1): counts what a learner is about, see `LawLearner`.
    - `carried` (5): what is carried [SI], as `LoadEstimator` tells it, in words.
    - `estimated_force` (3): what the estimator's model says [N].
    - `true_force` (3): the simulated object's, without noise [N].
    - `scene` (72): what is seen of several objects (`mmt_drake.model.scene_layout`) [SI]: boxes, coloured by state.
    - `point_cloud` (abstract, `mmt_drake.cloud.Cloud`): the surface.

    Samples are taken 100 times a second of simulation, pictures drawn 33 times a second of wall clock at most. Nothing
    waits for a browser, and nobody need look: a process of its own serves them. If that dies, a warning says so, and
    the run goes on without pictures.
    What is shown is the world outside: it stands in `self`, not in the Context, and has no influence on the run.

    Args:
        viewer: where to draw.
        proxy: radii of the detector's spheres.
    """

    def __init__(self, viewer: Viewer, proxy: ProxySettings | None = None) -> None:
        super().__init__()
        self._scene, self._viewer = Scene(viewer, proxy), viewer
        self._next_frame = -math.inf
        self._gone = False
        self.declare_inputs(*_SHOWN, optional=_SHOWN)
        self.DeclarePeriodicPublishEvent(SAMPLE_PERIOD, 0.0, self._publish)

    def _publish(self, context: Context) -> None:
        if self._gone:
            return
        *vectors, cloud = self.inputs_at(context)
        values = {name: vector.tolist() for name, vector in zip(_SHOWN, vectors, strict=False) if vector is not None}
        self._viewer.add_samples(sample(context.get_time(), values))
        now = time.monotonic()
        if now < self._next_frame:
            return
        self._next_frame = now + FRAME_INTERVAL
        self._scene.show(values, cloud)
        try:
            self._viewer.flush()
        except OSError as error:
            self._gone = True
            warnings.warn(f"the viewer is gone, the run goes on: {error.strerror}", stacklevel=1)
