"""Means of areas that stand while what they are means of hardly moves.

An area has a hundred samples, whose feet cost more than all else in a step. The weights that they give the nodes of
both faces stay as they are while the mean has slipped by less than a thousandth of the width of the area, and the
bodies have turned against each other by as little. S then slides over the plane of the master, as in an entry that is
not detected anew: nothing is lost on plane faces. Else a gap is wrong by .4 kappa h s where a line of samples, with .4
of the weight at most, has passed from a facet to the next: with the curvature kappa, the width h of facets and the slip
s, three thousandths of what it is wrong by because facets are chords of what they stand for, kappa h^2 / 8.

Forces act along one line in any case: momenta are as exact as by means made anew. Event-driven stepping, which looks
for where gaps close, keeps none.
"""

from __future__ import annotations

import math

from lcpflex.contact.spatial.bounds import is_beside_box
from lcpflex.contact.spatial.faces.means import Standing
from lcpflex.contact.spatial.faces.memory import KEPT, FaceMemory
from lcpflex.contact.spatial.narrow_phase.sides import Frame, seen_from, world_place
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import kernel
from lcpflex.kinematics.spatial.rotations import Vector
from lcpflex.kinematics.spatial.vectors import added, apart_from, dot, norm, row_vector, scaled, turned_back
from lcpflex.model.spatial import SpatialModel

__all__ = ["is_far", "is_kept", "keep", "still_stands"]

SLIPPED = 1e-3  # widths of the area; and radians: the samples of an area are as far from its mean as it is wide
RISEN = 0.1  # widths: what is higher above a face than half a width may meanwhile have another one nearer
CLOSE = 0.5  # widths: what is nearer has no nearer face
HALF = 0.5  # of the height up to which samples count: those that have no foot below it are beside the master


@kernel
def is_kept(memory: FaceMemory, node: int, b: int) -> bool:
    """Whether the means of a node with surface b are kept."""
    kept = memory.kept
    row = node - kept.first
    return bool(kept.used == 1 and 0 <= row < len(kept.on) and kept.count[row] > 0 and kept.on[row] == b)


@kernel
def axes_of(i: Frame, j: Frame) -> tuple[Vector, Vector]:
    """The first two axes of frame i, in j."""
    return turned_back(j.A, (i.A[0], i.A[3], i.A[6])), turned_back(j.A, (i.A[1], i.A[4], i.A[7]))


@kernel
def still_stands(memory: FaceMemory, row: int, over: Standing, i: Frame, j: Frame, wide: float) -> bool:
    """Whether the means kept in a row are those of the feet, as far as they tell; ``wide``: where samples count."""
    kept = memory.kept
    width = math.sqrt(kept.area[row])
    most = SLIPPED * width
    if abs(over.x - kept.slip[row, 0]) > most or abs(over.y - kept.slip[row, 1]) > most:
        return False
    high = CLOSE * width
    if over.gap < -high or (over.gap > high and abs(over.gap - kept.gap[row]) > RISEN * width):
        return False
    if over.gap + kept.rise[row] > (wide if kept.whole[row] == 1 else HALF * wide):
        return False
    first, second = axes_of(i, j)
    away = apart_from(first, row_vector(kept.turn[row], 0))
    aside = apart_from(second, row_vector(kept.turn[row], 1))
    return bool(dot(away, away) + dot(aside, aside) <= SLIPPED * SLIPPED)


@kernel
def keep(
    model: SpatialModel, memory: FaceMemory, node: int, b: int, over: Standing, i: Frame, j: Frame, own: int,
    count: int, area: float, wide: float,
) -> None:  # fmt: skip
    """Keep the means of a node with surface b that were weighed last, if they are those of many samples."""
    c, kept, row = model.contacts, memory.kept, node - memory.kept.first
    first, last = c.area_start[node], c.area_start[node + 1]
    if kept.used == 0 or last - first <= 1:
        return
    kept.count[row] = 0
    if count > KEPT:
        return
    whole, highest = 1, -math.inf
    for at in range(first, last):
        s = c.area_sample[at]
        if memory.foot_on[s] < 0:
            whole = 0
        else:
            highest = max(highest, memory.gap[s])
    if whole == 0 and highest > HALF * wide:
        return
    kept.count[row], kept.own[row], kept.on[row], kept.whole[row] = count, own, b, whole
    kept.area[row], kept.gap[row], kept.rise[row] = area, over.gap, highest - over.gap
    kept.slip[row, 0], kept.slip[row, 1] = over.x, over.y
    axes = axes_of(i, j)
    for d in range(3):
        kept.curvature[row, d] = memory.curvature[d]
        kept.turn[row, 0, d], kept.turn[row, 1, d] = axes[0][d], axes[1][d]
    for at in range(count):
        kept.point[row, at] = memory.listed[at]
        for column in range(4):
            kept.weight[row, at, column] = memory.part[at, column]


@kernel
def reach_of(model: SpatialModel, memory: FaceMemory, node: int) -> float:
    """How far the samples of a node are from its mean, undeformed [m]."""
    c, known = model.contacts, memory.kept.reach
    first, last = c.area_start[node], c.area_start[node + 1]
    if last - first <= 1:
        return 0.0
    row = node - memory.kept.first
    if known[row] == 0.0:
        middle = row_vector(model.points.place, c.node_point[node])
        for at in range(first, last):
            s, place = c.area_sample[at], (0.0, 0.0, 0.0)
            for k in range(c.sample_start[s], c.sample_start[s + 1]):
                place = added(place, scaled(c.sample_weight[k], row_vector(model.points.place, c.sample_point[k])))
            known[row] = max(known[row], norm(apart_from(place, middle)))
    return float(known[row])


@kernel
def is_far(
    model: SpatialModel, table: SpatialContactTable, i: Frame, j: Frame, node: int, surfaces: tuple[int, int],
    wide: float,
) -> bool:  # fmt: skip
    """Whether no sample of a node of the first surface is within ``wide`` of what boxes the second one has."""
    c, (a, b) = model.contacts, surfaces
    place = seen_from(j, world_place(i, row_vector(model.points.place, c.node_point[node])))
    near = wide + reach_of(model, table.faces, node) + table.bound[a, 3] + table.bound[b, 3]
    box = c.box_start[b]
    while box < c.box_start[b + 1]:
        if is_beside_box(model, box, place, place, near):
            box = c.box_skip[box]
        elif c.box_leaf[box, 1] > c.box_leaf[box, 0]:
            return False
        else:
            box += 1
    return True
