"""`mmt-drake effects`: the library of effects, for people and as JSON.

examples:
  mmt-drake effects
  mmt-drake effects --json | jq '.[].name'
  mmt-drake effects --effects my_effect.py

A file for --effects defines EFFECT as the files of mmt_drake/effects do.
"""

import argparse
import math
from typing import Any

from mmt_drake.arms.arm_effect import ArmEffect
from mmt_drake.arms.laws import ARM_EFFECTS
from mmt_drake.cli.options import add_effects
from mmt_drake.cli.output import add_json, print_json, say
from mmt_drake.effects import LIBRARY, Effect, Parameter, register_file
from mmt_drake.effects.wording import words


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    add_json(parser)
    add_effects(parser)


def main(arguments: argparse.Namespace) -> int:
    """List the library."""
    for file in arguments.effects:
        register_file(file)
    if arguments.json:
        alone = [_of_arms_alone(effect) for name, effect in ARM_EFFECTS.items() if name not in LIBRARY]
        print_json([*map(described, LIBRARY.values()), *alone])
    else:
        alone_said = [_text_of_arms(effect) for name, effect in ARM_EFFECTS.items() if name not in LIBRARY]
        say("\n\n".join([*map(_text, LIBRARY.values()), *alone_said]))
    return 0


def described(effect: Effect) -> dict[str, Any]:
    """An effect as data; a parameter without a limit has None as that bound."""
    return {
        "name": effect.name,
        "block": effect.block,
        "family": effect.family,
        "elsewhere": {at: {"family": f, "block": b} for at, (f, b) in effect.elsewhere.items()},
        "replaces": effect.replaces,
        "equal_to": list(effect.equal_to),
        "equal_massless": list(effect.equal_massless),
        "near_equal_to": [{"name": name, "where": where} for name, where in effect.near_equal.items()],
        "axis": effect.axis,
        "parameters": [
            {
                "symbol": parameter.symbol,
                "unit": parameter.unit,
                "bounds": [bound if math.isfinite(bound) else None for bound in parameter.bounds],
            }
            for parameter in effect.parameters
        ],
        "equation": effect.equation,
        "source": effect.source,
        "of_arms": _of_arms(effect.name),
    }


def _of_arms(name: str) -> dict[str, Any] | None:
    """What an effect is of a robot arm: where it acts, units of joints that turn, what looks like it; None: nothing."""
    if name not in ARM_EFFECTS:
        return None
    effect = ARM_EFFECTS[name]
    return {
        "place": effect.place,
        "parameters": [{"symbol": s, "unit": unit} for s, unit in zip(effect.symbols, effect.units, strict=True)],
        "near_equal_to": [{"name": other, "where": where} for other, where in effect.near_equal.items()],
    }


def _of_arms_alone(effect: ArmEffect) -> dict[str, Any]:
    """An effect that only arms have, with the keys of all others."""
    own = _of_arms(effect.name)
    assert own is not None  # it is one of arms
    return {
        "name": effect.name,
        "block": effect.block,
        "family": effect.family,
        "elsewhere": {},
        "replaces": None,
        "equal_to": [],
        "equal_massless": [],
        "near_equal_to": own["near_equal_to"],
        "axis": "",
        "parameters": [{**parameter, "bounds": [None, None]} for parameter in own["parameters"]],
        "equation": effect.equation,
        "source": effect.source,
        "of_arms": own,
    }


def _text_of_arms(effect: ArmEffect) -> str:
    lines = [f"{effect.name} ({effect.block}, of a robot's {effect.place})", f"  {effect.equation}"]
    lines += [
        f"  {symbol}" + (f" [{unit}]" if unit else "")
        for symbol, unit in zip(effect.symbols, effect.units, strict=True)
    ]
    lines += [f"  hardly told from {words(name)} {where}" for name, where in effect.near_equal.items()]
    return "\n".join([*lines, f"  source: {effect.source}"])


def _text(effect: Effect) -> str:
    where = "; ".join([effect.block, *(f"{block} of a {words(at)}" for at, (_, block) in effect.elsewhere.items())])
    where += f", replaces {effect.replaces}" if effect.replaces else ""
    lines = [f"{effect.name} ({where})", f"  {effect.equation}"]
    for parameter in effect.parameters:
        lines.append(f"  {parameter.symbol} {_range(parameter)}")
    if effect.equal_to:
        lines.append(f"  no recording can tell it from: {', '.join(effect.equal_to)}")
    if effect.equal_massless:
        lines.append(f"  without a mass no recording can tell it from: {', '.join(effect.equal_massless)}")
    lines += [f"  hardly told from {name} where {where}" for name, where in effect.near_equal.items()]
    return "\n".join([*lines, f"  source: {effect.source}"])


def _range(parameter: Parameter) -> str:
    if parameter.choices:
        text = f"[{parameter.unit}], one of {', '.join(str(choice) for choice in parameter.choices)}"
    else:
        low, high = parameter.bounds
        text = f"[{parameter.unit}], {low:g} to {high:g}"
        text += " each" if parameter.kind == "list" else ""
    return text if parameter.default is None else f"{text}; {parameter.default} unless said"
