"""Hypotheses: numbers in a vector and the model that they make, and what may stand beside what."""

import math
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from mmt_drake.diagnosis.fit.hypothesis import SKEW, WIDEST, Hypothesis
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import NORMAL, BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model_files import model_data, parse_model

BOX = FlexibleBoxModel(BoxParameters(m=0.8, k1=0.0, k2=400.0, b1=5.0, b2=20.0, Fc=0.3), NormalContact(600.0, 20.0))
BARE = FlexibleBoxModel(BoxParameters(m=0.8, k1=0.0, k2=400.0, b1=0.0, b2=20.0, Fc=0.0), NormalContact(600.0, 20.0))
SPRING = KelvinVoigt(k=400.0, b=20.0, x0=0.0, F0=0.2)
DRIVEN = DrivenBodyModel(m=0.8, b=5.0, k=60.0, Fc=0.3, offset=-0.1, gain=2.0)


def beside(model, *names, **held):
    """The hypothesis with effects added one after the other, and values held of some."""
    hypothesis = Hypothesis(model)
    for name in names:
        hypothesis = hypothesis.adding(LIBRARY[name], held.get(name))
    return hypothesis


def saying(data, values):
    """A model file with other numbers of the structure."""
    normal = {s.removeprefix("normal."): v for s, v in values.items() if s in NORMAL}
    own = {s: v for s, v in values.items() if s not in NORMAL}
    changed = {**data, "parameters": {**data["parameters"], **own}}
    return {**changed, "normal": {**data["normal"], **normal}} if normal else changed


def admitted(hypothesis):
    """Names of the effects that a search may add; a table is learned, not searched for."""
    return {name for name, effect in LIBRARY.items() if hypothesis.admits(effect)} - {"tabulated_force"}


# effects that were handed in


HANDED = {"static_friction": {"Fs": 0.9, "Fd": 0.6, "v_d": 0.004}, "nonlinear_stiffness": {"k3": 4e5}}


def handed_in():
    return parse_model(model_data(BOX, list(HANDED.items())))


def test_effects_handed_in_are_numbers_of_the_model_and_none_that_was_found():
    model = handed_in()
    hypothesis = Hypothesis.of(model)
    assert hypothesis.key == frozenset() and hypothesis.nominal == BOX
    assert hypothesis.model(hypothesis.base()) == model
    assert hypothesis.effect_values(hypothesis.base()) == HANDED
    assert {(p.effect, p.symbol) for p in hypothesis.free_parameters() if p.effect} == {
        (name, symbol) for name, values in HANDED.items() for symbol in values
    }


def test_what_is_found_next_stands_beside_them():
    hypothesis = Hypothesis.of(handed_in())
    assert not {"static_friction", "coulomb_friction", "stribeck_friction"} & admitted(hypothesis)
    more = hypothesis.adding(LIBRARY["force_bias"])
    x = more.vector({}, {"force_bias": {"bias": 0.2}})
    assert more.names == ("force_bias",) and more.effect_values(x) == {**HANDED, "force_bias": {"bias": 0.2}}
    assert len(more.model(x).additions.laws) == len(handed_in().additions.laws) + 1


# numbers


@pytest.mark.parametrize(
    ("model", "free"),
    [
        (BOX, ("m", "k2", "b1", "b2", "Fc", "normal.k", "normal.b")),
        (BARE, ("m", "k2", "b2", "normal.k", "normal.b")),
        (DRIVEN, ("m", "b", "k", "Fc", "offset")),
        (SPRING, ("k", "b", "F0")),
    ],
)
def test_what_is_not_0_is_free_and_the_base_is_the_nominal_model(model, free):
    hypothesis = Hypothesis(model)
    assert set(hypothesis.free) == set(free) and len(hypothesis.free) == len(free)
    assert hypothesis.model(hypothesis.base()) == model
    doubled = 2.0 * hypothesis.base()
    values = hypothesis.structure_values(doubled)
    assert hypothesis.model(doubled) == parse_model(saying(model_data(model), values))


def test_of_an_axis_that_no_recording_shows_no_number_is_free():
    assert Hypothesis(BOX, unseen=NORMAL).free == ("m", "k2", "b1", "b2", "Fc")


def test_a_normal_axis_that_a_model_leaves_out_is_sought_from_nothing_on():
    hypothesis = Hypothesis(replace(BOX, normal=NormalContact(0.0, 0.0)))
    places = {p.symbol: p for p in hypothesis.free_parameters()}
    assert [(places[s].low, places[s].high) for s in NORMAL] == [(0.0, math.inf)] * 2
    assert (places["normal.k"].scale, places["normal.b"].scale) == (400.0, 20.0)  # as along the surface


