"""Model files: what is read, and what is refused with one clear line."""

import numpy as np
import pytest

from mmt_drake.errors import BadInput
from mmt_drake.model.driven_model import DrivenBodyModel, Gravity
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import Additions, Friction
from mmt_drake.model.transmission import TransmissionModel
from mmt_drake.model_files import load_model, model_data, parse_model, save_model

BOX = "structure: flexible_box\nparameters: {m: 1.0, k1: 0.0, k2: 500.0, b1: 60.0, b2: 60.0, Fc: 0.05}\n"
DRIVEN = "structure: driven_body\n"
GEARS = "structure: transmission\n"


def read(tmp_path, text):
    path = tmp_path / "model.yaml"
    path.write_text(text)
    return load_model(path)


def test_the_contracts_example_is_read(tmp_path):
    effect = "effects:\n  - {name: static_friction, parameters: {Fs: 0.1, Fd: 0.05, v_d: 0.005}}\n"
    assert read(tmp_path, BOX + "normal: {k: 400.0, b: 50.0}\n" + effect) == FlexibleBoxModel(
        BoxParameters(m=1, k1=0, k2=500, b1=60, b2=60, Fc=0),  # which static friction takes the place of
        NormalContact(400, 50),
        additions=Additions(friction=Friction(0.1, 0.05, 0.005)),
        in_plane=None,
    )


def test_what_a_nominal_model_leaves_out_is_zero(tmp_path):
    model = read(tmp_path, "structure: flexible_box\nparameters: {m: 1, k2: 2}\n")
    assert model.parameters == BoxParameters(m=1, k1=0, k2=2, b1=0, b2=0, Fc=0)
    assert model.normal == NormalContact(k=0, b=0)


@pytest.mark.parametrize("friction", ["vector", "per_axis", None])
def test_whether_friction_is_a_vector_is_read_and_written(tmp_path, friction):
    model = read(tmp_path, BOX + ("" if friction is None else f"friction: {friction}\n"))
    assert model.in_plane == friction
    assert model_data(model).get("friction") == friction


@pytest.mark.parametrize(
    ("effect", "expected"),
    [
        ("coulomb_friction, parameters: {Fc: 0.4}", {"Fc": 0.45}),
        ("viscous_friction, parameters: {b: 3}", {"b1": 63.0}),
        ("ground_spring, parameters: {k: 7}", {"k1": 7.0}),
    ],
)
def test_an_effect_adds_to_the_structural_parameter_it_stands_for(tmp_path, effect, expected):
    model = read(tmp_path, BOX + f"effects: [{{name: {effect}}}]")
    assert {key: getattr(model.parameters, key) for key in expected} == pytest.approx(expected)


def test_kelvin_voigt_is_read(tmp_path):
    model = read(tmp_path, "structure: kelvin_voigt\nparameters: {k: 300, b: 20, x0: 0.01, F0: 0.5}\n")
    assert model == KelvinVoigt(300, 20, 0.01, 0.5)


