"""Model files: what a simulation believes in, read from YAML and written to it."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, TypeVar, get_args

import yaml

from mmt_drake.effects import LIBRARY, SOURCES, Effect
from mmt_drake.errors import BadInput, check_kind, located, suggest
from mmt_drake.model.controller import Controller, ControllerKind
from mmt_drake.model.driven_model import DrivenBodyModel, Gravity
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, InPlane, NormalContact
from mmt_drake.model.structure import Additions, Handed, Initial, PositionOut, Structure, Units
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.model.transmission import TransmissionModel
from mmt_drake.over import parsed, written
from mmt_drake.plain import plain
from mmt_drake.quantities import quantities
from mmt_drake.recording.atomic import replacing
from mmt_drake.typed_yaml import fill, known_keys, mapping, parse, read_text

Model = FlexibleBoxModel | KelvinVoigt | SurfaceContact | DrivenBodyModel | TransmissionModel
Modelled = TypeVar("Modelled", bound=Structure)
Moved = TypeVar("Moved", bound=PositionOut)

#: Keys beside structure, parameters and effects, by structure.
_STRUCTURES = {
    "flexible_box": ("normal", "friction"),
    "kelvin_voigt": (),
    "surface_contact": (),
    "driven_body": ("gravity", "controller", "window_s", "initial"),
    "transmission": ("window_s", "initial"),
}


def check_model(source: str, model: Model) -> None:
    """Refuse what is no model, as the name of its file.

    Raises:
        BadInput: it is none.
    """
    check_kind(source, "model", model, Structure, "a model: mmt_drake.load_model(path) reads one")


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
    data = mapping(data, source, "the model")
    structure = data.get("structure")
    if not isinstance(structure, str) or structure not in _STRUCTURES:
        raise BadInput(source, at="structure", found=repr(structure), expected=" or ".join(_STRUCTURES))
    known_keys(data, ("structure", "parameters", "units", "over", "effects", *_STRUCTURES[structure]), source, "")
    parameters = mapping(data.get("parameters", {}), source, "parameters")
    model: Model
    if structure == "flexible_box":
        model = _flexible_box(data, parameters, source)
    elif structure == "driven_body":
        model = _driven_body(data, parameters, source)
    elif structure == "transmission":
        model = _begun(_needing(TransmissionModel, "ratio", parameters, source), data, source)
    elif structure == "surface_contact":
        model = fill(SurfaceContact, parameters, source, "parameters")
    else:
        model = fill(KelvinVoigt, parameters, source, "parameters")
    if data.get("units") is not None:
        model = replace(model, units=fill(Units, mapping(data["units"], source, "units"), source, "units"))
    if data.get("over") is not None:
        curves = parsed(mapping(data["over"], source, "over"), model, source)
        try:
            model = replace(model, over=curves).with_numbers({})
        except BadInput as error:
            found = f"values with a mean of {error.found}"
            raise BadInput(source, at=f"over.{error.at}", found=found, expected=error.expected) from None
    model = with_effects(model, data.get("effects"), source)
    try:
        model.kernel_vector()
    except BadInput as error:
        if error.at is not None:
            raise BadInput(source, at=f"parameters.{error.at}", found=error.found, expected=error.expected) from None
        counts = ", with the integral of its controller" * model.memories
        raise BadInput(source, at="effects", found=f"{error.found}{counts}", expected=error.expected) from None
    return model


def with_effects(model: Modelled, entries: object, source: str) -> Modelled:
    """A model with the effects that a list of names and parameters, as in a model file, describes; null is none.

    Raises:
        BadInput: an unknown effect, parameters that it does not have or allow, effects that exclude each other, or one
            that has no place in this structure.
    """
    entries = entries or []
    if not isinstance(entries, list):
        raise BadInput(source, at="effects", found=type(entries).__name__, expected="a list of name and parameters")
    named = [_named(entry, i, source) for i, entry in enumerate(entries)]
    for i, (effect, _) in enumerate(named):
        for other, _ in named[:i]:
            if other.target == effect.target and not _go_together(other, effect):
                found = f"{effect.name} beside {other.name}"
                raise BadInput(source, at=f"effects[{i}]", found=found, expected=f"one for {effect.target}")
    bare, applied = model, []
    # What adds to a number of the structure comes before what builds on it or replaces it.
    for effect, values in sorted(named, key=lambda entry: entry[0].adds_to is None):
        with located(source, effect.name):
            checked = effect.checked(values, model, source)
            model = effect.apply(model, checked)
        applied.append((effect.name, checked))
    if not applied:
        return model
    before = (bare, ()) if bare.handed is None else (bare.handed.bare, bare.handed.effects)
    return replace(model, handed=Handed(before[0], (*before[1], *applied)))


def compared(model: Model, window_s: float | None, initial: Initial) -> Model:
    """The model held against recordings over windows of a length [s], None: whole ones; and how it begins these."""
    handed = model.handed
    if handed is not None:
        handed = replace(handed, bare=replace(handed.bare, window_s=window_s, initial=initial))
    return replace(model, window_s=window_s, initial=initial, handed=handed)


def model_data(model: Model, effects: Sequence[tuple[str, Mapping[str, Any]]] = ()) -> dict[str, Any]:
    """The mapping that describes a nominal model with effects: what `parse_model` reads.

    Args:
        model: without additions; what effects add is said by `effects`.
        effects: name and parameters of each.

    Raises:
        BadInput: the model has additions, or friction that its parameters do not tell.
    """
    along_normal = isinstance(model, FlexibleBoxModel) and model.along_normal != Additions()
    if model.additions != Additions() or along_normal:
        raise BadInput("model", found="a model with effects in it", expected="a nominal model, without effects")
    data: dict[str, Any] = {"structure": model.NAME}
    if isinstance(model, FlexibleBoxModel):
        if model.friction is not None:
            expected = "Coulomb friction of level Fc, and others as effects"
            raise BadInput("model", at="friction", found=model.friction, expected=expected)
        data |= {"parameters": asdict(model.parameters), "normal": asdict(model.normal)}
        if model.in_plane is not None:
            data["friction"] = model.in_plane
    else:
        data["parameters"] = {name: getattr(model, name) for name in quantities(type(model))}
    if isinstance(model, DrivenBodyModel) and model.gravity is not None:
        data["gravity"] = asdict(model.gravity)
    if isinstance(model, DrivenBodyModel) and model.controller is not None:
        data["controller"] = controller_data(model.controller)
    if model.units is not None:
        data["units"] = asdict(model.units)
    if model.window_s is not None:
        data["window_s"] = model.window_s
    if model.initial != "rest":
        data["initial"] = model.initial
    if model.over:
        data["over"] = {curve.number: written(curve) for curve in model.over}
    if effects:
        data["effects"] = [{"name": name, **_origin(name), "parameters": dict(values)} for name, values in effects]
    in_words: dict[str, Any] = plain(data)
    return in_words


def save_model(path: str | Path, data: Mapping[str, Any], comment: str = "") -> None:
    """Write a model file that reads back to the same numbers, whole or not at all.

    Args:
        path: the file, replaced if it is there.
        data: as `model_data` gives it, or anything else that `parse_model` reads.
        comment: lines above it.

    Raises:
        BadInput: the mapping describes no model, or the file cannot be written.
    """
    data = plain(data)
    parse_model(data, str(path))
    text = "".join(f"# {line}".rstrip() + "\n" for line in comment.splitlines())
    text += yaml.safe_dump(data, default_flow_style=None, sort_keys=False, allow_unicode=True, width=120)
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _flexible_box(data: Mapping[str, Any], parameters: Mapping[str, Any], source: str) -> FlexibleBoxModel:
    if "m" not in parameters or "k2" not in parameters:
        raise BadInput(source, at="parameters", found=sorted(parameters), expected="m and k2 at least")
    # What is absent is 0; the defaults of the classes are set-up 1's.
    normal = mapping(data.get("normal") or {}, source, "normal")
    in_plane = data.get("friction")
    if in_plane not in (None, *get_args(InPlane)):
        raise BadInput(source, at="friction", found=repr(in_plane), expected=" or ".join(get_args(InPlane)))
    return FlexibleBoxModel(
        in_plane=in_plane,
        parameters=fill(BoxParameters, {"k1": 0, "b1": 0, "b2": 0, "Fc": 0, **parameters}, source, "parameters"),
        normal=fill(NormalContact, {"k": 0, "b": 0, **normal}, source, "normal"),
    )


def _driven_body(data: Mapping[str, Any], parameters: Mapping[str, Any], source: str) -> DrivenBodyModel:
    body = _begun(_needing(DrivenBodyModel, "m", parameters, source), data, source)
    if data.get("controller") is not None:
        body = _controlled(body, mapping(data["controller"], source, "controller"), source)
    if data.get("gravity") is None:
        return body
    gravity = mapping(data["gravity"], source, "gravity")
    if set(gravity) != {"kind", "value"}:
        raise BadInput(source, at="gravity", found=sorted(gravity), expected="kind and value")
    return replace(body, gravity=fill(Gravity, gravity, source, "gravity"))


def _needing(owner: type[Moved], symbol: str, parameters: Mapping[str, Any], source: str) -> Moved:
    """A structure of parameters of which one must be said."""
    known_keys(parameters, tuple(quantities(owner)), source, "parameters")
    if symbol not in parameters:
        raise BadInput(source, at="parameters", found=sorted(parameters), expected=f"{symbol} at least")
    return fill(owner, parameters, source, "parameters")


def _begun(body: Moved, data: Mapping[str, Any], source: str) -> Moved:
    """The body with what the file says of windows and of how it begins."""
    if data.get("window_s") is not None:
        body = replace(body, window_s=_window(data["window_s"], source))
    initial = data.get("initial", "rest")
    if initial not in get_args(Initial):
        raise BadInput(source, at="initial", found=repr(initial), expected=" or ".join(get_args(Initial)))
    return replace(body, initial=initial)


def parse_controller(data: Mapping[str, Any], source: str, at: str) -> Controller:
    """A controller, from `kind`, `gains` and `limits`.

    Args:
        data: as in a file.
        source: the file, for messages.
        at: the place in it.

    Raises:
        BadInput: something in it is none of a controller.
    """
    known_keys(data, ("kind", "gains", "limits"), source, at)
    kind: Any = data.get("kind")
    if kind not in get_args(ControllerKind):
        expected = " or ".join(get_args(ControllerKind))
        raise BadInput(source, at=f"{at}.kind", found=repr(kind), expected=expected)
    gains = mapping(data.get("gains"), source, f"{at}.gains")
    wanted = {f"k{part}" for part in kind}
    if set(gains) != wanted:
        found, expected = ", ".join(gains) or "none", f"{', '.join(sorted(wanted))} of a {kind}"
        raise BadInput(source, at=f"{at}.gains", found=found, expected=expected)
    limits = data.get("limits", [-math.inf, math.inf])
    limits = limits if isinstance(limits, list) else [_negative(limits), limits]
    if len(limits) != 2 or not all(isinstance(x, int | float) and not isinstance(x, bool) for x in limits):
        found, expected = repr(data["limits"]), "[low, high], or one number for both ways"
        raise BadInput(source, at=f"{at}.limits", found=found, expected=expected)
    with located(source, at):
        return Controller(kind, **gains, low=limits[0], high=limits[1])


def _controlled(body: DrivenBodyModel, data: Mapping[str, Any], source: str) -> DrivenBodyModel:
    controller = parse_controller(data, source, "controller")
    with located(source, "parameters"):
        body = replace(body, controller=controller)
    if body.memories and body.window_s is not None:
        found, expected = (
            f"window_s beside a {controller.kind}",
            "no windows: what it has integrated is not known in their midst",
        )
        raise BadInput(source, at="controller", found=found, expected=expected)
    return body


def _negative(value: object) -> object:
    return -value if isinstance(value, int | float) and not isinstance(value, bool) else value


def controller_data(controller: Controller) -> dict[str, Any]:
    """A controller as it stands in a file."""
    data: dict[str, Any] = {"kind": controller.kind}
    data["gains"] = {f"k{part}": getattr(controller, f"k{part}") for part in controller.kind}
    if math.isfinite(controller.low) or math.isfinite(controller.high):
        data["limits"] = [controller.low, controller.high]
    return data


def _window(value: object, source: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
        raise BadInput(source, at="window_s", found=repr(value), expected="seconds, more than 0")
    return float(value)


def _named(entry: object, i: int, source: str) -> tuple[Effect, Mapping[str, Any]]:
    entry = mapping(entry, source, f"effects[{i}]")
    known_keys(entry, ("name", "parameters", "file"), source, f"effects[{i}]")
    name, file = entry.get("name"), entry.get("file")
    if file is not None and not isinstance(file, str):
        raise BadInput(source, at=f"effects[{i}].file", found=repr(file), expected="the name of a Python file")
    if not isinstance(name, str) or name not in LIBRARY:
        # A model file does not run code: the person does, by --effects.
        known = f"one of {', '.join(LIBRARY)}{suggest(str(name), LIBRARY)}"
        known = known if file is None else f"--effects {file}, where the model has it from"
        raise BadInput(source, at=f"effects[{i}].name", found=repr(name), expected=known)
    return LIBRARY[name], mapping(entry.get("parameters", {}), source, f"effects[{i}].parameters")


def _origin(name: str) -> dict[str, str]:
    """Where an effect of a person's own came from, to be read again; nothing of those of the library."""
    return {"file": str(SOURCES[name])} if name in SOURCES else {}


def _go_together(one: Effect, other: Effect) -> bool:
    """True if one adds to the number that the other builds on before it replaces that."""
    adding, taking = (one, other) if one.adds_to else (other, one)
    return adding.adds_to is not None and taking.replaces is not None and adding.adds_to in taking.builds_on