@pytest.mark.parametrize(
    ("model", "effects"),
    [
        (BOX, {"nonlinear_stiffness": {"k3": 4e5}}),
        (BARE, {"stribeck_friction": {"Fs": 0.9, "v_s": 0.05}, "coulomb_friction": {"Fc": 0.2}}),
        (BOX, {"static_friction": {"Fs": 0.9, "Fd": 0.6, "v_d": 0.004}, "force_lag": {"tau": 0.02}}),
        (BARE, {"viscous_friction": {"b": 9.0}, "ground_spring": {"k": 60.0}, "coulomb_friction": {"Fc": 0.5}}),
        (BOX, {"mass_change": {"time": 1.6, "dm": 0.5}, "second_mode": {"m2": 0.3, "k": 120.0, "b": 0.6}}),
        (BOX, {"time_delay": {"delay": 0.0153}, "contact_gap": {"gap": 0.004}, "force_bias": {"bias": -0.3}}),
        (DRIVEN, {"asymmetric_friction": {"Fc_plus": 0.9, "Fc_minus": 0.5}, "quadratic_drag": {"c": 40.0}}),
        (replace(DRIVEN, offset=0.0), {"constant_force": {"F": 0.7}, "mass_change": {"time": 2.0, "dm": -0.2}}),
        (SPRING, {"hysteresis": {"alpha": 300.0, "beta": 150.0}, "force_drift": {"rate": 0.02}}),
    ],
)
def test_values_go_into_the_vector_and_come_out_as_the_model_that_a_file_with_them_gives(model, effects):
    hypothesis = beside(model, *effects)
    own = {
        symbol: 1.1 * value for symbol, value in Hypothesis(model).structure_values(Hypothesis(model).base()).items()
    }
    own = {symbol: own[symbol] for symbol in hypothesis.free}
    x = hypothesis.vector(own, effects)
    assert hypothesis.structure_values(x) == own and hypothesis.effect_values(x) == effects
    np.testing.assert_array_equal(hypothesis.vector(own, hypothesis.effect_values(x)), x)
    data = model_data(model, list(effects.items()))
    assert hypothesis.model(x) == parse_model(saying(data, own))
    places = hypothesis.free_parameters()
    assert len(places) == len(x) and [p.symbol for p in places[: len(own)]] == list(own)
    assert {p.effect for p in places[len(own) :]} == set(effects)


def test_the_order_in_which_effects_came_in_does_not_matter():
    effects = {
        "coulomb_friction": {"Fc": 0.2},
        "stribeck_friction": {"Fs": 0.9, "v_s": 0.05},
        "force_bias": {"bias": 0.1},
    }
    models = [h.model(h.vector({}, effects)) for h in (beside(BARE, *order) for order in permutations(effects))]
    levels = {tuple(law.values for law in model.additions.laws if law.law.slot.name == "FRICTION") for model in models}
    assert levels == {((0.9, 0.05, 0.2),)}  # Stribeck's curve falls to the level that Coulomb friction adds
    assert len({frozenset(model.additions.laws) for model in models}) == 1


def test_a_default_is_held_at_what_a_start_says_and_is_not_free():
    hypothesis = beside(BOX, "end_stop", "force_bias", end_stop={"side": -1.0})
    x = hypothesis.vector({}, {"end_stop": {"position": 0.01, "stiffness": 800.0}, "force_bias": {"bias": 0.1}})
    assert [p.symbol for p in hypothesis.free_parameters() if p.effect == "end_stop"] == ["position", "stiffness"]
    assert hypothesis.effect_values(x)["end_stop"] == {"position": 0.01, "stiffness": 800.0, "side": -1.0}
    assert (0.01, 800.0, -1.0) in [law.values for law in hypothesis.model(x).additions.laws]
    rest = hypothesis.without("end_stop")
    assert rest.names == ("force_bias",) and not rest.held.get("end_stop")
    assert rest.key == frozenset({"force_bias"})


def test_limits_are_the_effects_own_and_some_times_the_nominal_value():
    hypothesis = beside(DRIVEN, "mass_change", "static_friction")
    x = hypothesis.vector(
        {}, {"mass_change": {"time": 3.0, "dm": -0.2}, "static_friction": {"Fs": 0.9, "Fd": 0.6, "v_d": 0.0}}
    )
    low, high, scale = hypothesis.limits(x)
    told = {(p.effect, p.symbol): (low[i], high[i], scale[i]) for i, p in enumerate(hypothesis.free_parameters(x))}
    assert told["", "m"] == (0.8 / WIDEST, 0.8 * WIDEST, 0.8)
    assert told["", "offset"] == (-np.inf, np.inf, pytest.approx(0.1))
    assert told["mass_change", "time"] == (0.0, np.inf, 3.0) and told["mass_change", "dm"] == (-np.inf, np.inf, 0.2)
    assert told["static_friction", "v_d"] == (0.0, np.inf, 1.0)  # a scale is never 0
    assert ("", "Fc") not in told  # static friction stands in its place
    assert {p.unit for p in hypothesis.free_parameters() if p.symbol in ("dm", "Fs")} == {"kg", "N"}


