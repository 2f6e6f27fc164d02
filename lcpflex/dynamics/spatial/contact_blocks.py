"""The Delassus operator of contacts between flexible bodies from blocks of their points, joints left aside.

A force along d at points of a body that is joined to nothing moves its modes and, through them and by itself, its
frame. Of the inverse of an arrow (:mod:`lcpflex.dynamics.spatial.inertia`) the modes have a part that no motion
changes; what is left has rank six:

    G_ab = d_a.E_ab d_b + s_a.s_b,   s = L^T x,

with E_ab of :mod:`lcpflex.dynamics.spatial.point_blocks`, L L^T the Schur complement of the frame and x the first six
velocities that a force gives. A pair of contacts then costs the same with twenty modes as with two hundred. The
compliance of static modes is such a sum of blocks, too, and has no frame.
"""

from __future__ import annotations

import math

from lcpflex.contact.spatial.levers import mean_on_i, mean_on_j, radius_of_j
from lcpflex.contact.spatial.table import RIM_FACET, RIM_RIM, SpatialContactTable, by_cylinder
from lcpflex.dynamics.delassus import delassus, spread
from lcpflex.dynamics.spatial.contact_problem import has_joints
from lcpflex.dynamics.spatial.inertia import SpatialArrow, SpatialWork
from lcpflex.dynamics.spatial.inertia_solve import turn_in
from lcpflex.dynamics.spatial.point_blocks import add_block, block_of, has_blocks, weigh_modes
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.kinematics.spatial.rotations import Matrix, rotation_matrix
from lcpflex.model.spatial import N_RIGID, SpatialModel

__all__ = ["fill_by_blocks", "fill_compliance", "fill_delassus", "is_rough", "is_wide", "moved_by", "wants_white"]

FEWEST, MOST = 4, 256  # contacts of a wide island; the operator of more takes tens of megabytes
WIDE = 50  # velocities that a contact moves: below, products of rows cost no more than blocks


@kernel
def fill_delassus(work: SpatialWork, m: int, G: FloatArray) -> None:
    """G of the m rows ``posed.part``, three a contact, joints left aside."""
    n_joint, rows, part = work.rows.n_joint, work.rows, work.posed.part
    n = m // 3
    if n > 1 and moved_by(work, part, 3, n) >= WIDE * n and fill_by_blocks(work, part, 3, n, 3, G):
        return
    delassus(rows.J[n_joint:], rows.solved[n_joint:], rows.body[n_joint:], part, m, G)


@kernel
def moved_by(work: SpatialWork, entry: IntArray, stride: int, n: int) -> int:
    """How many velocities n contacts move, each by itself: each ``stride``-th of the entries listed."""
    total, dof = 0, work.rows.dof
    for c in range(n):
        for side in range(2):
            b = work.rows.body[work.rows.n_joint + entry[stride * c], side]
            if b >= 0:
                total += dof[b + 1] - dof[b]
    return total


@kernel
def is_bare(table: SpatialContactTable, k: int, side: int) -> bool:
    """Whether entry k touches body ``side`` where material points are: no lever turns with the material."""
    if table.kind[k] in (RIM_FACET, RIM_RIM):
        return False
    if side == 0:
        return bool(table.radius[k, 0] == 0.0)
    return bool(radius_of_j(table, k) == 0.0 and not by_cylinder(table, k))


@kernel
def lay_parts(work: SpatialWork, c: int, k: int, side: int) -> bool:
    """Points and weights of a side of contact c, entry k, of which that is a mean; False where there are no blocks."""
    sides, table, blocks = work.impulses.solver.sides, work.rows.table, work.rows.arrow.blocks
    faces, touched = table.faces, sides.touched[c, side]
    first, w = (0, (1.0, 0.0, 0.0)) if side == 0 else (faces.told[k, 0], mean_on_j(table, k).w)
    touched[1] = faces.told[k, side]
    for e in range(touched[1]):
        weights = faces.told_weight[k, first + e]
        touched[2 + e] = faces.told_point[k, first + e]
        if side == 0:
            sides.share[c, side, e] = weights[0]
        else:
            sides.share[c, side, e] = w[0] * weights[1] + w[1] * weights[2] + w[2] * weights[3]
        if not has_blocks(blocks, touched[2 + e]):
            return False
    return bool(touched[1] > 0)


