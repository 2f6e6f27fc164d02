"""The foot of a sample of one face on another surface: the place there whose normal leads to the sample.

    r(x, y) = sum_i N_i(x, y) r_i,   r_,a . (y - r) = 0 for both a,   gap n.(y - r),   n = r_,1 x r_,2 / |.|

found by Gauss-Newton from the middle of each face of an element nearby. Of several feet the one with the least distance
counts; faces whose normals do not face that of the sample have none.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from lcpflex.contact.spatial.bounds import is_beside_box
from lcpflex.contact.spatial.faces.memory import FaceMemory
from lcpflex.contact.spatial.faces.shapes import is_inside, lay_bends, lay_shapes, middle
from lcpflex.contact.spatial.kinds import FACET
from lcpflex.contact.spatial.narrow_phase.sides import Frame, place_in
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import NOTHING, apart_from, dot, is_zero, norm, row_vector, scaled
from lcpflex.model.spatial import SpatialModel

__all__ = ["cell_point", "cell_size", "find_foot", "parts_along", "place_of"]

STEPS = 12  # of Gauss-Newton: it gains two digits each where a gap is a hundredth of the radius of a face
SETTLED = 1e-13  # change of the coordinates that ends it
OUTSIDE = 1e-6  # of the reference face: how far beside it a foot may be, where rounding puts one of equal faces
FACING = -0.1  # cosine of the normals of what may touch, at most: faces that stand across each other do not
CLOSE = 0.5  # of the width of a face: a sample that is so near one has its foot there
BESIDE = 0.5  # of a facet: how far beside it a place may be that has a foot on the curved face that it is a part of
ROUND = 0.1  # of a facet: how far a curved face may bulge out of its plane parts


class Foot(NamedTuple):
    """On a face of an element."""

    inside: bool
    gap: float  # [m]
    normal: Vector  # in the frame of the body
    e: Vector  # r_,1 there
    f: Vector
    bent: Vector  # n.r_,11, n.r_,12, n.r_,22


NOWHERE = Foot(False, math.inf, NOTHING, NOTHING, NOTHING, NOTHING)


@kernel
def place_of(model: SpatialModel, q: FloatArray, memory: FaceMemory, frame: Frame, p: int) -> Vector:
    """Where material point p is in the frame of its body [m], found once a search."""
    if memory.known[p] != memory.search:
        memory.known[p] = memory.search
        at = place_in(model.points, q, frame, p)
        memory.place[p, 0], memory.place[p, 1], memory.place[p, 2] = at
    return row_vector(memory.place, p)


@kernel
def cell_size(model: SpatialModel, f: int) -> int:
    """How many nodes the face of an element has that facet f is a part of."""
    cell = model.contacts.feature_cell[f]
    return 3 if cell < 0 else model.contacts.cell_start[cell + 1] - model.contacts.cell_start[cell]


@kernel
def cell_point(model: SpatialModel, f: int, i: int) -> int:
    """Node i of that face."""
    cell = model.contacts.feature_cell[f]
    return (
        model.contacts.feature_point[f, i]
        if cell < 0
        else model.contacts.cell_point[model.contacts.cell_start[cell] + i]
    )


@kernel
def lay_cell(model: SpatialModel, q: FloatArray, memory: FaceMemory, frame: Frame, f: int) -> int:
    """Places of the nodes of the face that facet f is a part of, in ``memory.corner``; how many they are."""
    nodes = cell_size(model, f)
    for i in range(nodes):
        at = place_of(model, q, memory, frame, cell_point(model, f, i))
        memory.corner[i, 0], memory.corner[i, 1], memory.corner[i, 2] = at
    return nodes


@kernel
def combined(memory: FaceMemory, nodes: int, column: int) -> Vector:
    """Sum of the places of the nodes, by a column of the shape functions."""
    x = y = z = 0.0
    for i in range(nodes):
        weight = memory.shape[i, column]
        x += weight * memory.corner[i, 0]
        y += weight * memory.corner[i, 1]
        z += weight * memory.corner[i, 2]
    return x, y, z


@kernel
def tangents(memory: FaceMemory, nodes: int) -> tuple[Vector, Vector]:
    """r_,1 and r_,2 of the face laid last, by the shape functions laid last."""
    return combined(memory, nodes, 1), combined(memory, nodes, 2)


@kernel
def parts_along(d: Vector, e: Vector, f: Vector) -> tuple[float, float, float]:
    """Coefficients of the projection of d on the plane of e and f, by these, times |e x f|^2; and that."""
    ee, ef, ff = dot(e, e), dot(e, f), dot(f, f)
    a, b = dot(e, d), dot(f, d)
    return ff * a - ef * b, ee * b - ef * a, ee * ff - ef * ef


@kernel
def bent_along(memory: FaceMemory, nodes: int, x: float, y: float, n: Vector) -> Vector:
    """n.r_,11, n.r_,12 and n.r_,22 of the face laid last [m]."""
    if nodes == 3:
        return NOTHING
    lay_bends(nodes, x, y, memory.bend)
    xx = xy = yy = 0.0
    for i in range(nodes):
        height = dot(n, row_vector(memory.corner, i))
        xx += memory.bend[i, 0] * height
        xy += memory.bend[i, 1] * height
        yy += memory.bend[i, 2] * height
    return xx, xy, yy


@kernel
def project(memory: FaceMemory, nodes: int, place: Vector) -> Foot:
    """The foot of a place on the face laid last; none where the face is degenerate there."""
    x = y = middle(nodes)
    for _ in range(STEPS):
        lay_shapes(nodes, x, y, memory.shape)
        e, f = tangents(memory, nodes)
        dx, dy, area = parts_along(apart_from(place, combined(memory, nodes, 0)), e, f)
        if not area > 0.0:
            return NOWHERE
        dx, dy = dx / area, dy / area
        x, y = x + dx, y + dy
        if abs(x) + abs(y) > 10.0:
            return NOWHERE
        if abs(dx) + abs(dy) <= SETTLED or nodes == 3:
            break
    if not is_inside(nodes, x, y, OUTSIDE):
        return NOWHERE
    lay_shapes(nodes, x, y, memory.shape)
    e, f = tangents(memory, nodes)
    n = cross(e, f)
    n = scaled(1.0 / norm(n), n)
    gap = dot(n, apart_from(place, combined(memory, nodes, 0)))
    return Foot(True, gap, n, e, f, bent_along(memory, nodes, x, y, n))


@kernel
def keep_foot(memory: FaceMemory, sample: int, f: int, nodes: int, foot: Foot) -> None:
    """The foot of a sample on the face of facet f, which was projected on last."""
    memory.foot_on[sample] = f
    memory.gap[sample] = foot.gap
    for c in range(3):
        memory.normal[sample, c] = foot.normal[c]
        memory.along[sample, 0, c] = foot.e[c]
        memory.along[sample, 1, c] = foot.f[c]
        memory.bent[sample, c] = foot.bent[c]
    for i in range(nodes):
        for c in range(3):
            memory.at_foot[sample, i, c] = memory.shape[i, c]


@kernel
def accepted(foot: Foot, outward: Vector, margin: float) -> bool:
    """Whether a foot is one of a sample with this outward normal, at most ``margin`` below it; 0: a round one's."""
    faces = is_zero(outward) or dot(foot.normal, outward) <= FACING
    return foot.inside and foot.gap <= margin and faces


