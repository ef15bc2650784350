"""`mmt-drake experiment`: the thesis's experiments, as figures, tables and one page.

examples:
  mmt-drake experiment 1
  mmt-drake experiment 2 --out out/contacts
  mmt-drake experiment 3 --json
  mmt-drake experiment 1 --operator hand.csv --out out/my_hand
  mmt-drake experiment engines
  mmt-drake experiment ablation --seconds 30
  mmt-drake experiment peers --json

1 and 3: one case per way of solving eq. 30 of the thesis, and one that learns nothing for 0.5 s after each touch
(settled_0.5s); in experiment 1 also one whose parameters stand still after 5 s of contact (frozen_5s).
2: the estimators on contacts: a simulated Panda (its model is the optional extra `arm`) slides an object, and public
recordings of a robot that palpates, where MMT_RECORDINGS or ../shared/recordings is a folder; what is not there is left
out.
engines: appendix E, our renderer and other people's physics engines on both of its tables; MuJoCo, Bullet and DART are
the optional extra `engines`, and are left out where they are not installed.
ablation: what may be behind the thesis's errors, one cause at a time and the likely ones together, and which of its
figures each reproduces; its recordings take 2 GB.
estimators: the thesis's estimator and the one whose model runs freely over a window, on strokes, a chirp and hands:
errors, when parameters are found, cost; --estimator rls: one; --with my.py:MyEstimator: your own beside them.
adequacy: objects that the model has the law of, that it has not, and that change: what the estimator says of them.
late: a force that is measured late, behind a delay and a low pass: whether the estimator finds both.
coverage: how often the truth lies within two of the deviations that the free-running estimator tells.
objects: a hundred objects drawn at random; --estimator rls: the thesis's; --anisotropic: objects of two materials.
plants: the free-running estimator on plants that share no physics with it, sensors that are late, a surface elsewhere.
device: an emulated haptic device in the hand, tick by tick: its encoders, its limits, the arm behind them.
network: a play-out buffer against jitter, loss and reordering, beside constant delays.
passivity: adversaries that try to get more energy out of the shipped renderers than they put in; --count: how many.
updates: how new parameters are taken up; the jumps of the force and the energy that this makes.
peers: the model beside direct and passivity-controlled force feedback, on one motion and one network.
bands: a second model fused in at high frequencies, and where it wins.
fit: first models from recordings alone of systems drawn at random; --count: of each kind.
cloud: contact on the cloud of a simulated depth camera, against its noise and its filters; --count: contacts.
surfaces: set-up 1 on planes of any tilt, a sphere, a cylinder, a saddle, a step and a height field, slips and 400 ms.
learning: set-up 1 with a law that is not in the model: what is told in the run, and felt; --count: objects of each law.
carrying: an object that is lifted, swung and put down: force, mass, slips, and adversaries; --count: objects.
scene: set-up 4 and ten minutes of pushing its three objects: second touches, who is who, pace; --count: runs of each.
arms: models of real arms, each diagnosed on one log and held to another, where there is a folder of recordings.
arm-force: the force on the probe of a simulated Panda, from the torques of its joints, before and after its diagnosis.
--out (out/experiment1 and so on by default) receives recordings, figures and index.html.
"""

import argparse
from pathlib import Path

from rich.markup import escape

from mmt_drake.cli.interrupted import known_kept
from mmt_drake.cli.options import seconds, seed
from mmt_drake.cli.output import add_json, console, on_terminal, print_json
from mmt_drake.cli.progress import progress
from mmt_drake.diagrams.proof.experiments import MODULES, study_of
from mmt_drake.diagrams.proof.studies import Asked, Report
from mmt_drake.errors import BadInput
from mmt_drake.processors import processors

_OPTIONS = ("anisotropic", "count", "estimator", "operator", "seconds", "seed", "with_")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    text = "experiment 1 (no delay), 2 (contacts) or 3 (400 ms each way) of the thesis, or as below"
    parser.add_argument("which", choices=MODULES, help=text)
    parser.add_argument("--operator", metavar="REC", help="replay the probe motion of a recording in place of strokes")
    parser.add_argument("--out", metavar="DIR", help="folder for recordings, figures and the page")
    parser.add_argument("--seconds", type=seconds, metavar="N", help="simulated time of each case")
    parser.add_argument("--seed", type=seed, metavar="S", help="of everything random (default 0)")
    text = "of objects (default output_error); of estimators: no other"
    parser.add_argument("--estimator", choices=("output_error", "rls"), help=text)
    text = "of estimators: hold a class of your own beside the others (docs/own_parts.md)"
    parser.add_argument("--with", dest="with_", metavar="FILE.py:CLASS", help=text)
    text = "of objects (100; adequacy: 10, late: 3, coverage: 20; fit: 8), contacts (16), adversaries (2000) or runs"
    parser.add_argument("--count", type=int, metavar="N", help=text)
    parser.add_argument("--anisotropic", action="store_true", help="objects whose normal axis is of another material")
    add_json(parser)


def main(arguments: argparse.Namespace) -> int:
    """Run an experiment."""
    which = arguments.which
    study = study_of(which)
    given = {name: getattr(arguments, name) for name in _OPTIONS}
    given = {name: value for name, value in given.items() if value is not None and value is not False}
    if others := [_option(name) for name in given if name not in study.takes]:
        expected = " and ".join((", ".join(map(_option, (*study.takes, "out"))), "--json"))
        raise BadInput(f"experiment {which}", found=", ".join(others), expected=f"no option but {expected}")
    out = Path(arguments.out or f"out/{f'experiment{which}' if which.isdigit() else which}")
    asked = Asked(out, **given, jobs=processors())
    shown = progress(study.label, study.steps(asked), simulated=study.simulated)
    with known_kept(out, arguments.command_line), shown as update:
        report = study.run(asked, update)
    page = report.write(out)
    if arguments.json:
        print_json(report.document)
    else:
        _tell(report, page)
    return 0


def _option(name: str) -> str:
    """Of an attribute of `Asked`, `with_` being the one whose name Python has taken."""
    return f"--{name.rstrip('_')}"


def _tell(report: Report, page: Path) -> None:
    target = console()
    target.print(escape(report.heading))
    for table in report.tables:
        target.print()
        target.print(on_terminal(table))
    target.print()
    for sentence in report.sentences:
        target.print(f"– {escape(sentence)}")
    target.print()
    target.print(f"page: {escape(str(page))} (figures and recordings beside it)", soft_wrap=True)
