"""A contact problem of a user as what iterations take: units of a group and an operator, in the plane and in space.

Rows of a planar problem are [normals; tangents of frictional contacts], those of one in space (n, t1, t2) of each
contact in turn; a table tells which rows are those of a unit. W is stored as one matrix, by its blocks or as a factor.
"""

from __future__ import annotations

import threading
from typing import Any, Protocol, TypeAlias

import numpy as np

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate
from lcpflex.solvers.contact.active_set import states_of
from lcpflex.solvers.contact.algebra import IN_SPACE, PLANAR, Vector, add_sparse_row, put, sparse_dot
from lcpflex.solvers.contact.coupling import ConeBlocks
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.laws import COULOMB
from lcpflex.solvers.contact.laws.states import BACK, OPEN, STICKING
from lcpflex.solvers.contact.matrices import as_dense
from lcpflex.solvers.contact.operators import Operator, begin, velocity
from lcpflex.solvers.contact.operators.blocks import Blocks
from lcpflex.solvers.contact.operators.dense import Dense
from lcpflex.solvers.contact.operators.factor import Factor
from lcpflex.solvers.contact.sweeping import sweep
from lcpflex.solvers.refusals import has_cones

__all__ = ["FEW", "MOST_DENSE", "SIZES", "ContactSystem", "Storage", "storage_of"]

# Contacts, by their numbers of rows, up to which a matrix is taken as it is: in the plane what elimination finishes, in
# space what Newton's method solves in compiled code.
MOST_DENSE = {2: 300, 3: 64}
FEW, SIZES = 64, 16  # contacts up to which memory is kept, beyond it takes little to lay it out; and how many sizes
AT_ONCE = 50_000  # contacts solved in one call of a kernel: some ms, in which nobody listens to Ctrl-C


class BlockRows(Protocol):
    """Blocks of contact k: first[k] to first[k + 1], with contact other[e], entries block[e] by rows; own (n, S S)."""

    @property
    def first(self) -> IntArray: ...
    @property
    def other(self) -> IntArray: ...
    @property
    def block(self) -> FloatArray: ...
    @property
    def own(self) -> FloatArray: ...


Storage: TypeAlias = "FloatArray | BlockRows | None"


@kernel
def renew(op: Operator, group: Group, like: Vector) -> None:
    """Velocities ``group.y`` under the forces ``group.p``, and what the operator keeps of these, made anew."""
    begin(op, group, group.p, like)
    for k in range(group.n):
        put(group.y, k, velocity(op, group, k, like))


@kernel
def pose(
    group: Group, free: FloatArray, friction: FloatArray, unit: FloatArray, row: IntArray, place: IntArray
) -> float:
    """The units of contacts, without forces; the size of their free velocities, in units of the contacts.

    free (m,) by the rows of the problem. Out: row (n, S) of each contact in the problem, place (m,) of each row of the
    problem in arrays (n, S).
    """
    n, rows = row.shape
    group.n = n
    tangent, load = n, 0.0
    for k in range(n):
        group.law[k], group.mu[k], group.unit[k] = COULOMB, friction[k], unit[k]
        group.slip[k], group.state[k] = 0.0, OPEN
        if rows == 2:
            row[k, 0], row[k, 1] = k, -1
            if friction[k] > 0.0:
                row[k, 1] = tangent
                tangent += 1
        size = 0.0
        for a in range(rows):
            if rows == 3:
                row[k, a] = 3 * k + a
            group.p[k, a], group.free[k, a] = 0.0, 0.0
            if row[k, a] >= 0:
                group.free[k, a] = free[row[k, a]]
                place[row[k, a]] = rows * k + a
                size = max(size, abs(group.free[k, a]))
        group.load[k] = unit[k] * size
        load = max(load, group.load[k])
    return load


@kernel
def own_blocks(W: FloatArray, row: IntArray, own: FloatArray) -> None:
    """own (n, S S): the block of each unit with itself, by rows; row (n, S) of each unit in W."""
    n, rows = row.shape
    for k in range(n):
        for a in range(rows):
            for b in range(rows):
                both = row[k, a] >= 0 and row[k, b] >= 0
                own[k, rows * a + b] = W[row[k, a], row[k, b]] if both else 0.0


