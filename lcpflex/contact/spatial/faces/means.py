"""The means that make a contact of a node or an area of one face with the faces of another surface.

With the shares c_s of its samples that have a foot, sum c_s = 1, and the directions d_a in the middle of the contact,

    S = sum_s c_s r_s,   M = sum_s c_s sum_i N_i r_i,   T_a = sum_s c_s P_s d_a,
    P_s d = (r_,1 r_,2) A^-1 (r_,1 r_,2)^T d,   A_ab = r_,a . r_,b

The gap is that of S over the plane through M along T_1 and T_2, in which feet may lie beside M: an area of one body
slides over one of the other as a node does over a facet. All are weighted sums of nodes, so they are material points:
rows, rates and biases are those of any others. On flat faces this is the mean of the gaps and rows of all samples, on
curved ones with an error of second order of the turn of the normal within the contact. Source: Wohlmuth 2011 (mortar
methods for contact; dual multipliers are not used, as hats keep multipliers positive).
"""

from __future__ import annotations

from typing import NamedTuple

from lcpflex.contact.spatial.faces.feet import cell_point, cell_size, parts_along, place_of
from lcpflex.contact.spatial.faces.memory import MEANS, PARTS, FaceMemory, begin_mean, mean_of
from lcpflex.contact.spatial.narrow_phase.facet import Plane
from lcpflex.contact.spatial.narrow_phase.point import axis, farthest_axis
from lcpflex.contact.spatial.narrow_phase.sides import Frame, seen_from, world_place
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import IDENTITY, added, apart_from, dot, norm, row_vector, scaled
from lcpflex.model.spatial import N_RIGID, SpatialModel

__all__ = ["Standing", "common_area", "lay_means", "stand", "weigh", "weight_in"]

S, M, T1, T2 = range(4)  # columns of the weights


class Standing(NamedTuple):
    """How the means of a node stand over the plane of the master."""

    slave: Vector  # S, in the world [m]
    plane: Plane  # through M along T_1 and T_2
    gap: float  # [m]
    x: float  # (S - M).T_1 [m]
    y: float  # (S - M).T_2


@kernel
def add_weight(memory: FaceMemory, p: int, column: int, weight: float, count: int) -> int:
    """Add a weight of material point p; how many points have some."""
    w = memory.weight
    if w[p, 0] == 0.0 and w[p, 1] == 0.0 and w[p, 2] == 0.0 and w[p, 3] == 0.0:
        known = False
        for i in range(count):
            known = known or memory.found[i] == p
        if not known:
            memory.found[count] = p
            count += 1
    w[p, column] += weight
    return count


@kernel
def list_parts(memory: FaceMemory, count: int) -> int:
    """List the points that have weights, those of the slave first, and clear these; how many are of the slave."""
    own, at = 0, 0
    for of_slave in range(1, -1, -1):
        for i in range(count):
            p = memory.found[i]
            if p < 0 or (of_slave == 1 and memory.weight[p, S] == 0.0):
                continue
            memory.listed[at] = p
            for column in range(4):
                memory.part[at, column] = memory.weight[p, column]
                memory.weight[p, column] = 0.0
            memory.found[i] = -1
            at += 1
        own = at if of_slave == 1 else own
    return own


@kernel
def common_area(model: SpatialModel, memory: FaceMemory, node: int) -> float:
    """Of the samples of a node that have a foot [m^2]."""
    c = model.contacts
    total = 0.0
    for at in range(c.area_start[node], c.area_start[node + 1]):
        if memory.foot_on[c.area_sample[at]] >= 0:
            total += c.area_share[at]
    return total


@kernel
def directions(model: SpatialModel, memory: FaceMemory, node: int) -> tuple[Vector, Vector]:
    """Two unit vectors across the mean normal of the feet, the first along that axis of the body farthest from it."""
    c = model.contacts
    n = (0.0, 0.0, 0.0)
    for at in range(c.area_start[node], c.area_start[node + 1]):
        s = c.area_sample[at]
        if memory.foot_on[s] >= 0:
            n = added(n, scaled(c.area_share[at], row_vector(memory.normal, s)))
    n = scaled(1.0 / norm(n), n)
    along = axis(IDENTITY, farthest_axis(IDENTITY, n, -1))
    d = apart_from(along, scaled(dot(n, along), n))
    d = scaled(1.0 / norm(d), d)
    return d, cross(n, d)


@kernel
def part_of(a: Vector, e: Vector, f: Vector) -> tuple[float, float]:
    """Coefficients of the projection of a on the plane of e and f, by these."""
    x, y, area = parts_along(a, e, f)
    return x / area, y / area


@kernel
def curve(memory: FaceMemory, share: float, bent: Vector, a: tuple[float, float], b: tuple[float, float]) -> None:
    """Add a share of the curvature at a foot, of the directions that have the coefficients a and b there."""
    xx, xy, yy = bent
    memory.curvature[0] += share * (a[0] * a[0] * xx + 2.0 * a[0] * a[1] * xy + a[1] * a[1] * yy)
    memory.curvature[1] += share * (a[0] * b[0] * xx + (a[0] * b[1] + a[1] * b[0]) * xy + a[1] * b[1] * yy)
    memory.curvature[2] += share * (b[0] * b[0] * xx + 2.0 * b[0] * b[1] * xy + b[1] * b[1] * yy)


