"""The notebook beside other packages: each that is told of the concealed friction finds it, and none else does."""

import importlib

import pytest

pytest.importorskip("pysindy", reason="the extra `peers`")
pytest.importorskip("mujoco", reason="the extra `peers`")


def test_each_fit_that_has_friction_finds_what_is_concealed_and_is_the_better_for_it(run_notebook):
    if not hasattr(importlib.import_module("mujoco.sysid"), "optimize"):
        pytest.skip("mujoco.sysid is without its dependencies")
    left = run_notebook("packages")
    assert left.stderr == "" and left.stdout.rstrip()
    assert {tool for tool, *_ in left.fits} == {"mmt_drake", "mujoco.sysid"}
    for (tool, hertz, has_friction), (before, took, _, error, numbers, *_) in left.fits.items():
        assert ("Fc" in numbers) == has_friction and min(before, took) > 0.0
        if has_friction:
            assert numbers["Fc"][0] == pytest.approx(left.concealed.parameters["Fc"], rel=0.05)
            assert numbers["k2"][0] == pytest.approx(left.case.base["k2"], rel=0.1)
            assert error < 0.5 * left.fits[tool, hertz, False][3]
    assert left.diagnosis.effects[0].name == "coulomb_friction"