@kernel
def own_of_rows(
    first: IntArray, place: IntArray, value: FloatArray, row: IntArray, x: FloatArray, own: FloatArray
) -> None:  # fmt: skip
    """The same of W = J J^T by the rows of J in compressed form. Work: x, as long as J has columns, zero throughout."""
    n, rows = row.shape
    for k in range(n):
        for a in range(rows):
            add_sparse_row(row[k, a], first, place, value, 1.0, x)
            for b in range(rows):
                there = row[k, a] >= 0
                own[k, rows * a + b] = sparse_dot(row[k, b], first, place, value, x) if there else 0.0
            add_sparse_row(row[k, a], first, place, value, -1.0, x)


@kernel
def friction_point(group: Group, row: IntArray, z: FloatArray, basis: IntArray) -> None:
    """z = [lambda_N, lambda_R, xi_L] of the three-unknown form for the forces and velocities of planar contacts.

    basis: 1 for those that the states leave free to be positive, else 0; row (n, 2) of each contact in the problem.
    """
    slips = (len(z) - group.n) // 2
    for k in range(group.n):
        z[k] = group.p[k, 0]
        state, t = group.state[k], row[k, 1]
        basis[k] = 0 if state == OPEN else 1
        if t >= 0:
            left = t + slips
            z[t] = group.p[k, 1] + group.mu[k] * group.p[k, 0]
            z[left] = max(-group.y[k, 1], 0.0)
            leaving = state == OPEN and z[left] > 0.0  # xi_L carries the speed, and lambda_R = 0 pays for it
            basis[t] = 1 if state in (STICKING, BACK) or leaving else 0
            basis[left] = 1 if state == BACK or leaving else 0


@kernel
def sweep_and_renew(
    op: Operator, group: Group, like: Vector, count: int, target: float
) -> tuple[int, float, float]:  # fmt: skip
    """Sweeps, and then velocities without what they have rounded; the largest force in its unit comes third.

    inf where forces are not finite.
    """
    made, change = sweep(op, group, like, count, target)
    renew(op, group, like)
    largest = 0.0
    for k in range(group.n):
        for a in range(len(like)):
            size = abs(group.p[k, a]) / group.unit[k]
            largest = max(largest, size) if size < np.inf else np.inf
    return made, change, largest


