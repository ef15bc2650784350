"""The plants that a trial's objects are simulated by: its own, an axis at a time, and the foreign one, in the plane."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from mmt_drake.diagrams.proof.trial.laws import LAWS
from mmt_drake.diagrams.proof.trial.motions import ProbeMotion
from mmt_drake.diagrams.proof.trial.physics import Physics
from mmt_drake.diagrams.proof.trial.plant import run_axis
from mmt_drake.foreign import plant as foreign
from mmt_drake.foreign.numbers import Numbers
from mmt_drake.numeric.arrays import Array

NOT_IN_A_PLANE: Final = (
    *("asymmetric_viscous_friction", "asymmetric_friction", "rough_patch", "ageing_friction", "frictional_heating"),
    *("run_in_softening", "load_stiffening", "loose_mass", "table_vibration"),
)
"""Effects that have no meaning along two axes at once, or that the foreign plant does not have."""


@dataclass(frozen=True)
class Plant:
    """What simulates an object under a probe.

    Attributes:
        name: of the plant.
        effects: that it can have in it, of `LAWS`.
        moves_x: probability that a hand moves along x too.
        forces: of the laws, the probe's motion, the tangential axes that are wanted, and steps per sample. Gives the
            force on the probe at every step ((n - 1) * steps + 1, axes) [N] and the body's displacement and velocity
            (n, 2) along the last of these axes [m], [m/s].
        without: parameters of effects that mean nothing to it.
    """

    name: str
    effects: tuple[str, ...]
    moves_x: float
    forces: Callable[[Physics, ProbeMotion, Sequence[int], int], tuple[Array, Array]]
    without: tuple[str, ...] = ()


def _own(physics: Physics, motion: ProbeMotion, axes: Sequence[int], substeps: int) -> tuple[Array, Array]:
    n = len(motion.time)
    forces, body = np.empty((len(axes), (n - 1) * substeps + 1)), np.empty((n, 2))
    z, vz = (np.ascontiguousarray(values[:, 2]) for values in (motion.position, motion.velocity))
    for axis, force in zip(axes, forces, strict=True):
        probe, probe_v = (np.ascontiguousarray(values[:, axis]) for values in (motion.position, motion.velocity))
        run_axis(motion.time, probe, probe_v, z, vz, physics, substeps, force, body)
    return forces.T, body


def foreign_numbers(physics: Physics) -> Numbers:
    """The same laws in the plane: friction is alike in all directions, and sticks without Karnopp's band."""
    same = {name: getattr(physics, name) for name in Numbers._fields if name in Physics._fields}
    return Numbers(**same, b1=physics.b_plus, Fs=physics.Fs_plus, Fd=physics.Fd_plus)


def _foreign(physics: Physics, motion: ProbeMotion, axes: Sequence[int], substeps: int) -> tuple[Array, Array]:
    probe = np.hstack([motion.position, motion.velocity])
    forces, body = foreign.simulated(motion.time, probe, foreign_numbers(physics), substeps)
    return forces[:, list(axes)], body[:, [axes[-1], 2 + axes[-1]]]


OWN: Final = Plant("own", tuple(LAWS), 0.2, _own)
FOREIGN: Final = Plant("foreign", tuple(n for n in LAWS if n not in NOT_IN_A_PLANE), 1.0, _foreign, ("v_d",))
PLANTS: Final = {plant.name: plant for plant in (OWN, FOREIGN)}
