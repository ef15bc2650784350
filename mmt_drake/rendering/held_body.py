"""The return of a rendered body to where friction holds it, by the policy that holds for parameters too.

Once friction holds the body, better parameters do not bring it to where it was; that is reported beside them
(`mmt_drake.model.held_body`). In every tick it moves a share s of the way there. The force on the probe is linear in s,
unless laws or a clearance act in the contact; then s is shortened until the force changes by no more than it may.
The energy in store is convex in s, so that a share R / dE of the way adds no more than a reserve R where the whole way
adds dE.
"""

import math

from numba import njit

from mmt_drake.model.body import ANCHOR, AXIS_SIZE, POSITION
from mmt_drake.model.energy import stored_energy
from mmt_drake.model.flexible_box import BODY, force_on_probe
from mmt_drake.model.held_body import astray, count_from, counted_elsewhere, lead
from mmt_drake.model.parameters import LAWS
from mmt_drake.numeric.arrays import Array
from mmt_drake.rendering.laws import bend
from mmt_drake.rendering.updates import CHANGE, RESERVE, ROUNDING, SHARE, SHORTER, TRIES, share_within


@njit(cache=True)
def distance(a: Array, b: Array | tuple[float, float, float]) -> float:
    """Between two forces (3,) [N]."""
    return math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


@njit(cache=True)
def bring(
    state: Array, p: Array, held: Array, since: Array, spent: float, reserve: float, rule: Array, force: Array
) -> float:
    """Bring the bodies that are held elsewhere towards their reported positions, one axis after the other.

    Args:
        state: of the object, changed in place.
        p: kernel vector of what is rendered.
        held: (HELD_SIZE,) the report.
        since: (3,) since when each body has been where it is, and the contact lasts [s].
        spent: change of force that this tick's update of the parameters has made [N].
        reserve: energy that may be added [J]; only for that policy.
        rule: of the policy.
        force: (3,) on the probe [N], kept up to date.

    Returns:
        The reserve that is left [J].
    """
    for i in range(2):
        if p[LAWS] != 0.0:
            reserve = _count_alike(state, p, i, held, since, reserve, rule)
        if not astray(state, i, held, since):
            continue
        at = BODY + AXIS_SIZE * i
        position, anchor, felt = state[at + POSITION], state[at + ANCHOR], (force[0], force[1], force[2])
        before = stored_energy(state, p)
        lead(state, i, held, 1.0)
        share = rule[SHARE]
        if rule[RESERVE] > 0.0:
            share = share_within(stored_energy(state, p) - before, max(reserve, 0.0))
        if math.isfinite(rule[CHANGE]):
            force_on_probe(state, p, force)
            share = min(share, share_within(distance(force, felt), max(rule[CHANGE] - spent, 0.0)))
        if share < 1.0:
            state[at + POSITION], state[at + ANCHOR] = position, anchor
            lead(state, i, held, share)
        force_on_probe(state, p, force)
        if math.isfinite(rule[CHANGE]) and bend(p):
            _lead_within(state, p, i, held, share, rule[CHANGE] - spent, (position, anchor), felt, force)
        spent += distance(force, felt)
        if rule[RESERVE] > 0.0:
            reserve = min(reserve - (stored_energy(state, p) - before), rule[RESERVE])
    return reserve


@njit(cache=True)
def _count_alike(state: Array, p: Array, i: int, held: Array, since: Array, reserve: float, rule: Array) -> float:
    """Count the body's position from where the report does: laws ask for it. No force on the probe changes at once.

    Args:
        state, p, i, held, since, rule: as of `bring`.
        reserve: energy that may be added [J].

    Returns:
        The reserve that is left [J].
    """
    off = counted_elsewhere(state, i, held, since)
    if off == 0.0:
        return reserve
    share, before = rule[SHARE], stored_energy(state, p)
    count_from(state, i, off)
    if rule[RESERVE] > 0.0:
        share = share_within(stored_energy(state, p) - before, max(reserve, 0.0))
    if share < 1.0:
        count_from(state, i, (share - 1.0) * off)
    return min(reserve - (stored_energy(state, p) - before), rule[RESERVE]) if rule[RESERVE] > 0.0 else reserve


@njit(cache=True)
def _lead_within(
    state: Array,
    p: Array,
    i: int,
    held: Array,
    share: float,
    most: float,
    was: tuple[float, float],
    felt: tuple[float, float, float],
    force: Array,
) -> None:
    """Bring a body that was led along axis i back to where the force, which laws may bend, has changed by `most` [N].

    Args:
        state, p, held, force: as of `bring`; the force is that after this share.
        i: the axis.
        share: of the way, that was gone.
        most: [N]; none below 0.
        was: the body's position and anchor [m] before.
        felt: the force [N] before; laws that know both axes change it along the other one, too.
    """
    at, tries = BODY + AXIS_SIZE * i, 0
    position, anchor = was
    while distance(force, felt) > max(most, 0.0) * ROUNDING and share > 0.0:
        tries += 1
        share = 0.0 if tries == TRIES else share * SHORTER * max(most, 0.0) / distance(force, felt)
        state[at + POSITION], state[at + ANCHOR] = position, anchor
        if share > 0.0:
            lead(state, i, held, share)
        force_on_probe(state, p, force)