class ContactSystem:
    """Units, operator and forces of one problem.

    Attributes
    ----------
    problem
        A :class:`ContactProblem` or :class:`SpatialContactProblem`.
    row
        (n, S) of each contact in the problem; -1 for the tangent of one without friction.
    group, op, like
        What iterations take.
    load
        Size of the free velocities, in units of the contacts.
    largest
        Size of the forces that sweeps have come to, in units.
    """

    def __init__(self, problem: Any, storage: Storage) -> None:
        """storage: the Delassus matrix, its blocks, or None for the factor of the problem."""
        self.problem = problem
        _, free, friction, _ = problem._data
        self.like: Vector = IN_SPACE if has_cones(problem) else PLANAR
        kept = _kept.systems.pop((len(friction), len(free), len(self.like)), None)
        self.group, self.row, self._place, self._dense = _laid_out(problem, self.like) if kept is None else kept
        self.load = pose(self.group, free, friction, problem.units, self.row, self._place)
        self.op: Any = _operator(problem, self.group, self.row, storage, self._dense)
        self.largest = 0.0

    def release(self) -> None:
        """Leave the memory of a few contacts to the next problem: this one is solved."""
        if self.group.n <= FEW:
            if len(_kept.systems) >= SIZES:
                _kept.systems.clear()
            dense = self.op if isinstance(self.op, Dense) else self._dense
            sizes = self.group.n, len(self._place), len(self.like)
            _kept.systems[sizes] = self.group, self.row, self._place, dense

    @property
    def forces(self) -> FloatArray:
        """(m,) in the order of the problem; a copy."""
        return self.by_rows(self.group.p)

    def by_rows(self, p: FloatArray) -> FloatArray:
        """Forces or velocities (n, S) of the units in the order of the problem, (m,)."""
        return p.ravel()[self._place]

    def take(self, forces: FloatArray) -> None:
        """Begin from forces (m,): their velocities, and the slips and states that they belong to."""
        group = self.group
        group.p.ravel()[self._place] = forces
        renew(self.op, group, self.like)
        if not forces.any():
            group.slip[:], group.state[:] = 0.0, OPEN
            return
        if self.like is PLANAR:
            group.state[:] = states_of(self.problem, forces, self.by_rows(group.y))
            return
        rub = np.hypot.reduce(group.p[:, 1:], axis=1)
        slip = np.hypot.reduce(group.y[:, 1:], axis=1)
        group.slip[:] = np.divide(slip, rub, out=np.zeros(group.n), where=rub > 0.0)

    def sweep(self, count: int, target: float) -> tuple[int, float]:
        """Up to so many sweeps; how many were made, and the largest change of a force in the last one, in units.

        In pieces, so that Ctrl-C is heard.
        """
        piece, made, change = max(1, AT_ONCE // max(1, len(self.row))), 0, np.inf
        while made < count and change > target:
            least = min(piece, count - made)
            done, change, self.largest = sweep_and_renew(self.op, self.group, self.like, least, target)
            made += done
        return made, change

    def point(self) -> tuple[FloatArray, IntArray | None]:
        """z of the problem for the forces as they are; in the plane its active set, too.

        That is what the states of the contacts leave free to be positive.
        """
        if self.like is not PLANAR:
            return self.forces, None
        z, basis = np.empty(self.problem.size), np.empty(self.problem.size, dtype=np.int64)
        friction_point(self.group, self.row, z, basis)
        return z, basis


def storage_of(problem: Any) -> Storage:
    """The Delassus matrix of a few contacts, the blocks of many; in the plane the factor where that alone is known.

    In space the factor where it cannot be multiplied out.
    """
    few = len(problem.friction) <= MOST_DENSE[3 if has_cones(problem) else 2]
    if not has_cones(problem):
        delassus = problem._data[0]
        if delassus is None:
            return None
        return delassus if few and isinstance(delassus, np.ndarray) else problem.coupling
    matrix = problem.matrix()
    if matrix is None:
        return None
    if few:
        return np.ascontiguousarray(as_dense(matrix))
    return ConeBlocks(matrix)


class _Kept(threading.local):
    """Memory of a few contacts, one of each size: to lay it out takes as long as to solve them."""

    def __init__(self) -> None:
        self.systems: dict[tuple[int, int, int], tuple[Group, IntArray, IntArray, Dense | None]] = {}


_kept = _Kept()


def _laid_out(problem: Any, like: Vector) -> tuple[Group, IntArray, IntArray, None]:
    """Memory of a group, of the rows of its units, and of the places of these in arrays (n, S)."""
    n, m, rows = len(problem.friction), len(problem.free), len(like)
    group = allocate(Group, {"units": n, "rows": rows, "block": rows * rows})
    return group, np.empty((n, rows), dtype=np.int64), np.empty(m, dtype=np.int64), None


def _operator(problem: Any, group: Group, row: IntArray, storage: Storage, dense: Dense | None) -> Operator:
    """The operator of a storage, in ``dense`` if that is given; writes the blocks of each unit with itself."""
    if storage is None:
        J = libs.sparse.csr_array(problem._data[3])
        compressed = J.indptr.astype(np.int64), J.indices.astype(np.int64), np.ascontiguousarray(J.data)
        named = dict(zip(("first", "place", "value"), compressed, strict=True))
        factor = allocate(Factor, {"columns": J.shape[1]}, row=row, **named)
        own_of_rows(*compressed, row, factor.x, group.own)
        return factor
    if not isinstance(storage, np.ndarray):
        group.own[:] = storage.own
        sizes = {"units": group.n, "rows": row.shape[1]}
        return allocate(Blocks, sizes, first=storage.first, other=storage.other, block=storage.block)
    if dense is None:
        shared = group.n > FEW and np.array_equal(storage, storage.T)
        columns = storage if shared else np.array(storage.T, order="C")
        dense = allocate(Dense, {"matrix": len(storage), "unknowns": 0}, columns=columns, row=row)
        dense.m = len(storage)
    else:
        dense.columns[:] = storage.T
    dense.free[:] = problem._data[1]
    own_blocks(storage, row, group.own)
    return dense
