"""The cases: one declaration per data set (two where it shows two things). Figures in SI units unless said.

Nominal values are those a user would have: published by the owners of the data, from a data sheet, or fitted to the
structure that is handed in.
"""

from collections.abc import Collection
from pathlib import Path
from typing import Final

from mmt_drake.diagrams.trial.real.case import HeldOut, Published, RealCase, RealPart
from mmt_drake.diagrams.trial.real.preparation import (
    from_horizontal,
    from_release,
    loaded_by_gravity,
    pressed_into_the_surface,
    slid_along_y,
)
from mmt_drake.errors import BadInput

_BASELINES = "Champneys et al. 2024, Baseline Results for Selected Nonlinear System Identification Benchmarks"
_BEST_SILVERBOX = "best result collected for the Silverbox on nonlinearbenchmark.org"
_NOBODY = None

# Mass and viscous friction as published (Janot, Gautier and Brunot 2019), its Coulomb friction and offset left out.
EMPS: Final = RealCase(
    name="emps",
    folder="emps",
    fitted=(RealPart("train.npz"),),
    held_out=(HeldOut("pulses", (RealPart("test_pulses.npz"),), Published(0.452, f"a neural model, in {_BASELINES}")),),
    model={"structure": "driven_body", "parameters": {"m": 95.11, "b": 203.5}},
    concealed="Coulomb friction with an offset or an asymmetry; viscous friction that depends on the direction",
    unit="mm",
    per_si=1e3,
)

# Values of a linear least-squares fit to the first 10 s, where the amplitude is small. The multisine comes in ten
# realisations of 14.2 s with a quiet gap between them: the stretches begin at the end of a gap, where the circuit has
# come to rest.
SILVERBOX: Final = RealCase(
    name="silverbox",
    folder="silverbox",
    fitted=(RealPart("snls80.npz", seconds=(66.4953, 123.456)),),
    held_out=(
        HeldOut("multisines", (RealPart("snls80.npz", seconds=(123.456, 208.8)),), Published(0.36, _BEST_SILVERBOX)),
        HeldOut("growing amplitude", (RealPart("snls80.npz", seconds=(0.0, 65.536)),), Published(1.4, _BEST_SILVERBOX)),
    ),
    model={"structure": "driven_body", "parameters": {"m": 5.18e-6, "b": 2.11e-4, "k": 0.955}},
    concealed="cubic stiffness; a bias of the input",
    unit="mV",
    per_si=1e3,
)


def _motions(*names: str) -> tuple[RealPart, ...]:
    return tuple(RealPart(f"xl330_{name}.npz", prepared=loaded_by_gravity) for name in names)


# Mass and length of the pendulum as recorded beside the data (0.49 kg, 0.1 m: 0.4807 N m); gain, inertia and
# Coulomb-viscous friction fitted free-running. Where the motor is let go (lift_and_drop) its braking by induced
# voltage, a part of b, goes too: those files are another system and left out.
BAM_SERVO: Final = RealCase(
    name="bam_servo",
    folder="bam_servo",
    fitted=_motions("kp100_sin_time_square", "kp400_sin_sin", "kp400_up_and_down"),
    held_out=(
        HeldOut(
            "other motions and gains", _motions("kp100_sin_sin", "kp100_up_and_down", "kp400_sin_time_square"), _NOBODY
        ),
    ),
    model={
        "structure": "driven_body",
        "parameters": {"m": 0.00866, "b": 0.0649, "Fc": 0.0473, "gain": 0.0883},
        "gravity": {"kind": "pendulum", "value": 0.4807},
    },
    concealed="friction of the gears that grows with the load, and the Stribeck effect (BAM's models m2 to m6)",
    unit="mrad",
    per_si=1e3,
)

# Spring and damper by least squares on the file that is fitted.
MR_DAMPER: Final = RealCase(
    name="mr_damper",
    folder="mr_damper",
    fitted=(RealPart("10mm1Hz1A.npz"),),
    held_out=(HeldOut("25 mm, 0.5 Hz", (RealPart("25mm0x5Hz1A.npz"),), _NOBODY),),
    model={"structure": "kelvin_voigt", "parameters": {"k": 17830.0, "b": 27580.0}},
    concealed="the magnetised fluid's yield force: hysteresis or friction",
    unit="N",
)


