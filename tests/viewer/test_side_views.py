"""Of a station split in two, each side shows what is known there."""

from collections.abc import Mapping

import numpy as np
import pytest
from packed import is_drawn, samples, transform
from pydrake.systems.analysis import Simulator

from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.two_sides import build_side
from mmt_drake.hw.link.link import Link
from mmt_drake.hw.link.options import OPERATOR, TELEROBOT, LinkSignal, Role
from mmt_drake.systems import live_view
from mmt_drake.viewer.charts import COLUMNS
from mmt_drake.viewer.viewer import Viewer

pytest.importorskip("cryptography", reason="the extra `link` is not installed")


class NobodyThere:
    """A socket on a cable that is cut."""

    def send(self, datagram: bytes) -> bool:
        return True

    def receive(self) -> bytes | None:
        return None

    def close(self) -> None:
        pass


def open_link(role: Role, signals: Mapping[Role, LinkSignal], agreed: str) -> Link:
    return Link(role, signals, bytes(32), NobodyThere(), scenario=agreed)


@pytest.mark.parametrize("switching", ["telerobot", "operator"])
@pytest.mark.parametrize(("role", "moved"), [(OPERATOR, "hand"), (TELEROBOT, "probe")])
def test_each_side_shows_what_is_known_there(
    viewer: Viewer, monkeypatch: pytest.MonkeyPatch, role: Role, moved: str, switching: str
) -> None:
    monkeypatch.setattr(live_view, "FRAME_INTERVAL", 0.0)
    with build_side(load_scenario("setup1", [f"switching={switching}"]), role, open_link, meshcat=viewer) as side:
        simulator = Simulator(side.diagram)
        simulator.AdvanceTo(0.2)
        port = "motion" if role == OPERATOR else "measurement"
        now = side.diagram.GetOutputPort(port).Eval(simulator.get_context())
        np.testing.assert_allclose(transform(viewer, f"/station/{moved}")[:3, 3], now[:3])
        assert is_drawn(viewer, "/station/cloud") == (role == TELEROBOT)
        assert is_drawn(viewer, "/station/object") == (role == TELEROBOT)
        last = dict(zip(COLUMNS, samples(viewer)[-1], strict=True))
        known = {name for name, value in last.items() if np.isfinite(value)}
        assert ("rendered_force_z" in known, "force_z" in known) == (role == OPERATOR, role == TELEROBOT)
        assert {"in_contact", "theta_stable"} <= known
