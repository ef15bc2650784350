"""The error of a simulated force against the measured one."""

import numpy as np

from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import AXES, Recording


def rms(values: Array) -> float:
    """Root of the mean square; 0 of nothing."""
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


def nrmse(measured: Array, simulated: Array) -> float | None:
    """sqrt(mean((measured - simulated)^2)) / std(measured), (n,) each; None where `measured` does not vary.

    The error's mean is not removed: an offset counts.
    """
    spread = float(np.std(measured)) if len(measured) else 0.0
    return float(np.sqrt(np.mean((measured - simulated) ** 2))) / spread if spread > 0.0 else None


def force_nrmse(measured: Recording, simulated: Recording) -> dict[str, float]:
    """`nrmse` of every measured force over the samples in contact.

    Args:
        measured: with the measured forces, if there are any. All samples count where it has no `in_contact`.
        simulated: the same times, the simulated forces.

    Returns:
        column -> error, for those columns that vary in contact.
    """
    contact = measured["in_contact"] != 0.0 if "in_contact" in measured else np.ones(len(measured), dtype=bool)
    names = [name for name in ("force", *(f"force_{axis}" for axis in AXES)) if name in measured]
    errors = {name: nrmse(measured[name][contact], simulated[name][contact]) for name in names}
    return {name: error for name, error in errors.items() if error is not None}
