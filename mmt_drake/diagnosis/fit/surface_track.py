"""Tracks of a tip on a surface: the three axes of its force."""

from dataclasses import dataclass

import numpy as np

from mmt_drake.diagnosis.fit.latest import Latest
from mmt_drake.diagnosis.fit.tracks import Replayed, Track
from mmt_drake.diagnosis.signals.smoother import Smoothed
from mmt_drake.errors import BadInput
from mmt_drake.model import surface_contact
from mmt_drake.model.structure import Structure
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.motion.hand import Place
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.signals import ORIENTATION

_latest = Latest()


def contact_over(s: Smoothed, model: Structure) -> Array:
    """(n, 6) of a recording: force [N], load along the normal [N], depth [m], speed of the tip along the surface [m/s].

    The latest is kept, for the tracks of the other axes.

    Raises:
        BadInput: a model of another structure, or as `tip_over`.
    """
    if not isinstance(model, SurfaceContact):
        raise BadInput(s.source, found=f"a {model.NAME} model", expected="surface_contact")
    p, tool = model.kernel_vector(), model.additions.tool

    def replayed() -> Array:
        found = np.empty((len(s.time), 6))
        position, rate = map(np.ascontiguousarray, tip_over(s, tool))
        surface_contact.replay(s.time, position, rate, p, found)
        return found

    return _latest.of((s,), (p.tobytes(), tool), replayed)


def tip_over(s: Smoothed, tool: Place) -> tuple[Array, Array]:
    """Position [m] and velocity [m/s] of the tip in a recording, (n, 3) each.

    Args:
        s: the recording.
        tool: see `Additions.tool`.

    Raises:
        BadInput: a tip that is not where it was recorded, of a hand whose orientation was not recorded.
    """
    if not any(tool):
        return s.input, s.input_rate
    if s.hand is None:
        expected = f"the columns {', '.join(ORIENTATION)}, by which its offset turns"
        raise BadInput(s.source, found="a tool_offset in the model", expected=expected)
    return s.hand.tip(s.input, s.input_rate, tool)


@dataclass(frozen=True)
class SurfaceTrack(Track):
    """One axis of the force on a tip that presses into a surface."""

    def _replayed(self, model: Structure, coarse: float, late: float) -> Replayed:
        s = self.smoothed
        found = contact_over(s, model)
        _, load, depth, speed = found[:, :3], *found[:, 3:].T
        return found[:, self.column].copy(), lambda: {
            "sliding_velocity": speed,
            "load": np.maximum(load, 0.0),
            "depth": depth,
            "depth_rate": np.gradient(depth, s.time),
            "position": s.input[:, self.column],
            "deflection": -depth,
            "deflection_rate": s.input_rate[:, self.column],
        }
