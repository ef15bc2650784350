"""One case through every package."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from mmt_drake.diagrams.trial.peers.case import read_case
from mmt_drake.diagrams.trial.peers.mujoco_sysid import fit_sysid, thinned
from mmt_drake.diagrams.trial.peers.own import fit_own
from mmt_drake.diagrams.trial.peers.result import PeerResult
from mmt_drake.diagrams.trial.peers.sindy import RECONSTRUCTED, RECORDED, fit_sindy


def compare(
    folder: Path, *, diagnosis: Mapping[str, Any] | None = None, told: Callable[[str], None] = lambda _: None
) -> list[PeerResult]:
    """Give a case of the flexible box to the project's own fit, to mujoco.sysid and to pysindy, in this process.

    The model's parameters are fitted, and once more with Coulomb friction beside them where the model has none: the
    same numbers from the same start within the same bounds. mujoco.sysid gets the recording as it is, and thinned out
    to the rate of the project's own fit. All on one thread; an ill-conditioned case may keep mujoco.sysid busy for a
    minute.

    Args:
        folder: of the case (`sealed.RECORDING`, `sealed.MODEL`).
        diagnosis: what `diagnose` says of it, for the words of the project's own rows.
        told: is told what is being run.

    Raises:
        BadInput: not a case of the flexible box without ground spring, or a recording that cannot be fitted.
        MissingDependency: the extra `peers` is not installed.
    """
    case = read_case(folder)
    every = thinned(case)
    results = []
    with threadpool_limits(1):
        for friction in (False, True) if case.friction_is_missing else (False,):
            told("own fit")
            results.append(fit_own(case, friction=friction, diagnosis=diagnosis))
            for step in dict.fromkeys((1, every)):
                told("mujoco.sysid")
                results.append(fit_sysid(case, friction=friction, every=step))
        for setting in (RECORDED, RECONSTRUCTED):
            told("pysindy")
            results.append(fit_sindy(case, setting=setting))
    return results
