"""`python scripts/theory.py [DIR]` writes the theory pages (docs/theory): one for each effect, and an index of them.

A docstring says in its first paragraph what the effect is, then how its law reads, and ends with a list under `Easily
confused with:` of other effects, each with the motion that tells the two apart. A pair is written down once, in either
file; both pages show it.
"""

import inspect
import math
import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from theory_pictures import Picture, picture

from mmt_drake.analysis.plotting import write_whole
from mmt_drake.effects import LIBRARY
from mmt_drake.effects.effect import Effect, Parameter
from mmt_drake.errors import BadInput
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.model.transmission import TransmissionModel

INDEX: Final = "README.md"
STRUCTURES: Final = (FlexibleBoxModel, KelvinVoigt, SurfaceContact, DrivenBodyModel, TransmissionModel)

_CONFUSED = "Easily confused with:"
_ITEM = re.compile(r"^- `(\w+)`: (.+?)(?=^- |\Z)", re.MULTILINE | re.DOTALL)
_BLOCKS: Final = {
    "friction": "between the body and the table",
    "contact": "between the probe and the body",
    "body": "what acts on it, and its mass",
    "force_sensor": "in the force sensor",
    "channel": "between the force and who records it",
    "geometry": "how frames lie to each other",
    "drive": "between the input and the body that it drives",
    "any": "where its parameters say",
}


@dataclass(frozen=True)
class Theory:
    """What an effect's docstring says.

    Attributes:
        about: the first paragraph, in one line.
        text: the paragraphs after it, Markdown.
        confused: other effect -> the motion that tells the two apart.
    """

    about: str
    text: str
    confused: Mapping[str, str]


def theory(effect: Effect) -> Theory:
    """The docstring of the module that an effect was declared in.

    Raises:
        BadInput: there is none, or its list of effects that it is confused with cannot be read.
    """
    module = sys.modules.get(f"mmt_drake.effects.{effect.name}") or inspect.getmodule(effect.starts)
    text = inspect.getdoc(module) if module is not None else None
    if not text:
        raise BadInput(effect.name, found="no docstring in its file", expected="what the effect is, in words")
    text, _, items = text.partition(_CONFUSED)
    about, _, rest = text.strip().partition("\n\n")
    confused = {name: _one_line(motion) for name, motion in _ITEM.findall(items)}
    if len(confused) != len(re.findall("^- ", items, re.MULTILINE)):
        raise BadInput(
            effect.name,
            at=_CONFUSED.removesuffix(":"),
            found=_one_line(items),
            expected="items `- `name`: what tells apart`",
        )
    return Theory(_one_line(about), rest.strip(), confused)


def pages(library: Mapping[str, Effect]) -> dict[str, str]:
    """All files by name: a Markdown page and, where it can be shown, an SVG picture for each effect, and the index.

    Raises:
        BadInput: as `theory`; an effect is said to be confused with one that is not in the library.
    """
    theories = {name: theory(effect) for name, effect in library.items()}
    confused = _both_ways(theories)
    files = {INDEX: _index(library, theories)}
    for name, effect in library.items():
        drawn = picture(effect)
        files[f"{name}.md"] = _page(effect, theories[name], confused[name], drawn, library)
        if drawn is not None:
            files[f"{name}.svg"] = drawn.svg
    return files


def _both_ways(theories: Mapping[str, Theory]) -> dict[str, dict[str, str]]:
    """Effect -> those it is confused with, those that name it themselves after its own."""
    result = {name: dict(theory.confused) for name, theory in theories.items()}
    for name, own in theories.items():
        for other, motion in own.confused.items():
            if other not in theories:
                raise BadInput(name, at=_CONFUSED.removesuffix(":"), found=other, expected="an effect of the library")
            result[other].setdefault(name, motion)
    return result


