"""The force renderer: the operator's own copy of the object, integrated without waiting for the network."""

import math
from typing import Literal, get_args

import numpy as np

from mmt_drake.errors import BadInput, check_number
from mmt_drake.model.held_body import NO_REPORT
from mmt_drake.model.parameters import InPlane
from mmt_drake.model_message import ModelMessage
from mmt_drake.numeric.arrays import Array
from mmt_drake.rendering.impedance import MEMORY_SIZE, NO_PLANE, PORT_SIZES, THING, drop_laws, meet, render_on
from mmt_drake.rendering.laws import felt_by_bytes
from mmt_drake.rendering.structures import RenderedStructure, rendered_as
from mmt_drake.rendering.updates import Policy, renderer_rules
from mmt_drake.systems.kernel_system import KernelSystem
from mmt_drake.told_laws import NO_LAWS, NUMBER, told_by

ProbeInput = Literal["moved", "placed"]


class ImpedanceRenderer(KernelSystem):
    """Force of the estimated object on the operator's probe (thesis, section 3.1.1 and D.4).

    An instance of the model of figure 3, driven by the operator's motion and integrated by a Runge-Kutta method of
    order 4 with that motion evaluated inside the step. Parameters are taken up as they arrive, by the policy that was
    chosen (`mmt_drake.rendering.updates`), the body's position and velocity carrying over; a body that friction holds
    is brought by the same policy to where it is known to be held. While `in_contact` is 0 the model is free space,
    F = 0 (eq. 9); the body then moves on by itself, and the next touch starts with an unstretched contact spring.
    Contact is what the flag says and nothing else.

    Until the first stable, finite theta the force is zero; later ones that are not stable, or so stiff that they would
    need more than a hundred steps for one, are passed over, the latest good one is kept, and `status` says so.
    Estimates scatter about zero: a negative Fc counts as no friction, since friction must not push; the other numbers
    are used as they come, unless the policy says otherwise.

    .. pydrake_system::

        name: ImpedanceRenderer
        input_ports:
        - motion
        - theta
        - stable
        - in_contact
        - held_body
        - hand
        - model_status
        - facet
        - model
        - thing
        output_ports:
        - force
        - status
        - update_jump
        - stored_energy
        - readout

    Ports (table frame):

    - `motion` (6): the operator's position [m] and velocity [m/s].
    - `theta` (10): m [kg], k1, k2 [N/m], b1, b2 [N s/m], Fc [N], normal_k [N/m], normal_b [N s/m], Fs [N], v_d [m/s].
    - `stable` (1): 1 where theta is an admissible, stable model (see `RlsEstimator`).
    - `in_contact` (1): 1 where the operator touches the object.
    - `held_body` (7): where friction holds the body (`mmt_drake.model.held_body`) [m], [s], as the estimator knows it,
      in the operator's time, and from where it counts; may stay unconnected, and then the body stays where friction has
      left it.
    - `hand` (6): position [m] and velocity [m/s] of the hand that feels the force, if an arm that yields is modelled
      before `motion`; energy is counted there. May stay unconnected.
    - `model_status` (1): 0 where the estimator is sure of theta (`OutputErrorEstimator`); anything else makes
      `EnergyPermitting` take it up more slowly. May stay unconnected, and then it is sure.
    - `facet` (4): the plane that touches the surface under the probe: outward unit normal n, and n · x of its points
      [m]; zeros: the last one. The contact then acts in its frame (`mmt_drake.model.local_contact`). May stay
      unconnected, and then the surface is level, z = 0.
    - `model` (44): the latest message of the estimator (`mmt_drake.model_message`) [SI], of which named laws are taken;
      zeros: none yet. They act where the surface stays and nothing slips on it, a clearance where `facet` stays
      unconnected. May stay unconnected, and then those of the option `model` act.
    - `thing` (1): identity of the object that the hand is over [1]; each other one begins at rest, with the theta that
      there is then. 0, or unconnected: it is always the same.
    - `force` (3): force on the operator's probe [N]; direct feedthrough from `motion`, so it is never a tick late.
    - `status` (1): what became of the latest theta, 0 to 9 as in `mmt_drake.rendering.status`: 0 where nothing has been
      rendered yet, 1 rendered, 2 on its way, 3 passed over as unstable, 4 as no model, 5 as too stiff; 6 where motion
      or contact is not finite, and it lets go of its force (`mmt_drake.rendering.finite`). Theta being rendered, 7
      where a message is passed over as unknown, broken or out of order, 8 as of a law that is not to be felt, 9 as of
      one too fast to integrate: the last good ones act.
    - `update_jump` (3): by how much the update of this tick changed the force [N], the probe's motion being equal.
    - `stored_energy` (1): what the model could give back to the hand [J], if its numbers stay.
    - `readout` (8 and the memory): the four above in that order, then the memory (`mmt_drake.rendering.impedance`).

    Args:
        period: of the updates [s].
        substeps: Runge-Kutta steps per update at least; stiff parameters may take more (`accurate_step`).
        updates: how new parameters are taken up; at once by default.
        probe: `moved`, as the operator moves it; or, to see what becomes of a force then, `placed`: set to each new
            position and standing still there, as a physics engine has an input body that is moved by its position. Its
            velocity is lost to the contact damper.
        in_plane: whether friction of the object is a vector, F = -Fc v/|v|, or that of each axis, as in the thesis.
        carried: whether the body carries the surface along; else it stays (`mmt_drake.surfaces.Shape`).
        mu: friction of the probe on the surface; None: it never slips.
        model: the message whose laws act where the port of that name stays unconnected; None: no laws.
        structure: as what theta is rendered (`mmt_drake.rendering.structures`); any other than a flexible box has no
            laws, and is held where it was touched.

    Raises:
        BadInput: a period that is not positive or less than one substep; no such way of having the probe, friction or
            structure.
    """

    def __init__(
        self,
        *,
        period: float = 1e-3,
        substeps: int = 1,
        updates: Policy | None = None,
        probe: ProbeInput = "moved",
        in_plane: InPlane = "vector",
        carried: bool = False,
        mu: float | None = None,
        model: ModelMessage | None = None,
        structure: RenderedStructure = "flexible_box",
    ) -> None:
        super().__init__()
        for at, found, known in (("probe", probe, ProbeInput), ("structure", structure, RenderedStructure)):
            if found not in get_args(known):
                raise BadInput("renderer", at=at, found=found, expected=f"one of {', '.join(get_args(known))}")
        self._structure: RenderedStructure = structure
        self._placed = probe == "placed"
        self._sure, self._unsure = renderer_rules(updates, period, substeps, in_plane)
        if mu is not None:
            check_number("renderer", "mu", mu, least=0.0, open_interval=True)
        self._fixed = 0.0 if carried else 1.0, math.inf if mu is None else mu
        self._laws = NO_LAWS if model is None else told_by(model)
        may_be_left = ("held_body", "hand", "model_status", "facet", "model", "thing")
        self.declare_inputs("motion", "theta", "stable", "in_contact", *may_be_left, optional=may_be_left)
        self.declare_readout(PORT_SIZES, np.zeros(MEMORY_SIZE), period)
        meet(np.zeros(MEMORY_SIZE), 0.0)  # compiled before the clock starts, as all else
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, *inputs: Array) -> None:
        motion, theta, stable, contact, held, hand, model_status, told, model, thing = inputs
        if thing is not None and thing[0] != memory[THING]:
            memory = memory.copy()
            meet(memory, thing[0])
            memory.setflags(write=False)  # as that of the Context is: another kind of array would be compiled anew
        hand = motion if hand is None else hand
        if self._placed:
            motion = np.concatenate((motion[:3], np.zeros(3)))
        bare = self._structure != "flexible_box"
        theta, held = rendered_as(self._structure, theta), NO_REPORT if held is None or bare else held
        rule = self._sure if model_status is None or model_status[0] == 0.0 else self._unsure
        given = memory, t, motion, hand, theta, stable[0], contact[0], rule, self._placed, held
        laws = self._laws if model is None or bare else felt_by_bytes(model.tobytes(), told is None)
        fixed = (NO_PLANE, 1.0, math.inf) if told is None else (told, *self._fixed)
        fixed[0].setflags(write=False)  # as memory is
        try:
            render_on(*given, *fixed, laws, out)
        except RuntimeError:  # of kernels that cannot follow
            without = memory.copy()
            if not drop_laws(without, laws[NUMBER]):
                raise
            without.setflags(write=False)
            render_on(without, *given[1:], *fixed, laws, out)
