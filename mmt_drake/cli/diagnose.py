"""`mmt-drake diagnose`: what physics a model leaves out that recordings show.

examples:
  mmt-drake diagnose contact.csv --model model.yaml --out out/diagnosis
  mmt-drake diagnose contact.csv --out out/first
  mmt-drake diagnose first.mcap second.mcap --model model.yaml --out out/both --jobs 2
  mmt-drake diagnose contact.csv --model model.yaml --out out/mine --effects my_effect.py
  mmt-drake diagnose out.mcap --model model.yaml --out out/station --blocks setup1-delay --set to_telerobot.delay=0.2

Without --model one is fitted to the recordings first, as `mmt-drake fit` does, and written as first_model.yaml: what is
then told is what its structure lacks.

With --blocks REC is of a whole station (`mmt-drake run SCENARIO --record REC`): every block of SCENARIO, with MODEL as
its object, is replayed by itself on what was recorded at its inputs, and those whose outputs differ are named. Of a run
with `--operator hand.csv` say --set 'operator=!Recorded {file: hand.csv}' here: the surface lies where that hand is.

Several REC are recordings of the same system. DIR receives diagnosis.json, report.html (one page, opens offline),
augmented_model.yaml (for `mmt-drake simulate`) and figures (SVG); where the recordings cannot decide between
explanations also next_motion.npz, a motion that would (`mmt-drake run setup1 --operator next_motion.npz`). Ctrl-C ends
it at once and leaves what was known by then in interrupted.json.

MODEL may say `units: {position: rad, force: A}`, which the report then has in the place of m and N;
`over: {Fc: current}`, a number that depends on a column recorded beside, or `over: {Fc: recording}`, free in each; and
of a driven body `controller: {kind: pd, gains: {kp: 40, kd: 1.5}, limits: 8}`: its input is the goal.

A MODEL of `structure: multibody` is of a robot arm, as a URDF, SDF or MJCF, and REC logs of its joints:
  mmt-drake diagnose log.csv --model arm.yaml --out out/arm

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

from mmt_drake.cli.interrupted import known_kept
from mmt_drake.cli.options import (
    TIME_BUDGET_S,
    add_effects,
    add_reading,
    add_repeated,
    add_time_budget,
    add_trust,
    add_workers,
    folder_to_write,
    recordings_of,
)
from mmt_drake.cli.output import add_json, console, print_json
from mmt_drake.cli.progress import working
from mmt_drake.errors import BadInput

if TYPE_CHECKING:
    from mmt_drake.diagnosis.decide.blocks import Block, BlockReplay
    from mmt_drake.diagnosis.tell.first import FirstModel
    from mmt_drake.model_files import Model
    from mmt_drake.recording import Recording


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("recordings", nargs="+", metavar="REC", help="recordings of one system")
    text = "what the simulation believes in (default: what a first fit finds)"
    parser.add_argument("--model", metavar="MODEL.yaml", help=text)
    parser.add_argument("--structure", metavar="S", help="of that first fit (default: by the columns)")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder for what is found")
    parser.add_argument("--blocks", metavar="SCENARIO", help="replay a station block by block: where it differs")
    add_repeated(parser, "--set", "KEY=VALUE", "change that scenario")
    add_trust(parser)
    add_time_budget(parser, TIME_BUDGET_S, f"default {TIME_BUDGET_S:g}")
    add_workers(parser)
    add_effects(parser)
    add_reading(parser)
    add_json(parser)


def main(arguments: argparse.Namespace) -> int:
    """Diagnose recordings."""
    from mmt_drake.arms.structure import is_arm_file

    if arguments.model is not None and is_arm_file(arguments.model):
        from mmt_drake.cli.arm import diagnose_arms

        return diagnose_arms(arguments)
    # Imported where needed, so that help comes at once.
    from mmt_drake.diagnosis.diagnose import diagnose
    from mmt_drake.diagnosis.first_model import fit
    from mmt_drake.diagnosis.fit.workers import workers
    from mmt_drake.diagnosis.search.watch import Stage
    from mmt_drake.diagnosis.tell.first import save_first_model, with_first_model
    from mmt_drake.diagnosis.tell.provenance import Provenance
    from mmt_drake.diagnosis.tell.report_text import replayed
    from mmt_drake.diagnosis.tell.written import write_outcome
    from mmt_drake.effects import register_file
    from mmt_drake.model_files import load_model

    out = folder_to_write(arguments.out)
    for file in arguments.effects:
        register_file(file)
    _check_model(arguments)
    model = None if arguments.model is None else load_model(arguments.model)
    recordings = recordings_of(arguments)
    blocks = () if model is None else _blocks(arguments, model, recordings)
    replays: tuple[BlockReplay, ...] = ()
    first: FirstModel | None = None
    with (
        known_kept(out, arguments.command_line),
        working("diagnosis", arguments.time_budget) as show,
        workers(arguments.jobs, arguments.cluster) as executor,
    ):
        if model is None:
            first = fit(recordings, arguments.structure, executor=executor, on_stage=show)
            model = first.model
        if blocks:
            from mmt_drake.diagnosis.decide.blocks import replay_blocks

            show(Stage("block by block"))
            replays = replay_blocks(recordings[0], blocks)
        outcome = diagnose(
            recordings, model, executor=executor, on_stage=show, on_answer=show.tell, time_budget=arguments.time_budget
        )
    # What is known on one side only is off without bound, and JSON has no number for that.
    told_replays = tuple(replace(r, nrmse=None) if r.nrmse == math.inf else r for r in replays)
    outcome = replace(outcome, diagnosis=replace(outcome.diagnosis, replays=told_replays))
    if first is not None:
        outcome = with_first_model(outcome, first)
    files = write_outcome(outcome, out, Provenance.of(arguments.recordings, arguments.model, arguments.command_line))
    if outcome.diagnosis.first_model is not None and first is not None:
        files.append(out / outcome.diagnosis.first_model)
        save_first_model(first, files[-1], [Path(recording.source).name for recording in recordings])
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


def _check_model(arguments: argparse.Namespace) -> None:
    """Refuse options that do not go with a model, or without one.

    Raises:
        BadInput: so they are.
    """
    if arguments.model is None and arguments.blocks is not None:
        raise BadInput("--blocks", found="no --model", expected="the object that the station is believed to have had")
    if arguments.model is not None and arguments.structure is not None:
        raise BadInput("--structure", found="--model beside it", expected="one of them: a model has its structure")


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
    scenario = load_scenario(arguments.blocks, arguments.set, trust_library=arguments.trust_library)
    return station_blocks(scenario, model=model)
