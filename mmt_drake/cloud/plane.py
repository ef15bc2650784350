"""The top of a box as a depth camera would sample it."""

import math
from functools import lru_cache
from typing import Literal

import numpy as np

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.errors import BadInput


@lru_cache(maxsize=4)  # a cloud never changes, and its grid costs more than the rest of a station
def plane(
    n: int,
    size: tuple[float, float] = (0.3, 0.3),
    *,
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0),
    layout: Literal["regular", "jittered", "random"] = "regular",
    noise: float = 0.0,
    seed: int = 0,
) -> Cloud:
    """n points on a horizontal rectangle, table frame.

    Args:
        n: number of points.
        size: the rectangle's sides along x and y [m].
        centre: its middle [m].
        layout: `regular`, rows of equally spaced points, as square as n allows (rows may differ by one point);
            `jittered`, the same with every point moved by up to half a spacing each way; `random`, uniformly strewn.
        noise: standard deviation of the points' z [m].
        seed: of jitter, strewing and noise; the same seed gives the same cloud.

    Raises:
        BadInput: a negative n or noise, a side that is not above 0, an unknown layout.
    """
    if n < 0:
        raise BadInput("plane", at="n", found=n, expected="a number of points, 0 or more")
    if not all(math.isfinite(side) and side > 0.0 for side in size):
        raise BadInput("plane", at="size", found=size, expected="two lengths above 0 m")
    if not (math.isfinite(noise) and noise >= 0.0):
        raise BadInput("plane", at="noise", found=noise, expected="a standard deviation of 0 m or more")
    if layout not in ("regular", "jittered", "random"):
        raise BadInput("plane", at="layout", found=layout, expected="regular, jittered or random")
    if n == 0:
        return Cloud.empty()
    random = np.random.default_rng(seed)
    if layout == "random":
        across = random.uniform(size=(n, 2))
    else:
        rows = max(1, round(math.sqrt(n * size[1] / size[0])))
        rows = min(rows, n)
        # Point k belongs to row k*rows // n, so rows hold n // rows points or one more.
        row = np.arange(n) * rows // n
        first = np.searchsorted(row, np.arange(rows))
        in_row = np.bincount(row)
        across = np.column_stack([(np.arange(n) - first[row] + 0.5) / in_row[row], (row + 0.5) / rows])
        if layout == "jittered":
            across += random.uniform(-0.5, 0.5, (n, 2)) / np.column_stack([in_row[row], np.full(n, rows)])
    points = np.empty((n, 3))
    points[:, :2] = (across - 0.5) * size
    points[:, 2] = noise * random.standard_normal(n) if noise > 0.0 else 0.0
    return Cloud(points + centre)