@pytest.mark.parametrize(
    ("position", "force", "unit", "expected"),
    [
        ("rad", "N m", "N s/m", "N m s/rad"),
        ("rad", "N m", "kg", "N m s^2/rad"),
        ("rad", "A", "N/m^3", "A/rad^3"),
        ("rad", "A", "N m", "A"),  # a pendulum's moment
        ("rad", "A", "Hz", "Hz"),
        ("rad", "A", "m^-n", "rad^-n"),
        ("m", "N", "kg", "kg"),
    ],
)
def test_units_of_a_model_file_take_the_place_of_metre_and_newton(position, force, unit, expected):
    units = {"position": position, "force": force}
    model = parse_model({"structure": "driven_body", "parameters": {"m": 1.0}, "units": units})
    assert model.unit(unit) == expected
    assert model_data(model)["units"] == units


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (BOX + "friction: round", "friction: found 'round', expected vector or per_axis"),
        (BOX + "units: {position: 3}", "units.position: found 3"),
        (BOX + "units: {position: m/s}", "units.position: found 'm/s', expected letters, as in rad, A or N m"),
        (BOX + "units: {torque: A}", "units: found the key 'torque', expected position, force"),
        ("", "the model: found NoneType"),
        ("structure: box", "structure: found 'box'"),
        (BOX + "normla: {k: 1}", "did you mean 'normal'?"),
        (BOX.replace("m: 1.0", "m: -1.0"), "parameters.m: found -1.0, expected a finite number > 0"),
        (BOX.replace("m: 1.0", "m: 1e-320"), "parameters.m: found 9.99989e-321 on springs of 500 and dampers of 120"),
        (BOX.replace("k2: 500.0", "k2: 1e300"), "parameters.m: found 1 on springs of 1e+300"),
        ("structure: driven_body\nparameters: {m: 1e-9, b: 1}", "parameters.m: found 1e-09 on springs of 0"),
        (
            BOX + "effects: [{name: mass_change, parameters: {time: 1, dm: -0.9999999999}}]",
            "expected a heavier body, or a softer hold: steps of 1e-06 s cannot follow it",
        ),
        (BOX.replace("m: 1.0", "m: heavy"), "parameters.m: found 'heavy'"),
        (BOX.replace("m: 1.0", "m: .nan"), "parameters.m: found nan"),
        (BOX.replace("k2", "k3"), "expected m and k2"),
        (BOX.replace("k1", "k3"), "parameters: found the key 'k3'"),
        (BOX + "effects: [{name: stiction}]", "effects[0].name: found 'stiction'"),
        (BOX + "effects: [{name: static_friction, parameters: {Fs: 1}}]", "static_friction.parameters"),
        (BOX + "effects: [{name: coulomb_friction, parameters: {Fc: -1}}]", "coulomb_friction.Fc: found -1"),
        (BOX + "effects: {}\neffects: []", "twice"),
        (
            BOX + "effects: [{name: static_friction, parameters: {Fs: 1, Fd: 1, v_d: 0}}, "
            "{name: coulomb_friction, parameters: {Fc: 1}}]",
            "effects[1]: found coulomb_friction beside static_friction, expected one for Fc",
        ),
        ("structure: [", "line"),
        ("structure: [a]", "structure: found ['a']"),
        ("structure: kelvin_voigt\neffects: 5", "effects: found int, expected a list"),
        (BOX + "effects: [{name: [x]}]", "effects[0].name: found ['x']"),
        (BOX + "effects: !list {}", "effects: found dict, expected a list"),
        (BOX + "effects: [{name: coulomb_friction, parameters: [1]}]", "effects[0].parameters: found list"),
        (BOX + "effects: [{name: mass_change, parameters: {time: 1, dm: -2}}]", "mass_change.dm: found -2"),
        (
            BOX + "effects: [{name: viscous_friction, parameters: {b: 1}}, "
            "{name: asymmetric_viscous_friction, parameters: {b_plus: 1, b_minus: 2}}]",
            "effects[1]: found asymmetric_viscous_friction beside viscous_friction, expected one for b",
        ),
        (
            BOX + "effects: [{name: contact_gap, parameters: {gap: 1}}, {name: contact_gap, parameters: {gap: 2}}]",
            "effects[1]: found contact_gap beside contact_gap, expected one for contact_gap",
        ),
        (
            BOX + "effects: [{name: second_mode, parameters: {m2: 1, k: 1, b: 1}}, "
            "{name: hysteresis, parameters: {alpha: 1, beta: 1}}, "
            "{name: viscoelastic_relaxation, parameters: {k_maxwell: 1, tau: 1}}]",
            "viscoelastic_relaxation: found 3 effects with a memory of their own on one body, expected 2 at most",
        ),
        (
            "structure: kelvin_voigt\neffects: [{name: constant_force, parameters: {F: 1}}]",
            "constant_force: found an effect of the block body in a kelvin_voigt, expected one of friction, contact",
        ),
        (
            "structure: driven_body\nparameters: {m: 1}\neffects: [{name: force_bias, parameters: {bias: 1}}]",
            "force_bias: found an effect of the block force_sensor in a driven_body",
        ),
        (DRIVEN + "parameters: {b: 1}", "expected m at least"),
        (DRIVEN + "parameters: {m: 1, k2: 3}", "found the key 'k2'"),
        (DRIVEN + "parameters: {m: 1}\ngravity: {kind: sideways, value: 1}", "gravity.kind: found 'sideways'"),
        (DRIVEN + "parameters: {m: 1}\ngravity: {kind: constant}", "gravity: found ['kind']"),
        (DRIVEN + "parameters: {m: 1}\nnormal: {k: 3}", "found the key 'normal'"),
        (GEARS + "parameters: {k: 3}", "parameters: found ['k'], expected ratio at least"),
        (GEARS + "parameters: {ratio: 0}", "parameters.ratio: found 0, expected a number other than 0"),
        (GEARS + "parameters: {ratio: 1, k: 0}", "parameters.k: found 0"),
        (GEARS + "parameters: {ratio: 1, gain: 2}", "parameters: found the key 'gain'"),
        (GEARS + "parameters: {ratio: 1}\ngravity: {kind: constant, value: 9.81}", "found the key 'gravity'"),
        (GEARS + "parameters: {ratio: 1, m: 1e-13}", "parameters.m: found 1e-13 on springs of 1 and dampers of 0"),
        (
            GEARS + "parameters: {ratio: 1}\neffects: [{name: gear_play, parameters: {gap: -1}}]",
            "gear_play.gap: found -1",
        ),
        (
            GEARS + "parameters: {ratio: 1}\neffects: [{name: contact_gap, parameters: {gap: 1}}]",
            "contact_gap: found an effect of the block contact in a transmission",
        ),
        (
            GEARS + "parameters: {ratio: 1}\neffects: [{name: ground_spring, parameters: {k: 1}}]",
            "ground_spring: found ground_spring in a model without k",
        ),
        (
            GEARS + "parameters: {ratio: 1}\neffects: [{name: stribeck_friction, parameters: {Fs: 1, v_s: 1}}]",
            "stribeck_friction: found stribeck_friction in a model without m, expected m not 0",
        ),
        (
            DRIVEN + "parameters: {m: 1}\neffects: [{name: gear_play, parameters: {gap: 1}}]",
            "gear_play: found gear_play in a model without ratio, expected ratio not 0",
        ),
    ],
)
def test_a_broken_file_is_refused_in_one_line_that_names_file_and_key(tmp_path, text, line):
    with pytest.raises(BadInput) as error:
        read(tmp_path, text)
    message = str(error.value)
    assert message.startswith(str(tmp_path / "model.yaml")) and line in message and "\n" not in message


