"""Which real arms are diagnosed, on what, and what simple fits leave of the same."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from mmt_drake.arms.arm_file import ArmModel
from mmt_drake.arms.believed import predicted
from mmt_drake.arms.diagnosis import diagnose_arm
from mmt_drake.arms.joint_log import JointLog, load_joint_log
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.diagrams.proof.trial.real import arm_plants
from mmt_drake.effects.wording import words
from mmt_drake.errors import BadInput
from mmt_drake.recording.public import FOLDER, public_recordings

_PLANTS: Final = Path(arm_plants.__file__)
_UR10E_GAINS: Final = (10.0, 10.70, 8.46, 9.00, 9.48, 10.12)
_KR300_GEARS: Final = (257.0, 267.0, 252.0, 221.0, 240.0, 154.0)
_SPEEDS: Final = ("0.05", "0.10", "0.50", "0.90", "1.50")


@dataclass(frozen=True)
class ArmCase:
    """One arm.

    Attributes:
        name: of the case.
        folder: of its recordings.
        robot: its file there; empty: `function` of `arm_plants` makes it.
        function: see there.
        column, factor: of the torque, see `ArmModel`.
        fitted: logs that are diagnosed.
        tested: log of another motion, or of the same once more; empty: there is none.
        simple: what the better of a viscous and a viscous-Coulomb refit leaves of it, by joint, as the notes of the
            recordings print it; None where they do not.
        after: the case whose model is handed in; empty: the robot's own.
        load_kg: what the arm carries beside that model; None: nothing.
    """

    name: str
    folder: str
    fitted: tuple[str, ...]
    tested: str = ""
    robot: str = ""
    function: str = ""
    column: str = ""
    factor: tuple[float, ...] = ()
    simple: tuple[float | None, ...] = ()
    after: str = ""
    load_kg: float | None = None

    def path(self, recordings: str | Path) -> Path:
        """Its folder in that of the public recordings.

        Raises:
            BadInput: there is none.
        """
        folder = Path(recordings) / self.folder
        if not folder.is_dir():
            raise BadInput(folder, found="no such folder", expected=f"the public recordings, which {FOLDER} names")
        return folder


_UR10E = ArmCase(
    "UR10e",
    "ur10e_arm",
    ("traj_20_02_10-30sec_12harm",),
    "traj_20_02_19_14harm50sec",
    robot="robot.urdf",
    column="i_A",
    factor=_UR10E_GAINS,
    simple=(0.084, 0.047, 0.048, 0.072, 0.098, 0.094),
)
_BEFORE = replace(
    _UR10E, name="UR10e, no load", fitted=(_UR10E.tested,), tested="traj_20_02_10-30sec_12harm", simple=()
)
_PSM = ArmCase(
    "PSM", "dvrk_psm", ("one_0g",), "one_repeat", function="psm", simple=(0.176, None, 0.212, None, None, None, None)
)

CASES: Final = (
    _UR10E,
    _BEFORE,
    replace(
        _UR10E,
        name="UR10e, 2.805 kg",
        fitted=("traj_20_02_19_14harm50secLoad",),
        tested="",
        simple=(),
        after=_BEFORE.name,
        load_kg=2.805,
    ),
    ArmCase(
        "LWR4+",
        "kuka_lwr4",
        ("measurements_1",),
        "measurements_3",
        robot="robot.urdf",
        simple=(0.65, 0.069, 0.18, 0.078, None, None, None),
    ),
    ArmCase(
        "KR300",
        "kuka_kr300",
        ("traj_A",),
        "traj_B",
        function="kr300",
        column="tau_motor_Nm",
        factor=_KR300_GEARS,
        simple=(0.47, 0.45, 0.65, 0.52, 0.56, 0.35),
    ),
    _PSM,
    replace(_PSM, name="PSM, 0.105 kg", fitted=("one_105g",), tested="", simple=(), after=_PSM.name, load_kg=0.105),
    # Twenty times the same torque; the arm goes farther each time.
    ArmCase(
        "Schunk", "schunk_arm", tuple(f"run_{number:03d}" for number in range(1, 20, 2)), "run_010", function="schunk"
    ),
    ArmCase(
        "Kinova joint 7",
        "kinova_gen3_joint7",
        tuple(f"v_{speed}" for speed in _SPEEDS),
        function="last_joint",
        column="tau_cmd_Nm",
    ),
)


@dataclass(frozen=True)
class ArmResult:
    """What came of one arm.

    Attributes:
        name, fitted, tested: of the case.
        joints: names.
        verdict, summary: of the diagnosis.
        handed_in, found: RMS error of the torque over its spread on the tested log while a joint moves, by joint; on
            blocks that nothing was fitted to where there is no other log.
        simple: of the case.
        dry: joint -> name of the law of dry friction and how deep it is certain.
        load_kg: of the case.
        payload_kg: found; None where none was.
        seconds: of the diagnosis.
        named: place -> effects that are sure there, and how deep; the empty place is the whole arm.
    """

    name: str
    fitted: tuple[str, ...]
    tested: str
    joints: tuple[str, ...]
    verdict: str
    summary: str
    handed_in: tuple[float, ...]
    found: tuple[float, ...]
    simple: tuple[float | None, ...]
    dry: dict[str, str]
    load_kg: float | None
    payload_kg: float | None
    seconds: float
    named: dict[str, str]


def model_of(case: ArmCase, folder: Path) -> ArmModel:
    """The model that is handed in.

    Args:
        case: whose.
        folder: of public recordings.
    """
    robot = folder / case.folder / case.robot if case.robot else _PLANTS
    return ArmModel(robot=robot, source=case.name, function=case.function, column=case.column, factor=case.factor)


def logs_of(case: ArmCase, names: tuple[str, ...], model: ArmModel, recordings: Path) -> list[JointLog]:
    """Logs of a case.

    Args:
        case: whose.
        names: of the logs.
        model: of the arm.
        recordings: folder of public recordings.

    Raises:
        BadInput: the folder of public recordings has no such file.
    """
    folder = case.path(recordings)
    arm = ArmPlant.of(model)
    return [load_joint_log(folder / f"{name}.npz", model, arm.joints) for name in names]


def run_case(case: ArmCase, recordings: Path | None = None, time_budget: float = math.inf) -> ArmResult:
    """Diagnose an arm, and hold what was found to another log.

    Args:
        case: what is diagnosed.
        recordings: folder of public recordings; where they usually are unless given.
        time_budget: of the diagnosis [s].
    """
    begun, folder = time.perf_counter(), recordings or public_recordings()
    model = model_of(case, folder)
    if case.after:
        before = next(other for other in CASES if other.name == case.after)
        model = diagnose_arm(logs_of(before, before.fitted, model, folder), model, time_budget=time_budget).model
        begun = time.perf_counter()
    diagnosis = diagnose_arm(logs_of(case, case.fitted, model, folder), model, time_budget=time_budget)
    seconds = time.perf_counter() - begun
    arm = ArmPlant.of(model)
    if case.tested:
        (other,) = logs_of(case, (case.tested,), model, folder)
        handed_in, found = (predicted(arm, m, other).nrmse for m in (model, diagnosis.model))
        errors = tuple(map(float, handed_in)), tuple(map(float, found))
    else:
        errors = tuple(j.nominal for j in diagnosis.joints), tuple(j.augmented for j in diagnosis.joints)
    dry = {e.where: f"{e.name} ({e.certain or 'not sure'})" for e in diagnosis.effects if e.family == "dry_friction"}
    named: dict[str, str] = {}
    for effect in diagnosis.effects:
        if effect.certain:
            before_it = f"{named[effect.where]}, " if effect.where in named else ""
            named[effect.where] = f"{before_it}{words(effect.name)} ({effect.certain})"
    masses = [e.numbers["m"] for e in diagnosis.effects if e.name == "payload"]
    return ArmResult(
        case.name,
        case.fitted,
        case.tested,
        arm.joints,
        diagnosis.verdict,
        diagnosis.summary,
        *errors,
        case.simple or (None,) * len(arm.joints),
        dry,
        case.load_kg,
        next((m.value for m in masses if not isinstance(m, str)), None),
        round(seconds, 1),
        named,
    )
