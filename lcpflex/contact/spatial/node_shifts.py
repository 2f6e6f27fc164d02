"""Displacements of all nodes of a surface at once: what each of them adds up mode by mode, side by side.

Sums of one node wait for each other, those of many nodes do not: each is the same, and all take a fifth of the time.
"""

from __future__ import annotations

from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector
from lcpflex.kinematics.spatial.vectors import added, row_vector
from lcpflex.model.spatial import N_PLACE, SpatialModel, SpatialPoints

__all__ = ["moved_place", "shift_nodes"]


@kernel
def add_in_turn(shapes: FloatArray, x: FloatArray, out: FloatArray) -> None:
    """out (k,) += sum_l x_l shapes_l, shapes flat (len(x), k), one after the other.

    Four at a time, so that ``out`` is loaded and stored a quarter as often.
    """
    n, width = len(x), len(out)
    whole = n - n % 4
    for i in range(0, whole, 4):
        a, b, c, d = x[i], x[i + 1], x[i + 2], x[i + 3]
        first = shapes[i * width : (i + 1) * width]
        second = shapes[(i + 1) * width : (i + 2) * width]
        third = shapes[(i + 2) * width : (i + 3) * width]
        fourth = shapes[(i + 3) * width : (i + 4) * width]
        for k in range(width):
            out[k] = (((out[k] + first[k] * a) + second[k] * b) + third[k] * c) + fourth[k] * d
    for i in range(whole, n):
        a = x[i]
        row = shapes[i * width : (i + 1) * width]
        for k in range(width):
            out[k] += row[k] * a


@kernel
def shift_nodes(model: SpatialModel, q: FloatArray, table: SpatialContactTable, a: int) -> bool:
    """``table.shift`` = Phi eta of the nodes of surface a; False where their shapes are not kept side by side."""
    c, place = model.contacts, model.bodies.place
    first, last = c.shape_start[a], c.shape_start[a + 1]
    if first == last:
        return False
    count, b = c.node_start[a + 1] - c.node_start[a], c.surface_body[a]
    out = table.shift[: 3 * count]
    for k in range(3 * count):
        out[k] = 0.0
    add_in_turn(c.node_shape[first:last], q[place[b] + N_PLACE : place[b + 1]], out)
    return True


@kernel
def moved_place(points: SpatialPoints, table: SpatialContactTable, p: int, at: int, count: int) -> Vector:
    """s of point p [m], which is node ``at`` of the ``count`` shifted last, in its frame."""
    shift = table.shift
    return added(row_vector(points.place, p), (shift[at], shift[count + at], shift[2 * count + at]))
