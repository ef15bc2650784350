"""The promises of every effect of the library, in every structure that has its block."""

import importlib
import math
import pickle

import numpy as np
import pytest
from responses import MODELS, PLACES, SOME, TIME, applied, respond
from scipy.optimize import least_squares

from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model import flexible_box
from mmt_drake.model.parameters import MAX_STEP

#: The contract's table: names in its order, blocks, and what must be said of each.
TABLE = """
viscous_friction friction b
asymmetric_viscous_friction friction b_plus b_minus
coulomb_friction friction Fc
asymmetric_friction friction Fc_plus Fc_minus
static_friction friction Fs Fd v_d
stribeck_friction friction Fs v_s
presliding_friction friction sigma0
load_dependent_friction friction mu
smooth_coulomb_friction friction Fc v_s
dahl_friction friction Fc sigma
elastoplastic_play friction Fc k gap
quadratic_drag friction c
nonlinear_stiffness contact k3
hunt_crossley_damping contact lambda
viscoelastic_relaxation contact k_maxwell tau
hardening_relaxation contact k3_maxwell tau
hysteresis contact alpha beta
contact_gap contact gap
stiffness_drift contact rate
stiffness_step contact time loss
power_law_stiffness contact k p
normal_nonlinear_stiffness contact k3
normal_hunt_crossley_damping contact lambda
normal_viscoelastic_relaxation contact k_maxwell tau
normal_hardening_relaxation contact k3_maxwell tau
normal_hysteresis contact alpha beta
normal_stiffness_drift contact rate
constant_force body F
ground_spring body k
mass_change body time dm
second_mode body m2 k b
end_stop body position stiffness
gravity_offset body angle
torque_ripple body amplitude period phase
force_bias force_sensor bias
force_drift force_sensor rate
force_lag force_sensor tau
force_crosstalk force_sensor gain
force_saturation force_sensor limit
periodic_disturbance force_sensor amplitude frequency phase
tip_mass force_sensor m_tip
time_delay channel delay
input_lag channel tau
probe_slip friction mu
surface_shape geometry x y height deviation
stiffness_map contact x y stiffness deviation
frame_misalignment geometry rx ry rz
tool_offset geometry x y z
gear_play drive gap
dead_band drive width
tabulated_force any of at value
"""

LEARNED = ("tabulated_force", "surface_shape", "stiffness_map")


def searched(name):
    """Parameters that a search fits: those without default."""
    return [p for p in LIBRARY[name].parameters if p.default is None]


def test_the_library_is_the_contracts_table():
    declared = [(e.name, e.block, *(p.symbol for p in searched(e.name))) for e in LIBRARY.values()]
    assert declared == [tuple(line.split()) for line in TABLE.split("\n") if line]
    assert set(SOME) == set(LIBRARY)


@pytest.mark.parametrize(("name", "structure"), PLACES)
def test_at_its_vanishing_value_it_changes_nothing(name, structure):
    model = MODELS[structure]
    if name == "presliding_friction":  # without bristles there is no friction at all
        model = model.with_value("Fc", 0.0)
    changed = applied(model, name, LIBRARY[name].vanished(model))
    np.testing.assert_allclose(respond(changed, to=name), respond(model, to=name), atol=1e-9)


@pytest.mark.parametrize(("name", "structure"), PLACES)
def test_it_changes_the_response_where_it_is_there(name, structure):
    nominal = respond(MODELS[structure], to=name)
    assert np.abs(respond(applied(MODELS[structure], name), to=name) - nominal).max() > 0.02 * nominal.std()


@pytest.mark.parametrize("name", [name for name, structure in PLACES if structure == "flexible_box"])
def test_a_body_under_a_tip_at_rest_moves_only_where_the_model_says_that_something_pushes_it(name):
    model = applied(MODELS["flexible_box"].with_value("Fc", 0.05), name)
    n = len(TIME)
    position, force, body = np.tile([0.02, -0.01, -0.004], (n, 1)), np.empty((n, 3)), np.empty((n, 4))
    flexible_box.replay(TIME, position, np.zeros((n, 3)), np.ones(n), model.kernel_vector(), force, body)
    moves = bool(np.abs(body).max() > 1e-9)
    assert not moves or model.pushed_at_rest
    assert moves or not model.pushed_at_rest or LIBRARY[name].law is None or name in LEARNED  # a curve may


