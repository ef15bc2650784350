"""Logs in other units, and torques of the other sign: input errors, told before anything is fitted to them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import nnls

from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.arms.problem import ArmProblem, JointRows
from mmt_drake.errors import BadInput

_TOO_FAR = 3.0
"""A joint does not go so many times as far as its limits are apart."""
_LESS = 0.25
"""Turned round, the motion explains the torque so much better, in squared error ..."""
_FAR_OFF = 100.0
"""A torque that is so many times what the links ask for, or the other way, on every joint where they ask for most of
it, is in another unit."""
_MOSTLY_LINKS = 0.5
_MOST = 0.3
"""... and leaves less than this part of its variance."""
_RESISTING = ("coulomb_friction", "viscous_friction", "rotor_inertia")


def check_units(arm: ArmPlant, log: JointLog) -> None:
    """Refuse positions that no joint of the arm can have, and torques that were not recorded.

    Args:
        arm: of the model.
        log: of that arm.

    Raises:
        BadInput: a joint goes much farther than its limits allow, as in degrees; or all torques stand still.
    """
    low, high = arm.position_limits
    way = np.ptp(log.q, axis=0)
    far = [j for j in range(len(arm.joints)) if not arm.slides[j] and way[j] > _TOO_FAR * (high[j] - low[j])]
    if far:
        j = far[0]
        raise BadInput(
            log.source,
            at=f"position of {arm.joints[j]}",
            found=f"a way of {way[j]:.4g} rad, from {log.q[:, j].min():.4g} to {log.q[:, j].max():.4g}",
            expected=f"radians from {low[j]:.4g} to {high[j]:.4g}; of degrees `position: {{factor: 0.0174533}}` of the "
            "model makes radians",
        )
    if not np.ptp(log.torque, axis=0).any():
        raise BadInput(
            log.source, at=f"torque ({log.column})", found="the same throughout", expected="what drives give"
        )


def check_signs(problem: ArmProblem, source: str) -> None:
    """Refuse torques that go against what the motion asks for.

    Friction takes power and inertia resists, whatever their size: with none of them negative, a torque of the right
    sign is explained, and one of the other sign is not.

    Args:
        problem: the logs.
        source: of the first of them, for the message.

    Raises:
        BadInput: so they are.
    """
    fits = {j: fit for j in problem.moving if (fit := _fitted(problem.rows[j])) is not None}
    scales = {j: fit.scale for j, fit in fits.items() if fit.scale > 0.0 and fit.left < _MOST}
    if scales and min(max(s, 1.0 / s) for s in scales.values()) > _FAR_OFF:
        j, scale = next(iter(scales.items()))
        raise BadInput(
            source,
            at="torque",
            found=f"{scale:.3g} times what the links ask for on {problem.arm.joints[j]}",
            expected="N m, or N of joints that slide: `torque: {factor: ...}` of the model makes it that",
        )
    wrong = [problem.arm.joints[j] for j, fit in fits.items() if fit.turned < min(_LESS * fit.left, _MOST)]
    if wrong:
        raise BadInput(
            source,
            at="torque",
            found=f"the other sign on {', '.join(wrong)}: it pushes against what the motion asks for",
            expected="torque along the joints: `torque: {factor: ...}` of the model turns it round",
        )


class _SignFit(NamedTuple):
    """What the motion leaves of a torque of this sign and of the other, in parts of its variance.

    `scale` is the torque over what the links ask for; 0 where these ask for less than half of it.
    """

    left: float
    turned: float
    scale: float


def _fitted(row: JointRows) -> _SignFit | None:
    terms = [next((t for t in row.terms if t.effect == name), None) for name in _RESISTING]
    own = [row.columns[:, t.columns[0]] for t in terms if t is not None]
    used = row.counted
    if used.sum() <= len(own) + 2 or not np.ptp(row.measured[used]) > 0.0:
        return None
    columns = np.stack([row.measured - row.target, *own], 1)[used]
    columns, measured = columns - columns.mean(axis=0), row.measured[used] - row.measured[used].mean()
    size = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    fits = [nnls(columns / size, side * measured) for side in (1.0, -1.0)]
    left, turned = (float(fit[1] ** 2 / (measured @ measured)) for fit in fits)
    links = np.linalg.norm(columns[:, 0] / size[0] * fits[0][0][0]) ** 2 / (measured @ measured)
    return _SignFit(left, turned, float(fits[0][0][0] / size[0]) if links > _MOSTLY_LINKS else 0.0)