def _balls(ball: str, mass: float, concealed: str) -> RealCase:
    """Two drops of one ball of a mass [kg]: the first is fitted, the second held out."""
    drops = tuple(RealPart(f"{ball}.npz", number=number, prepared=from_release) for number in (0, 1))
    return RealCase(
        name=f"falling_balls/{ball}",
        folder="falling_balls",
        fitted=drops[:1],
        held_out=(HeldOut("second drop", drops[1:], _NOBODY),),
        model={"structure": "driven_body", "parameters": {"m": mass}, "gravity": {"kind": "constant", "value": 9.81}},
        concealed=concealed,
        unit="m",
    )


BALLS: Final = (
    _balls("orange_whiffle_ball", 0.0425, "drag"),
    _balls("whiffle_ball_1", 0.0283, "drag"),
    _balls("yellow_whiffle_ball", 0.0425, "drag"),
    _balls("tennis_ball", 0.0567, "drag"),
    _balls("baseball", 0.1417, "drag, too small to be seen: it cannot be told"),
    _balls("golf_ball", 0.0459, "drag, too small to be seen: it cannot be told"),
    _balls("bowling_ball", 2.296, "nothing that could be seen"),
)

# Spring and damper by least squares on the stretch that is fitted, once the height of the surface is taken off.
PALPATION_PRESSED: Final = RealCase(
    name="dvrk_palpation/pressed",
    folder="dvrk_palpation",
    fitted=(RealPart("ContPalpRAL18T1.npz", seconds=(20.0, 200.0), prepared=pressed_into_the_surface),),
    held_out=(
        HeldOut(
            "rest of the scan",
            (RealPart("ContPalpRAL18T1.npz", seconds=(200.0, 390.0), prepared=pressed_into_the_surface),),
            _NOBODY,
        ),
    ),
    model={"structure": "kelvin_voigt", "parameters": {"k": 438.6, "b": 4.29, "F0": 1.198}},
    concealed="whatever the silicone does beyond a spring and a damper",
    unit="mN",
    per_si=1e3,
)

# Spring and damper by least squares on the stretch that is fitted.
PALPATION_SLID: Final = RealCase(
    name="dvrk_palpation/slid",
    folder="dvrk_palpation",
    fitted=(RealPart("Hamlyn_Zone2_T1.npz", seconds=(0.0, 180.0), prepared=slid_along_y),),
    held_out=(
        HeldOut(
            "rest of the scan",
            (RealPart("Hamlyn_Zone2_T1.npz", seconds=(180.0, 316.0), prepared=slid_along_y),),
            _NOBODY,
        ),
    ),
    model={"structure": "kelvin_voigt", "parameters": {"k": 0.893, "b": 23.2, "F0": 0.0407}},
    concealed="friction between the probe and the organ",
    unit="mN",
    per_si=1e3,
)

# Inertia and viscous friction of the current, and gravity, by least squares over the smoothed motion.
UR10E: Final = RealCase(
    name="ur10e_jointwise",
    folder="ur10e_jointwise",
    fitted=(RealPart("joint_2.npz", prepared=from_horizontal),),
    held_out=(),
    model={
        "structure": "driven_body",
        "parameters": {"m": 1.9, "b": 4.2},
        "gravity": {"kind": "pendulum", "value": 10.3},
    },
    concealed="dry friction (Coulomb, 1.3 A)",
    unit="mrad",
    per_si=1e3,
    simple=0.041,
)

# Small swings: their period, 1.089 s, and the decay of their amplitude.
PENDULUM: Final = RealCase(
    name="carter_pendulum",
    folder="carter_pendulum",
    fitted=(RealPart("cdip_pend_data.npz", seconds=(65.0, 120.0)),),
    held_out=(),
    model={
        "structure": "driven_body",
        "parameters": {"m": 1.0, "b": 0.08},
        "gravity": {"kind": "pendulum", "value": 33.3},
    },
    concealed="dry friction of the bearing (Coulomb or Dahl)",
    unit="mrad",
    per_si=1e3,
    simple=0.0068,
)

# Inertia and viscous friction as told beside the data.
HSM150: Final = RealCase(
    name="hsm150_motor",
    folder="hsm150_motor",
    fitted=(RealPart("idf_pos_0.06_1.npz"),),
    held_out=(HeldOut("second step", (RealPart("idf_pos_0.06_2.npz"),), _NOBODY),),
    model={"structure": "driven_body", "parameters": {"m": 0.00012, "b": 7.03e-5}},
    concealed="Coulomb friction or a constant force: one direction cannot tell",
    unit="rad",
    simple=0.006,
)

