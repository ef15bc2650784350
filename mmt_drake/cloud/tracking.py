"""Objects on a table by their tops, from one cloud to the next: who is who.

A cloud is segmented (`mmt_drake.cloud.segment`). A cluster belongs to an object where it covers a quarter of that
object's top, placed where it was last; so objects and clusters fall into groups. One object and one cluster: it is
there. Several clusters, one object: it is split. Several objects, one cluster: they are merged, and registered by their
outlines together; what of it none covers is another cluster. An object without a cluster is occluded, lost, and in the
end taken away; a cluster without an object is the only one among the missing that is just like it, found, or else new.
Nothing of this is silent: each is a state.

What the tip is in is sought where the tip takes it. What a grip holds goes with the tip once that is `_LIFTED` higher
than where it closed. Its points are nobody's then, and an object that shows less of itself beneath stays where it was.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.cloud.cloud_frame import SAME_TOP, WHOLE, CloudFrame, Cluster
from mmt_drake.cloud.seen import SeenScene, SeenThing
from mmt_drake.cloud.segment import above_table, load_open3d, registered, spacing_of, tops
from mmt_drake.cloud.tracking_options import Tracking
from mmt_drake.model.scene_layout import SeenState, under
from mmt_drake.numeric.arrays import Array, Flags

_COVERED = 0.25  # share of a top that a cluster of it covers at least
_ALIKE = 0.004  # [m], and two and a half spacings: extents of one object
_ROOM = 0.02  # [m] more than its extents: two objects were taken for one
_STILL = 0.0015  # [m]: noise of a place
_CALM = 0.1  # weight of a new place of an object that stands still
_HEIGHT = 0.002  # weight of a new height, in the long run: it does not change
_LIFTED = 0.006  # [m]: a gripped object is off the table
_FRAMES = 3  # that a change has to last


def load_tracking() -> None:
    """Load and compile what tells objects apart, before a clock starts."""
    load_open3d()
    under(SeenScene().vector(0.0), 0.0, 0.0, 0.0)


def tracked(
    before: SeenScene, cloud: Cloud, probe: Array, t: float, table: float, options: Tracking, gripped: int = 0
) -> SeenScene:
    """The scene after another cloud.

    Args:
        before: the scene before.
        cloud: what is seen now, table frame.
        probe: (3,) where its tip is [m].
        t: [s].
        table: height of the table in the table frame, as it is known beforehand [m].
        options: how objects are told apart.
        gripped: identity of what a closed grip holds at the tip; 0: nothing.
    """
    points, spacing = cloud.points(), spacing_of(cloud)
    high = np.flatnonzero(points[:, 2] > probe[2] + 1e-3)
    points = np.delete(points, high[_within(points[high], probe[:2], options.probe)], axis=0)
    grip, things, carried = _gripped(before, probe, t, table, gripped)
    things = _pushed(things, before.probe, probe, t)
    if carried is not None:
        high = np.flatnonzero(points[:, 2] > carried.top - carried.height - _LIFTED + 1e-3)
        near = _within(points[high], carried.place, 0.5 * math.hypot(*carried.size) + 0.01)
        points = np.delete(points, high[near], axis=0)
    upper, table = above_table(points, table)
    clusters = [Cluster(each) for each in tops(upper, spacing, options.fewest)]
    frame = CloudFrame(t, probe, table, spacing, points, options, cloud, carried)
    present = [thing for thing in things if thing.state not in (SeenState.TAKEN_AWAY, SeenState.CARRIED)]
    missing = {thing.thing: thing for thing in things if thing.state == SeenState.TAKEN_AWAY}
    found: dict[int, SeenThing] = {} if carried is None else {carried.thing: carried}
    strangers: list[Cluster] = []
    for things, group in _groups(frame, present, clusters):
        if not group:
            missing[things[0].thing] = _unseen(frame, things[0])
        elif not things:
            strangers += group
        elif len(things) == 1:
            kept, left = _single(frame, things[0], group)
            found[kept.thing] = kept
            strangers += left
        else:
            made, left = _merged(frame, things, group)
            found |= {thing.thing: thing for thing in made}
            strangers += left
    x, y, z = probe.tolist()
    return replace(_with_strangers(before, frame, found, missing, strangers), grip=grip, probe=(x, y, z))


def _within(points: Array, place: Array | tuple[float, float], radius: float) -> Flags:
    """Which of the points (n, 3) are as near to a place as that across z."""
    away: Array = np.hypot(*(points[:, :2] - place).T)
    return away < radius


def _gripped(
    before: SeenScene, probe: Array, t: float, table: float, gripped: int
) -> tuple[tuple[int, float, float, float] | None, list[SeenThing], SeenThing | None]:
    """What a grip holds since when, all objects, and the one among them that is off the table."""
    x, y, z = probe.tolist()
    grip, things, carried = None, list[SeenThing](), None
    for thing in before.things:
        if thing.thing == gripped:
            grip = before.grip
            if grip is None or grip[0] != gripped:
                grip = gripped, thing.place[0] - x, thing.place[1] - y, z
            if z > grip[3] + _LIFTED:
                top = table + thing.height + z - grip[3]
                carried = thing.now(SeenState.CARRIED, t, place=(x + grip[1], y + grip[2]), top=top, seen=t)
                things.append(carried)
                continue
        down = {"top": table + thing.height} if thing.state == SeenState.CARRIED else {}
        things.append(thing.now(SeenState.SEEN, t, **down) if down else thing)
    return grip, things, carried


def _pushed(
    things: list[SeenThing], before: tuple[float, float, float] | None, probe: Array, t: float
) -> list[SeenThing]:
    """All objects, that which the tip is in where it takes it: a camera's frames are far apart for one pushed fast."""
    if before is None:
        return things
    x, y, z = before
    scene = SeenScene(tuple(things)).vector(t)
    row, by = under(scene, x, y, 0.0), (float(probe[0]) - x, float(probe[1]) - y)
    return [
        replace(thing, place=(thing.place[0] + by[0], thing.place[1] + by[1]))
        if row >= 0 and thing.thing == scene[row] and thing.state != SeenState.CARRIED and max(z, probe[2]) < thing.top
        else thing
        for thing in things
    ]


