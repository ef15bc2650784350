"""Writes the picture of the live view in the docs: `python scripts/live_picture.py docs/images/live.jpg`."""

import sys
from pathlib import Path
from urllib.parse import urlsplit

from chromium import Chromium, find_chromium
from pydrake.systems.analysis import Simulator

from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.model.parameters import THETA
from mmt_drake.viewer.charts import page, station_panels
from mmt_drake.viewer.viewer import Viewer


def main(target: Path) -> None:
    """Run set-up 1 until it presses and slides, and take its picture."""
    program = find_chromium()
    if program is None:
        sys.exit("no Chromium on the path (MMT_CHROMIUM names one)")
    scenario = load_scenario("setup1-free-running")
    panels = station_panels(dict(zip(THETA, map(float, scenario.environment.object.theta()), strict=True)))
    with Viewer(page(panels=panels)) as viewer, Chromium(program, size=(1200, 680)) as browser:
        station = build_station(scenario, meshcat=viewer)
        simulator = Simulator(station.diagram)
        here = "http://" + urlsplit(viewer.url).netloc
        browser.open(viewer.url)
        browser.wait_for("samples.length > 0", here, lambda: simulator.AdvanceTo(0.5))
        browser.wait_for("'cloud' in viewer.scene_tree.children.station.children", here)
        simulator.AdvanceTo(11.2)
        browser.wait_for("samples[samples.length - 1][0] > 11", here)
        simulator.AdvanceTo(11.4)
        # It says how long nothing has come, which is how slow the machine is that takes the picture.
        browser.evaluate("document.getElementById('state').hidden = true", here)
        browser.picture(target)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
