"""The cases: one declaration per data set (two where it shows two things). Figures in SI units unless said.

Nominal values are those a user would have: published by the owners of the data, from a data sheet, or fitted to the
structure that is handed in.
"""

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any, Final, TypeVar

from mmt_drake.diagrams.proof.trial.real.arm_cases import CASES as ARMS
from mmt_drake.diagrams.proof.trial.real.arm_cases import ArmCase
from mmt_drake.diagrams.proof.trial.real.case import HeldOut, Published, RealCase, RealPart
from mmt_drake.diagrams.proof.trial.real.preparation import from_horizontal, from_release, loaded_by_gravity
from mmt_drake.errors import BadInput

Kind = TypeVar("Kind", RealCase, ArmCase)
_BASELINES = "Champneys et al. 2024, Baseline Results for Selected Nonlinear System Identification Benchmarks"
_TURNS = ("rad", "N m")
_BEST_SILVERBOX = "best result collected for the Silverbox on nonlinearbenchmark.org"


def _model(
    structure: str, pendulum: float | None = None, units: tuple[str, str] = ("m", "N"), **parameters: float
) -> dict[str, Any]:
    """A model file's mapping; `pendulum` is the torque of gravity of a link held out level, `units` of x and force."""
    gravity = {} if pendulum is None else {"gravity": {"kind": "pendulum", "value": pendulum}}
    position, force = units
    return {"structure": structure, "parameters": parameters, "units": {"position": position, "force": force}} | gravity


def motions(*names: str) -> tuple[RealPart, ...]:
    """Motions of the servo, under the load that gravity is."""
    return tuple(RealPart(f"xl330_{name}.npz", prepared=loaded_by_gravity) for name in names)


def balls(
    ball: str, mass: float, concealed: str, families: tuple[str, ...] = ("viscous",), simple: float | None = None
) -> RealCase:
    """Two drops of one ball of a mass [kg]: the first is fitted, the second held out."""
    drops = tuple(RealPart(f"{ball}.npz", number=number, prepared=from_release) for number in (0, 1))
    return RealCase(
        name=f"falling_balls/{ball}",
        fitted=drops[:1],
        held_out=(HeldOut("second drop", drops[1:]),),
        model={"structure": "driven_body", "parameters": {"m": mass}, "gravity": {"kind": "constant", "value": 9.81}},
        concealed=concealed,
        families=families,
        unit="m",
        simple=simple,
    )


def _scan(name: str, file: str, simple: float | None = None) -> RealCase:
    """One scan of a ball probe over an organ of silicone: a level surface and a rough guess of its stiffness."""
    return RealCase(
        name=f"dvrk_palpation/{name}",
        fitted=(RealPart(file),),
        model=_model("surface_contact", k=400.0, b=1.0),
        concealed="the shape of the surface, and friction between it and the probe",
        families=("geometry", "dry_friction", "contact_stiffness"),
        unit="mN",
        simple=simple,
    )


def reaching(person: str, concealed: str, families: tuple[str, ...] = ("timing",)) -> RealCase:
    """A field of 6 N s/m, felt by one person in single reaches: recordings 5 to 30 of the file are those with it."""
    fitted, unseen = (
        tuple(RealPart(f"{person}.npz", number=n) for n in some) for some in (range(6, 16), range(16, 30))
    )
    return RealCase(
        name=f"haptic_force_field/{person}",
        fitted=fitted,
        held_out=(HeldOut("later reaches", unseen),),
        model=_model("kelvin_voigt", k=0.0, b=6.0),
        concealed=concealed,
        families=families,
        unit="mN",
    )


def spindle_to_jaw(file: str) -> RealPart:
    """The surgical grasper as a transmission."""
    return RealPart(file, columns={"time": "t_raw", "input": "q_back_rad", "output": "q_front_rad"})