def _groups(
    frame: CloudFrame, things: Sequence[SeenThing], clusters: Sequence[Cluster]
) -> list[tuple[list[SeenThing], list[Cluster]]]:
    """Objects and clusters that have to do with each other."""
    groups: list[tuple[list[SeenThing], list[Cluster]]] = [([], [cluster]) for cluster in clusters]
    for thing in things:
        mine = [g for g in groups if any(frame.covered(thing, cluster) > _COVERED for cluster in g[1])]
        whole = [g for g in groups if g[1] and g not in mine and _lies_in(frame, thing, g[1])]
        mine += whole
        if not mine:
            groups.append(([thing], []))
            continue
        first = mine[0]
        for other in mine[1:]:
            first[0].extend(other[0])
            first[1].extend(other[1])
            groups = [g for g in groups if g is not other]
        first[0].append(thing)
    return groups


def _lies_in(frame: CloudFrame, thing: SeenThing, clusters: Sequence[Cluster]) -> bool:
    """Whether clusters are parts of an object's top, small as they may be."""
    if any(abs(cluster.top - thing.top) > SAME_TOP for cluster in clusters):
        return False
    low, high = thing.placed.min(axis=0) - 2.0 * frame.spacing, thing.placed.max(axis=0) + 2.0 * frame.spacing
    return all(bool(((c.across > low) & (c.across < high)).all()) for c in clusters)


def _single(frame: CloudFrame, thing: SeenThing, group: list[Cluster]) -> tuple[SeenThing, list[Cluster]]:
    """An object that is told from others, and clusters that are none of it."""
    whole = Cluster(np.concatenate([cluster.points for cluster in group]))
    if frame.beneath(thing, whole):
        return thing.now(SeenState.OCCLUDED, frame.t, seen=frame.t), []
    beyond, state = whole.extents - thing.size, SeenState.SEEN if len(group) == 1 else SeenState.SPLIT
    if thing.cut:
        if len(group) == 1 and beyond.max() > 0.0:  # it comes into view
            thing = replace(thing, outline=whole.across - whole.middle, place=whole.middle, frames=0)
            beyond = np.zeros(2)
        thing = replace(thing, cut=frame.cuts(whole))
    if beyond.max() > _ROOM:
        if thing.frames < _FRAMES:
            return _at(frame, thing, whole, state, frames=thing.frames + 1), []
        largest = max(group, key=lambda cluster: len(cluster.points))
        if len(group) > 1:  # it was two
            anew = replace(thing, outline=largest.across - largest.middle, frames=0)
            return _at(frame, anew, largest, SeenState.SPLIT), [c for c in group if c is not largest]
        kept = _at(frame, thing, whole, SeenState.MERGED)
        return kept, _rest(frame, [kept], whole.points)
    return _at(frame, thing, whole, state, frames=0), []


def _at(frame: CloudFrame, thing: SeenThing, cluster: Cluster, state: SeenState, **changes: Any) -> SeenThing:
    """An object where a cluster is."""
    if np.abs(cluster.extents - thing.size).max() < WHOLE + frame.spacing:
        place = cluster.middle
    else:  # a part of it, or more than it
        (by,) = registered([thing.placed], cluster.across, 1.5 * frame.spacing, frame.below(thing.top - SAME_TOP))
        place = thing.place[0] + by[0], thing.place[1] + by[1]
    place = _calmed(thing.place, place, _STILL)
    top, height, colour = thing.top, thing.height, thing.colour
    if state == SeenState.SEEN:
        colour = frame.coloured(cluster, colour)
        weight = max(_HEIGHT, 1.0 / (thing.looks + 1.0))
        top += weight * (cluster.top - top)
        height += weight * (cluster.top - frame.table - height)
    changes = {"frames": thing.frames} | changes
    told = thing.now(
        state, frame.t, place=place, top=top, height=height, seen=frame.t, looks=thing.looks + 1, **changes
    )
    return replace(told, cloud=cluster.points, colour=colour)


