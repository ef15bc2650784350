"""`mmt-drake diagnose`: what physics a model leaves out that recordings show.

examples:
  mmt-drake diagnose contact.csv --model model.yaml --out out/diagnosis
  mmt-drake diagnose first.mcap second.mcap --model model.yaml --out out/both --jobs 2
  mmt-drake diagnose contact.csv --model model.yaml --out out/mine --effects my_effect.py
  mmt-drake diagnose out.mcap --model model.yaml --out out/station --blocks setup1-delay --set to_telerobot.delay=0.2

With --blocks REC is of a whole station (`mmt-drake run SCENARIO --record REC`): every block of SCENARIO, with MODEL as
its object, is replayed by itself on what was recorded at its inputs, and those whose outputs differ are named. Of a run
with `--operator hand.csv` say --set 'operator=!Recorded {file: hand.csv}' here: the surface lies where that hand is.

Several REC are recordings of the same system. DIR receives diagnosis.json, report.html (one page, opens offline),
augmented_model.yaml (for `mmt-drake simulate`) and figures; where the recordings cannot decide between explanations
also next_motion.npz, a motion that would (`mmt-drake run setup1 --operator next_motion.npz`).

MODEL may say `units: {position: rad, force: A}`, which the report then has in the place of m and N.

Verdicts: no_mismatch, parameters, missing_physics, partly_explained, ambiguous, unexplained, insufficient_data; exit
status 0 with any of them.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from mmt_drake.cli.options import TIME_BUDGET_S, add_effects, add_repeated, add_time_budget, add_topics, add_workers
from mmt_drake.cli.output import add_json, console, print_json
from mmt_drake.cli.progress import working
from mmt_drake.errors import BadInput

if TYPE_CHECKING:
    from mmt_drake.diagnosis.decide.blocks import Block, BlockReplay
    from mmt_drake.model_files import Model
    from mmt_drake.recording import Recording


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("recordings", nargs="+", metavar="REC", help="recordings of one system")
    parser.add_argument("--model", required=True, metavar="MODEL.yaml", help="what the simulation believes in")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder for what is found")
    parser.add_argument("--blocks", metavar="SCENARIO", help="replay a station block by block: where it differs")
    add_repeated(parser, "--set", "KEY=VALUE", "change that scenario")
    add_time_budget(parser, TIME_BUDGET_S, f"default {TIME_BUDGET_S:g}")
    add_workers(parser)
    add_effects(parser)
    add_topics(parser)
    add_json(parser)


def main(arguments: argparse.Namespace) -> int:
    """Diagnose recordings."""
    # Imported where needed, so that help comes at once.
    from mmt_drake.diagnosis.diagnose import diagnose
    from mmt_drake.diagnosis.fit.workers import workers
    from mmt_drake.diagnosis.tell.report_text import replayed
    from mmt_drake.diagnosis.tell.written import write_outcome
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
    blocks = _blocks(arguments, model, recordings)
    replays: tuple[BlockReplay, ...] = ()
    with working("diagnosis") as show, workers(arguments.jobs, arguments.cluster) as executor:
        if blocks:
            from mmt_drake.diagnosis.decide.blocks import replay_blocks

            show("block by block")
            replays = replay_blocks(recordings[0], blocks)
        outcome = diagnose(recordings, model, executor=executor, on_stage=show, time_budget=arguments.time_budget)
    # What is known on one side only is off without bound, and JSON has no number for that.
    told_replays = tuple(replace(r, nrmse=None) if r.nrmse == math.inf else r for r in replays)
    outcome = replace(outcome, diagnosis=replace(outcome.diagnosis, replays=told_replays))
    files = write_outcome(outcome, out)
    if arguments.json:
        print_json(outcome.diagnosis.to_json())
        return 0
    target = console()
    target.print(f"{outcome.diagnosis.verdict}: {outcome.diagnosis.summary}", markup=False)
    if replays:
        target.print(f"blocks: {replayed(outcome.diagnosis)}", markup=False)
    if outcome.diagnosis.next_recording is not None:
        target.print(f"next recording: {outcome.diagnosis.next_recording}", markup=False)
    target.print("written: " + ", ".join(map(str, files)), markup=False, soft_wrap=True)
    return 0


def _blocks(arguments: argparse.Namespace, model: Model, recordings: Sequence[Recording]) -> tuple[Block, ...]:
    """The station that is believed to have been run, block by block; none unless asked for."""
    from mmt_drake.model.parameters import FlexibleBoxModel

    if arguments.blocks is None:
        if arguments.set:
            raise BadInput("--set", found="no --blocks", expected="a scenario to change")
        return ()
    from mmt_drake.diagrams.stations.blocks import station_blocks
    from mmt_drake.diagrams.stations.scenario import load_scenario

    if len(recordings) != 1:
        raise BadInput("--blocks", found=f"{len(recordings)} recordings", expected="one, of a whole station")
    if not isinstance(model, FlexibleBoxModel):
        raise BadInput(arguments.model, at="structure", found=model.NAME, expected="flexible_box, a station's object")
    scenario = load_scenario(arguments.blocks, arguments.set, trust_library=True)  # no device is opened here
    return station_blocks(scenario, model=model)
