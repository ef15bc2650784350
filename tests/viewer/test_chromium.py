"""In a real browser: the scene's things are there and move, the charts draw, a slider moves the probe."""

import json
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import urlsplit

import numpy as np
import pytest
from chromium import PATIENCE, Chromium
from pydrake.systems.analysis import Simulator

from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.viewer.viewer import Viewer

THINGS = (
    "table", "object/box", "cloud", "hand/tip", "probe/tip", "proxy/r1", "proxy/r2", "proxy/r3", "normal/shaft",
    "force/measured/head", "force/rendered/head",
)  # fmt: skip
NODE = """
  var node = (path) => path.split("/").reduce((at, part) => at?.children[part], viewer.scene_tree);
"""
RENDERED = (0xD5, 0x5E, 0x00)  # of a chart's line


def test_scene_charts_and_sliders_in_chromium(browser: Chromium, viewer: Viewer) -> None:
    page = "http://" + urlsplit(viewer.url).netloc
    station = build_station(load_scenario("setup1", ["operator=!Interactive {}"]), meshcat=viewer)
    simulator = Simulator(station.diagram)

    def run_on(seconds: float = 0.1) -> None:
        simulator.AdvanceTo(simulator.get_context().get_time() + seconds)

    run_on()
    browser.open(viewer.url)
    here = json.dumps([f"station/{thing}/<object>" for thing in THINGS])
    browser.wait_for(f"{NODE} {here}.every(node)", page, run_on)

    # The mouse takes the sliders: down onto the object and, once it rests there, along it, which tells its parameters.
    for name, share, value in (("hand z [m]", 0.05, -0.007), ("hand y [m]", 0.75, 0.05)):
        place = f"""(() => {{
            const at = sliders[{json.dumps(name)}]?.input.getBoundingClientRect();
            return at && [at.left + {share} * at.width, at.top + at.height / 2];
        }})()"""

        def click(place: str = place) -> None:
            browser.click(*browser.wait_for(place, page))
            run_on()

        there = f"Math.abs(sliders[{json.dumps(name)}].input.valueAsNumber - {value}) < 0.003"
        browser.wait_for(there, page, click)
        deadline = time.monotonic() + PATIENCE
        while abs(viewer.hear()[name] - value) > 0.003 and time.monotonic() < deadline:
            time.sleep(0.01)
        run_on(1.0)
    measurement = station.diagram.GetOutputPort("measurement").Eval(simulator.get_context())
    assert measurement[1] == pytest.approx(0.05, abs=0.004) and measurement[2] == pytest.approx(-0.007, abs=0.002)
    assert measurement[7] < -0.03 and measurement[8] > 2.0  # [N] it has dragged the object along, and presses

    # What the browser shows of it is what the station measures.
    at = f'{NODE} {{ const p = node("station/probe").object.position; [p.x, p.y, p.z] }}'
    near = f'{NODE} node("station/probe").object.position.y > 0.04'
    browser.wait_for(near, page, run_on)
    measurement = station.diagram.GetOutputPort("measurement").Eval(simulator.get_context())
    np.testing.assert_allclose(browser.evaluate(at, page), measurement[:3], atol=2e-3)
    assert browser.evaluate(f'{NODE} node("station/normal").object.visible', page)

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
    assert {urlsplit(url).hostname for url in fetched} == {"127.0.0.1"}

    browser.kill()  # the run does not mind
    run_on(0.5)


ATTACK = """<!DOCTYPE html><title>foreign</title><script>
  const done = [], body = JSON.stringify({name: "hand x [m]", value: 0.08, type: "slider"});
  const open = (socket) => new Promise((end) => { socket.onopen = () => end("open"); socket.onerror = () => end(0); });
  const heard = (url) => new Promise((end) => {
    const events = new EventSource(url);
    events.onmessage = () => end("heard");
    events.onerror = () => { events.close(); end(0); };
  });
  (async () => {
    for (const place of PLACES) {
      for (const mode of ["cors", "no-cors"]) {
        await fetch(place + "sliders", {method: "POST", mode, body}).then((answer) => done.push(answer.ok), () => {});
        await fetch(place, {mode}).then((answer) => done.push(answer.ok), () => {});
      }
      done.push(await heard(place + "events"), await open(new WebSocket(place.replace("http", "ws"))));
    }
    window.all = true;
  })();
</script>"""


def test_a_foreign_page_moves_no_hand_and_sees_nothing_even_if_it_knows_the_token(
    browser: Chromium, viewer: Viewer
) -> None:
    viewer.add_slider("hand x [m]", -0.1, 0.1, 0.0005, 0.0)
    viewer.flush()
    at = urlsplit(viewer.url)
    places = [viewer.url, f"http://localhost:{at.port}{at.path}", f"http://localhost:{at.port}/"]

    class Foreign(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.end_headers()
            self.wfile.write(ATTACK.replace("PLACES", json.dumps(places)).encode())

    with ThreadingHTTPServer(("127.0.0.1", 0), Foreign) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        here = f"http://localhost:{server.server_port}"
        browser.open(here)
        browser.wait_for("window.all", here)
        assert not any(browser.evaluate("done", here))
        server.shutdown()
    assert viewer.hear() == {"hand x [m]": 0.0}
    viewer.close()
    assert viewer.refused["foreign origin"] >= 6
