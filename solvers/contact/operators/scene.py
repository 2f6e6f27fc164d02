"""W = B A^-1 B^T by the rows of B and of A^-1 B^T as a step has laid them, by body; W is never formed.

x = A^-1 B^T p are the changes of the velocities of the bodies by the forces. A contact in space has a normal row and
two tangential ones, which follow each other; where it has no friction there are none. A row of a rigid body has six
numbers, and each addition of a product waits for the one before: of three rows side by side they wait together.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.solvers.contact import operators
from lcpflex.solvers.contact.algebra import Vector, size_of, taken
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.operators import own_terms

__all__ = ["SceneRows", "push_rows", "row_velocities", "scene_rows"]


@struct
class SceneRows:
    """Rows of a whole scene, and those of the units in them."""

    rows: FloatArray  # B (scene rows, 2, width)
    solved: FloatArray  # A^-1 B^T, as B
    row_body: IntArray  # (scene rows, 2); -1: none, or one that nothing moves
    dof: IntArray  # (bodies + 1,) first velocity of each body
    normal: IntArray = array("units")  # row of each unit
    tangent: IntArray = array("units")  # the first of its two others; -1: it has none
    x: FloatArray = array("ndof")


def scene_rows(
    units: int,
    rows: FloatArray | None = None,
    solved: FloatArray | None = None,
    row_body: IntArray | None = None,
    dof: IntArray | None = None,
) -> SceneRows:
    """Room for so many units in the rows of a scene, which are shared; without rows, for none that has any."""
    given = {
        "rows": np.zeros((0, 2, 0)) if rows is None else rows,
        "solved": np.zeros((0, 2, 0)) if solved is None else solved,
        "row_body": np.zeros((0, 2), dtype=np.int64) if row_body is None else row_body,
        "dof": np.zeros(1, dtype=np.int64) if dof is None else dof,
    }
    return allocate(SceneRows, {"units": units, "ndof": int(given["dof"][-1])}, **given)


@kernel
def push_rows(
    solved: FloatArray,
    row_body: IntArray,
    dof: IntArray,
    r: int,
    s: int,
    p: float,
    p1: float,
    p2: float,
    x: FloatArray,
) -> None:
    """x += A^-1 (rows_r p + rows_s p1 + rows_s+1 p2); s < 0: rows_r alone."""
    for i in range(2):
        b = row_body[r, i]
        if b < 0:
            continue
        d = dof[b]
        width = dof[b + 1] - d
        if s < 0:
            for c in range(width):
                x[d + c] += solved[r, i, c] * p
        else:
            for c in range(width):
                x[d + c] += solved[r, i, c] * p + solved[s, i, c] * p1 + solved[s + 1, i, c] * p2


@kernel
def row_velocities(
    rows: FloatArray, row_body: IntArray, dof: IntArray, r: int, s: int, u: FloatArray
) -> tuple[float, float, float]:
    """rows_r . u, rows_s . u and rows_s+1 . u of a contact [m/s]; s < 0: it has no tangential rows, and 0 there."""
    v, v1, v2 = 0.0, 0.0, 0.0
    for i in range(2):
        b = row_body[r, i]
        if b < 0:
            continue
        d = dof[b]
        width = dof[b + 1] - d
        if s < 0:
            for c in range(width):
                v += rows[r, i, c] * u[d + c]
        else:
            for c in range(width):
                y = u[d + c]
                v += rows[r, i, c] * y
                v1 += rows[s, i, c] * y
                v2 += rows[s + 1, i, c] * y
    return v, v1, v2


@operators.begin.of(SceneRows)
@kernel
def begin(op: SceneRows, group: Group, p: FloatArray, like: Vector) -> None:
    """x = A^-1 B^T p, of the bodies that the units move."""
    row_body, dof, x = op.row_body, op.dof, op.x
    for k in range(group.n):
        for side in range(2):
            b = row_body[op.normal[k], side]
            if b >= 0:
                for d in range(dof[b], dof[b + 1]):
                    x[d] = 0.0
    for k in range(group.n):
        if size_of(taken(p, k, like)) != 0.0:
            push_rows(op.solved, row_body, dof, op.normal[k], op.tangent[k], p[k, 0], p[k, 1], p[k, 2], x)


@operators.velocity.of(SceneRows)
@kernel(inline=True)
def velocity(op: SceneRows, group: Group, k: int, like: Vector) -> Vector:
    """free + B_k x."""
    v, v1, v2 = row_velocities(op.rows, op.row_body, op.dof, op.normal[k], op.tangent[k], op.x)
    return group.free[k, 0] + v, group.free[k, 1] + v1, group.free[k, 2] + v2


@operators.push.of(SceneRows)
@kernel(inline=True)
def push(op: SceneRows, group: Group, k: int, d: Vector) -> None:
    """x += A^-1 B_k^T d."""
    push_rows(op.solved, op.row_body, op.dof, op.normal[k], op.tangent[k], d[0], d[1], d[2], op.x)


@operators.terms.of(SceneRows)
@kernel(inline=True)
def terms(op: SceneRows, group: Group, k: int, p: FloatArray, v: Vector) -> tuple[float, float]:
    """Of its own force, and of all others together."""
    return own_terms(group, k, p, v)
