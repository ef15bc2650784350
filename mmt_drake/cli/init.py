"""`mmt-drake init`: look at a file of one's own; write what its columns are, and a model to start from.

examples:
  mmt-drake init tensile.csv
  mmt-drake init tensile.csv --out lab

Writes tensile.map.yaml, for `--map tensile.map.yaml` of every command that reads recordings, unless the columns have
the names of a recording's already; and tensile.model.yaml, with comments. Both are guesses, to be looked through.
"""

import argparse
from pathlib import Path

from mmt_drake.cli.output import say
from mmt_drake.errors import BadInput


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument(
        "recording", metavar="REC", help="a file with a recording: .csv, .npz, or any other that is read"
    )
    parser.add_argument("--out", metavar="DIR", default=".", help="folder for both files (default: this one)")


def main(arguments: argparse.Namespace) -> int:
    """Look at a file."""
    from mmt_drake.diagnosis.own_file import look  # so that help comes at once

    stem = Path(arguments.out) / Path(arguments.recording).stem
    mapping, model = (stem.with_name(f"{stem.name}.{what}.yaml") for what in ("map", "model"))
    for path in (mapping, model):
        if path.exists():
            raise BadInput(path, found="a file that is there already", expected="none: move it, or give another --out")
    found = look(arguments.recording)
    Path(arguments.out).mkdir(parents=True, exist_ok=True)
    if found.model is not None:
        found.write_model(model)  # first: if it is refused, no mapping is left behind
    options = ""
    if found.columns or found.recording is None:
        found.write_map(mapping)
        options = f" --map {mapping}"
    written = [path for path in (mapping, model) if path.exists()]
    say("\n".join([*found.remarks, f"written: {', '.join(map(str, written))}"]))
    if found.recording is None:
        say(f"Fill in {mapping}, and then:")
    rec = arguments.recording
    say(f"next: mmt-drake diagnose {rec}{options} --out out/{stem.name}")
    if model.exists():
        say(f"or, once its numbers are what you believe in: the same with --model {model}")
    return 0
