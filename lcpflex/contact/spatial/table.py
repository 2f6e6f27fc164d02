"""The table of near contacts in space: what detection fills, and steppers read.

An entry is a pair of features with its gap, normal and tangents. Its kind tells which (normal n from body j to body i,
t2 = n x t1):

* NODE_FACET: node P on i, plane through a, b, c on j (a facet, or a plane without end);
* NODE_EDGE: node P on i, edge a, b of radius R on j (R = 0: sharp, else the side of a capsule or cylinder);
* NODE_POINT: node P on i, vertex or sphere o of radius R on j (R < 0: touched from inside);
* EDGE_EDGE: edge a, b on i and edge c, d on j;
* EDGE_FACET: edge a, b on i and edge c, d on j, which cross over the face of i or j that has the last point, too;
* RIM_FACET: rim of a disc with centre o and a point on its axis on i, plane through a, b, c on j;
* NODE_SIDE, NODE_CAP, NODE_RIM: node P on i, cylinder from o along its axis to x on j: its side, the flat of one of its
  ends, or the circle around that;
* EDGE_SIDE, EDGE_RIM: edge a, b on i, side or rim of a cylinder from o to x on j;
* RIM_RIM: rims with centres o and a point on their axis on i and j;
* EDGE_CAP: edge a, b on i, where it leaves or enters the flat of an end of a cylinder from o to x on j.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from lcpflex.contact.rule_pairs import RulePairs, no_pairs
from lcpflex.contact.spatial.faces.memory import FaceMemory, FaceSizes, copy_means, face_memory, mean_of
from lcpflex.contact.table import ALL
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.model.arrays import frozen
from lcpflex.model.spatial import SpatialModel, SpatialPoints

__all__ = [
    "EDGE_CAP",
    "EDGE_EDGE",
    "EDGE_FACET",
    "EDGE_RIM",
    "EDGE_SIDE",
    "NODE_CAP",
    "NODE_EDGE",
    "NODE_FACET",
    "NODE_POINT",
    "NODE_RIM",
    "NODE_SIDE",
    "RIM_FACET",
    "RIM_RIM",
    "SpatialContactTable",
    "by_cylinder",
    "copy_entry",
    "points_of",
    "with_edge",
    "side_of",
    "spatial_contact_table",
    "weight_of",
]

PAIRS = (  # what of body i, and what of body j: by the numbers of the kinds
    ("node", "facet"),
    ("node", "edge"),
    ("node", "point"),
    ("edge", "edge"),
    ("rim", "facet"),
    ("node", "side"),
    ("node", "cap"),
    ("node", "rim"),
    ("edge", "side"),
    ("edge", "rim"),
    ("edge", "facet"),
    ("edge", "cap"),
    ("rim", "other rim"),
)
(
    NODE_FACET, NODE_EDGE, NODE_POINT, EDGE_EDGE, RIM_FACET, NODE_SIDE, NODE_CAP, NODE_RIM, EDGE_SIDE, EDGE_RIM,
    EDGE_FACET, EDGE_CAP, RIM_RIM,
) = range(len(PAIRS))  # fmt: skip
WITH_EDGE = frozen([of_i == "edge" for of_i, _ in PAIRS], bool)
BY_CYLINDER = frozen([of_j in ("side", "cap", "rim") for _, of_j in PAIRS], bool)


@struct
class SpatialContactTable:
    """Near contacts, one an entry, in the order of detection. Work arrays apart, the first length is the capacity."""

    key: IntArray = array("contacts")  # both features in one number, the same from call to call
    law: IntArray = array("contacts")  # declared contact
    kind: IntArray = array("contacts")
    node: IntArray = array("contacts")  # material point P, or the first one of i
    # material points: P, or a, b, or o and on the axis; then those of j, or of a face over which edges cross
    point: IntArray = array("contacts", 5)
    # of the node (or edge) of i, of the feature of j, of a rim or cylinder [m]
    radius: FloatArray = array("contacts", 3)
    # of the normal: of spheres sign of R, of two edges that of e x f; of the end of a cylinder +1 at x; else +1
    sense: FloatArray = array("contacts")
    # share of the corner in the middle of the patch it belongs to, by which forces that nothing determines are divided
    weight: FloatArray = array("contacts")
    # common area that the force of the entry acts on [m^2]; 0 where a force is no pressure
    area: FloatArray = array("contacts")
    curvature: FloatArray = array("contacts", 3)  # n.r'' of the master [1/m] along t1 t1, t1 t2 and t2 t2; of means
    averaged: IntArray = array("contacts")  # 1: its material points are means, of ``faces``, else those of the model
    # of nodes: least cosine of their outward normal and that of j, reversed; of a rim in a patch: the angle of the
    facing: FloatArray = array("contacts")  # place that touches where it lies flat [rad]
    # xi^1, xi^2 in a facet; s on an edge; s and t of two edges; s on an edge, and which half of a rim or end it meets;
    # of two rims, angles [rad]
    foot: FloatArray = array("contacts", 2)
    body: IntArray = array("contacts", 2)  # i, j; -1: ground
    gap: FloatArray = array("contacts")  # [m]
    normal: FloatArray = array("contacts", 3)  # from j to i, world axes
    tangent: FloatArray = array("contacts", 3)  # t1, world axes
    along: IntArray = array("contacts")  # which axis of body j t1 is the projection of; -1: the first edge of j
    bound: FloatArray = array("surfaces", 4)  # work: world centre of each surface, its deflection
    patch: FloatArray = array(2, "corners", 4)  # work: corners of a patch before and behind a cut, and a number of each
    trace: IntArray = array(2, "corners", 4)  # work: what made them
    shift: FloatArray = array("shifts")  # work: Phi eta of the nodes of a surface, body axes: x, y, z of all
    plane: FloatArray = array("surfaces", 15)  # work: of planes n, a point, t1 and the dual edges; world axes
    compliant: IntArray = array("laws")  # as in the plane
    first: IntArray = array("declared")  # first surface of each declared contact, in tables that tell it
    owner: IntArray = array("owners")  # and the body of each surface there
    collects: int
    seams: int  # 1: what bodies have on an edge of one alone, beyond two of its faces at once, is no contact
    pairs: RulePairs
    faces: FaceMemory
    touching: float


def spatial_contact_table(
    capacity: int,
    n_surfaces: int = 0,
    compliant: Sequence[int] = (),
    collects: int = ALL,
    pairs: RulePairs | None = None,
    touching: float = math.inf,
    corners: int = 0,
    faces: FaceSizes | None = None,
    nodes: int = 0,
) -> SpatialContactTable:
    """An empty table for ``capacity`` contacts between ``n_surfaces`` surfaces (those of the model it is used with).

    pairs: of the rule of that model, where it has one. corners: that a patch of that model has, at most. faces: what
    open faces of that model need. nodes: of the largest surface whose nodes are placed together.
    """
    return allocate(
        SpatialContactTable,
        {"contacts": capacity, "surfaces": n_surfaces, "corners": corners, "shifts": 3 * nodes},
        compliant=np.array(compliant, np.int64),
        first=np.zeros(0, np.int64),
        owner=np.zeros(0, np.int64),
        collects=collects,
        pairs=no_pairs() if pairs is None else pairs,
        faces=face_memory(capacity, faces),
        touching=touching,
    )


@kernel
def points_of(model: SpatialModel, table: SpatialContactTable, k: int) -> SpatialPoints:
    """What the material points of entry k are numbers of."""
    if table.averaged[k] == 1:
        return table.faces.means
    return model.points


@kernel
def copy_entry(source: SpatialContactTable, i: int, target: SpatialContactTable, j: int) -> None:
    """Entry i of one table becomes entry j of another (or the same)."""
    target.key[j] = source.key[i]
    target.law[j] = source.law[i]
    target.kind[j] = source.kind[i]
    target.node[j] = source.node[i]
    target.sense[j] = source.sense[i]
    target.weight[j] = source.weight[i]
    target.area[j] = source.area[i]
    target.facing[j] = source.facing[i]
    target.gap[j] = source.gap[i]
    target.along[j] = source.along[i]
    target.averaged[j] = source.averaged[i]
    for c in range(5):
        target.point[j, c] = source.point[i, c]
    if source.averaged[i] == 1:
        copy_means(source.faces, i, target.faces, j)
        for c in range(5):
            target.point[j, c] = mean_of(j, c % 4)
    for c in range(3):
        target.radius[j, c] = source.radius[i, c]
        target.curvature[j, c] = source.curvature[i, c]
        target.normal[j, c] = source.normal[i, c]
        target.tangent[j, c] = source.tangent[i, c]
    for c in range(2):
        target.foot[j, c] = source.foot[i, c]
        target.body[j, c] = source.body[i, c]


@kernel
def by_cylinder(table: SpatialContactTable, k: int) -> bool:
    """Whether entry k is that of a node or edge with a part of a cylinder."""
    return BY_CYLINDER[table.kind[k]]


@kernel
def with_edge(table: SpatialContactTable, k: int) -> bool:
    """Whether what of body i touches in entry k is an edge."""
    return WITH_EDGE[table.kind[k]]


@kernel
def side_of(told: Any, law: int, i: int) -> float:
    """1 where body i of an entry is that of the first surface of contact ``law``, -1 where that is its body j.

    told: a table that does, of the recorder or of compliant contacts. Where it knows no surfaces of a contact, the
    side i is taken for the first.
    """
    surface = -1
    if law < len(told.first):
        surface = told.first[law]
    elif law < len(told.pairs.pair):
        surface = told.pairs.pair[law, 0]
    return 1.0 if surface < 0 or told.owner[surface] == i else -1.0


@kernel
def weight_of(table: SpatialContactTable, k: int) -> float:
    """Share of entry k in what its law does: those of the corners of a patch make 4, as of a box on a plane."""
    return table.weight[k]
