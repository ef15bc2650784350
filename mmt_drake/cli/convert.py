"""``mmt-drake convert``: any recording into any other.

examples:
  mmt-drake convert out.mcap out.csv
  mmt-drake convert lab.bag lab.mcap --topic force=/ft_sensor/wrench --topic position=/ee_pose
  mmt-drake convert tensile.csv tensile.mcap --map time=t:ms --map position=x:mm --map force=-F:N

Read: .mcap .csv .npz, ROS 1 .bag, ROS 2 .db3 and the folder of a ROS 2 bag. Written: .mcap .csv .npz.
A file with several recordings becomes several: out_1.csv, out_2.csv ...
"""

import argparse
from pathlib import Path

from mmt_drake.cli.options import Reading, add_reading, reading
from mmt_drake.cli.output import say
from mmt_drake.errors import BadInput
from mmt_drake.recording.files import check_target, load_all, save
from mmt_drake.recording.recording import Recording


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("source", metavar="IN", help="a recording in any form that can be read")
    parser.add_argument("target", metavar="OUT", help="where to write; its ending says the form")
    add_reading(parser)


def main(arguments: argparse.Namespace) -> int:
    """Convert a recording."""
    say(convert(arguments.source, arguments.target, reading(arguments)))
    return 0


def convert(source: str, target: str, how: Reading) -> str:
    """Read every recording of ``source`` and write it in the form that the ending of ``target`` names.

    A source with several recordings gives several files: ``out.csv`` becomes ``out_1.csv``,
    ``out_2.csv`` and so on.

    Args:
        source: see ``recording.load``.
        target: ``.mcap``, ``.csv`` or ``.npz``.
        how: see ``recording.load``.

    Returns:
        What was written and what is worth knowing about it, a few lines.

    Raises:
        BadInput: anything that ``load`` or ``save`` refuses; nothing is written then.
    """
    check_target(target)
    recordings = load_all(source, **how)
    path = Path(target)
    several = len(recordings) > 1
    lines = []
    names: list[Path] = []
    for number, recording in enumerate(recordings, 1):
        name = path.with_stem(f"{path.stem}_{number}") if several else path
        try:
            save(recording, name)
        except BadInput:
            for written in names:
                written.unlink()
            raise
        names.append(name)
        lines += [f"{recording.source} -> {name}: {_described(recording)}", *(f"  {note}" for note in recording.notes)]
        if path.suffix.lower() == ".csv":
            left_out = [f"{len(recording.clouds)} point clouds"] * bool(recording.clouds)
            left_out += [f"{constant} = {value:g}" for constant, value in recording.constants.items()]
            if left_out:
                lines.append(f"  not in CSV: {', '.join(left_out)}")
    return "\n".join(lines)


def _described(recording: Recording) -> str:
    duration = recording.time[-1] - recording.time[0]
    kind = recording.kind.replace("_", " ")
    return f"{kind}, {len(recording)} samples, {duration:.3f} s, {len(recording.columns)} columns beside time"