def says_passive(name, structure):
    effect, model = LIBRARY[name], MODELS[structure]
    return effect.passive is not None and effect.passive.holds(model, effect.checked(SOME[name], model, "test"))


@pytest.mark.parametrize(("name", "structure"), [place for place in PLACES if says_passive(*place)])
def test_where_it_says_so_it_is_passive(name, structure):
    # The work put in never falls below zero: nothing here is a source of energy (and test_passivity_of_laws.py).
    _, power = respond(applied(MODELS[structure], name), rates=True, to=name)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * 1e-3)])
    assert work.min() > -1e-6 and work[-1] > 0.0


@pytest.mark.parametrize(("name", "structure"), PLACES)
def test_halving_the_integration_step_changes_next_to_nothing(name, structure):
    model = applied(MODELS[structure], name)
    step = min(model.kernel_vector()[MAX_STEP], 1e-3)
    coarse, fine = respond(model, to=name), respond(model, 0.5 * step, to=name)
    # Where a clearance closes the damper's force jumps, and a sample may fall on either side.
    assert np.sqrt(np.mean((coarse - fine) ** 2)) < 1e-4 * coarse.std()


@pytest.mark.parametrize("name", [name for name in LIBRARY if name not in LEARNED])
def test_its_parameters_are_found_again_in_its_own_response(name):
    structure = next(structure for n, structure in PLACES if n == name)
    symbols = [p.symbol for p in searched(name)]
    rest = {symbol: value for symbol, value in SOME[name].items() if symbol not in symbols}
    truth = np.array([SOME[name][symbol] for symbol in symbols])
    response = respond(applied(MODELS[structure], name), to=name)
    band = np.ones(21) / 21  # a fit compares in a band; the jumps of a clearance are no function to follow

    def error(parts):
        values = dict(zip(symbols, parts * truth, strict=True)) | rest
        difference = respond(applied(MODELS[structure], name, values), to=name) - response
        return np.convolve(difference, band, "valid") / response.std()

    # 20 % off; a moment and a frequency no worse than a grid of starts leaves them.
    off = np.array([0.03 if symbol in ("time", "frequency", "period") else 0.2 for symbol in symbols])
    start = 1.0 + off * np.where(np.arange(len(truth)) % 2, -1.0, 1.0)
    step = 0.02 if name == "contact_gap" else 1e-3
    found = least_squares(error, start, diff_step=step, xtol=1e-10, ftol=1e-12, bounds=(0.3, 3.0), max_nfev=60).x
    np.testing.assert_allclose(found, 1.0, rtol=2e-3)


@pytest.mark.parametrize("name", LIBRARY)
def test_missing_unknown_and_impossible_parameters_are_refused(name):
    model = MODELS["flexible_box"]
    first, low = LIBRARY[name].parameters[0].symbol, LIBRARY[name].parameters[0].bounds[0]
    wrong = [{}, {**SOME[name], "q": 1.0}]
    wrong += [
        {**SOME[name], first: value} for value in ("much", None, [1.0], True, float("nan"), float("inf"), 10**400)
    ]
    wrong += [{**SOME[name], first: low - 1.0}] if np.isfinite(low) else []
    for values in wrong:
        with pytest.raises(BadInput, match="test: "):
            LIBRARY[name].checked(values, model, "test")


