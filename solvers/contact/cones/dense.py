"""Islands in space posed with their Delassus operator: sweeps, and Newton's method where they crawl."""

from __future__ import annotations

from lcpflex.jit.kernel import kernel, late_kernel
from lcpflex.solvers.balance import DEAD, contact_units
from lcpflex.solvers.certificate import ROUNDING, terms_residual
from lcpflex.solvers.contact.algebra import IN_SPACE
from lcpflex.solvers.contact.best import copy_forces
from lcpflex.solvers.contact.cones.memory import SpatialContactData, SpatialSolverMemory
from lcpflex.solvers.contact.judging import FLOOR, is_good, lags, measure_loads, weigh
from lcpflex.solvers.contact.laws import COULOMB
from lcpflex.solvers.contact.memory import NOTHING_KNOWN, SOLUTION_KNOWN, WEDGED_KNOWN
from lcpflex.solvers.contact.strategy import conclude, find, serve_lagging
from lcpflex.solvers.contact.sweeping import sweep_on
from lcpflex.solvers.status import ITERATION_LIMIT, SOLVED

__all__ = ["FIRST_SWEEPS", "mend_posed", "newton_on", "solve_cones", "tell", "weigh_posed"]

FIRST_SWEEPS, SWEEPS = 200, 2000  # at most: before Newton's method, and behind it


@kernel
def tell(memory: SpatialSolverMemory) -> None:
    """Of the forces judged last what is told of a solve."""
    judged = memory.judged
    memory.residual, memory.strict, memory.missed = judged.residual, judged.strict, judged.missed
    memory.behind, memory.iterations = judged.behind, 1.0 * memory.sweeping.iterations


@kernel
def describe(data: SpatialContactData, memory: SpatialSolverMemory) -> None:
    """The contacts of the problem, their own blocks, units and loads."""
    G, group, n = data.delassus, memory.group, data.n_contacts
    unit = group.unit
    group.n, memory.dense.m = n, 3 * n
    for k in range(n):
        i = 3 * k
        for a in range(3):
            group.free[k, a] = data.free[i + a]
            for b in range(3):
                group.own[k, 3 * a + b] = G[i + a, i + b]
        unit[k] = max(G[i, i], max(G[i + 1, i + 1], G[i + 2, i + 2]))
        group.law[k], group.mu[k] = COULOMB, data.friction[k]
    contact_units(unit, n, DEAD)
    for k in range(n):
        load = 0.0
        for r in range(3 * k, 3 * k + 3):  # the free velocity, or what its terms make it worth
            load = max(load, unit[k] * max(abs(data.free[r]), FLOOR * data.terms[r]))
        group.load[k] = load
    measure_loads(group, memory.judged)


@kernel
def weigh_posed(memory: SpatialSolverMemory) -> bool:
    """Judge the forces of the problem described; whether they are good enough."""
    weigh(memory.dense, memory.group, memory.judged, memory.group.p, IN_SPACE)
    return is_good(memory.judged)


@kernel
def sweep_posed(memory: SpatialSolverMemory, count: int, patient: bool) -> bool:
    """Sweeps from the forces judged last; whether they are good enough."""
    return sweep_on(memory.dense, memory.group, memory.judged, memory.sweeping, memory.best, IN_SPACE, count, patient)


@late_kernel
def newton_on(memory: SpatialSolverMemory) -> bool:
    """Newton's method, and what else is in the table, from the forces judged last; whether they are good enough."""
    op, group, judged, best, work, search = (
        memory.dense, memory.group, memory.judged, memory.best, memory.newton, memory.search,
    )  # fmt: skip
    find(op, group, judged, best, work, search, memory.attempts, IN_SPACE)
    conclude(op, group, judged, best, IN_SPACE)
    if lags(judged):
        serve_lagging(op, group, judged, best, work, search, IN_SPACE)
    copy_forces(group, best.p, group.p, IN_SPACE)
    memory.sweeping.iterations += search.sweeps + work.factors
    return weigh_posed(memory)


@kernel
def mend_posed(memory: SpatialSolverMemory) -> bool:
    """A few sweeps from the forces judged last, Newton's method where they crawl; whether they are good enough."""
    return sweep_posed(memory, FIRST_SWEEPS, False) or newton_on(memory)


@kernel
def solve_described(data: SpatialContactData, memory: SpatialSolverMemory) -> bool:
    """Forces from those in ``memory``, as far as these are not known to solve the problem; whether they do."""
    known, judged = memory.known, memory.judged
    memory.known = NOTHING_KNOWN
    memory.size, memory.sweeping.iterations = 3 * data.n_contacts, 0
    describe(data, memory)
    for k in range(data.n_contacts):
        if data.friction[k] == 0.0:
            memory.group.p[k, 1], memory.group.p[k, 2] = 0.0, 0.0
    weigh_posed(memory)
    if known == WEDGED_KNOWN:
        judged.residual = terms_residual(max(judged.worst, ROUNDING * judged.terms), judged.terms, judged.load)
        return bool(judged.residual <= judged.tolerance)
    if known == SOLUTION_KNOWN and judged.residual <= judged.tolerance:
        return True
    return mend_posed(memory) or sweep_posed(memory, SWEEPS, True)


@kernel
def solve_cones(data: SpatialContactData, memory: SpatialSolverMemory) -> int:
    """Solve a contact problem from the forces in ``memory``; 0 where solved. What is told of it goes there, too.

    The Delassus operator is symmetric. A few sweeps, Newton's method where they crawl, many sweeps where that fails.
    """
    solved = solve_described(data, memory)
    tell(memory)
    return SOLVED if solved else ITERATION_LIMIT
