"""The options of `mmt-drake run`: all that its help needs, which so comes at once.

examples:
  mmt-drake run setup1
  mmt-drake run setup1 --operator hand.csv --record out.mcap
  mmt-drake run setup1-delay --set estimator.equations=without_d --set to_operator.jitter=0.02 --seconds 20
  mmt-drake run setup1 --operator sliders --meshcat
  mmt-drake run setup1-learning --seconds 50
  mmt-drake run setup1 --estimator my.py:MyEstimator
  mmt-drake run my_scenario.yaml --set 'operator={motion: chirp}' --seed 3 --json
  mmt-drake run setup1 --hardware --set operator_device.force=4 --set operator_device.limits.force=3
  mmt-drake run setup3 --hardware --set telerobot_device.address=172.16.0.2
  mmt-drake run setup1 --realtime --side telerobot --listen 10.0.0.2 --peer 10.0.0.1 --key link.key
  mmt-drake run setup1 --realtime --side operator --listen 10.0.0.1 --peer 10.0.0.2 --key link.key

With --operator the run lasts as long as that motion, unless --seconds or --set duration=... says otherwise.
A hand on sliders (--operator sliders, or operator: !Interactive in a scenario) needs --meshcat and always runs in real
time.

With --hardware, always in real time too, the operator's hand is on the device that `operator_device` describes: a and
Enter on standard input arms it, Enter alone is the emergency stop, r and Enter releases that. In setup3 the arm is the
one that `telerobot_device` describes: the same switches bring it into control and stop it, and it stops at the end.

Limits of devices end at bounds that no scenario can lift. What is looser than shipped is printed at the start, stands
in the recording (.mcap, .npz) and in the view, and with --hardware needs --loosened-limits.
Code that runs here: a file for --effects, --estimator and --renderer (docs/own_parts.md), and the library in the folder
that `operator_device.library` names. A scenario's file may name none (operator_device.library, estimator:
!OwnEstimator {code: my.py:MyEstimator}, renderer: !OwnRenderer) without --trust-library; --set may.
"""

import argparse

from mmt_drake.cli.options import add_effects, add_port, add_reading, add_repeated, add_trust, seconds, seed
from mmt_drake.cli.output import add_json
from mmt_drake.errors import BadInput

SLIDERS = "sliders"  # in the place of a recording's name
SIDES = ("operator", "telerobot")
WAIT = 60.0  # for the other side to be started [s]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    scenario = parser.add_argument(
        "scenario", metavar="SCENARIO", help="a YAML file, or the name of a shipped scenario"
    )
    setattr(scenario, "completer", _scenarios)  # noqa: B010  # as argcomplete wants it; argparse knows no such attribute
    text = f"replay the probe motion of a recording, put onto the table; {SLIDERS}: a hand on sliders in the browser"
    parser.add_argument("--operator", metavar="REC", help=text)
    add_reading(parser)
    parser.add_argument("--record", metavar="OUT", help="keep the recording: .mcap, .csv or .npz")
    add_repeated(parser, "--set", "KEY=VALUE", "change the scenario")
    add_effects(parser)
    for part, gives in (("estimator", "theta (10) and stable (1)"), ("renderer", "force (3)")):
        text = f"in the place of the scenario's {part} a class of your own: a Drake system with the outputs {gives}"
        parser.add_argument(f"--{part}", metavar="FILE.py:CLASS", help=text)
    parser.add_argument("--seconds", type=seconds, metavar="N", help="simulated time")
    parser.add_argument("--seed", type=seed, metavar="S", help="of noise and networks, in place of the scenario's")
    _add_devices(parser)
    parser.add_argument("--realtime", action="store_true", help="keep to the wall clock, and tell where it was missed")
    text = "real-time priority of a paced run, 1 to 99; 0: none (default: 40 where the system permits it)"
    parser.add_argument("--priority", type=int, metavar="N", help=text)
    parser.add_argument("--cpu", type=int, metavar="N", help="processor for a paced run, which nothing else should use")
    parser.add_argument("--lock-memory", action="store_true", help="keep all memory of a paced run in RAM")
    parser.add_argument("--meshcat", action="store_true", help="show the run to the browsers of this machine")
    add_port(parser)
    _add_sides(parser)
    add_json(parser)


