"""Redundant joints in space: which rows are dependent is a question of geometry, and answered without masses.

Spatial mechanisms are redundant as a rule: a planar four-bar of four hinges has 20 rows, 18 velocities and rank 17. It
is never assembled exactly. With an error e of places (in parts of the arms) and axes (rad) its rank is 18, and with all
18 rows it cannot move: the dependent rows must be found although they are independent by e.

The pivots of S = J A^-1 J^T do not tell: where bodies differ in mass by 1e4, rounding alone leaves 1e-10 of the
diagonal of dependent rows, and independent rows have as little. Those of

    J D J^T,   D = diag(1, 1, 1, 1/L^2, 1/L^2, 1/L^2, m, ...)   of each body, L its size, m its mass,

are the squares of the distances of each row from those before it. Measured on four-bars and Bennett linkages with mass
ratios up to 1e4: about .3 of the diagonal of independent rows, 5 e^2 of dependent ones. A lever of length l between two
joints of one body leaves (l/L)^2. The bound between them is DEPENDENT. Which rows of the joint that closes a loop are
independent changes as the mechanism moves: they are chosen by pivoting among the rows of each joint.

A row taken for dependent gets no multiplier: what it prescribes is then as far off as the mechanism is badly assembled,
and grows if it was not dependent: the drift of the joints tells.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.inertia import Arrow
from lcpflex.dynamics.joint_factor import JointFactor
from lcpflex.dynamics.joint_response import assemble_joints
from lcpflex.dynamics.rows import Rows
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.spatial import N_RIGID
from lcpflex.solvers.semidefinite import REDUNDANT
from lcpflex.solvers.sparse_cholesky import WEAK, factorise_sparse, reduce_row

__all__ = ["DEPENDENT", "eliminate_joints", "mark_dependent"]

DEPENDENT = 1e-7  # of the own diagonal of a row: errors of assembly up to 1e-4, levers from 3e-4 on
FREE, TURNS, BENDS = 0, 1, 2  # sums of squares of a body, in the place of its velocities


@kernel
def eliminate_joints(bodies: Arrow, rows: Rows) -> None:
    """S of the joint rows and its factor; where joints close loops, without the rows that geometry makes dependent."""
    if rows.joints.loops == 0:
        assemble_joints(rows)
        factorise_sparse(rows.joints.factor)
        return
    mark_dependent(rows)
    assemble_joints(rows)
    factorise_marked(rows)


@kernel
def mark_dependent(rows: Rows) -> None:
    """joints.left: for each row, in the order of the factor, its distance from those kept before it; 0: dependent.

    The square of it, in parts of its own. Overwrites the factor and ``joints.change``.
    """
    scale_bodies(rows)
    assemble_geometry(rows)
    block = rows.joints.block
    for joint in range(len(block) - 1):
        reduce_block(rows.joints, block[joint], block[joint + 1])
        choose_rows(rows.joints, block[joint], block[joint + 1])
        finish_block(rows.joints, block[joint], block[joint + 1])


@kernel
def reduce_block(joints: JointFactor, first: int, last: int) -> None:
    """The rows of one joint in the factor, up to those before it: its Schur complement, in ``joints.schur``, too."""
    factor, schur = joints.factor, joints.schur
    start, column, value, row = factor.start, factor.column, factor.value, factor.row
    before = start[first + 1] - start[first] - 1
    for i in range(first, last):
        begin = start[i]
        factor.own[i] = value[start[i + 1] - 1]
        for e in range(begin, start[i + 1]):
            j = column[e]
            entry = value[e]
            end = start[j + 1] - 1 if e < begin + before else start[j] + before
            for f in range(start[j], end):
                entry -= row[column[f]] * value[f]
            if e < begin + before:
                entry = entry / value[end] if value[end] > 0.0 else 0.0
                row[j] = entry
            else:
                schur[i - first, j - first] = entry
                schur[j - first, i - first] = entry
            value[e] = entry
        for e in range(begin, begin + before):
            row[column[e]] = 0.0


@kernel
def choose_rows(joints: JointFactor, first: int, last: int) -> None:
    """joints.left of one joint: always the row that is farthest from those chosen; overwrites ``joints.schur``.

    In the order of the rows, one that just becomes dependent as the mechanism moves would be kept to the last.
    """
    schur, own, distance = joints.schur, joints.factor.own, joints.left
    for i in range(first, last):
        distance[i] = 0.0
    n = last - first
    for _ in range(n):
        chosen, farthest = -1, DEPENDENT
        for k in range(n):
            if distance[first + k] == 0.0 and schur[k, k] > farthest * own[first + k]:
                chosen, farthest = k, schur[k, k] / own[first + k]
        if chosen < 0:
            break
        distance[first + chosen] = farthest
        pivot = schur[chosen, chosen]
        for k in range(n):
            if distance[first + k] == 0.0:
                part = schur[k, chosen] / pivot
                for m in range(n):
                    if distance[first + m] == 0.0:
                        schur[k, m] -= part * schur[chosen, m]


@kernel
def finish_block(joints: JointFactor, first: int, last: int) -> None:
    """The rows of one joint in the factor from the Schur complement on, without those that are not chosen."""
    start, value, distance = joints.factor.start, joints.factor.value, joints.left
    before = start[first + 1] - start[first] - 1
    for i in range(first, last):
        own = start[i] + before
        for j in range(i + 1 - first):
            other = start[first + j] + before
            entry = value[own + j]
            for k in range(j):
                entry -= value[own + k] * value[other + k]
            if first + j < i:
                value[own + j] = entry / value[other + j] if value[other + j] > 0.0 else 0.0
            else:
                value[own + j] = math.sqrt(entry) if distance[i] > 0.0 and entry > 0.0 else 0.0


@kernel
def dot3(a: FloatArray, r: int, i: int, b: FloatArray, s: int, j: int, k: int) -> float:
    """Of three numbers from k on of block i of row r of a, and of block j of row s of b."""
    return a[r, i, k] * b[s, j, k] + a[r, i, k + 1] * b[s, j, k + 1] + a[r, i, k + 2] * b[s, j, k + 2]


@kernel
def scale_bodies(rows: Rows) -> None:
    """joints.change of each body: 1, 1/L^2 and m.

    1/m: mean of what A^-1 makes of the translations in its rows; L^2: mean square of the arms, and J/m by such means,
    for bodies whose joints are all at the mass centre.
    """
    scale, dof, J, solved = rows.joints.change, rows.dof, rows.J, rows.solved
    for i in range(len(scale)):
        scale[i] = 0.0
    for r in range(len(rows.joints.left)):
        for i in range(2):
            b = rows.body[r, i]
            if b < 0:
                continue
            d = dof[b]
            moves = dot3(J, r, i, J, r, i, 0)
            turns = dot3(J, r, i, J, r, i, 3)
            scale[d] += moves
            scale[d + 1] += dot3(J, r, i, solved, r, i, 0)
            scale[d + 2] += turns if moves > 0.0 else 0.0
            scale[d + 3] += turns
            scale[d + 4] += dot3(J, r, i, solved, r, i, 3)
    for b in range(len(dof) - 1):
        d = dof[b]
        mass = scale[d] / scale[d + 1] if scale[d + 1] > 0.0 else 1.0
        arm = scale[d + 2] / scale[d] if scale[d] > 0.0 else 0.0
        inertia = scale[d + 3] / scale[d + 4] if scale[d + 4] > 0.0 else 0.0
        size = arm + inertia / mass
        scale[d + FREE] = 1.0
        scale[d + TURNS] = 1.0 / size if size > 0.0 else 1.0
        scale[d + BENDS] = mass


@kernel
def assemble_geometry(rows: Rows) -> None:
    """J D J^T of the joint rows in the place of their factor."""
    factor, J, row_body, scale = rows.joints.factor, rows.J, rows.body, rows.joints.change
    order, start, column, value = factor.order, factor.start, factor.column, factor.value
    width = J.shape[2]
    for place in range(len(order)):
        for e in range(start[place], start[place + 1]):
            r, s = order[place], order[column[e]]
            total = 0.0
            for i in range(2):
                b = row_body[r, i]
                for j in range(2):
                    if b < 0 or row_body[s, j] != b:
                        continue
                    d = rows.dof[b]
                    total += dot3(J, r, i, J, s, j, 0)
                    total += scale[d + TURNS] * dot3(J, r, i, J, s, j, 3)
                    for k in range(N_RIGID, width):
                        total += scale[d + BENDS] * J[r, i, k] * J[s, j, k]
            value[e] = total


@kernel
def factorise_marked(rows: Rows) -> None:
    """The factor of S, without the rows marked in ``joints.left``: these are not looked at when answers are checked."""
    factor, distance = rows.joints.factor, rows.joints.left
    start, value, diagonal = factor.start, factor.value, factor.own
    dependent, weak = 0, 0
    for i in range(len(diagonal)):
        last = start[i + 1] - 1
        own = value[last]
        total = reduce_row(factor, i)
        diagonal[i] = own if distance[i] > 0.0 else 0.0
        if distance[i] > 0.0 and not total > WEAK * own:
            weak += 1
        if distance[i] > 0.0 and total > REDUNDANT * own:
            value[last] = math.sqrt(total)
        else:
            value[last] = 0.0
            dependent += 1
    factor.dependent = dependent
    factor.weak = weak