@pytest.mark.parametrize(
    ("name", "values", "line"),
    [
        ("static_friction", {"Fs": 0.5, "Fd": 0.6, "v_d": 0.0}, "Fd: found 0.6, expected at most Fs = 0.5 N"),
        ("mass_change", {"time": 1.0, "dm": -0.8}, "dm: found -0.8, expected more than -0.8 kg"),
        ("hysteresis", {"alpha": 1.0, "beta": 2.0, "gamma": -2.1}, "gamma: found -2.1, expected at least -beta = -2"),
        ("end_stop", {"position": 0.0, "stiffness": 1.0, "side": 0.5}, "side: found 0.5, expected one of -1.0, 1.0"),
        ("tabulated_force", {"of": "mood", "at": [0, 1], "value": [0, 1]}, "of: found 'mood', expected one of sliding"),
        ("tabulated_force", {"of": "time", "at": [0, 1], "value": [0]}, "value: found 1 values, expected 2"),
        ("tabulated_force", {"of": "time", "at": [0, 0], "value": [0, 1]}, "at[1]: found 0.0, expected more than 0.0"),
        ("tabulated_force", {"of": "time", "at": [0], "value": [1]}, "at: found 1 values, expected two or more"),
        ("tabulated_force", {"of": "time", "at": [0, "x"], "value": [0, 1]}, "at[1]: found 'x', expected a number"),
        ("tabulated_force", {"of": "load", "at": [0, 1], "value": [0, -1]}, "value: found -1.0, expected levels"),
    ],
)
def test_what_does_not_go_together_is_refused(name, values, line):
    with pytest.raises(BadInput) as error:
        LIBRARY[name].checked(values, MODELS["flexible_box"], "test")
    assert line in str(error.value)


@pytest.mark.parametrize("name", LIBRARY)
def test_a_structure_without_its_block_refuses_it(name):
    for structure, model in MODELS.items():
        if (name, structure) not in PLACES:
            refused = (
                f"block {LIBRARY[name].block} in a {model.NAME}|{name} in a (model without|{model.NAME}, expected)"
            )
            with pytest.raises(BadInput, match=refused):
                LIBRARY[name].checked(SOME[name], model, "test")


@pytest.mark.parametrize("name", LIBRARY)
def test_it_is_documented(name):
    effect = LIBRARY[name]
    module = importlib.import_module(f"mmt_drake.effects.{name}")
    assert module.EFFECT is effect and len(module.__doc__.split()) >= 20
    assert effect.equation and effect.source and all(p.unit for p in effect.parameters)


@pytest.mark.parametrize(("name", "structure"), PLACES)
def test_a_model_with_it_travels_between_processes(name, structure):
    model = applied(MODELS[structure], name)
    assert pickle.loads(pickle.dumps(model)) == model


@pytest.mark.parametrize("name", [name for name in LIBRARY if name not in LEARNED])
def test_a_search_starts_within_its_bounds(name):
    from mmt_drake.effects import Scales

    scales = Scales(2.0, 0.1, 0.02, 0.01, 3.0, 0.8, 400.0, 4.0, 30.0, 1e-3)
    starts = LIBRARY[name].starts(scales)
    model = MODELS[next(structure for place, structure in PLACES if place == name)]
    assert starts
    for start in starts:
        assert {p.symbol for p in searched(name)} <= set(start)
        LIBRARY[name].checked(start, model, "test")


#: The contract's families of the laws that there are.
FAMILIES = """
dry_friction coulomb_friction asymmetric_friction static_friction stribeck_friction presliding_friction
dry_friction probe_slip load_dependent_friction smooth_coulomb_friction dahl_friction elastoplastic_play
viscous viscous_friction asymmetric_viscous_friction quadratic_drag
contact_stiffness nonlinear_stiffness contact_gap stiffness_drift power_law_stiffness stiffness_map
contact_stiffness stiffness_step
contact_stiffness normal_nonlinear_stiffness normal_stiffness_drift
contact_loss hunt_crossley_damping viscoelastic_relaxation hardening_relaxation hysteresis
contact_loss normal_hunt_crossley_damping normal_viscoelastic_relaxation normal_hardening_relaxation normal_hysteresis
body_force constant_force ground_spring end_stop gravity_offset torque_ripple
inertia mass_change second_mode
sensor force_bias force_drift force_crosstalk force_saturation periodic_disturbance tip_mass
timing time_delay input_lag force_lag
geometry surface_shape frame_misalignment tool_offset
drive_train gear_play dead_band
tabulated_force tabulated_force
"""


def test_families_are_the_contracts():
    lines = [line.split() for line in FAMILIES.split("\n") if line]
    assert {name: family for family, *names in lines for name in names} == {e.name: e.family for e in LIBRARY.values()}


