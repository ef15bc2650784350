"""The station's signals, shown while it runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pydrake.systems.framework import DiagramBuilder, OutputPort, System

from mmt_drake.cloud import ProxySettings
from mmt_drake.diagrams.ports import split
from mmt_drake.systems.contact_detector import PORT_SIZES
from mmt_drake.systems.live_view import LiveView
from mmt_drake.viewer.viewer import Viewer

_RECORDED = {
    ("master_position", "master_velocity"): "motion",
    ("position", "velocity", "force"): "measurement",
    ("rendered_force",): "rendered_force",
    ("theta",): "theta",
    ("theta_stable",): "stable",
    ("detected_contact",): "in_contact",
    ("operator_contact",): "in_contact",
}
"""Columns of a recording that one port gives -> the port of a `LiveView` that shows them."""


def wire_view(
    builder: DiagramBuilder,
    meshcat: Viewer,
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


def wire_view_of_columns(
    builder: DiagramBuilder,
    meshcat: Viewer,
    columns: Sequence[tuple[OutputPort, tuple[str, ...]]],
    parts: Mapping[str, System],
    *,
    proxy: ProxySettings | None = None,
) -> LiveView:
    """The same for a diagram of which it is known what it would record.

    Args:
        builder, meshcat, proxy: as for `wire_view`.
        columns: ports, and the columns that each of them gives.
        parts: systems by name; of `camera`, `environment` and `detector`, where they are, more is shown than is
            recorded.
    """
    ports = {_RECORDED[names]: port for port, names in columns if names in _RECORDED}
    if "environment" in parts:
        looks = parts.get("camera", parts["environment"])
        ports["point_cloud"] = looks.GetOutputPort("point_cloud")
        if parts["environment"].HasOutputPort("body"):
            ports["body_position"] = split(builder, parts["environment"].GetOutputPort("body"), (2,))[0]
    detector = parts["detector"].GetOutputPort("readout") if "detector" in parts else None
    return wire_view(builder, meshcat, ports, detector=detector, proxy=proxy)
