"""`python -m diagrams.experiments.cloud`: contact detection on a measured cloud."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from diagrams.experiments.cloud.plan import Plan
from diagrams.experiments.cloud.report import document, table, write
from diagrams.experiments.cloud.run import run
from mmt_drake.cli.output import add_json, console, on_terminal, print_json
from mmt_drake.errors import MmtError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment; 0, or 2 with one line on standard error where something handed in is no good."""
    parser = argparse.ArgumentParser(prog="python -m diagrams.experiments.cloud", description=__doc__)
    parser.add_argument("--out", default="out/cloud", help="folder for table and figure")
    parser.add_argument("--touches", type=int, default=Plan.touches, help="how often the hand comes down")
    parser.add_argument("--noise", type=float, nargs="+", default=Plan.noise, help="of the camera; 1: a stereo camera")
    parser.add_argument("--voxel", type=float, nargs="+", default=Plan.voxel, help="edges of the voxel filter [m]")
    parser.add_argument("--alpha", type=float, default=Plan.alpha, help="temporal filter, weight of a new frame")
    parser.add_argument("--seed", type=int, default=Plan.seed, help="of hand and camera")
    add_json(parser)
    given = parser.parse_args(arguments)
    try:
        noise, voxel = tuple(given.noise), tuple(given.voxel)
        plan = Plan(touches=given.touches, noise=noise, voxel=voxel, alpha=given.alpha, seed=given.seed)
        progress = (lambda done: print(f"\r{done:4.0%}", end="", file=sys.stderr)) if sys.stderr.isatty() else None
        result = run(plan, progress)
        written = write(result, given.out)
    except MmtError as error:
        print(error, file=sys.stderr)
        return 2
    if given.json:
        print_json(document(result))
    else:
        console().print(on_terminal(table(result)))
        console().print(*map(str, written), sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
