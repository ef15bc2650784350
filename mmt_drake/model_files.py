"""Model files: what a simulation believes in, read from YAML."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import BoxParameters, DrivenBodyModel, FlexibleBoxModel, Gravity, NormalContact
from mmt_drake.typed_yaml import fill, known_keys, parse, read_text

Model = FlexibleBoxModel | KelvinVoigt | DrivenBodyModel

#: Keys beside structure, parameters and effects, by structure.
_STRUCTURES = {"flexible_box": ("normal",), "kelvin_voigt": (), "driven_body": ("gravity",)}


def load_model(path: str | Path) -> Model:
    """Read a model file.

    Raises:
        BadInput: no such file, no YAML, an unknown key, structure or effect, a value of the wrong kind or range.
    """
    source = str(path)
    return parse_model(parse(read_text(path, "a model file (YAML)"), source), source)


def parse_model(data: object, source: str = "model") -> Model:
    """The model that a mapping describes (contract of model files).

    Raises:
        BadInput: as `load_model`.
    """
    data = _mapping(data, source, "the model")
    structure = data.get("structure")
    if not isinstance(structure, str) or structure not in _STRUCTURES:
        raise BadInput(source, at="structure", found=repr(structure), expected=" or ".join(_STRUCTURES))
    known_keys(data, ("structure", "parameters", "effects", *_STRUCTURES[structure]), source, "")
    parameters = _mapping(data.get("parameters", {}), source, "parameters")
    effects = data.get("effects") or []
    if not isinstance(effects, list):
        raise BadInput(source, at="effects", found=type(effects).__name__, expected="a list of name and parameters")
    if structure != "flexible_box":
        if effects:
            raise BadInput(
                source, at="effects", found=f"{len(effects)} effects", expected=f"none in a {structure} model"
            )
        if structure == "kelvin_voigt":
            return fill(KelvinVoigt, parameters, source, "parameters")
        return _driven_body(data, parameters, source)
    if "m" not in parameters or "k2" not in parameters:
        raise BadInput(source, at="parameters", found=sorted(parameters), expected="m and k2 at least")
    # What is absent is 0; the defaults of the classes are set-up 1's.
    normal = _mapping(data.get("normal") or {}, source, "normal")
    model = FlexibleBoxModel(
        parameters=fill(BoxParameters, {"k1": 0, "b1": 0, "b2": 0, "Fc": 0, **parameters}, source, "parameters"),
        normal=fill(NormalContact, {"k": 0, "b": 0, **normal}, source, "normal"),
    )
    taken: dict[str, str] = {}
    for i, entry in enumerate(effects):
        entry = _mapping(entry, source, f"effects[{i}]")
        known_keys(entry, ("name", "parameters"), source, f"effects[{i}]")
        name = entry.get("name")
        if not isinstance(name, str) or name not in LIBRARY:
            raise BadInput(source, at=f"effects[{i}].name", found=repr(name), expected=f"one of {', '.join(LIBRARY)}")
        effect = LIBRARY[name]
        place = effect.replaces or effect.adds_to or name
        if place in taken:
            raise BadInput(
                source, at=f"effects[{i}]", found=f"{name} beside {taken[place]}", expected=f"one for {place}"
            )
        taken[place] = name
        values = _mapping(entry.get("parameters", {}), source, f"effects[{i}].parameters")
        try:
            model = effect.apply(model, effect.checked(values, source))
        except BadInput as error:
            raise BadInput(source, at=f"{name}.{error.at}", found=error.found, expected=error.expected) from None
    return model


def _driven_body(data: Mapping[str, Any], parameters: Mapping[str, Any], source: str) -> DrivenBodyModel:
    known_keys(parameters, ("m", "b", "k", "Fc", "offset", "gain"), source, "parameters")
    if "m" not in parameters:
        raise BadInput(source, at="parameters", found=sorted(parameters), expected="m at least")
    body = fill(DrivenBodyModel, parameters, source, "parameters")
    if data.get("gravity") is None:
        return body
    gravity = _mapping(data["gravity"], source, "gravity")
    if set(gravity) != {"kind", "value"}:
        raise BadInput(source, at="gravity", found=sorted(gravity), expected="kind and value")
    return replace(body, gravity=fill(Gravity, gravity, source, "gravity"))


def _mapping(data: object, source: str, at: str) -> Mapping[str, Any]:
    if not isinstance(data, dict) or not all(isinstance(key, str) for key in data):
        raise BadInput(source, at=at, found=type(data).__name__, expected="a mapping of names to values")
    return data
