"""What is learned over places: heights of a surface, and its stiffness. How the force follows the values of a table.

The derivatives are written down, and sparse, for few neighbours of a place count: N and n follow the surface, and
friction follows N where the tip slips. What a table does to the way of a tip that sticks is left out, which costs steps
of a fit and no accuracy.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.surface_track import contact_over, tip_over
from mmt_drake.diagnosis.fit.tracks import Track
from mmt_drake.effects import stiffness_map, surface_shape
from mmt_drake.model.place_table import FIRST, PlaceTable, nodes_under
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.numeric.arrays import Array

Numbers = NDArray[np.intp]
SHAPE, STIFFNESS = surface_shape.EFFECT.name, stiffness_map.EFFECT.name
LEARNED = {SHAPE: "height", STIFFNESS: "stiffness"}
"""Effects whose numbers are a table over places -> the parameter that is the table."""
Tables = Mapping[str, Array]
"""Effect of `LEARNED` -> (m,) its values over the grid."""


def learned_by(hypothesis: Hypothesis) -> tuple[str, ...]:
    """Those of its effects that are tables over places."""
    return tuple(name for name in LEARNED if name in hypothesis.key)


def table_derivatives(
    tracks: Sequence[Track], rows: Numbers, model: SurfaceContact
) -> Iterator[dict[str, sparse.csr_matrix]]:
    """Of each axis of a recording: effect -> (n, m) derivatives of the residual after the values of its table.

    Args:
        tracks: the three axes.
        rows: (n,) samples.
        model: with the tables.
    """
    dial = sparse.diags
    all_tips, all_rates = tip_over(tracks[0].smoothed, model.additions.tool)
    tips, rate = all_tips[rows], all_rates[rows]
    force, load, depth, _ = np.split(contact_over(tracks[0].smoothed, model)[rows], [3, 4, 5], axis=1)
    load, depth, touches = load[:, 0], depth[:, 0], depth[:, 0] > 0.0
    k = np.full(len(rows), model.k)
    if model.stiffness is not None:
        stiffness = _under(model.stiffness, tips)[0]
        k = stiffness @ np.asarray(model.stiffness.value)
    if model.surface is not None:
        h, hx, hy = _under(model.surface, tips)
        heights = np.asarray(model.surface.value)
        sx, sy = hx @ heights, hy @ heights
    else:
        sx, sy = np.zeros((2, len(rows)))
    steep = np.sqrt(1.0 + sx**2 + sy**2)
    n = np.column_stack([-sx, -sy, np.ones_like(sx)]) / steep[:, np.newaxis]
    across = force - load[:, np.newaxis] * n
    # Friction goes with the load where it is all that friction can be; d(depth) is dh / steep - depth (...).
    slips = np.linalg.norm(across, axis=1) >= 0.999 * (model.mu * load + model.Fc)
    push = n + (across / np.maximum(load, 1e-9)[:, np.newaxis]) * (slips & (model.mu > 0.0))[:, np.newaxis]
    if model.surface is not None:
        turns = dial(sx / steep**2) @ hx + dial(sy / steep**2) @ hy
        press = dial(rate[:, 0] / steep) @ hx + dial(rate[:, 1] / steep) @ hy + dial((n * rate).sum(axis=1)) @ turns
        loads = dial(k * touches / steep) @ h - dial(k * depth) @ turns + dial(model.b * touches) @ press
    for i, track in enumerate(tracks):
        after = {}
        if model.surface is not None:
            direction = -(dial(n[:, i]) @ turns)
            if i < 2:
                direction = direction - dial(1.0 / steep) @ (hx, hy)[i]
            after[SHAPE] = (dial(push[:, i]) @ loads + dial(load * touches) @ direction) * (-1.0 / track.floor)
        if model.stiffness is not None:
            after[STIFFNESS] = dial(push[:, i] * depth * (-1.0 / track.floor)) @ stiffness
        yield after


def _under(table: PlaceTable, tips: Array) -> tuple[sparse.csr_matrix, ...]:
    """(n, m) each: by how much each value of a table makes it, and its slopes along x and y, under tips (n, 3)."""
    packed = table.packed()
    node, *parts = (np.empty((len(tips), 16)) for _ in range(4))
    nodes_under(packed, tips[:, 0].copy(), tips[:, 1].copy(), node, *parts)
    row, shape = np.repeat(np.arange(len(tips)), 16), (len(tips), len(packed) - FIRST)
    at = row, node.astype(int).ravel()
    return tuple(sparse.csr_matrix((part.ravel(), at), shape=shape) for part in parts)