def test_the_skew_of_the_clocks_is_the_last_number_and_a_delay_takes_its_place():
    hypothesis = Hypothesis(BOX, skew=5e-4)
    assert hypothesis.base()[-1] == 0.0 and hypothesis.free_parameters()[-1].symbol == SKEW
    x = hypothesis.vector({"m": 0.9}, {}, skew=2e-4)
    assert hypothesis.skew_of(x) == 2e-4 and len(x) == len(hypothesis.free) + 1
    low, high, scale = hypothesis.limits(x)
    assert (low[-1], high[-1], scale[-1]) == (-5e-4, 5e-4, 5e-4)
    assert SKEW not in hypothesis.structure_values(x) and hypothesis.structure_values(x)["m"] == 0.9
    assert hypothesis.model(x).additions.delay == 0.0  # a nuisance is no part of the model
    late = hypothesis.adding(LIBRARY["time_delay"])
    x = late.vector({}, {"time_delay": {"delay": 0.01}}, skew=2e-4)
    assert not late.has_skew and late.skew_of(x) == 0.0 and len(x) == len(late.free) + 1
    assert late.without("time_delay").has_skew
    biased = hypothesis.adding(LIBRARY["force_bias"])
    assert biased.skew_of(biased.vector({}, {"force_bias": {"bias": 0.1}}, skew=3e-4)) == 3e-4
    assert not Hypothesis(BOX).has_skew and Hypothesis(BOX).skew_of(Hypothesis(BOX).base()) == 0.0


def test_numbers_that_no_model_can_have_are_refused():
    hypothesis = beside(BOX, "static_friction")
    with pytest.raises(BadInput, match="static_friction: Fd"):
        hypothesis.model(hypothesis.vector({}, {"static_friction": {"Fs": 0.3, "Fd": 0.6, "v_d": 0.0}}))
    with pytest.raises(BadInput, match="m"):
        hypothesis.model(hypothesis.vector({"m": -1.0}, {"static_friction": {"Fs": 0.6, "Fd": 0.3, "v_d": 0.0}}))


# what may stand beside what


def test_only_effects_of_the_structures_blocks_are_admitted():
    for model in (BARE, SPRING, DRIVEN):
        for name in admitted(Hypothesis(model)):
            assert LIBRARY[name].block in model.BLOCKS
    assert "end_stop" not in admitted(Hypothesis(SPRING)) and "force_bias" not in admitted(Hypothesis(DRIVEN))


def test_what_a_structural_parameter_already_is_has_no_second_name():
    adding = {"viscous_friction", "coulomb_friction", "ground_spring"}
    assert admitted(Hypothesis(BARE)) >= adding
    assert admitted(Hypothesis(BOX)) & adding == {
        "ground_spring"
    }  # b1 and Fc are not 0 there: wrong values are no effects
    assert not admitted(Hypothesis(DRIVEN)) & adding


def test_a_constant_that_the_model_has_is_no_force_of_another_name():
    # Contract, section 3: offset is `constant_force` and F0 is `force_bias` where the nominal model has none.
    assert "constant_force" not in admitted(Hypothesis(DRIVEN))
    assert "constant_force" in admitted(Hypothesis(replace(DRIVEN, offset=0.0)))
    assert "force_bias" not in admitted(Hypothesis(SPRING))
    assert "force_bias" in admitted(Hypothesis(replace(SPRING, F0=0.0)))


def test_a_spring_and_damper_may_have_left_out_all_that_its_blocks_hold():
    # Contract, section 4; its b is not 0, so another one is a wrong value, and so is another F0. A slip, and places
    # that differ, need a plane; what lags behind its input is a body.
    blocks = {name for name, effect in LIBRARY.items() if effect.block in SPRING.BLOCKS and not effect.twin_of}
    of_others = {"probe_slip", "stiffness_map", "input_lag"}
    assert blocks - admitted(Hypothesis(SPRING)) == {"viscous_friction", "force_bias", *of_others}