CASES: Final = (
    # Mass and viscous friction as published (Janot, Gautier and Brunot 2019), its Coulomb friction and offset left out.
    RealCase(
        name="emps",
        fitted=(RealPart("train.npz"),),
        held_out=(
            HeldOut("pulses", (RealPart("test_pulses.npz"),), Published(0.452, f"a neural model, in {_BASELINES}")),
        ),
        model=_model("driven_body", m=95.11, b=203.5),
        concealed="Coulomb friction with an offset or an asymmetry; viscous friction that depends on the direction",
        families=("dry_friction", "viscous", "body_force"),
        unit="mm",
    ),
    # Values of a linear least-squares fit to the first 10 s, where the amplitude is small. The multisine comes in ten
    # realisations of 14.2 s with a quiet gap between them: the stretches begin at the end of a gap, where the circuit
    # has come to rest.
    RealCase(
        name="silverbox",
        fitted=(RealPart("snls80.npz", seconds=(66.4953, 123.456)),),
        held_out=(
            HeldOut(
                "multisines", (RealPart("snls80.npz", seconds=(123.456, 208.8)),), Published(0.36, _BEST_SILVERBOX)
            ),
            HeldOut(
                "growing amplitude", (RealPart("snls80.npz", seconds=(0.0, 65.536)),), Published(1.4, _BEST_SILVERBOX)
            ),
        ),
        model=_model("driven_body", units=("V", "V"), m=5.18e-6, b=2.11e-4, k=0.955),
        concealed="cubic stiffness; a bias of the input",
        families=("contact_stiffness", "body_force"),
        unit="mV",
    ),
    # Mass and length of the pendulum as recorded beside the data (0.49 kg, 0.1 m: 0.4807 N m); gain, inertia and
    # Coulomb-viscous friction fitted free-running. Where the motor is let go (lift_and_drop) its braking by induced
    # voltage, a part of b, goes too: those files are another system and left out.
    RealCase(
        name="bam_servo",
        fitted=motions("kp100_sin_time_square", "kp400_sin_sin", "kp400_up_and_down"),
        held_out=(
            HeldOut("other motions and gains", motions("kp100_sin_sin", "kp100_up_and_down", "kp400_sin_time_square")),
        ),
        model=_model("driven_body", pendulum=0.4807, units=_TURNS, m=0.00866, b=0.0649, Fc=0.0473, gain=0.0883),
        concealed="friction of the gears that grows with the load, and the Stribeck effect (BAM's models m2 to m6)",
        families=("dry_friction",),
        unit="mrad",
    ),
    # Spring and damper by least squares on the file that is fitted.
    RealCase(
        name="mr_damper",
        fitted=(RealPart("10mm1Hz1A.npz"),),
        held_out=(HeldOut("25 mm, 0.5 Hz", (RealPart("25mm0x5Hz1A.npz"),)),),
        model=_model("kelvin_voigt", k=17830.0, b=27580.0),
        concealed="the magnetised fluid's yield force: hysteresis or friction",
        families=("dry_friction", "contact_loss"),
        unit="N",
    ),
    balls("orange_whiffle_ball", 0.0425, "drag"),
    balls("whiffle_ball_1", 0.0283, "drag"),
    balls("yellow_whiffle_ball", 0.0425, "drag"),
    balls("tennis_ball", 0.0567, "drag", simple=0.0128),
    balls("baseball", 0.1417, "drag, too small to be seen: it cannot be told"),
    balls("golf_ball", 0.0459, "drag, too small to be seen: it cannot be told"),
    balls("bowling_ball", 2.296, "nothing that could be seen", (), simple=0.017),
    _scan("pressed", "ContPalpRAL18T1.npz", simple=0.318),
    _scan("slid", "Hamlyn_Zone2_T1.npz"),
    _scan("wrist_fixed", "zone1_wrist_fixed.npz"),
    _scan("wrist_moving", "zone3_adp_wrist_cdp.npz"),
    # Inertia and viscous friction of the current, and gravity, by least squares over the smoothed motion.
    RealCase(
        name="ur10e_jointwise",
        fitted=(RealPart("joint_2.npz", prepared=from_horizontal),),
        model=_model("driven_body", pendulum=10.3, units=("rad", "A"), m=1.9, b=4.2),
        concealed="dry friction (Coulomb, 1.3 A)",
        families=("dry_friction",),
        unit="mrad",
        simple=0.041,
    ),
    # Small swings: their period, 1.089 s, and the decay of their amplitude.
    RealCase(
        name="carter_pendulum",
        fitted=(RealPart("cdip_pend_data.npz", seconds=(65.0, 120.0)),),
        model=_model("driven_body", pendulum=33.3, units=_TURNS, m=1.0, b=0.08),
        concealed="dry friction of the bearing (Coulomb or Dahl)",
        families=("dry_friction",),
        unit="mrad",
        simple=0.0068,
    ),
    # Inertia and viscous friction as stated beside the data.
    RealCase(
        name="hsm150_motor",
        fitted=(RealPart("idf_pos_0.06_1.npz"),),
        held_out=(HeldOut("second step", (RealPart("idf_pos_0.06_2.npz"),)),),
        model=_model("driven_body", units=_TURNS, m=0.00012, b=7.03e-5),
        concealed="Coulomb friction or a constant force: one direction cannot tell",
        families=("dry_friction", "body_force"),
        unit="rad",
        simple=0.006,
    ),
    # Inertia and viscous friction of the current by least squares over the smoothed motion.
    RealCase(
        name="kinova_gen3_joint7",
        fitted=tuple(RealPart(f"v_{speed}.npz") for speed in ("0.05", "0.10", "0.50", "0.90", "1.50")),
        model=_model("driven_body", units=_TURNS, m=0.017, b=0.255),
        concealed="Stribeck friction (or dry friction)",
        families=("dry_friction",),
        unit="mrad",
    ),
    # Spring and damper by least squares on what is fitted, each; force on the probe.
    RealCase(
        name="pork_indentation",
        fitted=(RealPart("230331_FF1_1A.npz"),),
        held_out=(HeldOut("next site", (RealPart("230331_FF1_1B.npz"),)),),
        model=_model("kelvin_voigt", k=120.5, b=41.6),
        concealed="relaxation and nonlinear stiffness",
        families=("contact_loss", "contact_stiffness"),
        unit="mN",
        simple=0.173,
    ),
    RealCase(
        name="brfd_friction_damper",
        fitted=(RealPart("0.5Hz_30lb_1in.npz"),),
        held_out=(HeldOut("1.5 inch", (RealPart("0.5Hz_30lb_1.5in.npz"),)),),
        model=_model("kelvin_voigt", k=2.85e5, b=1.41e5),
        concealed="dry friction with play",
        families=("dry_friction",),
        unit="N",
    ),
    # A strip that is not pulled has no force: a spring without an offset, as the simple fit is.
    RealCase(
        name="silicone_tensile",
        fitted=(RealPart("Ecoflex_00-30.npz"),),
        model=_model("kelvin_voigt", k=21.35),
        concealed="nonlinear stiffness: it hardens",
        families=("contact_stiffness",),
        unit="N",
        simple=0.006,
    ),
    RealCase(
        name="davinci_tool",
        fitted=(RealPart("44.npz"),),
        held_out=(HeldOut("jaw loaded less", (RealPart("40.npz"),)),),
        model=_model("kelvin_voigt", units=_TURNS, k=0.0716, b=0.0385, F0=0.0918),
        concealed="dry friction that grows with the load",
        families=("dry_friction",),
        unit="mN m",
        simple=0.101,
    ),
    # Ratio and offset by least squares on the file that is fitted.
    RealCase(
        name="davinci_tool/drive_train",
        fitted=(spindle_to_jaw("44.npz"),),
        held_out=(HeldOut("jaw loaded less", (spindle_to_jaw("40.npz"),)),),
        model=_model("transmission", units=("rad", "rad"), ratio=-0.8698, offset=1.2094),
        concealed="play or dry friction of its cables: so slow a motion cannot tell which",
        families=("drive_train", "dry_friction"),
        unit="mrad",
    ),
    reaching("D70_person01", "a delay of 70 ms"),
    reaching("ND_person01", "nothing", ()),
)


