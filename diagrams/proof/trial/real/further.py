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


def _material(of: str, file: str, k: float, b: float, **more: float) -> RealCase:
    return _alone(of, file.removesuffix(".npz"), RealPart(file), k=k, b=b, **more)


FURTHER: Final = (
    _material("mr_damper", "10mm1Hz0A.npz", 1360.0, 3415.0),
    _material("mr_damper", "10mm1Hz0x5A.npz", 7848.0, 17000.0),
    _material("mr_damper", "25mm0x5Hz0A.npz", 982.4, 2906.0),
    _material("mr_damper", "25mm0x5Hz0x5A.npz", 2844.0, 13570.0),
    _material("mr_damper", "25mm0x5Hz1A.npz", 5424.0, 22690.0),
    _material("brfd_friction_damper", "0.5Hz_0lb_1in.npz", 50930.0, 33270.0),
    _material("brfd_friction_damper", "0.5Hz_30lb_0.5in.npz", 707600.0, 220700.0),
    _material("brfd_friction_damper", "0.5Hz_30lb_1.5in.npz", 177500.0, 109300.0),
    _material("pork_indentation", "230331_FF1_1B.npz", 153.5, 107.9),
    _material("pork_indentation", "230331_FF1_1C.npz", 135.5, 102.0),
    _material("pork_indentation", "230331_FF1_1D.npz", 148.4, 104.2),
    _material("pork_indentation", "230331_FF1_1E.npz", 135.5, 79.21),
    _material("pork_indentation", "230331_FF1_1F.npz", 116.1, 35.32),
    _material("davinci_tool", "40.npz", 0.0546, 0.028, F0=0.0304),
    _alone("davinci_tool/drive_train", "drive_train_40", spindle_to_jaw("40.npz")),
    balls("blue_basketball", 0.5103, "drag"),
    balls("green_basketball", 0.4536, "drag"),
    reaching("D70_person02", "a delay of 70 ms"),
    reaching("D70_person03", "a delay of 70 ms"),
    reaching("ND_person02", "nothing"),
    reaching("ND_person03", "nothing"),
    _alone("bam_servo", "kp100_sin_sin", *motions("kp100_sin_sin")),
    _alone("bam_servo", "kp100_up_and_down", *motions("kp100_up_and_down")),
    _alone("bam_servo", "kp400_sin_time_square", *motions("kp400_sin_time_square")),
    _alone("hsm150_motor", "second_step", RealPart("idf_pos_0.06_2.npz")),
    _alone("silverbox", "later_multisines", RealPart("snls80.npz", seconds=(137.7, 180.0))),
    _alone("silverbox", "growing_amplitude", RealPart("snls80.npz", seconds=(20.0, 65.5))),
    _alone("emps", "pulses", RealPart("test_pulses.npz")),
)
