"""A law that explains all to the noise is asked all the same whether a free curve says more."""

import numpy as np

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.effects import LIBRARY
from mmt_drake.model_files import parse_model
from mmt_drake.recording.check import completed

SOME = ("smooth_coulomb_friction", "coulomb_friction", "quadratic_drag", "asymmetric_viscous_friction")


def test_a_fluid_damper_is_no_smooth_coulomb_friction_for_sure() -> None:
    rng, time = np.random.default_rng(602), np.arange(12500) / 500.0
    waves = [
        (rng.uniform(0.3, 1.0), 2.0 * np.pi * hertz, rng.uniform(0.0, 6.28)) for hertz in np.linspace(0.15, 4.0, 8)
    ]
    x = 2e-3 * sum(a * np.sin(w * time + phase) for a, w, phase in waves)
    v = 2e-3 * sum(a * w * np.cos(w * time + phase) for a, w, phase in waves)
    force = -(2000.0 * x + 225.0 * np.sign(v) * np.abs(v) ** 0.4) + rng.normal(0.0, 0.8, len(time))
    columns = {"position": x + rng.normal(0.0, 2e-6, len(time)), "force": force}
    believed = parse_model({"structure": "kelvin_voigt", "parameters": {"k": 2500.0, "b": 500.0}}, "believed")
    told = diagnose([completed(time, columns, "damper")], believed, library=[LIBRARY[name] for name in SOME]).diagnosis
    assert told.fit.heldout_nrmse.augmented < told.fit.noise_floor  # most of it is noise of the position, through b
    assert told.effects and all(effect.certain == "block" for effect in told.effects)
