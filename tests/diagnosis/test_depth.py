"""How deep names hold beside what else there is."""

import pytest

from mmt_drake.diagnosis.decide.depth import (
    MINUTE,
    SLIGHT,
    beside_another_curve,
    beside_another_size,
    beside_its_block,
    beside_its_kin,
    beside_the_nameless,
    beside_the_untried,
)
from mmt_drake.effects import LIBRARY


@pytest.mark.parametrize(
    ("depth", "nameless", "said"),
    [
        ("law", 0.039, "law"),
        ("law", 0.041, "family"),
        ("family", 0.19, "family"),
        ("family", 0.21, "block"),
        ("law", 0.21, "block"),
        ("block", 0.3, "block"),
        (None, 0, None),
        (None, 0.3, None),
    ],
)
def test_a_law_is_sure_only_beside_little_that_has_no_name_and_a_family_beside_no_more_than_half(
    depth, nameless: float, said
) -> None:
    assert beside_the_nameless(depth, 0.4, nameless, may_be_all=False) == said
    assert beside_the_nameless(depth, 0.4, nameless, may_be_all=True) == ("family" if said == "law" else said)
    if nameless < 0.3:  # what it takes together with the parameters counts for its family
        assert beside_the_nameless(depth, 0.4, nameless, may_be_all=True, shared=0.2) != "block" or depth == "block"


@pytest.mark.parametrize(
    ("depth", "untried", "said"),
    [
        ("law", (), "law"),
        ("law", ("contact_gap", "force_bias"), "law"),  # of other places
        ("law", ("contact_gap", "static_friction"), "family"),
        ("family", ("static_friction",), "family"),
        ("law", ("static_friction", "quadratic_drag"), "block"),
        ("block", ("static_friction", "quadratic_drag"), "block"),
        (None, ("static_friction",), None),
    ],
)
def test_a_name_is_no_surer_than_what_there_was_time_to_try_in_its_place(depth, untried, said) -> None:
    others = [LIBRARY[name] for name in untried]
    assert beside_the_untried(depth, LIBRARY["stribeck_friction"], others) == said


@pytest.mark.parametrize(
    ("others", "depth", "said"),
    [
        (["coulomb_friction", "smooth_coulomb_friction"], "law", "family"),
        (["coulomb_friction", "smooth_coulomb_friction"], "block", "block"),
        (["coulomb_friction", "nonlinear_stiffness"], "law", "law"),
        (["coulomb_friction"], "law", "law"),
    ],
)
def test_two_laws_of_one_family_may_make_up_a_third(others, depth, said) -> None:
    assert beside_its_kin(depth, LIBRARY["coulomb_friction"], [LIBRARY[name] for name in others]) == said


@pytest.mark.parametrize(
    ("other", "share", "depth", "said", "of_the_great"),
    [
        ("quadratic_drag", 0.9 * SLIGHT * 0.5, "law", "block", "family"),  # of the same block, which takes 0.5
        ("quadratic_drag", 1.1 * SLIGHT * 0.5, "law", "law", "law"),
        ("quadratic_drag", 0.9 * SLIGHT * 0.5, None, None, None),
        ("quadratic_drag", 0.9 * SLIGHT * 0.5, "block", "block", "block"),
        ("nonlinear_stiffness", 0.9 * SLIGHT * 0.5, "law", "law", "law"),
    ],
)
def test_a_slight_effect_beside_a_great_one_may_be_what_that_law_gets_wrong(
    other, share, depth, said, of_the_great
) -> None:
    effect, beside = LIBRARY["stribeck_friction"], LIBRARY[other]
    assert beside_another_size(depth, effect, {effect: share, beside: 0.5}) == said
    assert beside_another_size(depth, beside, {effect: share, beside: 0.5}) == of_the_great


@pytest.mark.parametrize(("part", "said"), [(0.9, None), (1.1, "law")])
def test_what_takes_less_than_a_hundredth_of_another_effect_is_not_sure(part: float, said: str | None) -> None:
    ripple, friction = LIBRARY["torque_ripple"], LIBRARY["asymmetric_friction"]
    shares = {ripple: 0.97, friction: part * MINUTE * 0.97}
    assert beside_another_size("law", friction, shares) == said
    assert beside_another_size("law", ripple, shares) == "law"


@pytest.mark.parametrize(
    ("names", "bent", "said"),
    [
        ("smooth_coulomb_friction", "", "family"),
        ("smooth_coulomb_friction", "smooth_coulomb_friction", "block"),  # a damper that levels off
        ("smooth_coulomb_friction coulomb_friction", "", "block block"),  # which the two may draw, too
        ("coulomb_friction quadratic_drag", "quadratic_drag", "family family"),
        ("time_delay viscoelastic_relaxation", "", "family family"),
        ("time_delay viscoelastic_relaxation", "time_delay", "family None"),  # a lag: no delay, and no relaxation
    ],
)
def test_a_curve_that_is_another_one_takes_the_family_and_a_delay_that_is_none_the_names_beside_it(
    names, bent, said
) -> None:
    effects = [LIBRARY[name] for name in names.split()]
    found = [beside_another_curve("family", effect, effects, frozenset(bent.split())) for effect in effects]
    assert list(map(str, found)) == said.split()


def test_no_law_is_sure_beside_an_effect_of_its_block_of_which_the_block_alone_is() -> None:
    lag, tip, spring = (LIBRARY[name] for name in ("force_lag", "tip_mass", "nonlinear_stiffness"))
    assert lag.block == tip.block != spring.block
    found = beside_its_block({lag: "law", tip: "block", spring: "law"})
    assert found == {"force_lag": "family", "tip_mass": "block", "nonlinear_stiffness": "law"}
