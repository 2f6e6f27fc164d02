"""The kinds of features, and the one place that chooses among them."""

from __future__ import annotations

import math

from lcpflex.contact.narrow_phase.arc import (
    arc_bias,
    arc_margin,
    arc_rows,
    arc_velocity,
    near_arc,
    over_arc,
    refresh_arc,
    within_arc,
)
from lcpflex.contact.narrow_phase.segment import (
    near_segment,
    over_segment,
    refresh_segment,
    segment_bias,
    segment_rows,
    segment_velocity,
)
from lcpflex.contact.narrow_phase.vertex import over_vertex, vertex_margin
from lcpflex.contact.table import ContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.points import point_angle
from lcpflex.model.arrays import Model

__all__ = [
    "ARC",
    "SEGMENT",
    "VERTEX",
    "contact_bias",
    "depth_of_feature",
    "feature_rows",
    "feature_velocity",
    "foot_margin",
    "is_wall",
    "may_touch",
    "over",
    "refresh",
    "node_margin",
]

SEGMENT, ARC, VERTEX = range(3)


@kernel
def may_touch(model: Model, f: int, x: float, y: float, reach: float, deflection: float) -> bool:
    """Whether a node at (x, y), in the frame of feature f, is within ``reach`` of its undeformed shape or below it.

    ``deflection``: how far deformation may carry points of the feature's surface [m].
    """
    if model.contacts.feature_kind[f] == SEGMENT:
        return near_segment(model, f, x, y, reach, deflection)
    return near_arc(model, f, x, y, reach)


@kernel
def over(
    model: Model, q: FloatArray, f: int, x: float, y: float, highest: float
) -> tuple[bool, float, float, float, float, float]:
    """Whether a node at (x, y), in the frame of the body of f, is over f, at most ``highest`` above and not too deep.

    Further s, the signed distance without radius of the node from the line or circle of f, the normal, and how far
    the node is from f itself: beyond the end of a segment from that end, not from its line.
    """
    kind = model.contacts.feature_kind[f]
    if kind == SEGMENT:
        return over_segment(model, q, f, x, y, highest)
    if kind == VERTEX:
        return over_vertex(model, q, f, x, y, highest)
    return over_arc(model, q, f, x, y, highest)


@in_space("lcpflex.contact.spatial.pairs")
@kernel
def refresh(model: Model, q: FloatArray, table: ContactTable, k: int) -> None:
    """Gap, normal and foot of entry k at q, with its feature kept."""
    if table.kind[k] == SEGMENT:
        refresh_segment(model, q, table, k)
    else:
        refresh_arc(model, q, table, k)


@kernel
def feature_rows(
    model: Model, q: FloatArray, table: ContactTable, k: int, normal_row: FloatArray, tangent_row: FloatArray
) -> None:
    """Add the blocks of the body of the feature to the rows of entry k."""
    if table.kind[k] == SEGMENT:
        segment_rows(model, q, table, k, normal_row, tangent_row)
    else:
        arc_rows(model, q, table, k, normal_row, tangent_row)


@kernel
def feature_velocity(model: Model, q: FloatArray, u: FloatArray, table: ContactTable, k: int) -> tuple[float, float]:
    """Velocity of the point that the gap of entry k is measured from [m/s]."""
    if table.kind[k] == SEGMENT:
        return segment_velocity(model, q, u, table, k)
    return arc_velocity(model, q, u, table, k)


@in_space("lcpflex.contact.spatial.pairs")
@kernel
def contact_bias(model: Model, q: FloatArray, u: FloatArray, table: ContactTable, k: int) -> tuple[float, float]:
    """w_N and w_T [m/s^2] of entry k."""
    if table.kind[k] == SEGMENT:
        return segment_bias(model, q, u, table, k)
    return arc_bias(model, q, u, table, k)


@in_space("lcpflex.contact.spatial.pairs")
@kernel
def foot_margin(model: Model, q: FloatArray, table: ContactTable, k: int) -> float:
    """How far the foot of entry k is inside its feature: in s of a segment or its neighbours, in angle of an arc."""
    if table.kind[k] == SEGMENT:
        return min(table.s[k] - table.span[k, 0], table.span[k, 1] - table.s[k])
    if table.kind[k] == VERTEX:
        return vertex_margin(model, q, table, k)
    return arc_margin(model, q, table, k)


@in_space("lcpflex.contact.spatial.pairs")
@kernel
def node_margin(model: Model, q: FloatArray, table: ContactTable, k: int) -> float:
    """How far the foot of entry k is inside the arc that its node is [rad]."""
    if table.node_radius[k] == 0.0:
        return math.inf
    span = model.contacts.node_span[table.key[k] // len(model.contacts.feature_kind)]
    angle = math.atan2(-table.normal[k, 1], -table.normal[k, 0])
    return within_arc(angle - point_angle(model.bodies, model.points, q, table.node[k]), span[0], span[1])


@kernel
def depth_of_feature(model: Model, table: ContactTable, k: int) -> float:
    """How deep below its feature the node of entry k is still of it [m]: no deeper than to the centre of a disc."""
    reach = model.contacts.feature_depth[table.key[k] % len(model.contacts.feature_kind), 1]
    if table.kind[k] != SEGMENT and table.radius[k] >= 0.0:
        reach = min(reach, table.radius[k])
    return reach


@kernel
def is_wall(table: ContactTable, k: int) -> bool:
    """Whether the feature of entry k is passed in a straight line through it only: a segment or the wall of a hole."""
    return table.kind[k] == SEGMENT or table.sense[k] < 0.0
