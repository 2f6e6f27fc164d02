"""Areas over round bodies: by how much the mean of the gaps of their samples is more than the gap of their mean.

The gap grows by |d|^2/2R for a way d across the normal n, and across the axis a of what has one. With the samples s of
an area, their shares c_s, which sum to 1, and their mean r,

    V = sum_s c_s (r_s - r)(r_s - r)^T,   mean gap = gap of r + (tr V - n.V n - a.V a)/2R,

R < 0 from inside, with an error of fourth order in the width over R. The mean is a node whose radius is less by that.
"""

from __future__ import annotations

from lcpflex.bodies.spatial.surface import FACE
from lcpflex.contact.spatial.kinds import EDGE
from lcpflex.contact.spatial.narrow_phase.sides import Frame, line_between
from lcpflex.contact.spatial.pairs import locate
from lcpflex.contact.spatial.table import SpatialContactTable, copy_entry
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector
from lcpflex.kinematics.spatial.vectors import NOTHING, norm, row_vector, scaled, turned, turned_back
from lcpflex.model.spatial import SpatialModel

__all__ = ["are_spread", "keep_over_round", "radius_over"]


@kernel
def are_spread(model: SpatialModel, a: int) -> bool:
    """Whether nodes of surface a may be means of samples, as those of an open face are."""
    return len(model.contacts.node_spread) > 0 and model.contacts.surface_kind[a] == FACE


@kernel
def spread_along(model: SpatialModel, node: int, d: Vector) -> float:
    """d.V d [m^2], d in the frame of the body."""
    V = model.contacts.node_spread[node]
    x, y, z = d
    return V[0] * x * x + V[1] * y * y + V[2] * z * z + 2.0 * (V[3] * y * z + V[4] * x * z + V[5] * x * y)


@kernel
def radius_over(model: SpatialModel, i: Frame, node: int, n: Vector, a: Vector, radius: float) -> float:
    """Radius of a node of a face [m] over what curves with ``radius`` across n and a, unit vectors in world axes.

    a: 0 of spheres.
    """
    V = model.contacts.node_spread[node]
    across = V[0] + V[1] + V[2] - spread_along(model, node, turned_back(i.A, n))
    across -= spread_along(model, node, turned_back(i.A, a))
    return model.contacts.node_radius[node] - across / (2.0 * radius)


@kernel
def keep_over_round(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, frames: tuple[Frame, Frame],
    node: int, first: int, n: int,
) -> int:  # fmt: skip
    """Of the entries first..n of a node of a face, keep those with gap <= margin, as it is a mean; the new count."""
    m = first
    for k in range(first, n):
        radius = table.radius[k, 1]
        if radius > 0.0:
            axis, p = NOTHING, table.point[k, 1]
            if model.contacts.feature_kind[table.key[k] % len(model.contacts.feature_kind)] == EDGE:
                line = line_between(model.points, q, frames[1], p, table.point[k, 2])
                axis = turned(frames[1].A, scaled(1.0 / norm(line), line))
            table.radius[k, 0] = radius_over(model, frames[0], node, row_vector(table.normal, k), axis, radius)
            locate(model, q, table, k)
            if table.gap[k] > margin:
                continue
        copy_entry(table, k, table, m)
        m += 1
    return m
