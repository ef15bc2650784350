"""Systems that show a surface which moves with a body."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, State

from mmt_drake.cloud import Cloud
from mmt_drake.errors import check_number
from mmt_drake.numeric.layout import Layout
from mmt_drake.random import fill_normal
from mmt_drake.systems.kernel_system import KernelSystem

# The readout: each output port in turn, then what is the system's own.
PORT_SIZES = {"measurement": 9, "force": 3, "in_contact": 1, "body": 4}
_, FORCE, CONTACT, BODY, OWN = map(Layout(), (*PORT_SIZES.values(), 0))


class SurfaceSystem(KernelSystem):
    """Base of these systems: after its readout an `__init__` declares the surface, the port `point_cloud`."""

    def declare_surface(
        self, surface: Cloud | None, period: float, noise: float, seed: int, count_at: int, moves: bool = True
    ) -> None:
        """Declare the cloud, renewed every `period`.

        Args:
            surface: undisplaced; by default none is seen.
            period: [s].
            noise: standard deviation of each coordinate of each point, fresh for every cloud [m].
            seed: of the noise.
            count_at: where in the readout a count of updates stands.
            moves: whether it goes with the body.

        Raises:
            BadInput: a period or noise without meaning.
        """
        check_number("environment", "cloud_noise", noise, least=0.0)
        check_number("environment", "cloud_period", period, least=0.0, open_interval=True)
        self._cloud_noise, self._cloud_seed, self._count_at = noise, seed, count_at
        self._moves = 1.0 if moves else 0.0
        self._surface = Cloud.empty() if surface is None else surface
        cloud = self.DeclareAbstractState(AbstractValue.Make(self._surface))
        self.DeclareStateOutputPort("point_cloud", cloud)
        if len(self._surface):
            self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._update_cloud)
        if noise > 0.0:
            fill_normal(0, 0, np.zeros(1))  # compiles it

    def _update_cloud(self, context: Context, state: State) -> None:
        now = self._readout.Eval(context)
        x, y = self._moves * now[BODY : BODY + 2]
        t = context.get_time()
        cloud = self._surface.moved((x, y, 0.0), t)
        if self._cloud_noise > 0.0:
            disturbance = np.empty((len(cloud), 3))
            fill_normal(self._cloud_seed, int(now[self._count_at]), disturbance.ravel())
            noisy = cloud.points() + self._cloud_noise * disturbance
            cloud = Cloud(noisy, stamp=t, normals=cloud.normals)
        state.get_mutable_abstract_state(0).set_value(cloud)
