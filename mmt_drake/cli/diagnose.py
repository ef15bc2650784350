"""`mmt-drake diagnose`: what physics a model leaves out that recordings show."""

from __future__ import annotations

import argparse
from pathlib import Path

from mmt_drake.cli.options import add_effects, add_topics, add_workers
from mmt_drake.cli.output import add_json, console, print_json
from mmt_drake.cli.progress import working
from mmt_drake.errors import BadInput

EPILOG = """\
examples:
  mmt-drake diagnose contact.csv --model model.yaml --out out/diagnosis
  mmt-drake diagnose first.mcap second.mcap --model model.yaml --out out/both --jobs 2
  mmt-drake diagnose contact.csv --model model.yaml --out out/mine --effects my_effect.py

Several REC are recordings of the same system. DIR receives diagnosis.json, report.html (one page, opens offline),
augmented_model.yaml (for `mmt-drake simulate`) and figures; where the recordings cannot decide between explanations
also next_motion.npz, a motion that would (`mmt-drake run setup1 --operator next_motion.npz`).

Verdicts: no_mismatch, parameters, missing_physics, ambiguous, unexplained, insufficient_data; exit status 0."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("recordings", nargs="+", metavar="REC", help="recordings of one system")
    parser.add_argument("--model", required=True, metavar="MODEL.yaml", help="what the simulation believes in")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder for what is found")
    add_workers(parser)
    add_effects(parser)
    add_topics(parser)
    add_json(parser)


def main(arguments: argparse.Namespace) -> int:
    """Diagnose recordings."""
    # Imported where needed, so that help comes at once.
    from mmt_drake.diagnosis.diagnose import diagnose
    from mmt_drake.diagnosis.workers import workers
    from mmt_drake.diagnosis.written import write_outcome
    from mmt_drake.effects import register_file
    from mmt_drake.model_files import load_model
    from mmt_drake.recording import load_all

    out = Path(arguments.out)
    if out.exists() and not out.is_dir():
        raise BadInput(out, found="a file", expected="a folder, or a name for one")
    for file in arguments.effects:
        register_file(file)
    model = load_model(arguments.model)
    topics = dict(arguments.topic)
    recordings = [recording for file in arguments.recordings for recording in load_all(file, topics)]
    with working("diagnosis") as told, workers(arguments.jobs, arguments.cluster) as executor:
        outcome = diagnose(recordings, model, executor=executor, told=told)
    files = write_outcome(outcome, out)
    if arguments.json:
        print_json(outcome.diagnosis.to_json())
        return 0
    target = console()
    target.print(f"{outcome.diagnosis.verdict}: {outcome.diagnosis.summary}", markup=False)
    if outcome.diagnosis.next_recording is not None:
        target.print(f"next recording: {outcome.diagnosis.next_recording}", markup=False)
    target.print("written: " + ", ".join(map(str, files)), markup=False, soft_wrap=True)
    return 0
