"""Logs in other units, and torques of the other sign: input errors, told before anything is fitted to them."""

from __future__ import annotations

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
_MOST = 0.3
"""... and leaves less than this part of its variance."""
_RESISTING = ("coulomb_friction", "viscous_friction", "rotor_inertia")


def check_units(arm: ArmPlant, log: JointLog) -> None:
    """Refuse positions that no joint of the arm can have, and torques that were not recorded.

    Args:
        arm: of the model.
        log: of that arm.

    Raises:
        BadInput: a joint goes much farther than its limits allow, as positions in degrees do; or all torques stand still.
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
        raise BadInput(log.source, at=f"torque ({log.column})", found="the same throughout", expected="what drives give")


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
    wrong = [problem.arm.joints[j] for j in problem.moving if _is_reversed(problem.rows[j])]
    if wrong:
        raise BadInput(
            source,
            at="torque",
            found=f"the other sign on {', '.join(wrong)}: it pushes against what the motion asks for",
            expected="torque along the joints: `torque: {factor: ...}` of the model turns it round",
        )


def _is_reversed(row: JointRows) -> bool:
    terms = [next((t for t in row.terms if t.effect == name), None) for name in _RESISTING]
    own = [row.columns[:, t.columns[0]] for t in terms if t is not None]
    used = row.counted
    if used.sum() <= len(own) + 2 or not np.ptp(row.measured[used]) > 0.0:
        return False
    columns = np.stack([row.measured - row.target, *own], 1)[used]
    columns, measured = columns - columns.mean(axis=0), row.measured[used] - row.measured[used].mean()
    size = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    left = [nnls(columns / size, side * measured)[1] ** 2 for side in (1.0, -1.0)]
    return bool(left[1] < _LESS * left[0] and left[1] < _MOST * (measured @ measured))