def real_cases(directory: str | Path, only: Collection[str] = (), cases: Sequence[RealCase] = CASES) -> list[RealCase]:
    """The cases of some data sets, or all, once it is known that the folder of every one of them is there.

    Args:
        directory: holds the folders of the data sets (`MMT_RECORDINGS` usually names it).
        only: folders of data sets; all unless given.
        cases: of which they are.

    Raises:
        BadInput: a folder is missing, or no case is about one that is asked for; it says which.
    """
    known = {case.folder for case in CASES} | {case.folder for case in ARMS}
    for name in only:
        if name not in known:
            raise BadInput("--only", found=repr(name), expected=f"one of {', '.join(sorted(known))}")
    return _chosen(cases, directory, only)


def real_arms(directory: str | Path, only: Collection[str] = ()) -> list[ArmCase]:
    """The same of robot arms, whose recordings are logs of their joints.

    Args:
        directory: holds the folders of the data sets.
        only: folders of data sets; all unless given.

    Raises:
        BadInput: a folder is missing; it says which.
    """
    return _chosen(ARMS, directory, only)


def _chosen(cases: Sequence[Kind], directory: str | Path, only: Collection[str]) -> list[Kind]:
    chosen = [case for case in cases if not only or case.folder in only]
    for case in chosen:
        case.path(directory)
    return chosen


def without_a_case(directory: str | Path) -> list[str]:
    """Folders of data sets that no case is about."""
    folders = {path.name for path in Path(directory).iterdir() if path.is_dir()}
    return sorted(folders - {case.folder for case in (*CASES, *ARMS)})