@kernel
def weigh(model: SpatialModel, memory: FaceMemory, node: int, area: float) -> tuple[int, int]:
    """Weights of all material points in the means of a node; how many are of the slave, and how many in all."""
    c = model.contacts
    first, second = directions(model, memory, node)
    for d in range(3):
        memory.curvature[d] = 0.0
    count = 0
    for at in range(c.area_start[node], c.area_start[node + 1]):
        s = c.area_sample[at]
        if memory.foot_on[s] < 0:
            continue
        share = c.area_share[at] / area
        for k in range(c.sample_start[s], c.sample_start[s + 1]):
            count = add_weight(memory, c.sample_point[k], S, share * c.sample_weight[k], count)
        f = memory.foot_on[s]
        e, g = row_vector(memory.along[s], 0), row_vector(memory.along[s], 1)
        a, b = part_of(first, e, g), part_of(second, e, g)
        curve(memory, share, row_vector(memory.bent, s), a, b)
        for i in range(cell_size(model, f)):
            p = cell_point(model, f, i)
            shape, by_x, by_y = memory.at_foot[s, i, 0], memory.at_foot[s, i, 1], memory.at_foot[s, i, 2]
            count = add_weight(memory, p, M, share * shape, count)
            count = add_weight(memory, p, T1, share * (a[0] * by_x + a[1] * by_y), count)
            count = add_weight(memory, p, T2, share * (b[0] * by_x + b[1] * by_y), count)
    return list_parts(memory, count), count


@kernel
def stand(
    model: SpatialModel, q: FloatArray, memory: FaceMemory, frames: tuple[Frame, Frame], listed: IntArray,
    part: FloatArray, own: int,
) -> Standing:  # fmt: skip
    """How the means of listed points stand, of which the first ``own`` are of the slave; frames: of both bodies."""
    place = (0.0, 0.0, 0.0)
    for at in range(own):
        place = added(place, scaled(part[at, S], place_of(model, q, memory, frames[0], listed[at])))
    foot, e, f = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for at in range(own, len(listed)):
        r = place_of(model, q, memory, frames[1], listed[at])
        foot = added(foot, scaled(part[at, M], r))
        e = added(e, scaled(part[at, T1], r))
        f = added(f, scaled(part[at, T2], r))
    n = cross(e, f)
    area = norm(n)
    slave = world_place(frames[0], place)
    away = apart_from(seen_from(frames[1], slave), foot)
    return Standing(
        slave, Plane(foot, e, f, scaled(1.0 / area, n), area), dot(n, away) / area, dot(e, away), dot(f, away)
    )


@kernel
def add_modes(total: FloatArray, phi: FloatArray, weight: float) -> None:
    """Add ``weight`` times phi (n, 3) to the modes of a mean: as one line of numbers, which is what makes it fast."""
    sums, parts = total.reshape(total.size), phi.reshape(phi.size)
    for m in range(len(sums)):
        sums[m] += weight * parts[m]


@kernel
def weight_in(part: FloatArray, which: int, size: float) -> float:
    """Weight of a point in the means S, M, M + l T_1 and M + l T_2 of an entry, with the length l = ``size``."""
    return float(part[which] if which <= M else part[M] + size * part[which])


@kernel
def lay_mean_of(
    model: SpatialModel, memory: FaceMemory, listed: IntArray, part: FloatArray, size: float, k: int, which: int,
    body: int,
) -> None:  # fmt: skip
    """Place and modes of mean ``which`` of entry k, of a body, as the sum of listed points."""
    modes = 0 if body < 0 else model.bodies.dof[body + 1] - model.bodies.dof[body] - N_RIGID
    first = begin_mean(memory, k, which, body, modes)
    place = memory.means.place[mean_of(k, which)]
    total = memory.means.phi[first : first + modes]
    for at in range(len(listed)):
        p = listed[at]
        weight = weight_in(part[at], which, size)
        for c in range(3):
            place[c] += weight * model.points.place[p, c]
        start = model.points.start[p]
        add_modes(total, model.points.phi[start : start + modes], weight)


@kernel
def lay_means(
    model: SpatialModel, memory: FaceMemory, listed: IntArray, part: FloatArray, own: int, k: int,
    bodies: tuple[int, int], size: float,
) -> None:  # fmt: skip
    """The four material points of entry k: S, and M, M + l T_1 and M + l T_2 with the length l = ``size``."""
    lay_mean_of(model, memory, listed[:own], part[:own], size, k, S, bodies[0])
    for which in range(M, T2 + 1):
        lay_mean_of(model, memory, listed[own:], part[own:], size, k, which, bodies[1])
    tell_parts(memory, listed, part, own, k, size)


@kernel
def tell_parts(memory: FaceMemory, listed: IntArray, part: FloatArray, own: int, k: int, size: float) -> None:
    """Points and weights of the means of entry k, where these are few."""
    memory.told[k, 0], memory.told[k, 1] = 0, 0
    if len(listed) > PARTS:
        return
    memory.told[k, 0], memory.told[k, 1] = own, len(listed) - own
    for at in range(len(listed)):
        memory.told_point[k, at] = listed[at]
        for which in range(MEANS):
            memory.told_weight[k, at, which] = weight_in(part[at], which, size)
