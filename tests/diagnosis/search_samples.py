"""A recording with something concealed, and the fit of the model without it: what a search begins with."""

from trial_samples import model, recorded

from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.prepare import prepare, scales_of
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.effects import LIBRARY, Scales

NOMINAL = model(k2=480.0, b2=23.0)  # the spring 7 % and the damper 8 % off
SOME = [LIBRARY[name] for name in ("force_bias", "nonlinear_stiffness", "coulomb_friction", "force_lag")]
ENOUGH = 1.5

BIAS = ("force_bias", (("bias", 0.3),))
CUBIC = ("nonlinear_stiffness", (("k3", 4e6),))
SLIGHT = ("nonlinear_stiffness", (("k3", 1e6),))
LAG = ("force_lag", (("tau", 0.01),))


def fitted_base(*effects, nominal=NOMINAL, seed=4) -> tuple[Problem, Fitted, Scales]:
    prepared = prepare([recorded(*effects, seed=seed)], nominal)
    assert prepared.problem is not None
    hypothesis = Hypothesis(nominal, prepared.skew)
    base = prepared.problem.fit(hypothesis, hypothesis.base())
    return prepared.problem, base, scales_of(prepared.problem, base.model)
