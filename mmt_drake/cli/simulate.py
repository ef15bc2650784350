"""`mmt-drake simulate`: a recording's probe motion through a model file.

examples:
  mmt-drake simulate --model model.yaml --operator contact.csv --out simulated.csv
  mmt-drake simulate --model diagnosed/augmented_model.yaml --windows servo.csv --out simulated.csv

OUT has the time stamps and columns of REC. The force (a driven body's output) is the model's as its sensor reads it,
free-running and at rest at the first sample (a driven body whose model says `initial: fitted` from a state fitted to
REC's output); every other column is REC's. A REC without forces, of a hand alone, gets them.
--windows restarts a driven body every so often from a state that is fitted to a lead-in of REC's output, as a diagnosis
does. How often says the key window_s of the model; without it, what a diagnosis would choose.

With a model of a robot arm (`structure: multibody`) REC is a log of its joints, and OUT (.npz, .csv) has the torque
that the model predicts for that motion, and the measured one, smooth below the model's band.

model.yaml, for example:
  structure: flexible_box
  parameters: {m: 1.0, k1: 0.0, k2: 500.0, b1: 60.0, b2: 60.0, Fc: 0.05}
  normal: {k: 500.0, b: 60.0}
"""

import argparse
from pathlib import Path

from mmt_drake.analysis.nrmse import force_nrmse
from mmt_drake.arms.structure import is_arm_file
from mmt_drake.cli.options import add_effects, add_reading, reading
from mmt_drake.cli.output import say
from mmt_drake.effects import register_file
from mmt_drake.model.structure import PositionOut
from mmt_drake.model_files import Model, compared, load_model
from mmt_drake.recording import Recording, load, save
from mmt_drake.recording.atomic import beside
from mmt_drake.recording.files import check_target
from mmt_drake.replay import in_windows
from mmt_drake.simulation import answered, simulate
from mmt_drake.windows import Windows


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("--model", required=True, metavar="MODEL.yaml", help="model file, nominal or augmented")
    replayed = parser.add_mutually_exclusive_group(required=True)
    replayed.add_argument("--operator", metavar="REC", help="recording whose probe motion, or input, is replayed")
    replayed.add_argument("--windows", metavar="REC", help="the same, over windows from states fitted in lead-ins")
    add_reading(parser)
    add_effects(parser)
    parser.add_argument("--out", required=True, metavar="OUT", help="where to write: .mcap, .csv or .npz")


def main(arguments: argparse.Namespace) -> int:
    """Replay a recording."""
    if is_arm_file(arguments.model):
        from mmt_drake.cli.arm import simulate_arm

        return simulate_arm(arguments)
    check_target(arguments.out)
    beside(Path(arguments.out))
    for file in arguments.effects:
        register_file(file)
    model = load_model(arguments.model)
    windows = arguments.windows is not None
    recording = load(arguments.windows if windows else arguments.operator, **reading(arguments), forces=False)
    simulated = _in_windows(model, recording) if windows else simulate(model, recording)
    save(simulated, arguments.out)
    length = recording.time[-1] - recording.time[0]
    parts = [f"{arguments.out}: {len(simulated)} samples, {length:.3f} s"]
    errors = force_nrmse(recording, simulated)
    if errors:
        parts.append("nrmse in contact: " + ", ".join(f"{name} {error:.4g}" for name, error in errors.items()))
    say("; ".join(parts))
    return 0


def _in_windows(model: Model, recording: Recording) -> Recording:
    """The recording with its output simulated over windows; free-running where the model allows the whole of it."""
    from mmt_drake.diagnosis.fit.prepare import prepare

    if isinstance(model, PositionOut) and recording.kind == "driven_body" and model.window_s is None:
        prepared = prepare([recording], model)
        model = compared(model, prepared.window_s, prepared.initial)
    if not isinstance(model, PositionOut) or model.window_s is None:
        return simulate(model, recording)
    windows = Windows.of(recording.time, recording["output"], model.window_s)
    simulated, _ = in_windows(model, recording, windows)
    return answered(recording, simulated)
