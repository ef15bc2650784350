"""`mmt-drake effects`: the library of effects, for people and as JSON."""

from __future__ import annotations

import argparse
import json
import math
from typing import Any

from mmt_drake.effects import LIBRARY, Effect

EPILOG = """\
examples:
  mmt-drake effects
  mmt-drake effects --json | jq '.[].name'"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("--json", action="store_true", help="print one JSON document and nothing else")


def main(arguments: argparse.Namespace) -> int:
    """List the library."""
    if arguments.json:
        print(json.dumps([described(effect) for effect in LIBRARY.values()], indent=2, allow_nan=False))
    else:
        print("\n\n".join(_told(effect) for effect in LIBRARY.values()))
    return 0


def described(effect: Effect) -> dict[str, Any]:
    """An effect as data; a parameter without a limit has None as that bound."""
    return {
        "name": effect.name,
        "block": effect.block,
        "replaces": effect.replaces,
        "equal_to": list(effect.equal_to),
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


def _told(effect: Effect) -> str:
    place = f"{effect.block}, replaces {effect.replaces}" if effect.replaces else effect.block
    lines = [f"{effect.name} ({place})", f"  {effect.equation}"]
    for parameter in effect.parameters:
        low, high = parameter.bounds
        lines.append(f"  {parameter.symbol} [{parameter.unit}], {low:g} to {high:g}")
    if effect.equal_to:
        lines.append(f"  no recording can tell it from: {', '.join(effect.equal_to)}")
    return "\n".join([*lines, f"  source: {effect.source}"])
