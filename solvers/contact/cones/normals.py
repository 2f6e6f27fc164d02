"""Problems in space without friction, posed with one row a contact: the contacts that carry are found by exchanges.

Their matrix is a ninth of that of three rows, and nothing has to be swept.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray, kernel, late_kernel
from lcpflex.solvers.auto import TARGET
from lcpflex.solvers.balance import DEAD, contact_units
from lcpflex.solvers.contact.algebra import IN_SPACE
from lcpflex.solvers.contact.cones.dense import tell, weigh_posed
from lcpflex.solvers.contact.cones.memory import SpatialContactData, SpatialSolverMemory
from lcpflex.solvers.contact.judging import FLOOR, measure_loads
from lcpflex.solvers.contact.laws import COULOMB
from lcpflex.solvers.lcp.principal_pivoting import principal_pivoting
from lcpflex.solvers.status import SOLVED

__all__ = ["exchange", "lay_three", "solve_normals"]

PIVOTS = 100, 20  # of the exchanges at most, and for each contact besides


@kernel
def exchange(memory: SpatialSolverMemory, G: FloatArray, free: FloatArray, n: int) -> bool:
    """``dense.y`` = forces of n contacts with the matrix G, from those that ``basis`` has as carrying; if found."""
    dense, basis = memory.dense, memory.basis
    basis[len(basis) - 1] = 0  # nobody calls
    most = PIVOTS[0] + PIVOTS[1] * n
    status, pivots = principal_pivoting(G, free, n, dense.y, dense.table, basis, True, TARGET, most)
    memory.sweeping.iterations += pivots
    return bool(status == SOLVED)


@kernel
def describe(data: SpatialContactData, memory: SpatialSolverMemory) -> None:
    """The contacts of the problem, their own numbers, units and loads."""
    G, group, n = data.delassus, memory.group, data.n_contacts
    group.n, memory.dense.m = n, n
    for k in range(n):
        for e in range(9):
            group.own[k, e] = 0.0
        group.own[k, 0], group.unit[k] = G[k, k], G[k, k]
        group.free[k, 0], group.free[k, 1], group.free[k, 2] = data.free[k], 0.0, 0.0
        group.p[k, 1], group.p[k, 2] = 0.0, 0.0
        group.law[k], group.mu[k] = COULOMB, 0.0
    contact_units(group.unit, n, DEAD)
    for k in range(n):
        group.load[k] = group.unit[k] * max(abs(data.free[k]), FLOOR * data.terms[k])
    measure_loads(group, memory.judged)


@kernel
def number_rows(row: IntArray, n: int, each: int) -> None:
    """Of contacts of one row ``each``, or three."""
    for k in range(n):
        for e in range(3):
            row[k, e] = each * k + e if e < each else -1


@kernel
def solve_normals(data: SpatialContactData, memory: SpatialSolverMemory) -> bool:
    """Solve a problem of one row a contact, from the contacts that ``basis`` has as carrying; whether that was found.

    Where it was, what is told of it goes to ``memory``.
    """
    n, p = data.n_contacts, memory.group.p
    memory.size, memory.sweeping.iterations = 3 * n, 0
    describe(data, memory)
    if not exchange(memory, data.delassus, data.free, n):
        return False
    for k in range(n):
        p[k, 0] = memory.dense.y[k]
    number_rows(memory.dense.row, n, 1)
    good = weigh_posed(memory)
    number_rows(memory.dense.row, n, len(IN_SPACE))
    tell(memory)
    return good


@late_kernel
def lay_three(data: SpatialContactData, part: IntArray) -> None:
    """The problem of one row a contact as one of three; ``part``: what its rows are."""
    G, n = data.delassus, data.n_contacts
    for k in range(n - 1, -1, -1):
        for c in range(n - 1, -1, -1):
            normal = G[k, c]
            for e in range(3):
                for f in range(3):
                    G[3 * k + e, 3 * c + f] = 0.0
            G[3 * k, 3 * c] = normal
        data.free[3 * k], data.terms[3 * k], part[3 * k] = data.free[k], data.terms[k], part[k]
        for e in range(1, 3):
            data.free[3 * k + e], data.terms[3 * k + e], part[3 * k + e] = 0.0, 0.0, -1
    data.n_tangents = 2 * n
