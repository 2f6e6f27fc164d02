"""What Newton's method asks of a dense W: its unknowns x are the changes of the forces themselves.

(I + C W) dx = -F,   F = x - (q - c),   measured by F.W F, what F does; by its length where W is not symmetric
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact import operators
from lcpflex.solvers.contact.algebra import Vector
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.operators.dense import Dense
from lcpflex.solvers.dense_factor import factorise_rows, solve_rows

__all__: list[str] = []

LAW_WORK = 900.0  # measured: multiplications of a factor that take as long as the law of a unit in space


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


@operators.unknowns.of(Dense)
@kernel(inline=True)
def unknowns(op: Dense, group: Group) -> int:
    """All components of all forces."""
    return int(group.n * group.p.shape[1])


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
    total, S = 0.0, len(like)
    if op.symmetric == 0:
        for i in range(S * group.n):
            total += a[i] * b[i]
        return total
    apply(op, group, b, like)
    for k in range(group.n):
        for e in range(S):
            r = op.row[k, e]
            if r >= 0:
                total += a[S * k + e] * op.caused[r]
    return total


@operators.defect.of(Dense)
@kernel
def defect(op: Dense, group: Group, x: FloatArray, change: FloatArray, rest: FloatArray, like: Vector) -> float:
    """F = x - change."""
    S = len(like)
    for k in range(group.n):
        for e in range(S):
            rest[S * k + e] = x[S * k + e] - change[k, e]
    return math.sqrt(max(product(op, group, rest, rest, like), 0.0))


@operators.factorise.of(Dense)
@kernel
def factorise(op: Dense, group: Group, C: FloatArray, like: Vector) -> bool:
    """LU of I + C W."""
    S, table = len(like), op.table
    for c in range(group.n):
        for g in range(S):
            column, s = S * c + g, op.row[c, g]
            for k in range(group.n):
                for e in range(S):
                    total = 1.0 if c == k and g == e else 0.0
                    if s >= 0:
                        for f in range(S):
                            r = op.row[k, f]
                            if r >= 0:
                                total += C[k, S * e + f] * op.columns[s, r]
                    table[S * k + e, column] = total
    return factorise_rows(table, S * group.n, op.pivots)


@operators.solve.of(Dense)
@kernel
def solve(op: Dense, group: Group, x: FloatArray) -> None:
    """By the factor made last."""
    solve_rows(op.table, group.n * group.p.shape[1], op.pivots, x, op.solution)


@operators.prepare.of(Dense)
@kernel(inline=True)
def prepare(op: Dense, group: Group) -> bool:
    """There is room for a factor of all rows."""
    return True


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
