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

from mmt_drake.cli.options import add_effects
from mmt_drake.cli.output import add_json, print_json, say
from mmt_drake.effects import LIBRARY, Effect, Parameter, register_file


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    add_json(parser)
    add_effects(parser)


def main(arguments: argparse.Namespace) -> int:
    """List the library."""
    for file in arguments.effects:
        register_file(file)
    if arguments.json:
        print_json([described(effect) for effect in LIBRARY.values()])
    else:
        say("\n\n".join(_text(effect) for effect in LIBRARY.values()))
    return 0


def described(effect: Effect) -> dict[str, Any]:
    """An effect as data; a parameter without a limit has None as that bound."""
    return {
        "name": effect.name,
        "block": effect.block,
        "family": effect.family,
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
    }


def _text(effect: Effect) -> str:
    where = f"{effect.block}, replaces {effect.replaces}" if effect.replaces else effect.block
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
