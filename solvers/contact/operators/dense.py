"""W as one matrix. Velocities are kept up to date by its columns: a change of one force is one pass over memory.

Newton's unknowns x are the changes of the forces themselves,

    (I + C W) dx = -F,   F = x - (q - c),   measured by F.W F, what F does; by its length where W is not symmetric.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import array, struct
from lcpflex.solvers.contact import operators
from lcpflex.solvers.contact.algebra import Vector, add_to_rows, taken, taken_at
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.operators import product_as_they_are
from lcpflex.solvers.dense_factor import factorise_rows, solve_rows

__all__ = ["REGULAR", "Dense"]

REGULAR = 1e-8  # of the largest own diagonal: by less, null vectors of dependent contacts are mostly rounding
LAW_WORK = 900.0  # measured: multiplications of a factor that take as long as the law of a unit in space


@struct
class Dense:
    """The matrix and the velocities of all its rows."""

    m: int  # rows
    symmetric: int  # 1: W is
    columns: FloatArray = array("matrix", "matrix")  # W^T: that of a symmetric W itself
    row: IntArray = array("units", "rows")  # of each unit in the matrix; -1: it has none there
    free: FloatArray = array("matrix")
    y: FloatArray = array("matrix")  # velocities under the forces as they are
    # of Newton's method
    table: FloatArray = array("unknowns", "unknowns")
    pivots: IntArray = array("unknowns")
    solution: FloatArray = array("unknowns")
    caused: FloatArray = array("matrix")


@operators.begin.of(Dense)
@kernel
def begin(op: Dense, group: Group, p: FloatArray, like: Vector) -> None:
    """y = free + W p."""
    for i in range(op.m):
        op.y[i] = op.free[i]
    for k in range(group.n):
        push(op, group, k, taken(p, k, like))


@operators.velocity.of(Dense)
@kernel(inline=True)
def velocity(op: Dense, group: Group, k: int, like: Vector) -> Vector:
    """What is kept."""
    return taken_at(op.y, op.row, k, like)


@operators.push.of(Dense)
@kernel(inline=True)
def push(op: Dense, group: Group, k: int, d: Vector) -> None:
    """y += W_k d, the columns of unit k."""
    add_to_rows(op.columns, op.row, k, d, op.y, op.m)


@operators.terms.of(Dense)
@kernel
def terms(op: Dense, group: Group, k: int, p: FloatArray, v: Vector) -> tuple[float, float]:
    """|free| + |W| |p|, the largest of its rows."""
    largest = 0.0
    for e in range(len(v)):
        r = op.row[k, e]
        if r >= 0:
            size = abs(op.free[r])
            for c in range(group.n):
                for f in range(len(v)):
                    if op.row[c, f] >= 0:
                        size += abs(op.columns[op.row[c, f], r] * p[c, f])
            largest = max(largest, size)
    return group.unit[k] * largest, group.unit[k] * largest


operators.unknowns.of(Dense)(operators.components_of_forces)
operators.norm.of(Dense)(operators.norm_of_forces)
operators.defect.of(Dense)(operators.defect_of_forces)
operators.prepare.of(Dense)(operators.has_room)


@kernel
def apply(op: Dense, group: Group, x: FloatArray, like: Vector) -> None:
    """``caused`` = W x, by rows of the matrix."""
    caused, S = op.caused, len(like)
    for r in range(op.m):
        caused[r] = 0.0
    for k in range(group.n):
        for e in range(S):
            r, force = op.row[k, e], x[S * k + e]
            if r >= 0 and force != 0.0:
                column = op.columns[r]
                for i in range(op.m):
                    caused[i] += force * column[i]


@operators.moves_centre.of(Dense)
@kernel(inline=True)
def moves_centre(op: Dense) -> bool:
    """It has."""
    return True


@operators.add_effect.of(Dense)
@kernel
def add_effect(op: Dense, group: Group, x: FloatArray, base: FloatArray, y: FloatArray, like: Vector) -> None:
    """y = base + W x."""
    apply(op, group, x, like)
    for k in range(group.n):
        for e in range(len(like)):
            r = op.row[k, e]
            y[k, e] = base[k, e] + op.caused[r] if r >= 0 else 0.0


@operators.product.of(Dense)
@kernel
def product(op: Dense, group: Group, a: FloatArray, b: FloatArray, like: Vector) -> float:
    """a.W b; a.b where W is not symmetric."""
    if op.symmetric == 0:
        return product_as_they_are(op, group, a, b, like)
    total, S = 0.0, len(like)
    apply(op, group, b, like)
    for k in range(group.n):
        for e in range(S):
            r = op.row[k, e]
            if r >= 0:
                total += a[S * k + e] * op.caused[r]
    return total


@kernel
def fill_table(op: Dense, group: Group, C: FloatArray, shift: float, moving: bool, like: Vector) -> None:
    """``table`` = I + C (W + shift), less C / rho where the centre is ``moving``; shift in units of the contacts."""
    S, table = len(like), op.table
    for c in range(group.n):
        for g in range(S):
            column, s = S * c + g, op.row[c, g]
            for k in range(group.n):
                for e in range(S):
                    total = 0.0
                    if s >= 0:
                        for f in range(S):
                            r = op.row[k, f]
                            if r >= 0:
                                total += C[k, S * e + f] * op.columns[s, r]
                    table[S * k + e, column] = total
    for k in range(group.n):
        square = group.unit[k] * group.unit[k]
        for e in range(S):
            table[S * k + e, S * k + e] += 1.0
            for g in range(S):
                table[S * k + e, S * k + g] += C[k, S * e + g] / square * (shift - (1.0 if moving else 0.0))


@operators.factorise.of(Dense)
@kernel
def factorise(op: Dense, group: Group, C: FloatArray, like: Vector) -> bool:
    """LU of I + C W."""
    fill_table(op, group, C, 0.0, False, like)
    return factorise_rows(op.table, len(like) * group.n, op.pivots)


@operators.factorise_moving.of(Dense)
@kernel
def factorise_moving(op: Dense, group: Group, C: FloatArray, like: Vector) -> bool:
    """LU of I - C / rho + C (W + a little)."""
    fill_table(op, group, C, REGULAR, True, like)
    return factorise_rows(op.table, len(like) * group.n, op.pivots)


@operators.solve.of(Dense)
@kernel
def solve(op: Dense, group: Group, x: FloatArray) -> None:
    """By the factor made last."""
    solve_rows(op.table, group.n * group.p.shape[1], op.pivots, x, op.solution)


@operators.factor_work.of(Dense)
@kernel(inline=True)
def factor_work(op: Dense, group: Group) -> float:
    """A third of the cube of the unknowns."""
    return op.m**3 / 3.0


@operators.sweep_work.of(Dense)
@kernel(inline=True)
def sweep_work(op: Dense, group: Group) -> float:
    """A pass over the matrix, and the law of each unit."""
    return op.m**2 + LAW_WORK * group.n
