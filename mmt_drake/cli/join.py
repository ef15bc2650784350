"""`mmt-drake join`: one recording of the two sides of a run on two machines.

examples:
  mmt-drake join o.mcap t.mcap
  mmt-drake join o.mcap t.mcap --out whole.mcap
  mmt-drake join o.mcap t.mcap --json

Each side of `mmt-drake run --side` records what it has, by its own clock. The rows are the telerobot's; hand, rendered
force and what else the operator alone has stand beside them, at the same instants. How the two clocks stand is found
from the packets' time stamps in both files, and told with its uncertainty. Of packets one can never tell how much of a
round trip was the way there: what is quicker one way than the other stays within that uncertainty.

At the end stands the summary of a run: the rendered force against the measured one, lags, energy. The result is a
recording as any other: `mmt-drake view`, `diagnose`, `convert` take it.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mmt_drake.cli.output import add_json, print_json, say
from mmt_drake.errors import BadInput

if TYPE_CHECKING:
    from mmt_drake.recording.two_recordings import JoinedSides


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("first", metavar="A.mcap", help="the recording of one side")
    parser.add_argument("second", metavar="B.mcap", help="that of the other; the order does not matter")
    text = "where to write: .mcap, .csv or .npz (default: joined.mcap)"
    parser.add_argument("--out", metavar="C.mcap", default="joined.mcap", help=text)
    add_json(parser)


def main(arguments: argparse.Namespace) -> int:
    """Join two recordings."""
    from mmt_drake.cli.run_summary import RunScores, further
    from mmt_drake.recording import load, save
    from mmt_drake.recording.files import check_target
    from mmt_drake.recording.two_recordings import join

    out = Path(arguments.out)
    check_target(out)
    for name in (arguments.first, arguments.second):
        if out.exists() and Path(name).exists() and out.samefile(name):
            raise BadInput("--out", found=f"{name}, which is to be joined", expected="another file")
    joined = join(load(arguments.first, forces=False), load(arguments.second, forces=False))
    save(joined.recording, out)
    scores = RunScores.of(joined.recording)
    more = further(joined.recording)
    if arguments.json:
        data: dict[str, Any] = clock_data(joined) | scores.to_json() | {"recording": str(out)}
        print_json(data | {name: figure.data for name, figure in more.items()})
    else:
        lines = [*clock_lines(joined), *scores.lines(), *(figure.line for figure in more.values())]
        say("\n".join([*lines, f"recording: {out}"]))
    return 0


def clock_lines(joined: JoinedSides) -> list[str]:
    """How the clocks stand, for a terminal."""
    clocks, rows = joined.clocks, len(joined.recording)
    way = "ahead of" if clocks.offset >= 0.0 else "behind"
    drift = f", drift {clocks.drift * 1e6:+.1f} us/s" if clocks.drift_told else ""
    least, most = clocks.least_drift * 1e6, clocks.most_drift * 1e6
    told = f" (between {least:+.1f} and {most:+.1f} us/s)"
    left = f"; {joined.left_out} rows left out, of which the operator has none" if joined.left_out else ""
    return [
        f"joined: {rows} rows, {joined.recording.time[-1] - joined.recording.time[0]:.3f} s{left}",
        f"clocks: the telerobot's is {abs(clocks.offset):.6f} s {way} the operator's, within "
        f"{clocks.uncertainty * 1e3:.3f} ms{drift or ', no drift that could be told'}{told}",
        f"delay from hand to probe: {joined.delay_s * 1e3:.2f} ms",
    ]


def clock_data(joined: JoinedSides) -> dict[str, Any]:
    """The same as data."""
    clocks = joined.clocks
    return {
        "rows": len(joined.recording),
        "rows_left_out": joined.left_out,
        "clock_offset_s": clocks.offset,
        "clock_uncertainty_s": clocks.uncertainty,
        "clock_drift": clocks.drift if clocks.drift_told else None,
        "clock_drift_bounds": [clocks.least_drift, clocks.most_drift],
        "delay_s": joined.delay_s,
    }
