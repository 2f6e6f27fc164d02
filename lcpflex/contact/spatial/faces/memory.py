"""Material points that detection makes for the contacts of faces, and its scratch.

A contact of two faces is one of means: of the slave, of the feet of it on the master, and of the tangents there. Each
mean is a material point, as its place and its modes are those of nodes, weighted. An entry k of a table has four, which
stand where no other entry has its own: S of the slave, and a, b, c, through which the plane of the master goes.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, pack, struct
from lcpflex.model.spatial import SpatialPoints, material_points

__all__ = [
    "EACH",
    "KEPT",
    "MEANS",
    "PARTS",
    "FaceMemory",
    "FaceSizes",
    "KeptMeans",
    "copy_means",
    "face_memory",
    "face_sizes",
    "mean_of",
]

MEANS = 4  # material points of an entry
EACH = 2  # numbers of points that one takes: what offsets of modes begin at the one behind it is no point
PARTS = 10  # points of an entry that are told: a node, and its foot in a facet of nine nodes
KEPT = 96  # points of means that are kept: 25 of the slave and 49 of the master are nodes of faces of nine nodes


@struct
class KeptMeans:
    """Of areas the means made last: see :mod:`lcpflex.contact.spatial.faces.kept`. Of node k in row k - ``first``."""

    first: int  # the first node of the model that is an area
    used: int  # 1: by a stepper whose gaps may be wrong by as little as those of kept means are
    count: IntArray = array("areas")  # points that have a part in them; 0: none are kept
    own: IntArray = array("areas")  # of the slave, the first ones
    on: IntArray = array("areas")  # surface of the master
    whole: IntArray = array("areas")  # 1: all samples have a foot
    point: IntArray = array("areas", KEPT)
    weight: FloatArray = array("areas", KEPT, 4)  # in S, and in the foot and both tangents of the master
    area: FloatArray = array("areas")  # common [m^2]
    curvature: FloatArray = array("areas", 3)  # of the master [1/m]
    gap: FloatArray = array("areas")  # when they were made [m]
    rise: FloatArray = array("areas")  # of the highest sample that has a foot, above that [m]
    slip: FloatArray = array("areas", 2)  # place of S along both tangents [m]
    turn: FloatArray = array("areas", 2, 3)  # two axes of the body of the slave, in the frame of that of the master
    reach: FloatArray = array("areas")  # how far the samples are from their mean, undeformed [m]; 0: not known


@struct
class FaceMemory:
    """Means of the entries of a table, and what the search of feet works with.

    ``means`` is like the points of a model, and kernels take it in their place.
    """

    means: SpatialPoints
    kept: KeptMeans
    modes: int  # rows of the modes of a mean
    search: int  # number of the present one: what is known of it has this number
    known: IntArray = array("points")  # number of the search in which a place was found
    place: FloatArray = array("points", 3)  # of the material points of the model, deformed, in the frame of their body
    foot_on: IntArray = array("samples")  # feature of the foot of each sample; -1: none
    gap: FloatArray = array("samples")  # there [m]
    normal: FloatArray = array("samples", 3)  # and the normal, in the frame of the body of the face
    along: FloatArray = array("samples", 2, 3)  # and the tangents r_,1 and r_,2
    at_foot: FloatArray = array("samples", 9, 3)  # and the shape functions of the nodes, with their derivatives
    bent: FloatArray = array("samples", 3)  # and n.r_,11, n.r_,12 and n.r_,22 [m]
    tried: IntArray = array("samples")  # number of the search in which it was looked for
    listed: IntArray = array("points")  # points that have a part in the means of a node, those of the slave first
    part: FloatArray = array("points", 4)  # their weights: in S, and in the foot and both tangents of the master
    found: IntArray = array("points")  # the points as they are found
    weight: FloatArray = array("points", 4)  # and the weights of each point, 0 between nodes
    shape: FloatArray = array(9, 3)
    bend: FloatArray = array(9, 3)  # second derivatives of the shape functions
    corner: FloatArray = array(9, 3)
    curvature: FloatArray = array(3)  # of the master of the present mean [1/m], along both tangents
    told: IntArray = array(
        "entries", 2
    )  # how many points the means of an entry have, of the slave and the master; or 0
    told_point: IntArray = array("entries", PARTS)  # those of the slave first
    told_weight: FloatArray = array("entries", PARTS, MEANS)  # their weights in each mean


FaceSizes: TypeAlias = dict[str, int]  # how much memory the faces of a model need, by the names of dimensions


def no_faces() -> FaceSizes:
    """Of a model without."""
    return {"points": 0, "samples": 0, "first": 0, "areas": 0, "modes": 0}


def face_sizes(contacts: Any) -> FaceSizes:
    """Of the contacts of a model."""
    samples = len(contacts.sample_start) - 1 if hasattr(contacts, "sample_start") else 0
    if samples <= 0:
        return no_faces()
    used = [contacts.node_point, contacts.feature_point.ravel(), contacts.cell_point, contacts.sample_point]
    points = 1 + max(int(np.max(some, initial=-1)) for some in used)
    areas = np.flatnonzero(np.diff(contacts.area_start) > 1)
    first, end = (int(areas[0]), int(areas[-1]) + 1) if len(areas) else (0, 0)
    modes = contacts.surface_deflection.shape[1]
    return {"points": points, "samples": samples, "first": first, "areas": end - first, "modes": modes}


def face_memory(capacity: int, sizes: FaceSizes | None = None) -> FaceMemory:
    """For a table of ``capacity`` entries."""
    sizes = sizes or no_faces()
    entries = capacity if sizes["samples"] else 0
    count, modes = MEANS * EACH * entries, sizes["modes"]
    start = np.zeros(count + 1, np.int64)
    flat = np.zeros((MEANS * entries * modes, 3))
    means = material_points(np.zeros(count, np.int64), np.zeros((count, 3)), start, flat, flat.copy())
    kept = allocate(KeptMeans, sizes, first=sizes["first"])
    made: FaceMemory = allocate(FaceMemory, {**sizes, "entries": entries}, means=pack(means), kept=kept, modes=modes)
    return made


@kernel
def mean_of(k: int, which: int) -> int:
    """The material point that is mean ``which`` of entry k."""
    return MEANS * EACH * k + EACH * which


@kernel
def lay_mean(memory: FaceMemory, k: int, which: int, body: int, modes: int) -> int:
    """Say that a mean of entry k is one of a body with so many modes; the first of the rows of its modes."""
    means = memory.means
    p = mean_of(k, which)
    first = (MEANS * k + which) * memory.modes
    means.body[p] = body
    means.start[p] = first
    means.start[p + 1] = first + modes
    return first


@kernel
def clear_rows(rows: FloatArray) -> None:
    """Set rows of three to 0."""
    line = rows.reshape(rows.size)
    for i in range(len(line)):
        line[i] = 0.0


@kernel
def copy_rows(rows: FloatArray, to: FloatArray) -> None:
    """Copy rows of three."""
    line, other = rows.reshape(rows.size), to.reshape(to.size)
    for i in range(len(line)):
        other[i] = line[i]


@kernel
def begin_mean(memory: FaceMemory, k: int, which: int, body: int, modes: int) -> int:
    """Make a mean of entry k one at 0, of a body with so many modes; the first of the rows of these."""
    first = lay_mean(memory, k, which, body, modes)
    for c in range(3):
        memory.means.place[mean_of(k, which), c] = 0.0
    clear_rows(memory.means.phi[first : first + modes])
    return first


@kernel
def copy_means(source: FaceMemory, i: int, target: FaceMemory, j: int) -> None:
    """The means of entry i of one table become those of entry j of another, or the same ones of the same."""
    for which in range(MEANS):
        p, to = mean_of(i, which), mean_of(j, which)
        start = source.means.start[p]
        modes = source.means.start[p + 1] - start
        first = lay_mean(target, j, which, source.means.body[p], modes)
        for c in range(3):
            target.means.place[to, c] = source.means.place[p, c]
        copy_rows(source.means.phi[start : start + modes], target.means.phi[first : first + modes])
    target.told[j, 0], target.told[j, 1] = source.told[i, 0], source.told[i, 1]
    for at in range(source.told[i, 0] + source.told[i, 1]):
        target.told_point[j, at] = source.told_point[i, at]
        for which in range(MEANS):
            target.told_weight[j, at, which] = source.told_weight[i, at, which]