def _page(
    effect: Effect, own: Theory, confused: Mapping[str, str], drawn: Picture | None, library: Mapping[str, Effect]
) -> str:
    needs = effect.needs if effect.adds_to in (None, "Fc") else (*effect.needs, effect.adds_to)
    alone = [s for s in STRUCTURES if not effect.twin_of or "z" in s.AXES]
    taken = [s for s in alone if effect.is_taken_by(s)]
    able = [s for s in taken if all(symbol in s.SYMBOLS for symbol in needs)]
    structures = [s.NAME for s in able if effect.block == "any" or effect.block in s.BLOCKS]
    facts = [f"Block `{effect.block}`: {_BLOCKS[effect.block]}"]
    facts += ["along the surface normal"] if effect.axis == "z" else []
    facts += [f"takes the place of `{effect.replaces}`"] if effect.replaces is not None else []
    facts += [f"adds to `{effect.adds_to}`"] if effect.adds_to is not None else []
    facts += [f"only where `{symbol}` is not 0" for symbol in effect.needs if symbol != "surface"]
    facts += ["of a transmission only where `m` is not 0"] if effect.inertial and "transmission" in structures else []
    if effect.passive is not None:
        facts += [
            f"gives no energy that was not put in{f', where {effect.passive.where}' * bool(effect.passive.where)}"
        ]
    parts = [
        f"# {effect.name}",
        own.about,
        " · ".join(facts),
        own.text,
        f"```\n{effect.equation}\n```",
        "## Parameters",
        _table(effect),
        "Without effect are all values of the last column together." if len(effect.parameters) > 1 else "",
        f"Structures that can have it: {', '.join(f'`{name}`' for name in structures) or 'none of the library'}.",
    ]
    if drawn is not None:
        parts += [f"![{effect.name}: with it and without]({effect.name}.svg)", drawn.caption]
    if effect.equal_to:
        equal = " or ".join(_linked(other, library) for other in effect.equal_to)
        parts += ["## Equal to", f"As said above, no recording of one axis can tell it from {equal}."]
    if effect.equal_massless:
        equal = " or ".join(_linked(other, library) for other in effect.equal_massless)
        parts += ["## Equal without a mass", f"In a model without a mass no recording can tell it from {equal}."]
    if effect.near_equal:
        near = [f"{_linked(other, library)} where {where}" for other, where in effect.near_equal.items()]
        parts += ["## Nearly equal", f"Recordings hardly tell it from {'; or '.join(near)}."]
    if confused:
        parts += ["## Easily confused with"]
        parts += ["\n".join(f"- {_linked(name, library)}: {motion}" for name, motion in confused.items())]
    parts += ["## Source", f"{effect.source}.", f"[All effects]({INDEX})"]
    return "\n\n".join(part for part in parts if part) + "\n"


def _table(effect: Effect) -> str:
    rows = ["| parameter | unit | bounds | unless said | no effect at |", "| --- | --- | --- | --- | --- |"]
    for parameter in effect.parameters:
        default = "must be said" if parameter.default is None else _named(parameter.default)
        rows.append(
            f"| `{parameter.symbol}` | {parameter.unit} | {_bounds(parameter)} | {default} | {_vanishing(parameter)} |"
        )
    return "\n".join(rows)


def _bounds(parameter: Parameter) -> str:
    if parameter.choices:
        return ", ".join(_named(choice) for choice in parameter.choices)
    low, high = parameter.bounds
    if math.isinf(low) and math.isinf(high):
        text = "any"
    elif math.isinf(high):
        text = f"{low:g} or more"
    elif math.isinf(low):
        text = f"{high:g} or less"
    else:
        text = f"{low:g} to {high:g}"
    return f"a list, {text} each" if parameter.kind == "list" else text


def _vanishing(parameter: Parameter) -> str:
    value = parameter.vanishes_at
    return ", ".join(map(_named, value)) if isinstance(value, tuple) else _named(value)


def _named(value: float | str) -> str:
    return f"`{value}`" if isinstance(value, str) else f"{value:g}"


def _index(library: Mapping[str, Effect], theories: Mapping[str, Theory]) -> str:
    parts = [
        "# Effects",
        "Physics that a simulation may have left out. v is the sliding velocity of the body, x its displacement, d the "
        "deflection of the contact spring, N the normal load, t the time since the first sample; SI units throughout. "
        "A page is made of its effect's docstring and declaration: `python scripts/theory.py`.",
    ]
    for block, where in _BLOCKS.items():
        members = [effect for effect in library.values() if effect.block == block]
        if not members:
            continue
        rows = ["| effect | what it is | law |", "| --- | --- | --- |"]
        for effect in members:
            law = effect.equation.replace("|", "\\|")  # in a table even code ends at a bar
            rows.append(f"| [{effect.name}]({effect.name}.md) | {theories[effect.name].about} | `` {law} `` |")
        parts += [f"## {block}: {where}", "\n".join(rows)]
    return "\n\n".join(parts) + "\n"


def _linked(names: str, library: Mapping[str, Effect]) -> str:
    """Names of effects, joined by " + ", each a link where it has a page."""
    return " + ".join(f"[{n}]({n}.md)" if n in library else n for n in names.split(" + "))


def _one_line(text: str) -> str:
    return " ".join(text.split())


if __name__ == "__main__":
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/theory")
    for name, text in pages(LIBRARY).items():
        write_whole(folder / name, text.encode())
