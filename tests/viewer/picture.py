"""Writes the picture of the live view in the docs: `python tests/viewer/picture.py docs/images/live.jpg`."""

from __future__ import annotations

import sys
from pathlib import Path

from chromium import Chromium, find_chromium
from pydrake.systems.analysis import Simulator

from mmt_drake.diagrams.scenario import load_scenario
from mmt_drake.diagrams.station import build_station
from mmt_drake.viewer.viewer import open_viewer


def main(target: Path) -> None:
    """Run set-up 1 until it presses and slides, and take its picture."""
    program = find_chromium()
    if program is None:
        sys.exit("no Chromium on the path (MMT_CHROMIUM names one)")
    with open_viewer() as viewer, Chromium(program, size=(1200, 680)) as browser:
        station = build_station(load_scenario("setup1-free-running"), meshcat=viewer.meshcat)
        simulator = Simulator(station.diagram)
        scene = viewer.meshcat.web_url()
        browser.open(viewer.url)
        browser.wait_for("samples.length > 0", viewer.url, lambda: simulator.AdvanceTo(0.5))
        browser.wait_for("'cloud' in viewer.scene_tree.children.station.children", scene)
        browser.evaluate("viewer.gui.close()", scene)
        simulator.AdvanceTo(11.2)
        browser.wait_for("samples[samples.length - 1][0] > 11", viewer.url)
        simulator.AdvanceTo(11.4)
        # It says how long nothing has come, which is how slow the machine is that takes the picture.
        browser.evaluate("document.getElementById('state').hidden = true", viewer.url)
        browser.picture(target)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
