"""Fits that differ in one law."""

import pytest
from trial_samples import named

from mmt_drake.diagnosis.decide.exchange import as_good_kin, contenders


@pytest.mark.parametrize(
    ("instead", "error", "unsure"),
    [
        ("coulomb_friction", 0.99, {"stribeck_friction"}),  # simpler, of its family, and no worse
        ("coulomb_friction", None, set()),
        ("coulomb_friction", 1.01, set()),
        ("hysteresis", 0.5, set()),  # of another family
        ("coulomb_friction force_bias", 0.5, set()),  # more than one law is another
    ],
)
def test_a_law_is_unsure_where_a_simpler_kin_predicts_unseen_blocks_as_well(
    instead: str, error: float | None, unsure: set[str]
) -> None:
    law, other = named("stribeck_friction"), named(*instead.split())
    assert as_good_kin(law, [law, other], {law.hypothesis.key: 1.0, other.hypothesis.key: error}) == unsure


def test_what_could_do_without_a_name_is_compared() -> None:
    """The best, the best single one, and the two best without the law, the family and the block of either effect."""
    sets = ("coulomb_friction force_bias", "coulomb_friction force_drift", "stribeck_friction", "quadratic_drag")
    ranked = [named(*names.split()) for names in (*sets, "static_friction", "hysteresis", "constant_force")]
    chosen = {id(f) for f in contenders(ranked, 1)}
    assert chosen == {id(f) for i, f in enumerate(ranked) if i != 4}


@pytest.mark.parametrize("beside", ["", " force_bias"])
def test_the_simpler_law_that_another_may_draw_is_compared_however_it_ranks(beside: str) -> None:
    sets = ("asymmetric_friction", "static_friction", "stribeck_friction", "quadratic_drag", "coulomb_friction")
    ranked = [named(*f"{name}{beside}".split()) for name in sets]
    assert ranked[4] in contenders(ranked, 1)