def main(arguments: argparse.Namespace) -> int:
    """Run a scenario."""
    from mmt_drake.cli.run import run  # Drake and all

    _check_sides(arguments)
    _check_devices(arguments)
    return run(arguments)


def _scenarios(prefix: str, **_: object) -> list[str]:
    """What a shell offers for a scenario that begins so."""
    from argcomplete.completers import FilesCompleter

    from mmt_drake.diagrams.stations.shipped import shipped

    return [*(name for name in shipped() if name.startswith(prefix)), *FilesCompleter(("yaml", "yml"))(prefix)]


def _add_devices(parser: argparse.ArgumentParser) -> None:
    """Add the options of a run on devices."""
    parser.add_argument("--hardware", action="store_true", help="devices in place of what simulates them")
    text = "let the arm here follow a hand on sliders at the other side, at most 5 cm/s along each axis"
    parser.add_argument("--sliders-move-hardware", action="store_true", help=text)
    text = "on devices, too, take limits that are looser than shipped"
    parser.add_argument("--loosened-limits", action="store_true", help=text)
    add_trust(parser)


def _add_sides(parser: argparse.ArgumentParser) -> None:
    """Add the options of a run on two machines."""
    group = parser.add_argument_group("two machines (both sides with --realtime and the same scenario and key)")
    group.add_argument("--side", choices=SIDES, help="run this side alone, and talk to the other over UDP")
    group.add_argument("--peer", metavar="HOST[:PORT]", help="where the other side listens")
    text = "where this side listens (default: 127.0.0.1, this machine alone)"
    group.add_argument("--listen", metavar="HOST[:PORT]", help=text)
    group.add_argument("--key", metavar="FILE", help="the key that both sides share, readable by its owner alone")
    group.add_argument("--wait", type=seconds, metavar="N", help=f"for the other side (default: {WAIT:g} s)")
    text = "limits of the link: timeout, oldest, playout, cloud_points, cloud_interval"
    add_repeated(group, "--link", "KEY=VALUE", text)


def _check_devices(arguments: argparse.Namespace) -> None:
    """Refuse options that do not fit to devices, before anything is done.

    Raises:
        BadInput: a hand is replayed; sliders are let move what is not there, limits loosened of no device.
    """
    if arguments.sliders_move_hardware and not (arguments.hardware and arguments.side == "telerobot"):
        found, expected = "no arm that the other side moves", "--hardware --side telerobot beside it"
        raise BadInput("--sliders-move-hardware", found=found, expected=expected)
    if arguments.loosened_limits and not arguments.hardware:
        raise BadInput("--loosened-limits", found="no --hardware", expected="--hardware beside it")
    if arguments.hardware and arguments.operator is not None:
        raise BadInput("--operator", found="--hardware", expected="one of them: a person's hand follows no recording")


def _check_sides(arguments: argparse.Namespace) -> None:
    """Refuse options that do not fit together, before anything is done.

    Raises:
        BadInput: one is missing, or of no use without `--side`.
    """
    if arguments.side is None:
        for name in ("peer", "listen", "key", "wait", "link"):
            if getattr(arguments, name):
                raise BadInput(f"--{name}", found="no --side", expected=f"--side {' or '.join(SIDES)} beside it")
        return
    if not arguments.realtime:
        raise BadInput("--side", found="no --realtime", expected="--realtime: two machines share no other clock")
    for name in ("peer", "key"):
        if getattr(arguments, name) is None:
            raise BadInput("--side", found=f"no --{name}", expected=f"--{name} beside it")
