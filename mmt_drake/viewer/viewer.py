"""Starts what a browser looks at: Meshcat, and the page with scene and charts."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from pydrake.geometry import Meshcat, MeshcatParams

from mmt_drake.errors import BadInput
from mmt_drake.viewer.charts import page
from mmt_drake.viewer.page_server import PageServer


@dataclass(frozen=True)
class Viewer:
    """What was started.

    Attributes:
        meshcat: the scene's, reachable from this machine alone.
        url: of the page with scene and charts; the scene's own where the page could not be served.
        missing: why it could not, else None.
    """

    meshcat: Meshcat
    url: str
    missing: str | None = None


@contextmanager
def open_viewer(port: int | None = None) -> Iterator[Viewer]:
    """A viewer for the browsers of this machine, who open it, close it or let it be as they like.

    The page's server ends with the context, Meshcat's with the last reference to it.

    Args:
        port: of Meshcat; by default the first free one from 7000 on.

    Raises:
        BadInput: Meshcat finds no port.
    """
    try:
        meshcat = Meshcat(MeshcatParams(host="localhost", port=port, show_stats_plot=False))
    except RuntimeError as error:
        found = str(error).splitlines()[0]
        expected = "a free port" if port is None else f"port {port} to be free"
        raise BadInput("viewer", found=found, expected=expected) from None
    try:
        server = PageServer(page(meshcat.web_url()))
    except OSError as error:
        yield Viewer(meshcat, meshcat.web_url(), str(error))
        return
    with server:
        yield Viewer(meshcat, server.url)
