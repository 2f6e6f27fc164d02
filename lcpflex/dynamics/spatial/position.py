"""The contact problem at position level in space: cones of friction. See :mod:`lcpflex.dynamics.position`."""

from __future__ import annotations

import math

from lcpflex.dynamics.contact_problem import describe_contacts, rows_of_each
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.algebra import IN_SPACE, PLANAR
from lcpflex.solvers.contact.cones.dense import solve_cones
from lcpflex.solvers.contact.cones.memory import POSED
from lcpflex.solvers.contact.cones.normals import lay_three, solve_normals
from lcpflex.solvers.contact.cones.recollection import keep_force, known_force
from lcpflex.solvers.contact.memory import NOTHING_KNOWN
from lcpflex.solvers.contact.recollection import place_of, turn_over
from lcpflex.solvers.status import SOLVED

__all__ = ["describe", "friction_before", "remember_friction", "slip_in", "solve_position", "split_forces", "stiffens"]

INSIDE = 1.0 - 1e-6  # of the cone: friction of a contact that slides is on it to the tolerance of solvers


@kernel
def describe(work: SpatialWork) -> None:
    """Friction, names and rows of the contacts laid, as one problem: three rows a contact, or where nothing rubs one.

    Solvers that are not compiled in, and whoever is told of problems, know problems of three.
    """
    solver = work.impulses.solver
    if work.rows.n_tangents == 0 and solver.method != POSED and solver.known == NOTHING_KNOWN:
        describe_contacts(work, 0, PLANAR)
    else:
        describe_contacts(work, 0, IN_SPACE)


@kernel
def friction_before(work: SpatialWork, j: int) -> float:
    """Friction along tangential row j at the end of the step before [N]."""
    k, table, known = work.rows.tangent[j], work.rows.table, work.impulses.remembered
    place = place_of(known, table.key[k], k)
    _, first, second, _ = known_force(known, place, table.normal, table.tangent, k, work.rows.mu[k])
    return first if work.posed.tangent_of[k] == j else second


@kernel
def begin_forces(work: SpatialWork, unit: FloatArray) -> None:
    """Forces of the problem posed to begin from: those at the end of the step before."""
    group, table, known, guess = work.impulses.solver.group, work.rows.table, work.impulses.remembered, 0
    for k in range(work.rows.n_contacts):
        place = place_of(known, table.key[k], guess)
        f, first, second, _ = known_force(known, place, table.normal, table.tangent, k, work.rows.mu[k])
        if place >= 0:
            guess = place + 1 if place + 1 < known.n else 0
        group.p[k, 0], group.p[k, 1], group.p[k, 2] = f / unit[0], first / unit[0], second / unit[0]
        group.slip[k] = 0.0


@kernel
def solve_position(work: SpatialWork, unit: FloatArray, again: bool, tolerance: float) -> int:
    """Solve the problem posed, from the forces of the last step, or pass; 0 where solved.

    Arguments as of :func:`lcpflex.dynamics.position.solve_position`.
    """
    memory, p, n_joint, problem = work.impulses.solver, work.impulses.p, work.rows.n_joint, work.posed.problem
    memory.judged.tolerance = tolerance
    if memory.known == NOTHING_KNOWN:
        if again:
            for k in range(work.rows.n_contacts):
                j = work.posed.tangent_of[k]
                s = n_joint + work.rows.n_contacts + j
                memory.group.p[k, 0] = p[n_joint + k] / unit[0]
                memory.group.p[k, 1] = p[s] / unit[0] if j >= 0 else 0.0
                memory.group.p[k, 2] = p[s + 1] / unit[0] if j >= 0 else 0.0
        else:
            begin_forces(work, unit)
    if rows_of_each(work) == 1:
        basis = memory.basis
        for k in range(problem.n_contacts):
            basis[k] = 1 if memory.group.p[k, 0] > 0.0 or work.rows.table.gap[k] < 0.0 else 0
        if solve_normals(problem, memory):
            return SOLVED
        lay_three(problem, work.posed.part)
    return solve_cones(problem, memory)


@kernel
def remember_friction(work: SpatialWork) -> None:
    """Keep the forces of this step for the next one."""
    known, table, p = work.impulses.remembered, work.rows.table, work.impulses.p
    n_joint, n = work.rows.n_joint, work.rows.n_contacts
    for k in range(n):
        j = work.posed.tangent_of[k]
        s = n_joint + n + j
        first, second = (p[s], p[s + 1]) if j >= 0 else (0.0, 0.0)
        keep_force(known, k, table.key[k], table.normal, table.tangent, k, p[n_joint + k], first, second, 0.0)
    known.n_next = n
    turn_over(known)


@kernel
def slip_in(work: SpatialWork, j: int) -> float:
    """Slip of tangential row j in the solution of the problem posed, in its largest gap."""
    k = work.rows.tangent[j]
    return float(work.impulses.solver.group.y[k, 1 if work.posed.tangent_of[k] == j else 2])


@kernel
def split_forces(work: SpatialWork, unit: FloatArray) -> None:
    """Forces [N] of the contact rows, impulses.normal, impulses.tangential and impulses.p, from the solution."""
    n_joint, n, found = work.rows.n_joint, work.rows.n_contacts, work.impulses.solver.group.p
    for k in range(n):
        work.impulses.normal[k] = max(found[k, 0], 0.0) * unit[0]
        work.impulses.p[n_joint + k] = work.impulses.normal[k]
        j = work.posed.tangent_of[k]
        for t in range(2 if j >= 0 else 0):
            work.impulses.tangential[j + t] = found[k, 1 + t] * unit[0]
            work.impulses.p[n_joint + n + j + t] = work.impulses.tangential[j + t]


@kernel
def stiffens(work: SpatialWork, r: int) -> bool:
    """Whether contact row r is a spring in the present solution: a normal that is closed, a tangent that sticks.

    Friction on its cone is none: across its slip, it turns.
    """
    n = work.rows.n_contacts
    k = r if r < n else work.rows.tangent[r - n]
    force = work.impulses.solver.group.p[k]
    if r < n:
        return bool(force[0] > 0.0)
    return math.hypot(force[1], force[2]) < INSIDE * work.rows.mu[k] * force[0]
