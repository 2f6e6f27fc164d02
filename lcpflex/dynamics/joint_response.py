"""What joints answer, by the sparse factor of S = J A^-1 J^T.

    rates b of the joints are cancelled by the impulses -S^-1 b
    contacts with the joints: G_c = G_WW - G_WJ S^-1 G_JW,   b_c = b_W - G_WJ S^-1 b_J

A belongs to the rows as they were solved: the mass matrix, or the matrix of a step. Redundant joints leave S singular:
their dependent rows get no multiplier (a basic solution), which changes no motion (in space, where most mechanisms are
redundant, they are found by geometry: :mod:`lcpflex.dynamics.spatial.redundancy`). Where pivots are small, rounding of
those before them may hide a dependent row, and an answer is compared with what it was to cancel and corrected.

Joint rows come first, then contact rows, which touch two bodies at most: the joints answer one of them along a path in
the elimination tree, and no array of joints times contacts is made.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.delassus import apply_impulses, row_velocity
from lcpflex.dynamics.inertia import Arrow
from lcpflex.dynamics.rows import Rows
from lcpflex.jit.kernel import FloatArray, IntArray, kernel, late_kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.planar import N_RIGID
from lcpflex.solvers.semidefinite import dot
from lcpflex.solvers.sparse_cholesky import add_path, factorise_sparse, forget_path, solve_on_path, solve_sparse

__all__ = [
    "assemble_joints",
    "condense",
    "couple",
    "factorise_joints",
    "joint_impulses",
    "respond",
    "row_product",
    "solve_joints",
]

MET = 1e-13  # of the largest rate that joints are to cancel: what their answer may leave
CORRECTIONS = 3  # of an answer, at most


@kernel
def row_product(rows: Rows, r: int, i: int, s: int) -> float:
    """Block i of rows_r with A^-1 rows_s."""
    total = 0.0
    b = rows.body[r, i]
    if b >= 0:
        for j in range(2):
            if rows.body[s, j] == b:
                total += dot(rows.J[r, i], rows.solved[s, j], 0, rows.J.shape[2])
    return total


@kernel
def factorise_joints(rows: Rows) -> None:
    """S of the joint rows, which come first, and its factor: O(entries)."""
    eliminate_joints(rows.arrow, rows)


@in_space("lcpflex.dynamics.spatial.redundancy")
@kernel
def eliminate_joints(bodies: Arrow, rows: Rows) -> None:
    """The same, by the kind of the bodies."""
    assemble_joints(rows)
    factorise_sparse(rows.joints.factor)


@kernel
def assemble_joints(rows: Rows) -> None:
    """S of the joint rows in the place of its factor."""
    factor, J, solved, row_body = rows.joints.factor, rows.J, rows.solved, rows.body
    order, start, column, value = factor.order, factor.start, factor.column, factor.value
    width = J.shape[2]
    for place in range(len(order)):
        for e in range(start[place], start[place + 1]):
            r = max(order[place], order[column[e]])
            s = min(order[place], order[column[e]])
            total = 0.0
            for i in range(2):
                b = row_body[r, i]
                if b < 0:
                    continue
                for j in range(2):
                    if row_body[s, j] != b:
                        continue
                    if width == N_RIGID:  # a call costs more than these
                        part = J[r, i, 0] * solved[s, j, 0] + J[r, i, 1] * solved[s, j, 1]
                        total += part + J[r, i, 2] * solved[s, j, 2]
                    else:
                        total += dot(J[r, i], solved[s, j], 0, width)
            value[e] = total


@kernel
def solve_joints(rows: Rows, b: FloatArray) -> None:
    """b <- S^-1 b of all joint rows, in their own order; 0 for dependent rows.

    Where pivots are small, what is left of the rates b is solved for again, as long as that makes it less.
    """
    joints = rows.joints
    order, x = joints.factor.order, joints.x
    n = len(order)
    for i in range(n):
        x[i] = b[order[i]]
    solve_sparse(joints.factor, x)
    if joints.factor.weak > 0:
        correct(rows, b)
    for i in range(n):
        b[order[i]] = x[i]
        x[i] = 0.0


@kernel
def missed(rows: Rows, b: FloatArray, x: FloatArray) -> float:
    """joints.left = b - S x; the largest of it in parts of the largest of b, each row in units of its own diagonal."""
    joints, J, row_body, dof = rows.joints, rows.J, rows.body, rows.dof
    order, own, change, left = joints.factor.order, joints.factor.own, joints.change, joints.left
    for k in range(len(change)):
        change[k] = 0.0
    for i in range(len(order)):
        joints.impulses[order[i]] = x[i]
    apply_impulses(rows.solved, row_body, 0, len(order), joints.impulses, dof, change)
    worst = 0.0
    largest = 0.0
    for i in range(len(order)):
        r = order[i]
        left[i] = b[r] - row_velocity(J, row_body, r, dof, change)
        if own[i] > 0.0:
            unit = 1.0 / math.sqrt(own[i])
            worst = max(worst, abs(left[i]) * unit)
            largest = max(largest, abs(b[r]) * unit)
    return worst / largest if largest > 0.0 else 0.0


@late_kernel
def correct(rows: Rows, b: FloatArray) -> None:
    """Correct the answer ``joints.x`` to the rates b by solving for what is left of them."""
    joints = rows.joints
    x, left, better = joints.x, joints.left, joints.better
    before = missed(rows, b, x)
    for _ in range(CORRECTIONS):
        if not before > MET:
            break
        solve_sparse(joints.factor, left)
        for i in range(len(x)):
            better[i] = x[i] + left[i]
        after = missed(rows, b, better)
        if not after < 0.5 * before:  # rows that contradict each other, or nothing but rounding is left
            break
        for i in range(len(x)):
            x[i] = better[i]
        before = after


@kernel
def rate_by_joints(rows: Rows, r: int, p: FloatArray) -> float:
    """rows_r A^-1 J^T p for the impulses p of all joint rows."""
    joints, row_body = rows.joints, rows.body
    order, first, place = joints.factor.order, joints.first, joints.place
    total = 0.0
    for i in range(2):
        b = row_body[r, i]
        if b >= 0:
            for k in range(first[b], first[b + 1]):
                j = order[place[k]]
                total += row_product(rows, r, i, j) * p[j]
    return total


@kernel
def rates_of_joints(rows: Rows, r: int, p: FloatArray) -> None:
    """p[place] += J A^-1 rows_r, in the order of the factor; 0 but for the joints on the bodies of row r."""
    joints, row_body = rows.joints, rows.body
    order, first, place = joints.factor.order, joints.first, joints.place
    for i in range(2):
        b = row_body[r, i]
        if b >= 0:
            for k in range(first[b], first[b + 1]):
                p[place[k]] += row_product(rows, r, i, order[place[k]])


@kernel
def respond(rows: Rows, r: int) -> float:
    """Impulses ``joints.answer`` of all joints that cancel what a unit impulse of row r does to their rates.

    Returns the part of the row's own rate that the joints take away.
    """
    joints = rows.joints
    order, x = joints.factor.order, joints.x
    rates_of_joints(rows, r, x)
    for i in range(len(order)):
        joints.answer[order[i]] = x[i]
        x[i] = 0.0
    solve_joints(rows, joints.answer)
    return rate_by_joints(rows, r, joints.answer)


@kernel
def couple(rows: Rows, first: int, m: int) -> None:
    """``joints.coupling`` of the m rows from ``first`` on."""
    joints, row_body = rows.joints, rows.body
    factor = joints.factor
    coupling, acting = joints.coupling, joints.acting
    for c in range(m):
        n = 0
        for i in range(2):
            b = row_body[first + c, i]
            if b < 0 or joints.first[b] == joints.first[b + 1]:
                continue
            for k in range(joints.first[b], joints.first[b + 1]):
                place = joints.place[k]
                acting[c, n] = place
                coupling[c, n] = row_product(rows, first + c, i, factor.order[place])
                n += 1
        joints.n_acting[c] = n


@kernel
def find_path(rows: Rows, part: IntArray, first: int, m: int) -> None:
    """The path on which the joints answer m rows: ``part`` of those from ``first`` on."""
    joints, row_body = rows.joints, rows.body
    forget_path(joints.factor)
    for c in range(m):
        for i in range(2 if part[c] >= 0 else 0):
            b = row_body[first + part[c], i]
            if b >= 0 and joints.first[b] < joints.first[b + 1]:
                add_path(joints.factor, joints.place[joints.first[b]])  # joints on one body are on one path


@kernel
def condense(rows: Rows, part: IntArray, first: int, m: int, G: FloatArray, free: FloatArray) -> None:
    """Take the part of the joints out of G and ``free`` of m rows: ``part`` of those from ``first`` on, all coupled.

    S^-1 b is known. Rows that are none, -1, have nothing to do with joints.
    """
    find_path(rows, part, first, m)
    joints = rows.joints
    factor, answer, x = joints.factor, joints.answer, joints.x
    coupling, acting, n_acting = joints.coupling, joints.acting, joints.n_acting
    for c in range(m):
        a = part[c]
        if a < 0 or n_acting[a] == 0:
            continue
        for k in range(n_acting[a]):
            free[c] -= coupling[a, k] * answer[factor.order[acting[a, k]]]
            x[acting[a, k]] += coupling[a, k]
        if factor.weak == 0:
            solve_on_path(factor, x)
        else:
            answer_in_full(rows)
        for e in range(c + 1):
            b = part[e]
            for k in range(n_acting[b] if b >= 0 else 0):
                G[c, e] -= coupling[b, k] * x[acting[b, k]]
            G[e, c] = G[c, e]
        if factor.weak == 0:
            for k in range(len(factor.path) - factor.n_path, len(factor.path)):
                x[factor.path[k]] = 0.0
        else:
            for i in range(len(x)):
                x[i] = 0.0


@kernel
def answer_in_full(rows: Rows) -> None:
    """joints.x <- S^-1 x with its corrections: on a path alone there is nothing to compare it with."""
    order, x, rates = rows.joints.factor.order, rows.joints.x, rows.joints.rates
    for i in range(len(x)):
        rates[order[i]] = x[i]
    solve_joints(rows, rates)
    for i in range(len(x)):
        x[i] = rates[order[i]]


@kernel
def joint_impulses(rows: Rows, last: int, p: FloatArray) -> None:
    """p_J = -S^-1 (b + G_JW p_W) for the impulses p_W of the rows behind the joints up to ``last``.

    Both S^-1 b and G_JW are those of the last contact problem.
    """
    joints = rows.joints
    n_joint = len(joints.answer)
    order, rates, coupling, acting = joints.factor.order, joints.rates, joints.coupling, joints.acting
    loaded = False
    for j in range(n_joint):
        p[j] = -joints.answer[j]
        rates[j] = 0.0
    if n_joint == 0:
        return
    for c in range(last - n_joint):
        impulse = p[n_joint + c]
        if impulse != 0.0 and joints.n_acting[c] > 0:
            loaded = True
            for k in range(joints.n_acting[c]):
                rates[order[acting[c, k]]] += coupling[c, k] * impulse
    if not loaded:
        return
    solve_joints(rows, rates)
    for j in range(n_joint):
        p[j] -= rates[j]
