"""The station's signals, shown while it runs."""

from __future__ import annotations

from collections.abc import Mapping

from pydrake.geometry import Meshcat
from pydrake.systems.framework import DiagramBuilder, OutputPort

from diagrams.ports import split
from mmt_drake.cloud import ProxySettings
from mmt_drake.systems.contact_detector import PORT_SIZES
from mmt_drake.systems.live_view import LiveView


def wire_view(
    builder: DiagramBuilder,
    meshcat: Meshcat,
    ports: Mapping[str, OutputPort],
    *,
    detector: OutputPort | None = None,
    proxy: ProxySettings | None = None,
) -> LiveView:
    """Add a `LiveView`, called `live_view`, to a diagram that is being built.

    Args:
        builder: of the diagram.
        meshcat: where to draw.
        ports: what to show, by the names of its input ports; what is left out is not shown.
        detector: readout of the contact detector: where the proxy is and how the surface stands there.
        proxy: radii of its spheres.
    """
    view = builder.AddNamedSystem("live_view", LiveView(meshcat, proxy))
    shown = dict(ports)
    if detector is not None:
        # Behind the detector's ports is the proxy's memory: its position, then the normal.
        *parts, _, normal = split(builder, detector, (*PORT_SIZES.values(), 3, 3))
        shown |= {"in_contact": parts[0], "proxy": parts[1], "normal": normal}
    for name, port in shown.items():
        builder.Connect(port, view.GetInputPort(name))
    return view