def _calmed(before: tuple[float, float], now: tuple[float, float], still: float) -> tuple[float, float]:
    """Where an object is that may stand still: a place no farther off than that [m] counts little."""
    if math.dist(now, before) >= still:
        return now
    x, y = before
    return x + _CALM * (now[0] - x), y + _CALM * (now[1] - y)


def _rest(frame: CloudFrame, things: Sequence[SeenThing], points: Array) -> list[Cluster]:
    """What is left of points (n, 3) beside the tops of objects, if that is enough for another one."""
    away = cKDTree(np.concatenate([each.placed for each in things])).query(points[:, :2])[0] > 2.0 * frame.spacing
    return [Cluster(points[away])] if int(np.count_nonzero(away)) >= frame.options.fewest else []


def _merged(
    frame: CloudFrame, things: Sequence[SeenThing], group: Sequence[Cluster]
) -> tuple[list[SeenThing], list[Cluster]]:
    """Objects that are one cluster, and what of that is none of them."""
    points = np.concatenate([cluster.points for cluster in group])
    low = frame.below(min(thing.top for thing in things) - SAME_TOP)
    apart = registered([thing.placed for thing in things], points[:, :2], 1.5 * frame.spacing, low)
    made = []
    for thing, by in zip(things, apart, strict=True):
        place = thing.place[0] + float(by[0]), thing.place[1] + float(by[1])
        place = _calmed(thing.place, place, 0.5 * frame.spacing)  # rims alone tell it, as finely as there are points
        made.append(thing.now(SeenState.MERGED, frame.t, place=place, seen=frame.t, frames=0))
    owner = cKDTree(np.concatenate([each.placed for each in made])).query(points[:, :2])[1]
    ends = np.cumsum([len(each.outline) for each in made])
    which = np.searchsorted(ends, owner, side="right")
    rest = _rest(frame, made, points)
    if rest:  # another one is among them, and who is who is in doubt
        made = [each.now(SeenState.SPLIT, frame.t) for each in made]
    return [replace(each, cloud=points[which == i]) for i, each in enumerate(made)], rest


def _unseen(frame: CloudFrame, thing: SeenThing) -> SeenThing:
    """An object without a cluster."""
    missed, options = frame.t - thing.seen, frame.options
    near = math.dist(thing.place, frame.probe[:2]) < options.hides + 0.5 * max(thing.size)
    hidden = (near or frame.beneath(thing)) and not frame.bare(thing)
    patience = (3.0 if hidden else 1.0) * options.taken_after
    if missed > options.lost_after + patience:
        return thing.now(SeenState.TAKEN_AWAY, frame.t)
    if hidden:
        return thing.now(SeenState.OCCLUDED, frame.t)
    return thing.now(SeenState.LOST, frame.t) if missed > options.lost_after else thing


def _with_strangers(
    before: SeenScene,
    frame: CloudFrame,
    found: dict[int, SeenThing],
    missing: dict[int, SeenThing],
    strangers: Sequence[Cluster],
) -> SeenScene:
    """The scene with clusters that belong to nobody: the same as one that is missing, or new."""
    newcomers, following = [], before.following
    for cluster in sorted(strangers, key=lambda each: each.middle):
        close = [n for x, y, n in before.newcomers if math.dist((x, y), cluster.middle) < 0.03]
        count = max(close, default=0) + 1
        if count < _FRAMES and before.things:
            newcomers.append((*cluster.middle, count))
            continue
        like = [thing for thing in missing.values() if _is_like(frame, thing, cluster)]
        if len(like) == 1 and sum(_is_like(frame, like[0], other) for other in strangers) == 1:
            back = replace(like[0], place=cluster.middle, top=cluster.top, cloud=cluster.points, seen=frame.t, frames=0)
            found[back.thing] = back.now(SeenState.FOUND, frame.t)
            del missing[back.thing]
            continue
        found[following] = SeenThing(
            following,
            SeenState.NEW,
            place=cluster.middle,
            top=cluster.top,
            height=cluster.top - frame.table,
            outline=cluster.across - cluster.middle,
            cloud=cluster.points,
            known=frame.t,
            since=frame.t,
            seen=frame.t,
            cut=frame.cuts(cluster),
            colour=frame.coloured(cluster),
        )
        following += 1
    everything = found | missing
    return SeenScene(tuple(everything[thing] for thing in sorted(everything)), tuple(newcomers), following)


def _is_like(frame: CloudFrame, thing: SeenThing, cluster: Cluster) -> bool:
    """Whether a cluster could be an object that is not seen elsewhere."""
    same = np.abs(cluster.extents - thing.size).max() < _ALIKE + 2.5 * frame.spacing
    return bool(same and abs(cluster.top - thing.top) < SAME_TOP)