def test_a_learned_table_is_held_as_it_is():
    table = {"of": "deflection", "at": (-0.01, 0.0, 0.01), "value": (-0.5, 0.0, 0.9)}
    hypothesis = beside(BOX, "force_bias", "tabulated_force", tabulated_force=table)
    x = hypothesis.vector({}, {"force_bias": {"bias": 0.1}, "tabulated_force": {}})
    assert len(x) == len(hypothesis.free) + 1 and hypothesis.effect_values(x)["tabulated_force"] == table
    data = model_data(BOX, [("force_bias", {"bias": 0.1}), ("tabulated_force", table)])
    assert hypothesis.model(x) == parse_model(data)


def test_one_place_is_taken_by_one_effect():
    on_Fc = {"asymmetric_friction", "static_friction", "stribeck_friction", "presliding_friction"}
    on_b = {"viscous_friction", "asymmetric_viscous_friction"}
    for name in on_Fc:
        assert not admitted(beside(BOX, name)) & on_Fc
        assert admitted(beside(BOX, name)) >= {"load_dependent_friction", "quadratic_drag"}
    for name in on_b:
        assert not admitted(beside(BARE, name)) & on_b
    assert all(name not in admitted(beside(BARE, name)) for name in admitted(Hypothesis(BARE)))


def test_what_builds_on_a_number_goes_with_what_adds_to_it_in_either_order():
    for name in ("stribeck_friction", "presliding_friction"):
        assert name in admitted(beside(BARE, "coulomb_friction")) and "coulomb_friction" in admitted(beside(BARE, name))
    for name in ("asymmetric_friction", "static_friction"):
        assert name not in admitted(beside(BARE, "coulomb_friction"))
        assert "coulomb_friction" not in admitted(beside(BARE, name))
    for one, other in (("stribeck_friction", "coulomb_friction"), ("coulomb_friction", "presliding_friction")):
        start = {e: {p.symbol: 0.5 for p in LIBRARY[e].parameters if p.default is None} for e in (one, other)}
        hypothesis = beside(BARE, one, other)
        data = model_data(BARE, list(start.items()))
        assert hypothesis.model(hypothesis.vector({}, start)) == parse_model(data)  # and a file may say the same


def test_what_replaces_a_number_that_it_does_not_read_leaves_nothing_of_it_to_be_fitted():
    assert "Fc" in beside(BOX, "stribeck_friction").free and "Fc" in beside(BOX, "presliding_friction").free
    assert "Fc" not in beside(BOX, "static_friction").free and "Fc" not in beside(BOX, "asymmetric_friction").free
    assert "b1" not in beside(BOX, "asymmetric_viscous_friction").free


def test_there_is_room_for_two_memories():
    remembering = {n for n, e in LIBRARY.items() if e.law is not None and e.law.remembers and not e.axis}
    assert len(remembering) >= 4
    full = beside(BOX, "viscoelastic_relaxation", "hysteresis")
    assert not admitted(full) & remembering and admitted(full) >= {"force_bias", "nonlinear_stiffness"}
    x = full.vector(
        {}, {"viscoelastic_relaxation": {"k_maxwell": 9.0, "tau": 0.1}, "hysteresis": {"alpha": 1.0, "beta": 9.0}}
    )
    assert len(full.model(x).additions.laws) == 2
    assert "normal_hysteresis" in admitted(full)  # the normal axis remembers for itself


@pytest.mark.parametrize("model", [BOX, BARE, DRIVEN, SPRING])
def test_every_pair_that_is_admitted_makes_a_model_that_a_file_can_hold(model):
    values = {
        name: {p.symbol: max(p.bounds[0], 0.5) for p in LIBRARY[name].parameters if p.default is None}
        for name in admitted(Hypothesis(model))
    }
    for one, other in permutations(values, 2):
        first = beside(model, one)
        if first.admits(LIBRARY[other]):
            hypothesis = first.adding(LIBRARY[other])
            pair = {name: values[name] for name in (one, other)}
            made = hypothesis.model(hypothesis.vector({}, pair))
            assert made == parse_model(model_data(model, list(pair.items()))), f"{one} + {other}"


def test_a_branch_beside_a_spring_is_sought_only_where_there_is_a_spring():
    beside = {"viscoelastic_relaxation", "hardening_relaxation", "stiffness_step"}
    assert not beside & admitted(Hypothesis(replace(DRIVEN, k=0.0)))
    assert beside <= admitted(Hypothesis(replace(DRIVEN, k=90.0)))


def test_what_is_not_admitted_cannot_be_added():
    with pytest.raises(BadInput, match="found stribeck_friction beside"):
        beside(BOX, "static_friction", "stribeck_friction")
