"""Commands on robot arms: what `diagnose` and `simulate` do with a model of `structure: multibody`."""

from __future__ import annotations

import argparse
from pathlib import Path

from mmt_drake.cli.interrupted import known_kept
from mmt_drake.cli.options import folder_to_write
from mmt_drake.cli.output import console, print_json, say
from mmt_drake.cli.progress import working
from mmt_drake.errors import BadInput

_NOT_FOR_ARMS = ("blocks", "set", "effects", "structure", "cluster", "map", "axis", "topic")


def diagnose_arms(arguments: argparse.Namespace) -> int:
    """Diagnose logs of an arm.

    Raises:
        BadInput: options that say nothing of an arm; a file that is none.
    """
    from mmt_drake.arms.arm_file import load_arm_model
    from mmt_drake.arms.diagnosis import diagnose_arm
    from mmt_drake.arms.joint_log import load_joint_log
    from mmt_drake.arms.plant import ArmPlant
    from mmt_drake.arms.result import as_json
    from mmt_drake.arms.written import MODEL_FILE, write_arm_diagnosis
    from mmt_drake.diagnosis.tell.provenance import Provenance

    _refuse_others(arguments)
    out = folder_to_write(arguments.out)
    model = load_arm_model(arguments.model)
    arm = ArmPlant.of(model)
    logs = [load_joint_log(file, model, arm.joints) for file in arguments.recordings]
    with known_kept(out, arguments.command_line), working("diagnosis", arguments.time_budget) as show:
        budget = arguments.time_budget
        diagnosis = diagnose_arm(logs, model, on_stage=show, on_answer=show.tell, time_budget=budget)
    provenance = Provenance.of(arguments.recordings, arguments.model, arguments.command_line)
    files = write_arm_diagnosis(diagnosis, model, logs[0], arguments.out, provenance)
    if arguments.json:
        print_json(as_json(diagnosis, MODEL_FILE))
        return 0
    target = console()
    target.print(f"{diagnosis.verdict}: {diagnosis.summary}", markup=False)
    target.print("written: " + ", ".join(map(str, files)), markup=False, soft_wrap=True)
    return 0


def simulate_arm(arguments: argparse.Namespace) -> int:
    """Write the torque that a model of an arm predicts for a log's motion, and say how far it is off.

    Raises:
        BadInput: options that say nothing of an arm; a file that is none; OUT is neither .npz nor .csv.
    """
    import numpy as np

    from mmt_drake.arms.arm_file import load_arm_model
    from mmt_drake.arms.believed import predicted
    from mmt_drake.arms.joint_log import load_joint_log
    from mmt_drake.arms.plant import ArmPlant
    from mmt_drake.recording.atomic import replacing

    _refuse_others(arguments)
    if arguments.windows is not None:
        raise BadInput("--windows", found="a model of an arm", expected="--operator, a log of its joints")
    out = Path(arguments.out)
    if out.suffix not in (".npz", ".csv"):
        raise BadInput(out, found=f"the ending {out.suffix!r}", expected=".npz or .csv for the torques of an arm")
    model = load_arm_model(arguments.model)
    arm = ArmPlant.of(model)
    one = predicted(arm, model, load_joint_log(arguments.operator, model, arm.joints))
    with replacing(out) as partial:
        if out.suffix == ".npz":
            with partial.open("wb") as file:
                np.savez_compressed(
                    file, t_s=one.time, tau_Nm=one.predicted, measured_tau_Nm=one.measured, counted=one.counted
                )
        else:
            names = [f"{what}_{j}" for what in ("tau", "measured_tau", "counted") for j in range(len(arm.joints))]
            table = np.column_stack([one.time, one.predicted, one.measured, one.counted])
            np.savetxt(partial, table, delimiter=",", header=",".join(["time", *names]), comments="", fmt="%.9g")
    errors = ", ".join(f"{name} {error:.4g}" for name, error in zip(arm.joints, one.nrmse, strict=True))
    say(f"{out}: {len(one.time)} samples below {model.band_hz:g} Hz; nrmse of the torque while it moves: {errors}")
    return 0


def _refuse_others(arguments: argparse.Namespace) -> None:
    """Refuse options that only other models have."""
    for name in _NOT_FOR_ARMS:
        if getattr(arguments, name, None):
            raise BadInput(f"--{name}", found="a model of an arm", expected="a contact, a body or a transmission")