@pytest.mark.parametrize(
    ("name", "intervals", "may"),
    [
        ("coulomb_friction", {"Fc": (0.0, 0.3)}, True),
        ("coulomb_friction", {"Fc": (0.1, 0.3)}, False),
        ("constant_force", {"F": (-0.1, 0.1)}, True),
        # Both levels at the model's, whichever that is.
        ("asymmetric_friction", {"Fc_plus": (0.2, 0.4), "Fc_minus": (0.3, 0.5)}, True),
        ("asymmetric_friction", {"Fc_plus": (0.2, 0.3), "Fc_minus": (0.4, 0.5)}, False),
        # The intervals overlap; that of the difference, as wide as hypot(0.1, 0.1), does not reach 0.
        ("asymmetric_friction", {"Fc_plus": (0.2, 0.4), "Fc_minus": (0.35, 0.55)}, False),
        # Beside the model's own level, which it reads.
        ("stribeck_friction", {"Fs": (0.3, 0.5), "v_s": (0.01, 0.02), "Fc": (0.2, 0.25)}, False),
        ("stribeck_friction", {"Fs": (0.3, 0.5), "v_s": (0.01, 0.02), "Fc": (0.2, 0.36)}, True),
        # Nothing is known of one of the two.
        ("stribeck_friction", {"Fs": (-math.inf, math.inf), "v_s": (0.01, 0.02), "Fc": (0.2, 0.36)}, True),
        # Frequency and phase say how it acts; only its amplitude how strongly.
        ("periodic_disturbance", {"amplitude": (0.0, 0.1), "frequency": (2.0, 2.1), "phase": (1.0, 2.0)}, True),
        ("periodic_disturbance", {"amplitude": (0.1, 0.2), "frequency": (0.0, 9.0), "phase": (-4.0, 4.0)}, False),
        ("second_mode", {"m2": (0.1, 0.2), "k": (0.0, 9.0), "b": (0.0, 1.0)}, False),
    ],
)
@pytest.mark.filterwarnings("error")
def test_an_interval_that_holds_the_vanishing_value_is_seen(name, intervals, may):
    assert LIBRARY[name].may_vanish(intervals) is may


TOUCHED = {"since_touch": (0.0, 5.0), "step": (2e-3, 2e-3)}


@pytest.mark.parametrize("name", [name for name in LIBRARY if "relaxation" in name])
def test_a_branch_that_relaxes_within_a_sample_is_a_damper(name):
    engages = LIBRARY[name].engages
    assert engages({"tau": 2.1e-3}, TOUCHED) and not engages({"tau": 1.9e-3}, TOUCHED)


@pytest.mark.parametrize(
    ("name", "symbol", "shows", "hidden"),
    [
        ("stribeck_friction", "v_s", 0.19, 0.21),  # its level hardly falls within the motion
        ("smooth_coulomb_friction", "v_s", 0.049, 0.051),  # it never reaches its level: a damper
        ("periodic_disturbance", "frequency", 0.1, 0.099),  # it does not repeat within the record
        ("viscoelastic_relaxation", "tau", 49.0, 51.0),  # it does not relax while it is touched: a spring
    ],
)
def test_what_is_too_slow_for_the_recording_does_not_happen_in_it(name, symbol, shows, hidden):
    ranges = {"sliding_velocity": (-0.1, 0.05), "time": (0.0, 20.0), **TOUCHED, "m": (1.0, 1.0)}
    engages = LIBRARY[name].engages
    assert engages({"Fc": 1.0, symbol: shows}, ranges) and not engages({"Fc": 1.0, symbol: hidden}, ranges)


@pytest.mark.parametrize(("name", "signal"), [("mass_change", "time"), ("stiffness_step", "time_in_contact")])
def test_what_happens_once_does_not_as_soon_as_anything_shows(name, signal):
    engages = LIBRARY[name].engages
    shown = {"time": (0.0, 30.0), "time_in_contact": (1.0, 21.0), signal: (1.0, 21.0)}
    assert [engages({"time": time}, shown) for time in (1.1, 1.3, 20.7, 20.9)] == [False, True, True, False]