def test_a_missing_file_is_refused():
    with pytest.raises(BadInput, match="no such file"):
        load_model("nowhere.yaml")


def test_a_driven_body_is_read_with_its_gravity(tmp_path):
    text = "structure: driven_body\nparameters: {m: 95, b: 200, Fc: 20, offset: -3, gain: 35}\n"
    assert read(tmp_path, text) == DrivenBodyModel(m=95, b=200, Fc=20, offset=-3, gain=35)
    text += "gravity: {kind: pendulum, value: 0.3}\n"
    assert read(tmp_path, text).gravity == Gravity("pendulum", 0.3)


LEVEL = "{name: coulomb_friction, parameters: {Fc: 0.4}}"
STRIBECK = "{name: stribeck_friction, parameters: {Fs: 0.9, v_s: 0.02}}"
BRISTLES = "{name: presliding_friction, parameters: {sigma0: 500}}"


@pytest.mark.parametrize("order", [(LEVEL, STRIBECK), (STRIBECK, LEVEL)])
def test_what_adds_to_a_level_comes_before_what_builds_on_it_whatever_the_order(tmp_path, order):
    model = read(tmp_path, BOX + f"effects: [{', '.join(order)}]")
    assert model.parameters.Fc == 0.0
    assert model.additions.laws[0].values == pytest.approx((0.9, 0.02, 0.45))


def test_a_default_that_is_the_models_level_builds_on_it_too(tmp_path):
    model = read(tmp_path, BOX + f"effects: [{BRISTLES}, {LEVEL}]")
    assert model.additions.laws[0].values == pytest.approx((500, 0, 0.45, 1e-3, 0.45))


@pytest.mark.parametrize(
    "text",
    [
        BOX + "normal: {k: 400.0, b: 50.0}\n",
        "structure: driven_body\nparameters: {m: 95, b: 200, Fc: 20, offset: -3, gain: 35}\n"
        "gravity: {kind: pendulum, value: 0.3}\n",
        "structure: kelvin_voigt\nparameters: {k: 300, b: 20, x0: 0.01, F0: 0.5}\n",
    ],
)
def test_what_is_saved_reads_back_to_the_last_bit(tmp_path, text):
    nominal = read(tmp_path, text)
    third = np.float64(1) / 3
    table = {"of": "sliding_velocity", "at": np.array([-third, 1e-7, 3.0]), "value": np.array([-1e-9, 0.1 + 0.2, 1e4])}
    effects = [("nonlinear_stiffness", {"k3": 1e5 * third}), ("tabulated_force", table)]
    data = model_data(nominal, effects)
    save_model(tmp_path / "saved.yaml", data)
    saved = load_model(tmp_path / "saved.yaml")
    assert saved == parse_model(data) and parse_model(model_data(nominal)) == nominal
    cubic, curve = saved.additions.laws
    assert cubic.values[0] == 1e5 * (1 / 3)
    assert curve.curve == ((-1 / 3, -1e-9), (1e-7, 0.1 + 0.2), (3.0, 1e4))


def test_a_mapping_that_is_no_model_is_not_saved(tmp_path):
    with pytest.raises(BadInput, match="structure"):
        save_model(tmp_path / "saved.yaml", {"structure": "box"})
    assert list(tmp_path.iterdir()) == []


def test_a_model_that_has_effects_in_it_is_no_nominal_one(tmp_path):
    with pytest.raises(BadInput, match="a nominal model, without effects"):
        model_data(read(tmp_path, BOX + f"effects: [{STRIBECK}]"))


def test_a_transmission_is_read_and_saved_with_play(tmp_path):
    text = GEARS + "parameters: {ratio: -0.5, offset: 0.1, m: 0.2, k: 300, b: 2, c: 1, Fc: 0.3, load: 1}\n"
    nominal = read(tmp_path, text + "units: {position: rad, force: N m}\ninitial: fitted\n")
    assert nominal == TransmissionModel(ratio=-0.5, offset=0.1, m=0.2, k=300, b=2, c=1, Fc=0.3, load=1)
    assert nominal.unit("N s/m") == "N m s/rad" and nominal.initial == "fitted"
    effects = [("gear_play", {"gap": 0.01}), ("dead_band", {"width": 0.02})]
    save_model(tmp_path / "saved.yaml", model_data(nominal, effects))
    saved = load_model(tmp_path / "saved.yaml")
    assert (saved.additions.gap, saved.additions.dead_band) == (0.01, 0.02)
    assert saved.handed.bare == nominal and saved.initial == "fitted"