@kernel
def lay_points(work: SpatialWork, c: int, k: int, side: int, averaged: bool) -> bool:
    """Body, points and weights of a side of contact c, entry k; False where there are no blocks of it.

    Of a rigid body no points count. ``averaged``: of means as well.
    """
    sides, table, blocks = work.impulses.solver.sides, work.rows.table, work.rows.arrow.blocks
    b = work.rows.body[work.rows.n_joint + k, side]
    touched = sides.touched[c, side]
    touched[0], touched[1] = b, 0
    if b < 0 or work.rows.dof[b + 1] - work.rows.dof[b] == N_RIGID:
        return True
    if not is_bare(table, k, side):
        return False
    if table.averaged[k] == 1:
        return averaged and lay_parts(work, c, k, side)
    mean = mean_on_i(table, k) if side == 0 else mean_on_j(table, k)
    touched[1], touched[2], touched[3], touched[4] = mean.number, mean.a, mean.b, mean.c
    for e in range(3):
        sides.share[c, side, e] = mean.w[e]
        if not has_blocks(blocks, touched[2 + e]):
            return False
    return True


@kernel
def lay_frame(arrow: SpatialArrow, b: int, x: FloatArray, s: FloatArray) -> None:
    """s = L^T x of the first six velocities x of body b, v in world axes."""
    lower = arrow.lower
    if arrow.blocks.centred[b] != 0:
        heavier = math.sqrt(arrow.blocks.mass[b])
        s[0], s[1], s[2] = heavier * x[0], heavier * x[1], heavier * x[2]
        s[3] = x[3] / lower[b, 0] + lower[b, 1] * x[4] + lower[b, 3] * x[5]
        s[4] = x[4] / lower[b, 2] + lower[b, 4] * x[5]
        s[5] = x[5] / lower[b, 5]
        return
    s[0], s[1], s[2] = turn_in(arrow.axes, b, x[0], x[1], x[2])
    s[3], s[4], s[5] = x[3], x[4], x[5]
    for i in range(N_RIGID):
        total = s[i] / lower[b, i * (i + 1) // 2 + i]
        for k in range(i + 1, N_RIGID):
            total += lower[b, k * (k + 1) // 2 + i] * s[k]
        s[i] = total


@kernel
def lay_rows(work: SpatialWork, c: int, k: int, side: int, count: int, framed: bool) -> None:
    """Directions, body axes, and where ``framed`` s, of ``count`` rows of a side of contact c, entry k; 0: has none."""
    rows, arrow, sides = work.rows, work.rows.arrow, work.impulses.solver.sides
    b, j = sides.touched[c, side, 0], work.posed.tangent_of[k]
    if b < 0:
        return
    for e in range(count):
        r = rows.n_joint + (k if e == 0 else rows.n_contacts + j + e - 1)
        along, frame = sides.along[c, side, e], sides.frame[c, side, e]
        if e > 0 and j < 0:
            for i in range(3):
                along[i], frame[i], frame[3 + i] = 0.0, 0.0, 0.0
            continue
        row = rows.J[r, side]
        along[0], along[1], along[2] = turn_in(arrow.axes, b, row[0], row[1], row[2])
        if framed:
            lay_frame(arrow, b, rows.solved[r, side], frame)


@kernel
def lay_contacts(
    work: SpatialWork, entry: IntArray, stride: int, n: int, count: int, weight: FloatArray, framed: bool
) -> bool:
    """Both sides of n contacts, each ``stride``-th of the entries listed; False where blocks are not to be had.

    weight: of the modes; ``framed``: of all, and what is left of the frame counts, else of all velocities.
    """
    sides, arrow, dof = work.impulses.solver.sides, work.rows.arrow, work.rows.dof
    known, flexible = True, False
    for side in range(2):
        last = -1
        for c in range(n):
            if not lay_points(work, c, entry[stride * c], side, not framed and count == 3):
                return False
            b = sides.touched[c, side, 0]
            if sides.touched[c, side, 1] > 0 and b != last:
                flexible = True
                at = dof[b] - N_RIGID * b if framed else dof[b] + N_RIGID
                known = weigh_modes(arrow.blocks, b, weight, at) and known
                last = b
    if not (known and flexible):
        return False
    for c in range(n):
        for side in range(2):
            lay_rows(work, c, entry[stride * c], side, count, framed)
    return True


@kernel
def block_between(work: SpatialWork, a: int, x: int, b: int, y: int) -> Matrix:
    """E of side x of contact a and side y of contact b, of one body that has modes: sum of w_a w_b E_ab."""
    sides, blocks = work.impulses.solver.sides, work.rows.arrow.blocks
    one, other = sides.touched[a, x], sides.touched[b, y]
    if one[1] == 1 and other[1] == 1:
        return block_of(blocks, one[2], other[2])
    total = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for e in range(one[1]):
        for f in range(other[1]):
            weight = sides.share[a, x, e] * sides.share[b, y, f]
            total = add_block(total, weight, block_of(blocks, one[2 + e], other[2 + f]))
    return total


@kernel
def add_pair(work: SpatialWork, a: int, x: int, b: int, y: int, count: int, rank: int, G: FloatArray) -> None:
    """Add what side y of contact b does to side x of contact a, of the same body; ``rank``: numbers of its frame."""
    sides = work.impulses.solver.sides
    along, frame = sides.along, sides.frame
    E = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if sides.touched[a, x, 1] > 0:
        E = block_between(work, a, x, b, y)
    for f in range(count):
        u, v, w = along[b, y, f, 0], along[b, y, f, 1], along[b, y, f, 2]
        p = E[0] * u + E[1] * v + E[2] * w
        q = E[3] * u + E[4] * v + E[5] * w
        r = E[6] * u + E[7] * v + E[8] * w
        for e in range(count):
            total = along[a, x, e, 0] * p + along[a, x, e, 1] * q + along[a, x, e, 2] * r
            for i in range(rank):
                total += frame[a, x, e, i] * frame[b, y, f, i]
            G[count * a + e, count * b + f] += total


@kernel
def fill_by_blocks(work: SpatialWork, entry: IntArray, stride: int, n: int, count: int, G: FloatArray) -> bool:
    """G of ``count`` rows of each of n contacts, each ``stride``-th of the entries listed; False where there is none.

    None is made for bodies without modes, for points without blocks, for levers that turn with the material, and where
    the matrix of the step is another one than that of the last.
    """
    if not lay_contacts(work, entry, stride, n, count, work.rows.arrow.diagonal, True):
        return False
    add_pairs(work, n, count, N_RIGID, G)
    return True


@kernel
def add_pairs(work: SpatialWork, n: int, count: int, rank: int, G: FloatArray) -> None:
    """G of ``count`` rows of each of n contacts that were laid; ``rank``: numbers of frames."""
    touched = work.impulses.solver.sides.touched
    for a in range(n):
        for b in range(a + 1):
            for e in range(count):
                for f in range(count):
                    G[count * a + e, count * b + f] = 0.0
            for x in range(2):
                for y in range(2):
                    if touched[a, x, 0] >= 0 and touched[a, x, 0] == touched[b, y, 0]:
                        add_pair(work, a, x, b, y, count, rank, G)
            for e in range(count):
                for f in range(count):
                    G[count * b + f, count * a + e] = G[count * a + e, count * b + f]


@kernel
def fill_compliance(
    model: SpatialModel, q: FloatArray, work: SpatialWork, flexibility: FloatArray, size: int, G: FloatArray
) -> None:
    """G of the ``size`` rows ``posed.part``, rows W at q: W^T diag(flexibility) W, ``flexibility`` of all velocities.

    By blocks of the points where these are to be had; else ``rows.solved`` becomes diag(flexibility) W.
    """
    n, part, axes = work.posed.problem.n_contacts, work.posed.part, work.rows.arrow.axes
    count = size // n if n > 0 else 1
    for b in range(len(model.bodies.mass)):
        i = model.bodies.place[b]
        turned = rotation_matrix(q[i + 3], q[i + 4], q[i + 5], q[i + 6])
        for k in range(9):
            axes[b, k] = turned[k]
    if lay_contacts(work, part, count, n, count, flexibility, False):
        add_pairs(work, n, count, 0, G)
        return
    n_joint, rows = work.rows.n_joint, work.rows
    spread(work, flexibility, n_joint, n_joint + rows.n_contacts + rows.n_tangents)
    delassus(rows.J[n_joint:], rows.solved[n_joint:], rows.body[n_joint:], part, size, G)


@kernel
def is_rough(work: SpatialWork, i: int) -> bool:
    """Whether island i has friction."""
    islands = work.posed.islands
    rough = False
    for c in range(islands.start[i], islands.start[i + 1]):
        rough = rough or work.posed.tangent_of[islands.contact[c]] >= 0
    return rough


@kernel
def is_wide(work: SpatialWork, i: int, rough: bool) -> bool:
    """Whether the Delassus operator of island i costs less than the rows of its contacts; ``rough``: with friction."""
    islands = work.posed.islands
    n = islands.start[i + 1] - islands.start[i]
    if not FEWEST <= n <= MOST:
        return False
    moved = moved_by(work, islands.contact[islands.start[i] : islands.start[i + 1]], 1, n)
    return bool(moved >= WIDE * n and (3 if rough else 1) * n * n <= moved)


@kernel
def wants_white(work: SpatialWork, i: int) -> bool:
    """Whether island i, which has many contacts, is solved by rows that are whitened: others are if that fails."""
    return bool(has_joints(work, i) or not is_wide(work, i, is_rough(work, i)))
