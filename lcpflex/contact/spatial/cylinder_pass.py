"""What the nodes of one surface of space have with a cylinder of another: which part of it a node belongs to.

Beyond an end and beside the side it is the rim, the circle around that end; else the side or an end, whichever the node
is farther outside of, to a thickness that stands for rounding. Below the surface that is the nearest part, down to
where another one is nearer: every place has one owner, and the gap is the distance to the cylinder, without a jump.
"""

from __future__ import annotations

import math

from lcpflex.contact.spatial.entries import load_by_cylinder
from lcpflex.contact.spatial.faces.round_means import are_spread, radius_over
from lcpflex.contact.spatial.narrow_phase.cylinder import length_between, radial
from lcpflex.contact.spatial.narrow_phase.rim import rim_axis
from lcpflex.contact.spatial.narrow_phase.sides import frame_of, place_in, world_place
from lcpflex.contact.spatial.node_pass import THIN
from lcpflex.contact.spatial.pairs import locate
from lcpflex.contact.spatial.table import NODE_CAP, NODE_RIM, NODE_SIDE, SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.kinematics.spatial.vectors import apart_from, scaled
from lcpflex.model.spatial import SpatialModel

__all__ = ["SIDE_OF", "nodes_on_cylinder"]

SIDE_OF, ENDS_OF = 2, 3  # of the features of a cylinder the side and the ends: behind its two rims


@kernel
def part_of(z: float, r: float, length: float, radius: float, thin: float) -> tuple[int, int, float]:
    """Kind of pair, number of the feature, and distance [m] of a place z along and r from the axis of a cylinder."""
    end = 1 if z + z >= length else 0
    above = z - length if end == 1 else -z
    beside = r - radius
    if above > thin and beside > thin:
        return NODE_RIM, end, math.hypot(above, beside)
    if above > beside:
        return NODE_CAP, ENDS_OF + end, above
    return NODE_SIDE, SIDE_OF, beside


@late_kernel
def nodes_on_cylinder(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts of the nodes of surface a with the cylinder b, from entry n on; returns the new count."""
    c = model.contacts
    first = c.feature_start[b]
    o, x = c.feature_point[first, 0], c.feature_point[first, 1]
    frame, of_nodes = frame_of(model.bodies, q, c.surface_body[b]), frame_of(model.bodies, q, c.surface_body[a])
    start = world_place(frame, place_in(model.points, q, frame, o))
    axis = rim_axis(model.points, q, frame, o, x)
    length, thin = length_between(model.points, o, x), THIN * c.surface_extent[b]
    spread = are_spread(model, a)
    for node in range(c.node_start[a], c.node_start[a + 1]):
        place = world_place(of_nodes, place_in(model.points, q, of_nodes, c.node_point[node]))
        z, p, r = radial(axis, apart_from(place, start))
        kind, part, distance = part_of(z, r, length, c.feature_radius[first], thin)
        radius = c.node_radius[node]
        if spread and kind == NODE_SIDE and r > 0.0:  # ends are flat
            radius = radius_over(model, of_nodes, node, scaled(1.0 / r, p), axis, c.feature_radius[first])
        if distance - radius <= margin:
            if n < len(table.key):
                load_by_cylinder(model, table, n, law, kind, node, first, part)
                table.radius[n, 0] = radius
                locate(model, q, table, n)
            n += 1
    return n
