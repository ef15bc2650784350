"""A lump under the surface: the contact is stiffer there, and that is told from a hill, and not where there is none."""

import numpy as np
import pytest
from palpation_samples import palpation, stiffness_at

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.effects import LIBRARY
from mmt_drake.model.surface_contact import SurfaceContact

BELIEVED = SurfaceContact(k=400.0, b=0.5)
SEARCHED = [
    LIBRARY[name]
    for name in ("surface_shape", "stiffness_map", "probe_slip", "nonlinear_stiffness", "viscoelastic_relaxation")
]


def found_in(**made):
    return diagnose([palpation(**made)], BELIEVED, library=SEARCHED).diagnosis.effects


def mapped(effects):
    """Places (m,) each where the probe was, and the stiffness there."""
    told = {symbol: v.value for symbol, v in effects["stiffness_map"].parameters.items()}
    x, y = (at.ravel() for at in np.meshgrid(told["x"], told["y"]))
    inside = (np.abs(x) < 0.009) & (np.abs(y) < 0.015)
    assert min(told["deviation"]) > 0.0
    return x[inside], y[inside], np.asarray(told["stiffness"])[inside]


@pytest.mark.parametrize(
    ("made", "names"),
    [
        ({}, {"stiffness_map"}),
        ({"mu": 0.3, "seed": 1}, {"stiffness_map", "probe_slip"}),
        ({"radius": 0.08, "mu": 0.3, "seed": 2}, {"stiffness_map", "probe_slip", "surface_shape"}),
    ],
)
def test_a_lump_is_named_with_what_else_is_there_and_its_stiffness_found_again(made, names):
    effects = {e.name: e for e in found_in(lump=1.0, **made)}
    assert set(effects) == names and {e.certain for e in effects.values()} == {"law"}
    x, y, k = mapped(effects)
    true = stiffness_at(x, y, 1.0)
    assert np.sqrt(np.mean((k - true) ** 2)) < 0.15 * np.std(true)


def test_a_hill_without_a_lump_is_no_lump():
    assert {e.name for e in found_in(radius=0.08, mu=0.3, seed=3)} == {"surface_shape", "probe_slip"}


def test_a_spring_that_hardens_everywhere_is_no_lump():
    names = {e.name for e in found_in(seed=4, hardens=2e7)}
    assert "stiffness_map" not in names and "nonlinear_stiffness" in names
