"""In a real browser: the scene's things are there and move, the charts draw, a slider moves the probe."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from urllib.parse import urlsplit

import numpy as np
import pytest
from chromium import Chromium, find_chromium
from pydrake.systems.analysis import Simulator

from mmt_drake.diagrams.scenario import load_scenario
from mmt_drake.diagrams.station import build_station
from mmt_drake.viewer.viewer import Viewer, open_viewer

THINGS = (
    "table", "object/box", "cloud", "hand/tip", "probe/tip", "proxy/r1", "proxy/r2", "proxy/r3", "normal/shaft",
    "force/measured/head", "force/rendered/head",
)  # fmt: skip
NODE = """
  var node = (path) => path.split("/").reduce((at, part) => at?.children[part], viewer.scene_tree);
"""
RENDERED = (0xD5, 0x5E, 0x00)  # of a chart's line


@pytest.fixture
def browser() -> Iterator[Chromium]:
    program = find_chromium()
    if program is None:
        pytest.skip("no Chromium on the path (MMT_CHROMIUM names one)")
    with Chromium(program) as chromium:
        yield chromium


@pytest.fixture
def viewer() -> Iterator[Viewer]:
    with open_viewer() as opened:
        yield opened


def test_scene_charts_and_sliders_in_chromium(browser: Chromium, viewer: Viewer) -> None:
    scene, page = viewer.meshcat.web_url(), viewer.url
    station = build_station(load_scenario("setup1", ["operator=!Interactive {}"]), meshcat=viewer.meshcat)
    simulator = Simulator(station.diagram)

    def run_on(seconds: float = 0.1) -> None:
        simulator.AdvanceTo(simulator.get_context().get_time() + seconds)

    run_on()
    browser.open(page)
    here = json.dumps([f"station/{thing}/<object>" for thing in THINGS])
    browser.wait_for(f"{NODE} {here}.every(node)", scene, run_on)

    # The mouse takes the hand's sliders: down onto the object, then along it.
    for name, share, value in (("hand z [m]", 0.05, -0.007), ("hand y [m]", 0.75, 0.05)):
        place = f"""(() => {{
            for (const row of document.querySelectorAll(".dg li"))
              if (row.querySelector(".property-name")?.textContent === {json.dumps(name)}) {{
                const at = row.querySelector(".slider").getBoundingClientRect();
                return [at.left + {share} * at.width, at.top + at.height / 2];
              }}
        }})()"""

        def click(place: str = place) -> None:
            browser.click(*browser.wait_for(place, scene))
            run_on()

        there = f"Math.abs(viewer.gui_controllers[{json.dumps(name)}].getValue() - {value}) < 0.003"
        browser.wait_for(there, scene, click)
    deadline = time.monotonic() + 20.0
    while viewer.meshcat.GetSliderValue("hand y [m]") < 0.03 and time.monotonic() < deadline:
        time.sleep(0.01)
    run_on(1.5)
    measurement = station.diagram.GetOutputPort("measurement").Eval(simulator.get_context())
    assert measurement[1] == pytest.approx(0.05, abs=0.004) and measurement[2] == pytest.approx(-0.007, abs=0.002)
    assert measurement[7] < -0.03 and measurement[8] > 2.0  # [N] it has dragged the object along, and presses

    # What the browser shows of it is what the station measures.
    at = f'{NODE} {{ const p = node("station/probe").object.position; [p.x, p.y, p.z] }}'
    near = f'{NODE} node("station/probe").object.position.y > 0.04'
    browser.wait_for(near, scene, run_on)
    measurement = station.diagram.GetOutputPort("measurement").Eval(simulator.get_context())
    np.testing.assert_allclose(browser.evaluate(at, scene), measurement[:3], atol=2e-3)
    assert browser.evaluate(f'{NODE} node("station/normal").object.visible', scene)

    drawn = f"""(() => {{
        const canvas = charts[1].canvas, pen = canvas.getContext("2d");
        const at = pen.getImageData(0, 20, canvas.width, canvas.height - 36).data;
        let count = 0;
        for (let i = 0; i < at.length; i += 4)
          count += Math.hypot(at[i] - {RENDERED[0]}, at[i + 1] - {RENDERED[1]}, at[i + 2] - {RENDERED[2]}) < 40;
        return count > 30;
    }})()"""
    browser.wait_for(drawn, page, run_on)
    last = browser.evaluate("samples[samples.length - 1]", page)
    assert last[0] == pytest.approx(simulator.get_context().get_time(), abs=1.0)

    assert not browser.complaints
    fetched = [url for url in browser.requested if not url.startswith(("data:", "blob:"))]
    assert {urlsplit(url).hostname for url in fetched} == {"localhost"}

    browser.kill()  # the run does not mind
    run_on(0.5)
    deadline = time.monotonic() + 20.0
    while viewer.meshcat.GetNumActiveConnections() and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not viewer.meshcat.GetNumActiveConnections()
    run_on(0.5)