def test_smooth_friction_that_sets_in_at_once_is_coulomb_friction():
    smooth, moving = LIBRARY["smooth_coulomb_friction"], {"sliding_velocity": (-0.2, 0.2)}
    for m, at_once, gradually in ((1.0, 0.002, 0.003), (0.0, 1.9e-4, 2.1e-4)):  # of 1 N and 1 kg the steepest: 2.5 mm/s
        ranges = {**moving, "m": (m, m)}
        assert not smooth.engages({"Fc": 1.0, "v_s": at_once}, ranges)
        assert smooth.engages({"Fc": 1.0, "v_s": gradually}, ranges)
    assert LIBRARY["coulomb_friction"].is_simpler_than(smooth)


YIELDING = {
    "dahl_friction": {"Fc": 1.0, "sigma": 100.0},
    "elastoplastic_play": {"Fc": 1.0, "k": 100.0, "gap": 0.01},
    "hysteresis": {"alpha": 100.0, "beta": 50.0},
}


@pytest.mark.parametrize("name", [*YIELDING, "asymmetric_friction"])
def test_what_shows_only_where_motion_turns_does_not_happen_in_a_fall_that_begins_a_little_upwards(name):
    values, wide = (
        YIELDING.get(name, {"Fc_plus": 1.0, "Fc_minus": 1.0}),
        {"position": (0.0, 0.1), "deflection": (0.0, 0.1)},
    )
    for velocity, turns in (((-1.0, 0.06), True), ((-0.06, 1.0), True), ((-8.0, 0.3), False)):
        assert LIBRARY[name].engages(values, {"sliding_velocity": velocity, **wide}) is turns


@pytest.mark.parametrize(
    ("name", "spring"),
    [
        ("dahl_friction", {"Fc": 101.0, "sigma": 100.0}),  # a way of a tenth of Fc/sigma: it hardly yields
        ("elastoplastic_play", {"Fc": 9.6, "k": 100.0, "gap": 0.01}),  # 0.096 m of spring and half of the play
        ("hysteresis", {"alpha": 100.0, "beta": 0.49}),
    ],
)
def test_bristles_that_do_not_yield_within_the_recording_are_a_ground_spring(name, spring):
    ranges = {"sliding_velocity": (-1.0, 1.0), "position": (0.0, 0.1), "deflection": (-0.1, 0.05)}
    assert LIBRARY[name].engages(YIELDING[name], ranges) and not LIBRARY[name].engages(spring, ranges)
    assert LIBRARY["ground_spring"].is_simpler_than(LIBRARY[name])


@pytest.mark.parametrize(
    ("name", "at_once"),
    [("dahl_friction", {"Fc": 1.0, "sigma": 1.1e5}), ("elastoplastic_play", {"Fc": 1.0, "k": 1.1e5, "gap": 0.0})],
)
def test_bristles_that_yield_within_a_ten_thousandth_of_the_way_are_coulomb_friction(name, at_once):
    ranges = {"sliding_velocity": (-1.0, 1.0), "position": (0.0, 0.1)}
    later = {symbol: 0.9e5 if symbol in ("sigma", "k") else value for symbol, value in at_once.items()}
    assert LIBRARY[name].engages(later, ranges) and not LIBRARY[name].engages(at_once, ranges)
    assert LIBRARY["coulomb_friction"].is_simpler_than(LIBRARY[name])


def test_hysteresis_of_a_driven_body_is_dry_friction_and_of_a_contact_a_loss_there():
    found = [LIBRARY["hysteresis"].within(MODELS[name]) for name in ("flexible_box", "driven_body")]
    assert [(e.family, e.block) for e in found] == [("contact_loss", "contact"), ("dry_friction", "friction")]
    assert LIBRARY["hysteresis"].law is found[1].law


def test_asymmetric_friction_has_a_level_either_way() -> None:
    asymmetric, ranges = LIBRARY["asymmetric_friction"], {"sliding_velocity": (-0.1, 0.1)}
    assert asymmetric.engages({"Fc_plus": 0.01, "Fc_minus": 1.0}, ranges)
    assert not asymmetric.engages({"Fc_plus": 0.0, "Fc_minus": 1.0}, ranges)
