"""What a viewer holds for a browser, read without one."""

import numpy as np
from numpy.typing import NDArray

from mmt_drake.viewer.charts import COLUMNS
from mmt_drake.viewer.viewer import Viewer


def transform(viewer: Viewer, path: str) -> NDArray[np.float64]:
    """The (4, 4) transform at a path."""
    return np.frombuffer(viewer.drawn["transform", path]["matrix"]).reshape(4, 4).T  # sent column by column


def samples(viewer: Viewer) -> NDArray[np.float64]:
    """The last batch of samples of the charts, a row each."""
    return np.frombuffer(viewer.drawn["samples",]["samples"]).reshape(-1, len(COLUMNS))


def is_drawn(viewer: Viewer, path: str) -> bool:
    """Whether there is anything at a path or below it."""
    return any(kind == "object" and f"{at[0]}/".startswith(f"{path}/") for kind, *at in viewer.drawn)


def is_visible(viewer: Viewer, path: str) -> bool:
    """Whether what is at a path is shown; it is unless something hid it."""
    return viewer.drawn.get(("property", path, "visible"), {"value": True})["value"]
