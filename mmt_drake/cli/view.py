"""`mmt-drake view`: plays a recording in the live view.

examples:
  mmt-drake view out.mcap
  mmt-drake view out.mcap --truth setup1 --port 8080
  mmt-drake view contact.csv
  mmt-drake view out.mcap --foxglove layout.json

It prints the one address of the page, which this machine alone can open: the scene with arrows of force, charts, and
sliders to play, scrub and loop. It plays while somebody looks, and ends after --seconds, with Ctrl-C, or when nobody
has looked for two minutes. A recording of one axis or of a driven body has charts alone.
--foxglove writes a layout for Foxglove and plays nothing: open the .mcap there and import the layout; its panels show
scene, forces, estimate and contact.
--truth draws the parameters of a scenario's object beside those that were estimated.
"""

import argparse
import time
from pathlib import Path

from mmt_drake.cli.options import add_port, add_reading, count, reading, seconds
from mmt_drake.cli.output import say
from mmt_drake.errors import BadInput

_IDLE_S = 120.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("recording", metavar="REC", help="recording to be played")
    parser.add_argument(
        "--number", type=count, metavar="K", help="which of the recordings in REC, where it has several"
    )
    parser.add_argument("--truth", metavar="SCENARIO", help="draw its object's parameters beside the estimate")
    parser.add_argument("--seconds", type=seconds, metavar="N", help="end after so long by the wall clock")
    text = "write a layout for Foxglove, which opens .mcap too, and play nothing"
    parser.add_argument("--foxglove", metavar="OUT.json", help=text)
    add_port(parser)
    add_reading(parser)


def main(arguments: argparse.Namespace) -> int:
    """Play a recording."""
    from mmt_drake.diagrams.stations.scenario import load_scenario
    from mmt_drake.model.parameters import THETA
    from mmt_drake.recording import load_all
    from mmt_drake.viewer.charts import page
    from mmt_drake.viewer.replay import FRAME_S, Replay, replay_panels
    from mmt_drake.viewer.viewer import Viewer

    if arguments.foxglove is not None:
        return write_layout(arguments.recording, arguments.foxglove)
    found = load_all(arguments.recording, **reading(arguments), forces=False)
    number = arguments.number or (1 if len(found) == 1 else None)
    if number is None or number > len(found):
        said = f"{len(found)} recording{'s' * (len(found) > 1)}, " + (f"no {number}" if number else "no --number")
        raise BadInput(arguments.recording, found=said, expected=f"--number 1 to {len(found)}")
    recording = found[number - 1]
    truth = None
    if arguments.truth is not None:
        theta = load_scenario(arguments.truth).environment.object.theta()
        truth = dict(zip(THETA, map(float, theta), strict=True))
    with Viewer(page(panels=replay_panels(recording, truth), replay=True), arguments.port or 0) as viewer:
        replay = Replay(viewer, recording)
        say(f"view: {viewer.url}", stderr=True)  # at once, in a pipe too
        begun = seen = time.monotonic()
        while True:
            try:
                replay.step()
            except OSError:
                raise BadInput("viewer", found="that its server has ended", expected="it to go on") from None
            now = time.monotonic()
            if viewer.looking:
                seen = now
            if arguments.seconds is not None and now - begun >= arguments.seconds:
                return 0
            if now - seen > _IDLE_S:
                say(f"view: ended, nobody has looked for {_IDLE_S:g} s", stderr=True)
                return 0
            time.sleep(FRAME_S)


def write_layout(name: str, target: str) -> int:
    """Write the layout for Foxglove, and say which of its topics a recording lacks.

    Raises:
        BadInput: the recording is no `.mcap`, or cannot be read; the layout cannot be written.
    """
    from mmt_drake.recording.atomic import replacing
    from mmt_drake.recording.files import ending_of
    from mmt_drake.recording.mcap_file import McapFile
    from mmt_drake.viewer.foxglove import layout_text, shown

    recording, layout = Path(name), Path(target)
    if ending_of(recording) != ".mcap":
        raise BadInput(
            name, found="another format", expected=".mcap, as Foxglove reads it (`mmt-drake convert` makes it)"
        )
    if layout.suffix.lower() != ".json":
        raise BadInput(target, found=f"ending {layout.suffix!r}", expected=".json")
    there = {channel.topic for channel in McapFile(recording).channels.values()}
    with replacing(layout) as temporary:
        temporary.write_text(layout_text())
    missing = sorted({topic for topic, _ in shown()} - there)
    say(f"layout: {target}" + (f"; not in {name}: {', '.join(missing)}" if missing else ""))
    return 0
