"""A station's block diagram as a picture: operator's side, network, telerobot's side."""

from __future__ import annotations

from typing import Final

from matplotlib.figure import Figure

from mmt_drake.analysis.diagram_picture import Lane, block_diagram
from mmt_drake.analysis.wording import milliseconds
from mmt_drake.diagrams.station import Station
from mmt_drake.network.parameters import usual_delay

_LANES: Final = (Lane("operator's side"), Lane("network"), Lane("telerobot's side", 2))
_PLACES: Final = {
    "operator": (0, 0),
    "operator_detector": (0, 1),
    "to_renderer": (0, 3),
    "renderer": (0, 2),
    "to_telerobot": (1, 0),
    "clouds_to_operator": (1, 1),
    "to_operator": (1, 2),
    "energy_to_telerobot": (1, 3),
    "telerobot": (2, 0),
    "detector": (2, 1),
    "environment": (3, 0),
    "estimator": (3, 2),
    "high_band": (2, 2),
}


def station_picture(station: Station) -> Figure:
    """Draw the systems of a station and what runs between them; its recorder is left out."""
    scenario = station.scenario
    delays = {
        name: f"delay {milliseconds(usual_delay(getattr(scenario, name), scenario.step))}"
        for name in ("to_telerobot", "to_operator")
    }
    places = {name: place for name, place in _PLACES.items() if station.diagram.HasSubsystemNamed(name)}
    return block_diagram(station.diagram, places, _LANES, notes=delays, hidden=("recorder",))
