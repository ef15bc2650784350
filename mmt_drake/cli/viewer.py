"""The viewer of `run --meshcat`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from mmt_drake.cli.output import say
from mmt_drake.errors import BadInput

if TYPE_CHECKING:
    from mmt_drake.viewer.viewer import Viewer


@contextmanager
def viewer(wanted: bool, *, needed: bool, notices: Sequence[str] = ()) -> Iterator[Viewer | None]:
    """What shows the run, a line that says where, and at the end one that says how many requests were dropped.

    None if none is wanted, or none can be had.

    Args:
        wanted: whether it is.
        needed: by the sliders of a hand.
        notices: what whoever looks has to know from the first moment on.

    Raises:
        BadInput: none can be had although it is needed, for the sliders of a hand.
    """
    if not wanted:
        yield None
        return
    from mmt_drake.viewer.charts import page
    from mmt_drake.viewer.viewer import Viewer

    try:
        shown = Viewer(page(notices))
    except BadInput as error:
        if needed:
            raise
        say(f"viewer: none, the run goes on without; {error}", stderr=True)
        yield None
        return
    with shown:
        say(f"viewer: {shown.url}", stderr=True)
        yield shown
    if shown.refused:
        why = ", ".join(f"{count} x {reason}" for reason, count in sorted(shown.refused.items()))
        say(f"viewer: dropped what was not of its page: {why}", stderr=True)
