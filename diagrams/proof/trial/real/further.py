"""Further recordings of the same data sets, each diagnosed alone: no case is fitted to one of them.

Spring and damper of a material are by least squares on the recording itself; all other numbers are those of the data
set's own case.
"""

from dataclasses import replace
from typing import Final

from mmt_drake.diagrams.proof.trial.real.case import RealCase, RealPart
from mmt_drake.diagrams.proof.trial.real.data_sets import CASES, balls, motions, reaching, spindle_to_jaw

_CASES = {case.name: case for case in CASES}


def _alone(of: str, name: str, part: RealPart, **parameters: float) -> RealCase:
    """A recording in the place of those of a case, and other numbers of its model where they are said."""
    case = _CASES[of]
    model = {**case.model, "parameters": parameters or case.model["parameters"]}
    return replace(case, name=f"{case.folder}/{name}", fitted=(part,), held_out=(), simple=None, model=model)


_MATERIALS: Final = {
    "mr_damper": {
        "10mm1Hz0A": (1360.0, 3415.0),
        "10mm1Hz0x5A": (7848.0, 17000.0),
        "25mm0x5Hz0A": (982.4, 2906.0),
        "25mm0x5Hz0x5A": (2844.0, 13570.0),
        "25mm0x5Hz1A": (5424.0, 22690.0),
    },
    "brfd_friction_damper": {
        "0.5Hz_0lb_1in": (50930.0, 33270.0),
        "0.5Hz_30lb_0.5in": (707600.0, 220700.0),
        "0.5Hz_30lb_1.5in": (177500.0, 109300.0),
    },
    "pork_indentation": {
        "230331_FF1_1B": (153.5, 107.9),
        "230331_FF1_1C": (135.5, 102.0),
        "230331_FF1_1D": (148.4, 104.2),
        "230331_FF1_1E": (135.5, 79.21),
        "230331_FF1_1F": (116.1, 35.32),
    },
}
"""Data set -> file -> spring [N/m] and damper [N s/m]."""

FURTHER: Final = (
    *(
        _alone(of, file, RealPart(f"{file}.npz"), k=k, b=b)
        for of, files in _MATERIALS.items()
        for file, (k, b) in files.items()
    ),
    _alone("davinci_tool", "40", RealPart("40.npz"), k=0.0546, b=0.028, F0=0.0304),
    _alone("davinci_tool/drive_train", "drive_train_40", spindle_to_jaw("40.npz")),
    balls("blue_basketball", 0.5103, "drag"),
    balls("green_basketball", 0.4536, "drag"),
    reaching("D70_person02", "a delay of 70 ms"),
    reaching("D70_person03", "a delay of 70 ms"),
    reaching("ND_person02", "nothing", ()),
    reaching("ND_person03", "nothing", ()),
    *(
        _alone("bam_servo", motion, *motions(motion))
        for motion in ("kp100_sin_sin", "kp100_up_and_down", "kp400_sin_time_square")
    ),
    _alone("hsm150_motor", "second_step", RealPart("idf_pos_0.06_2.npz")),
    _alone("silverbox", "later_multisines", RealPart("snls80.npz", seconds=(137.7, 180.0))),
    _alone("silverbox", "growing_amplitude", RealPart("snls80.npz", seconds=(20.0, 65.5))),
    _alone("emps", "pulses", RealPart("test_pulses.npz")),
)
