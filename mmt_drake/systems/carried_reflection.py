"""The force of a carried object on the operator, beside the renderer of the object on the table."""

import numpy as np

from mmt_drake.numeric.arrays import Array
from mmt_drake.rendering.carried import MEMORY_SIZE, NO_SWING, PORT_SIZES, carried_force, holds_contact
from mmt_drake.rendering.updates import Policy, renderer_rule
from mmt_drake.systems.kernel_system import KernelSystem


class CarriedReflection(KernelSystem):
    """What the operator feels of an object that may be lifted: on the table what another renderer says, off it this.

    Integrated on the operator's side from the operator's motion, without waiting for the network, and held to the
    energy that the hand has put in where the policy asks for that (`mmt_drake.rendering.carried`).

    .. pydrake_system::

        name: CarriedReflection
        input_ports:
        - motion
        - force
        - grip
        - in_contact
        - theta
        - carried
        - facet
        - height
        - thing
        output_ports:
        - force
        - carries
        - readout
        - in_contact

    Ports (table frame):

    - `motion` (6): the operator's position [m] and velocity [m/s], which is not read.
    - `force` (3): of the object on the table [N].
    - `grip` (1): of the hand [N].
    - `in_contact` (1): 1 where the operator touches the object.
    - `theta` (10): of the contact, as it was told [SI].
    - `carried` (5): what is carried [SI], as it was told (`LoadEstimator`).
    - `facet` (4): the plane of the object's top where it stands [1], [m]; there only with `seen`.
    - `height` (1): of the object above the table [m], whose half is where its centre is believed to be; there only with
      `seen`.
    - `thing` (1): identity of what the hand touches or holds [1]; there only with `seen`.
    - `force` (3): force on the operator's probe [N]; direct feedthrough, never a tick late.
    - `carries` (1): 1 while the operator's copy of the object is off the table.
    - `readout` (the two above, the memory).
    - `in_contact` (1): for the renderer on the table: 1 while a closed grip holds the object there, 0 while it is off
      the table, else as the input of that name.

    Args:
        period: of the ticks [s].
        updates: the renderer's policy; `EnergyPermitting` watches the energy here too. At once by default.
        height: of the object above the table, as far as it is known beforehand [m]; 0: it is not, and does not swing
            until its centre has been told.
        seen: which object it is, its height and where its top is are told; else there is one, its top at z = 0.

    Raises:
        BadInput: a period that is not positive.
    """

    def __init__(
        self, *, period: float = 1e-3, updates: Policy | None = None, height: float = 0.0, seen: bool = False
    ) -> None:
        super().__init__()
        self._height = height
        self._period, self._rule = period, renderer_rule(updates, period, 1)
        always = "motion", "force", "grip", "in_contact", "theta", "carried"
        there = 1 if seen else 0
        self.declare_inputs(*always, facet=4 * there, height=there, thing=there)
        self.declare_readout(PORT_SIZES, np.zeros(MEMORY_SIZE), period)
        self.declare_computed("in_contact", 1, self._contact, ["in_contact"])
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, *inputs: Array) -> None:
        motion, force, grip, touches, theta, load, facet, height, thing = inputs
        given = (memory, t, self._period, motion, force, grip[0], touches[0], theta, load)
        top, tall, which = (0.0, self._height, 0.0) if facet is None else (facet[3], height[0], thing[0])
        carried_force(*given, top, which, max(0.5 * tall, NO_SWING), self._rule, out)

    def _contact(self, t: float, memory: Array, out: Array, touches: Array) -> None:
        out[0] = holds_contact(memory, touches[0])
