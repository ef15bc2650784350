"""A station's block diagram as a picture: operator's side, network, telerobot's side."""

from typing import Final

from matplotlib.figure import Figure

from mmt_drake.analysis.diagram_picture import Lane, block_diagram
from mmt_drake.analysis.wording import milliseconds
from mmt_drake.diagrams.stations.station import Station
from mmt_drake.diagrams.stations.table import PARTS
from mmt_drake.network.parameters import usual_delay

_LANES: Final = (Lane("operator's side"), Lane("network"), Lane("telerobot's side", 2))


def station_picture(station: Station) -> Figure:
    """Draw the systems of a station and what runs between them; its recorder is left out."""
    scenario = station.scenario
    delays = {
        name: f"delay {milliseconds(usual_delay(getattr(scenario, name), scenario.step))}"
        for name in ("to_telerobot", "to_operator")
    }
    places = {p.name: p.at for p in PARTS if p.at is not None and station.diagram.HasSubsystemNamed(p.name)}
    return block_diagram(station.diagram, places, _LANES, notes=delays, hidden=("recorder",))
