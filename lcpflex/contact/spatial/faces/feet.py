"""The foot of a sample of one face on another surface: the place there whose normal leads to the sample.

    r(x, y) = sum_i N_i(x, y) r_i,   r_,a . (y - r) = 0 for both a,   gap n.(y - r),   n = r_,1 x r_,2 / |.|

found by Gauss-Newton from the middle of each face of an element nearby. Of several feet the one with the least distance
counts; faces whose normals do not face that of the sample have none.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from lcpflex.contact.spatial.faces.memory import FaceMemory
from lcpflex.contact.spatial.faces.shapes import is_inside, lay_shapes, middle
from lcpflex.contact.spatial.kinds import FACET
from lcpflex.contact.spatial.narrow_phase.sides import Frame, place_in
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import apart_from, dot, norm, row_vector, scaled
from lcpflex.model.spatial import SpatialModel

__all__ = ["find_foot", "lay_cell", "place_of", "tangents"]

STEPS = 12  # of Gauss-Newton: it gains two digits each where a gap is a hundredth of the radius of a face
SETTLED = 1e-13  # change of the coordinates that ends it
OUTSIDE = 1e-6  # of the reference face: how far beside it a foot may be, where rounding puts one of equal faces
FACING = -0.1  # cosine of the normals of what may touch, at most: faces that stand across each other do not
ROUND = 0.1  # of a facet: how far a curved face may bulge out of its plane parts


class Foot(NamedTuple):
    """On a face of an element."""

    inside: bool
    x: float
    y: float
    gap: float  # [m]
    normal: Vector  # in the frame of the face


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
def project(memory: FaceMemory, nodes: int, place: Vector) -> Foot:
    """The foot of a place on the face laid last; none where the face is degenerate there."""
    x = y = middle(nodes)
    for _ in range(STEPS):
        lay_shapes(nodes, x, y, memory.shape)
        e, f = tangents(memory, nodes)
        d = apart_from(place, combined(memory, nodes, 0))
        ee, ef, ff = dot(e, e), dot(e, f), dot(f, f)
        area = ee * ff - ef * ef
        if not area > 0.0:
            return Foot(False, x, y, math.inf, e)
        a, b = dot(e, d), dot(f, d)
        dx, dy = (ff * a - ef * b) / area, (ee * b - ef * a) / area
        x, y = x + dx, y + dy
        if abs(x) + abs(y) > 10.0:
            return Foot(False, x, y, math.inf, e)
        if abs(dx) + abs(dy) <= SETTLED or nodes == 3:
            break
    if not is_inside(nodes, x, y, OUTSIDE):
        return Foot(False, x, y, math.inf, place)
    lay_shapes(nodes, x, y, memory.shape)
    e, f = tangents(memory, nodes)
    n = cross(e, f)
    n = scaled(1.0 / norm(n), n)
    return Foot(True, x, y, dot(n, apart_from(place, combined(memory, nodes, 0))), n)


@kernel
def keep_foot(memory: FaceMemory, sample: int, f: int, foot: Foot) -> None:
    """The foot of a sample on the face of facet f."""
    memory.foot_on[sample] = f
    row = memory.foot[sample]
    row[0], row[1], row[2] = foot.x, foot.y, foot.gap
    row[3], row[4], row[5] = foot.normal


@kernel
def find_foot(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, frame: Frame, b: int, sample: int,
    place: Vector, outward: Vector,
) -> None:  # fmt: skip
    """The foot of a sample on surface b, at most ``margin`` below it, kept in the memory of faces.

    place, outward: of the sample and its normal in the frame of b.
    """
    c, memory = model.contacts, table.faces
    memory.tried[sample] = memory.search
    memory.foot_on[sample] = -1
    near = margin + table.bound[b, 3]
    least, last = math.inf, -2
    box = c.box_start[b]
    while box < c.box_start[b + 1]:
        apart = False
        for k in range(3):
            if place[k] < c.box[box, k] - near or place[k] > c.box[box, 3 + k] + near:
                apart = True
        if apart:
            box = c.box_skip[box]
            continue
        for at in range(c.box_leaf[box, 0], c.box_leaf[box, 1]):
            f = c.box_feature[at]
            cell = c.feature_cell[f]
            if c.feature_kind[f] != FACET or (cell >= 0 and cell == last):
                continue
            last = cell
            foot = project(memory, lay_cell(model, q, memory, frame, f), place)
            faces = foot.inside and dot(foot.normal, outward) <= FACING
            if faces and foot.gap <= margin and foot.gap >= -c.feature_depth[f] and abs(foot.gap) < least:
                least = abs(foot.gap)
                keep_foot(memory, sample, f, foot)
        box += 1
