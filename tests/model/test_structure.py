"""What every structure says of itself: its common symbols, its units, and what a file may not say of it."""

import pytest

from mmt_drake.errors import BadInput
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.laws import load_file
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.model.structure import Units
from mmt_drake.model_files import parse_model


@pytest.mark.parametrize(
    ("model", "values"),
    [
        (KelvinVoigt(k=3.0, b=2.0), {"k": 3.0, "k2": 3.0, "b": 2.0, "b2": 2.0}),
        (FlexibleBoxModel(BoxParameters(1, 2, 3, 4, 5, 6)), {"m": 1, "k": 2, "k2": 3, "b": 4, "b2": 5, "Fc": 6}),
        (DrivenBodyModel(m=1, b=2, k=3, Fc=4, gain=5), {"m": 1, "b": 2, "b2": 2, "k": 3, "k2": 3, "Fc": 4, "gain": 5}),
    ],
)
def test_a_symbol_that_a_structure_does_not_have_acts_as_nothing(model, values):
    nothing = {"m": 0, "Fc": 0, "b": 0, "k": 0, "k2": 0, "b2": 0, "g": 0, "gain": 1, "pendulum": 0}
    assert {symbol: model.value(symbol) for symbol in nothing} == nothing | values


@pytest.mark.parametrize("name", [3, None, "", "m/s", "m2", " N", ["m"]])
def test_what_is_no_name_of_a_unit_is_refused(name):
    assert Units("rad", "N m").of("N s/m") == "N m s/rad"
    for at in ("position", "force"):
        with pytest.raises(BadInput, match=f"units: {at}: .*letters"):
            Units(**{at: name})


@pytest.mark.parametrize("key", ["additions", "handed", "units", "window_s", "initial"])
def test_what_is_no_number_of_the_structure_is_no_parameter_of_a_model_file(key):
    with pytest.raises(BadInput, match=f"parameters: found the key '{key}'"):
        parse_model({"structure": "kelvin_voigt", "parameters": {"k": 3.0, key: None}})


def test_laws_are_not_read_from_what_is_no_python_file(tmp_path):
    with pytest.raises(ImportError, match="is no Python file"):
        load_file("laws_in_a_text", str(tmp_path / "laws.txt"))
