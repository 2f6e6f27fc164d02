"""Whether a pair of features goes through each other on the path of a step in space."""

from __future__ import annotations

import math

from lcpflex.contact.narrow_phase.limits import SPAN_TOLERANCE
from lcpflex.contact.spatial.pairs import foot_margin, node_margin, refresh
from lcpflex.contact.spatial.table import (
    EDGE_CAP,
    EDGE_EDGE,
    EDGE_FACET,
    EDGE_RIM,
    EDGE_SIDE,
    NODE_CAP,
    NODE_FACET,
    NODE_RIM,
    RIM_FACET,
    RIM_RIM,
    SpatialContactTable,
    by_cylinder,
    with_edge,
)
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import compose, conjugate, exponential, logarithm, unit
from lcpflex.model.spatial import N_PLACE, SpatialModel
from lcpflex.steppers.passages import CLIPPED, LOOKS, WITHIN

__all__ = ["crosses", "on_way"]


@kernel
def on_way(model: SpatialModel, before: FloatArray, after: FloatArray, share: float, q: FloatArray) -> None:
    """The configuration at a share of the path, along which bodies move and turn evenly, by the shorter way."""
    place = model.bodies.place
    for b in range(len(place) - 1):
        i = place[b]
        for k in range(3):
            q[i + k] = before[i + k] + share * (after[i + k] - before[i + k])
        p = (before[i + 3], before[i + 4], before[i + 5], before[i + 6])
        x, y, z = logarithm(compose(conjugate(p), (after[i + 3], after[i + 4], after[i + 5], after[i + 6])))
        w, x, y, z = unit(compose(p, exponential(share * x, share * y, share * z)))
        q[i + 3] = w
        q[i + 4] = x
        q[i + 5] = y
        q[i + 6] = z
        for k in range(i + N_PLACE, place[b + 1]):
            q[k] = before[k] + share * (after[k] - before[k])


@kernel
def depth_of_entry(model: SpatialModel, table: SpatialContactTable, k: int) -> float:
    """How deep i of entry k may be below the feature of j before it belongs to the other side [m].

    No deeper than to the centre of a sphere, or the axis of an edge that is round. Of a rim over a plane, nodes and
    facets beside it tell. Nothing round is below the rim of a cylinder; what is sharp, edges and other rims, cuts it,
    and their distance has a sign.
    """
    if table.kind[k] == RIM_FACET:
        return math.inf
    if table.kind[k] == RIM_RIM:
        return float(min(table.radius[k, 1], table.radius[k, 2]))
    if table.kind[k] == EDGE_RIM and table.radius[k, 0] == 0.0:
        return float(table.radius[k, 2])
    if table.kind[k] in (NODE_RIM, EDGE_RIM):
        return 0.0
    depth, count = model.contacts.feature_depth, len(model.contacts.feature_kind)
    reach = depth[table.key[k] % count]
    if table.kind[k] in (EDGE_EDGE, EDGE_FACET):
        if table.radius[k, 0] > 0.0 or table.radius[k, 1] > 0.0:
            return float(table.radius[k, 1])
        return min(reach, depth[table.key[k] // count - len(model.contacts.node_point)])
    if table.kind[k] != NODE_FACET and not by_cylinder(table, k) and table.radius[k, 1] >= 0.0:
        reach = min(reach, table.radius[k, 1])
    return reach


@kernel
def is_wall(table: SpatialContactTable, k: int) -> bool:
    """Whether entry k tells which side of its feature it is on: of what is flat, a hole's wall, and crossing lines.

    The distance of the lines of two edges has a sign, by their sense.
    """
    return (
        table.kind[k] in (NODE_FACET, NODE_CAP, EDGE_CAP, EDGE_EDGE, EDGE_FACET, EDGE_SIDE) or table.radius[k, 1] < 0.0
    )


@kernel
def inside(model: SpatialModel, q: FloatArray, table: SpatialContactTable, k: int) -> float:
    """How far the foot of entry k is inside its feature, and on an edge of body i inside that as well."""
    margin = foot_margin(model, q, table, k)
    return min(margin, node_margin(model, q, table, k)) if with_edge(table, k) else margin


@kernel
def crosses(
    model: SpatialModel, table: SpatialContactTable, k: int, before: FloatArray, after: FloatArray, low: float,
    high: float, free: bool, q: FloatArray,
) -> bool:  # fmt: skip
    """Whether the node of entry k goes through its feature, or over a round one, between two shares of the path.

    Entry k: as it is at ``low``. Where the path is ``free``, half as deep as that, or a little into what is round,
    wherever it ends: what was found there might as well have been missed.
    """
    limit = table.radius[k, 0] + depth_of_entry(model, table, k)  # beyond, the node is behind what it touches
    if limit == math.inf:
        return False
    if free:
        limit *= WITHIN
    deepest = table.gap[k]
    f = deepest
    for look in range(1, LOOKS + 1):
        share = low + (high - low) * look / LOOKS
        on_way(model, before, after, share, q)
        refresh(model, q, table, k)
        last, f = f, table.gap[k]
        if last > -limit >= f and is_wall(table, k):
            part = (last + limit) / (last - f)
            on_way(model, before, after, share - (1.0 - part) * (high - low) / LOOKS, q)
            refresh(model, q, table, k)
            if inside(model, q, table, k) >= -SPAN_TOLERANCE:
                return True
        if not by_cylinder(table, k) or inside(model, q, table, k) >= -SPAN_TOLERANCE:  # else beside a cylinder
            deepest = min(deepest, f)
    if is_wall(table, k):
        return False
    if free:
        return deepest < -CLIPPED / WITHIN * limit
    if table.kind[k] in (NODE_RIM, EDGE_RIM) and deepest < -(1.0 - CLIPPED) * limit:
        return True  # as deep as that goes: behind a rim, nothing is told of it any more
    on_way(model, before, after, 1.0, q)
    refresh(model, q, table, k)
    return max(-deepest, 0.0) - max(-table.gap[k], 0.0) > CLIPPED * limit
