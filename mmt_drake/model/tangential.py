"""Both tangential axes of a flexible object between two samples of the probe."""

from numba import njit

from mmt_drake.model.body import AXIS_SIZE, advance_body
from mmt_drake.model.forces import Spring
from mmt_drake.model.hermite import Cubic
from mmt_drake.model.parameters import Constants
from mmt_drake.model.plane_call import advance_both
from mmt_drake.numeric.arrays import Array


@njit(error_model="numpy", forceinline=True)
def advance_object(
    state: Array,
    at: int,
    s: float,
    s_end: float,
    along: Cubic,
    across: Cubic,
    height: Cubic,
    contact: bool,
    start: float,
    first: Spring,
    second: Spring,
    p: Constants,
    vector: int,
    size: int,
) -> None:
    """Advance both axes, which begin at `at` in the state, from s to s_end [s] after the latest sample.

    The springs are the contact's along both. The kernel vector p stands at an address, too, and is of a size.

    Raises:
        RuntimeError: as `mmt_drake.model.body.advance_axis` and `mmt_drake.model.plane.advance_axes`.
    """
    if p.coupled:
        springs = (first.k, first.b, first.push, second.k, second.b, second.push)
        body, held, call = state[at:].ctypes.data, 1.0 if contact else 0.0, int(p.planar)
        if advance_both(call, body, s, s_end, along, across, height, held, start, *springs, vector, size) != 0.0:
            raise RuntimeError("two samples more than ten million integration steps apart, or laws that decay too fast")
    else:
        advance_body(state, at, s, s_end, along, height, contact, start, first, p)
        advance_body(state, at + AXIS_SIZE, s, s_end, across, height, contact, start, second, p)
