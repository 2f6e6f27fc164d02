"""Rows W and biases w of contact pairs: gdot = W^T u, gddot = W^T udot + w.

P is the node with radius r on body i; the feature belongs to body j. With J = [[0, -1], [1, 0]] and t = -J n:

    segment a-b, Q = r_a + s e, e = r_b - r_a:  gdot_N = n.(v_P - v_Q), gdot_T = t.(v_P - v_Q) + r adot_P
    arc about o, n = sense (r_P - r_o)/|.|:     gdot_N = n.(v_P - v_o), gdot_T = t.(v_P - v_o) + r adot_P + R adot_o

where adot is the rate of rotation of the material at a point and R the signed radius (< 0 for holes). w collects the
Coriolis and centrifugal accelerations, the rotation of n and t, and the sliding of Q along its surface.
Sources: Pfeiffer & Glocker 1996; Ebrahimi & Eberhard 2005.
"""

from __future__ import annotations

from lcpflex.contact.narrow_phase.feature import feature_rows, feature_velocity
from lcpflex.contact.table import ContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.points import (
    add_point_rows,
    add_rotation_row,
    point_motion,
    point_position,
)
from lcpflex.model.arrays import Model


@in_space("lcpflex.contact.spatial.pairs")
@kernel
def contact_rows(
    model: Model, q: FloatArray, table: ContactTable, k: int, normal: FloatArray, tangents: FloatArray
) -> None:
    """Rows of entry k at q, ``normal`` (2, width) and ``tangents`` (1, 2, width), of which there are two in space.

    Blocks for body i and body j; a block on the ground stays 0.
    """
    tangent = tangents[0]
    for i in range(2):
        for c in range(normal.shape[1]):
            normal[i, c] = 0.0
            tangent[i, c] = 0.0
    if table.body[k, 0] >= 0:
        p = table.node[k]
        nx = table.normal[k, 0]
        ny = table.normal[k, 1]
        add_point_rows(model.bodies, model.points, q, p, nx, ny, normal[0], tangent[0])
        if table.node_radius[k] != 0.0:
            add_rotation_row(model.points, p, table.node_radius[k], tangent[0])
    if table.body[k, 1] >= 0:
        feature_rows(model, q, table, k, normal[1], tangent[1])


@in_space("lcpflex.contact.spatial.pairs")
@kernel
def gap_rate(model: Model, q: FloatArray, u: FloatArray, table: ContactTable, k: int) -> float:
    """gdot_N [m/s] of entry k."""
    _, _, vx, vy, _, _ = point_motion(model.bodies, model.points, q, u, table.node[k])
    wx, wy = feature_velocity(model, q, u, table, k)
    return table.normal[k, 0] * (vx - wx) + table.normal[k, 1] * (vy - wy)


@in_space("lcpflex.contact.spatial.pairs")
@kernel
def contact_point(model: Model, q: FloatArray, table: ContactTable, k: int) -> tuple[float, float]:
    """Where entry k touches: the point of the node's circle nearest to the feature [m], world axes."""
    px, py = point_position(model.bodies, model.points, q, table.node[k])
    return px - table.node_radius[k] * table.normal[k, 0], py - table.node_radius[k] * table.normal[k, 1]