# Inertia and viscous friction of the current by least squares over the smoothed motion.
KINOVA: Final = RealCase(
    name="kinova_gen3_joint7",
    folder="kinova_gen3_joint7",
    fitted=tuple(RealPart(f"v_{speed}.npz") for speed in ("0.05", "0.10", "0.50", "0.90", "1.50")),
    held_out=(),
    model={"structure": "driven_body", "parameters": {"m": 0.017, "b": 0.255}},
    concealed="Stribeck friction (or dry friction)",
    unit="mrad",
    per_si=1e3,
)

# Spring and damper by least squares on what is fitted, each; force on the probe.
PORK: Final = RealCase(
    name="pork_indentation",
    folder="pork_indentation",
    fitted=(RealPart("230331_FF1_1A.npz"),),
    held_out=(HeldOut("next site", (RealPart("230331_FF1_1B.npz"),), _NOBODY),),
    model={"structure": "kelvin_voigt", "parameters": {"k": 120.5, "b": 41.6}},
    concealed="relaxation and nonlinear stiffness",
    unit="mN",
    per_si=1e3,
    simple=0.173,
)
FRICTION_DAMPER: Final = RealCase(
    name="brfd_friction_damper",
    folder="brfd_friction_damper",
    fitted=(RealPart("0.5Hz_30lb_1in.npz"),),
    held_out=(HeldOut("1.5 inch", (RealPart("0.5Hz_30lb_1.5in.npz"),), _NOBODY),),
    model={"structure": "kelvin_voigt", "parameters": {"k": 2.85e5, "b": 1.41e5}},
    concealed="dry friction with play",
    unit="N",
)

SILICONE: Final = RealCase(
    name="silicone_tensile",
    folder="silicone_tensile",
    fitted=(RealPart("Ecoflex_00-30.npz"),),
    held_out=(),
    model={"structure": "kelvin_voigt", "parameters": {"k": 25.4, "b": 15700.0, "F0": 0.118}},
    concealed="nonlinear stiffness: it hardens",
    unit="N",
    simple=0.006,
)
DAVINCI: Final = RealCase(
    name="davinci_tool",
    folder="davinci_tool",
    fitted=(RealPart("44.npz"),),
    held_out=(HeldOut("jaw loaded less", (RealPart("40.npz"),), _NOBODY),),
    model={"structure": "kelvin_voigt", "parameters": {"k": 0.0716, "b": 0.0385, "F0": 0.0918}},
    concealed="dry friction that grows with the load",
    unit="mN m",
    per_si=1e3,
    simple=0.101,
)


def _reaching(person: str, concealed: str) -> RealCase:
    """A field of 6 N s/m, felt by one person in single reaches: the file's trials 5 to 30 are those with the field."""
    fitted, unseen = (
        tuple(RealPart(f"{person}.npz", number=n) for n in some) for some in (range(6, 16), range(16, 30))
    )
    return RealCase(
        name=f"haptic_force_field/{person}",
        folder="haptic_force_field",
        fitted=fitted,
        held_out=(HeldOut("later reaches", unseen, _NOBODY),),
        model={"structure": "kelvin_voigt", "parameters": {"k": 0.0, "b": 6.0}},
        concealed=concealed,
        unit="mN",
        per_si=1e3,
    )


LATE_FIELD: Final = _reaching("D70_person01", "a delay of 70 ms")
FIELD: Final = _reaching("ND_person01", "nothing")

CASES: Final = (
    EMPS,
    SILVERBOX,
    BAM_SERVO,
    MR_DAMPER,
    *BALLS,
    PALPATION_PRESSED,
    PALPATION_SLID,
    UR10E,
    PENDULUM,
    HSM150,
    KINOVA,
    PORK,
    FRICTION_DAMPER,
    SILICONE,
    DAVINCI,
    LATE_FIELD,
    FIELD,
)


def real_cases(directory: str | Path, only: Collection[str] = ()) -> list[RealCase]:
    """The cases of some data sets, or all, once it is known that the folder of every one of them is there.

    Args:
        directory: holds the folders of the data sets (`MMT_RECORDINGS` usually names it).
        only: folders of data sets; all unless given.

    Raises:
        BadInput: a folder is missing, or no case is about one that is asked for; it says which.
    """
    known = {case.folder for case in CASES}
    for name in only:
        if name not in known:
            raise BadInput("--only", found=repr(name), expected=f"one of {', '.join(sorted(known))}")
    cases = [case for case in CASES if not only or case.folder in only]
    for case in cases:
        case.path(directory)
    return cases


def without_a_case(directory: str | Path) -> list[str]:
    """Folders of data sets that no case is about."""
    folders = {path.name for path in Path(directory).iterdir() if path.is_dir()}
    return sorted(folders - {case.folder for case in CASES})
