"""The viewer of `run --meshcat`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING

from mmt_drake.cli.output import say
from mmt_drake.errors import BadInput

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat


@contextmanager
def viewer(wanted: bool, *, needed: bool) -> Iterator[Meshcat | None]:
    """What shows the run, and a line that says where; None if none is wanted, or none can be had.

    Raises:
        BadInput: none can be had although it is needed, for the sliders of a hand.
    """
    if not wanted:
        yield None
        return
    from mmt_drake.viewer.viewer import open_viewer

    with ExitStack() as stack:
        meshcat = None
        try:
            opened = stack.enter_context(open_viewer())
            meshcat = opened.meshcat
            told = opened.url if opened.missing is None else f"{opened.url}, without charts: {opened.missing}"
        except BadInput as error:
            if needed:
                raise
            told = f"none, the run goes on without; {error}"
        say(f"viewer: {told}", stderr=True)
        yield meshcat
