"""`mmt-drake fit`: a first model, from recordings alone.

examples:
  mmt-drake fit contact.csv --out model.yaml
  mmt-drake fit tensile.csv --map time=t:ms --map position=x:mm --map force=-F:N --out model.yaml
  mmt-drake fit first.mcap second.mcap --axis y --out model.yaml

Several REC are recordings of the same system. The structure is what goes with the columns: of three axes of position
and force flexible_box, of one kelvin_voigt, of input and output driven_body; --structure says another, as
surface_contact for a tip that presses on a surface of unknown shape: of that k and b are guessed, not fitted.

Every number is sought over three decades, from many starts. Printed beside each is its 95 % interval, and one word:
`determined`; `of this structure` (more than noise is left, so another structure may have another value); `at most` (it
may as well be 0, or next to it); `cannot be told` (the interval is as wide as the search). A third of the recording is
held out of the fit; the error there is printed too. Ctrl-C ends it at once; the best numbers by then are left in a
file beside MODEL.yaml, MODEL.interrupted.json.
"""

import argparse
from pathlib import Path

from mmt_drake.cli.interrupted import FILE, known_kept
from mmt_drake.cli.options import add_reading, add_workers, recordings_of
from mmt_drake.cli.output import add_json, console, on_terminal, print_json
from mmt_drake.cli.progress import working
from mmt_drake.errors import BadInput


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("recordings", nargs="+", metavar="REC", help="recordings of one system")
    text = "flexible_box, kelvin_voigt, driven_body or surface_contact (default: by the columns)"
    parser.add_argument("--structure", metavar="S", help=text)
    parser.add_argument("--out", required=True, metavar="MODEL.yaml", help="where to write the model")
    add_workers(parser)
    add_reading(parser)
    add_json(parser)


def main(arguments: argparse.Namespace) -> int:
    """Fit a first model."""
    # Imported where needed, so that help comes at once.
    from mmt_drake.diagnosis.first_model import fit
    from mmt_drake.diagnosis.fit.workers import workers
    from mmt_drake.diagnosis.tell.first import first_document, numbers_table, remarks, save_first_model
    from mmt_drake.recording.atomic import beside

    out = Path(arguments.out)
    beside(out)
    kept = known_kept(out.parent, arguments.command_line, f"{out.stem}.{FILE}")
    recordings = recordings_of(arguments)
    with kept, working("fit") as show, workers(arguments.jobs, arguments.cluster) as executor:
        found = fit(recordings, arguments.structure, executor=executor, on_stage=show)
    if found.reason is not None:
        raise BadInput(recordings[0].source, found=found.reason, expected="a recording that tells a model")
    save_first_model(found, out, [Path(recording.source).name for recording in recordings])
    if arguments.json:
        print_json(first_document(found))
        return 0
    target = console()
    target.print(on_terminal(numbers_table(found)))
    for remark in remarks(found):
        target.print(remark, markup=False)
    target.print(f"written: {arguments.out} ({found.model.NAME})", markup=False, soft_wrap=True)
    return 0