@kernel
def width(memory: FaceMemory) -> float:
    """Length of the first side of the face laid last [m]."""
    return norm(apart_from(row_vector(memory.corner, 1), row_vector(memory.corner, 0)))


@kernel
def is_over(model: SpatialModel, q: FloatArray, memory: FaceMemory, frame: Frame, f: int, place: Vector) -> bool:
    """Whether a place is over or below a plane facet, or not far beside it: a curved face may have its foot there."""
    point = model.contacts.feature_point
    a = place_of(model, q, memory, frame, point[f, 0])
    e = apart_from(place_of(model, q, memory, frame, point[f, 1]), a)
    g = apart_from(place_of(model, q, memory, frame, point[f, 2]), a)
    x, y, area = parts_along(apart_from(place, a), e, g)
    slack = BESIDE * area
    return x >= -slack and y >= -slack and x + y <= area + slack


@kernel
def find_foot(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, frame: Frame, b: int, sample: int,
    place: Vector, outward: Vector,
) -> None:  # fmt: skip
    """The foot of a sample on surface b, at most ``margin`` below it, kept in the memory of faces.

    place, outward: of the sample and its normal in the frame of b. Where the face of the last one has one that is
    nearer than that face is large, no other can have a nearer one.
    """
    c, memory = model.contacts, table.faces
    memory.tried[sample] = memory.search
    f = memory.foot_on[sample]
    if f >= c.feature_start[b] and f < c.feature_start[b + 1]:
        nodes = lay_cell(model, q, memory, frame, f)
        foot = project(memory, nodes, place)
        if accepted(foot, outward, margin) and abs(foot.gap) <= CLOSE * width(memory):
            keep_foot(memory, sample, f, nodes, foot)
            return
    memory.foot_on[sample] = -1
    near = margin + table.bound[b, 3]
    least, last = math.inf, -2
    box = c.box_start[b]
    while box < c.box_start[b + 1]:
        if is_beside_box(model, box, place, place, near):
            box = c.box_skip[box]
            continue
        for at in range(c.box_leaf[box, 0], c.box_leaf[box, 1]):
            f = c.box_feature[at]
            cell = c.feature_cell[f]
            if c.feature_kind[f] != FACET or (cell >= 0 and cell == last):
                continue
            if not is_over(model, q, memory, frame, f, place):
                continue
            last = cell
            nodes = lay_cell(model, q, memory, frame, f)
            foot = project(memory, nodes, place)
            if accepted(foot, outward, margin) and foot.gap >= -c.feature_depth[f] and abs(foot.gap) < least:
                least = abs(foot.gap)
                keep_foot(memory, sample, f, nodes, foot)
        box += 1
