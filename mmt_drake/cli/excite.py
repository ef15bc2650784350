"""`mmt-drake excite`: a motion that tells a robot arm's inertial numbers, within its joints' limits.

examples:
  mmt-drake excite --model arm.yaml --out motion.csv --acceleration 10
  mmt-drake excite --model arm.yaml --out motion.csv --acceleration 15 10 20 --log log.csv --seconds 30

Plans a Fourier series for each joint (Swevers et al. 1997), repeated over the length, by which the base parameters and
friction of every joint are told as well as may be. It begins and ends at rest, at a place that is printed: bring the
arm there first. OUT (.csv) has t [s], then q_0 ..., v_0 ... and a_0 ... of each joint in the order of the model, in rad
or m.

Within 0.9 of every limit of position, velocity and acceleration, and 0.75 of the effort, where the robot's file has it,
that its links ask for; checked on a grid of 1 kHz or finer. Limits come from the robot's file, or from the options; of
both the stricter holds. Few files have accelerations: 10 rad/s^2 is much for a large arm.

NOT checked: the floor, walls, cables, tools, people. Links are kept 1 cm apart where the robot's file has collision
geometry that Drake reads; what is printed says whether they are. Look at the motion first, run it slowly, stay near
the stop.

With --log it also says what a log that is there does not tell and this motion would.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from mmt_drake.cli.options import count, seconds, seed
from mmt_drake.cli.output import console, on_terminal, say
from mmt_drake.cli.progress import progress
from mmt_drake.errors import BadInput

if TYPE_CHECKING:
    from mmt_drake.arms.base_parameters import BaseParameters

_WEAKEST, _TERMS = 8, 3
_MOST_ROWS = 3e6


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("--model", required=True, metavar="ARM.yaml", help="model file of an arm")
    parser.add_argument("--out", required=True, metavar="OUT", help="where to write the motion: .csv")
    parser.add_argument("--seconds", type=seconds, default=20.0, metavar="S", help="length (default: 20)")
    parser.add_argument("--rate", type=float, default=500.0, metavar="HZ", help="rows in a second (default: 500)")
    parser.add_argument("--harmonics", type=count, default=5, metavar="N", help="of the series (default: 5)")
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="of the motions tried first (default: 0)")
    parser.add_argument("--log", metavar="LOG", help="a log of this arm, to compare with")
    for name, unit in (
        ("position", "rad or m, to either side of 0"),
        ("velocity", "rad/s"),
        ("acceleration", "rad/s^2"),
    ):
        text = f"limit of each joint, or one for all [{unit}]"
        parser.add_argument(f"--{name}", type=float, nargs="+", default=[], metavar="LIMIT", help=text)


def main(arguments: argparse.Namespace) -> int:
    """Plan a motion."""
    from mmt_drake.arms.arm_file import load_arm_model  # so that help comes at once
    from mmt_drake.arms.base_parameters import BaseStructure
    from mmt_drake.arms.believed import check_places, with_payloads
    from mmt_drake.arms.excitation import NOISE, Excitation, motion_told, period_of, write_course
    from mmt_drake.arms.joint_limits import JointLimits
    from mmt_drake.arms.joint_log import load_joint_log
    from mmt_drake.arms.plant import ArmPlant
    from mmt_drake.arms.self_collision import SelfCollision
    from mmt_drake.arms.structure import STRUCTURE, is_arm_file
    from mmt_drake.recording.atomic import beside
    from mmt_drake.typed_yaml import parse, read_text

    out, wanted = Path(arguments.out), [arguments.position, arguments.velocity, arguments.acceleration]
    if out.suffix != ".csv":
        raise BadInput(out, found=f"the ending {out.suffix!r}", expected=".csv")
    if arguments.harmonics < 2:
        raise BadInput("--harmonics", found=arguments.harmonics, expected="2 or more: one alone does not begin at rest")
    if (rows := arguments.seconds * arguments.rate) > _MOST_ROWS:
        raise BadInput("--seconds and --rate", found=f"{rows:.3g} rows", expected=f"{_MOST_ROWS:.0e} at most")
    beside(out)
    if not is_arm_file(arguments.model):
        parse(read_text(arguments.model, "a model file (YAML)"), arguments.model)  # says why it cannot be read
        raise BadInput(arguments.model, found="no model of an arm", expected=f"structure: {STRUCTURE}")
    model = load_arm_model(arguments.model)
    if not arguments.rate >= (least := 4.0 * model.band_hz):
        raise BadInput("--rate", found=f"{arguments.rate:g} Hz", expected=f"{least:g} Hz or more, for the model's band")
    arm = ArmPlant.of(model)
    check_places(arm, model)
    structure = BaseStructure.of(arm, with_payloads(arm, model).ravel())
    limits = JointLimits.of(arm, model, *wanted)
    log = (
        motion_told(structure, load_joint_log(arguments.log, model, arm.joints), model.band_hz)
        if arguments.log
        else None
    )
    period = period_of(arguments.seconds, limits, arguments.harmonics, model.band_hz)
    try:
        collision: SelfCollision | None = SelfCollision(model, arm)
        apart = "links stay 1 cm apart"
        if collision and collision.left_out:
            apart += f", but {', '.join('-'.join(pair) for pair in collision.left_out)}, which touch in every pose"
    except BadInput as error:
        collision, apart = None, f"whether links meet is NOT checked ({error.found})"
    search = Excitation(structure, limits, period, arguments.harmonics, collision)
    with progress("exciting motion", 1.0) as update:
        best = search.best(arguments.seed, update)
    course, size = search.admitted(best, arguments.seconds, arguments.rate)
    told = motion_told(structure, course, model.band_hz)
    write_course(course, out)
    places = ", ".join(f"{name} {q:.4g}" for name, q in zip(arm.joints, course.q[0], strict=True))
    smaller = "" if size == 1.0 else f"; made smaller, to {size:.2g} of its size, for efforts and links"
    say(
        f"{out}: {arguments.seconds:g} s at {arguments.rate:g} Hz, a period of {period:.4g} s{smaller}\n"
        f"begins and ends at rest at {places}\n{apart}; floor, walls and tools are not known\n"
        f"condition number of the regressor: {told.condition:.3g}"
        + (f"; of {arguments.log}: {log.condition:.3g}" if log else "")
        + (", which is better already" if log and log.condition < told.condition else "")
    )
    _tell(told, log, str(arguments.log), NOISE)
    return 0


def _tell(told: BaseParameters, log: BaseParameters | None, name: str, noise: float) -> None:
    """Print the base parameters that a motion tells worst, and what it tells that a log does not."""
    from mmt_drake.analysis.table import Table

    def shown(one: BaseParameters) -> list[float | None]:
        return [None if p.deviation is None else p.deviation / p.size for p in one.structural]

    columns = [shown(told), *([shown(log)] if log else [])]
    order = sorted(range(len(told.structural)), key=lambda i: -(columns[-1][i] or float("inf")))[:_WEAKEST]
    rows = [(told.structural[i].said(_TERMS), *(column[i] for column in columns)) for i in order]
    headers = ("base parameter", "this motion", *(["log"] if log else []))
    caption = f"Standard deviation in parts of what each may be, at noise of {noise:g} of the torque; the weakest:"
    console().print(on_terminal(Table(headers, rows, caption, digits=2)))
    if log is not None:
        known = {one.name for one in log.well_told}
        more = [one.said(_TERMS) for one in told.well_told if one.name not in known]
        say(f"told by this motion and not by {name}: {'; '.join(more) or 'no further base parameter'}")
