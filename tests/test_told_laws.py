"""Laws as kernels that know the numbers alone take them."""

import pytest

from mmt_drake.model.parameters import THETA
from mmt_drake.model_message import UNKNOWN_THETA, ModelMessage, ToldEffect
from mmt_drake.told_laws import NO_LAWS, told_by, without_effect


@pytest.mark.parametrize(
    ("name", "values", "idle"),
    [
        ("asymmetric_friction", {"Fc_plus": 0.2, "Fc_minus": 0.3}, {"Fc", "Fs", "v_d"}),
        ("asymmetric_viscous_friction", {"b_plus": 20.0, "b_minus": 30.0}, {"b1"}),
        ("stribeck_friction", {"Fs": 2.0, "v_s": 0.03}, {"Fs", "v_d"}),  # it reads Fc
        ("power_law_stiffness", {"k": 8000.0, "p": 1.5}, {"normal_k"}),
        ("nonlinear_stiffness", {"k3": 1e6}, set()),
        ("contact_gap", {"gap": 0.002}, set()),
    ],
)
def test_numbers_that_a_law_does_without_have_no_effect(name: str, values: dict[str, float], idle: set[str]) -> None:
    known = told_by(ModelMessage(UNKNOWN_THETA, (ToldEffect(name, values),)))
    assert {symbol for symbol, flag in zip(THETA, without_effect(known), strict=True) if flag} == idle


def test_without_laws_every_number_has_its_effect() -> None:
    assert not without_effect(NO_LAWS).any()
