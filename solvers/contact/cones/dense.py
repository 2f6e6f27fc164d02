"""Islands in space posed with their Delassus operator: sweeps, and Newton's method where they crawl."""

from __future__ import annotations

from lcpflex.jit.kernel import kernel
from lcpflex.solvers.balance import DEAD, contact_units
from lcpflex.solvers.certificate import ROUNDING, terms_residual
from lcpflex.solvers.contact.algebra import IN_SPACE
from lcpflex.solvers.contact.cones.memory import (
    NOTHING_KNOWN,
    SOLUTION_KNOWN,
    WEDGED_KNOWN,
    SpatialContactData,
    SpatialSolverMemory,
)
from lcpflex.solvers.contact.cones.newton import newton, proximal
from lcpflex.solvers.contact.judging import is_good, lags, measure_loads, weigh
from lcpflex.solvers.contact.laws import COULOMB
from lcpflex.solvers.contact.sweeping import left_over, sweep_on
from lcpflex.solvers.status import ITERATION_LIMIT, SOLVED

__all__ = ["FIRST_SWEEPS", "FLOOR", "mend_posed", "newton_on", "solve_cones", "tell", "weigh_posed"]

FLOOR = 1e-3  # of the terms of which free velocities are made: less of them is no measure of a residual
FIRST_SWEEPS, SWEEPS = 200, 2000  # at most: before Newton's method, and behind it
SYSTEMS, PROXIMAL_SYSTEMS = 40, 400  # that Newton's method solves, and proximal points
EXACT, PROXIMAL = 1e-15, 0.1  # of Alart and Curnier's function; of the tolerance


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


@kernel
def newton_on(data: SpatialContactData, memory: SpatialSolverMemory) -> bool:
    """Newton's method from the forces judged last, then proximal points; whether they are good enough.

    What does not make them better is not kept.
    """
    n, G, work, group, judged = data.n_contacts, data.delassus, memory.newton, memory.group, memory.judged
    W, free, force, unit = memory.alike, memory.alike_free, memory.alike_force, group.unit
    for r in range(3 * n):
        own = unit[r // 3]
        free[r] = own * data.free[r]
        for s in range(3 * n):
            W[r, s] = own * unit[s // 3] * G[r, s]
    for way in range(2):
        lagging = lags(judged)
        before = left_over(judged, lagging)
        for r in range(3 * n):
            force[r] = group.p[r // 3, r % 3] / unit[r // 3]
            memory.aside[r // 3, r % 3] = group.p[r // 3, r % 3]
        if way == 0:
            _, solved = newton(W, free, data.friction, n, 0.0, force, EXACT * judged.load, SYSTEMS, work)
        else:
            _, solved = proximal(W, free, data.friction, n, force, PROXIMAL * judged.tolerance, PROXIMAL_SYSTEMS, work)
        memory.sweeping.iterations += solved
        for r in range(3 * n):
            group.p[r // 3, r % 3] = unit[r // 3] * force[r]
        good = weigh_posed(memory)
        if not (left_over(judged, lagging) <= before and (lags(judged) or good or not lagging)):
            for r in range(3 * n):
                group.p[r // 3, r % 3] = memory.aside[r // 3, r % 3]
            good = weigh_posed(memory)
        if good:
            return True
    return False


@kernel
def mend_posed(data: SpatialContactData, memory: SpatialSolverMemory) -> bool:
    """A few sweeps from the forces judged last, Newton's method where they crawl; whether they are good enough."""
    return sweep_posed(memory, FIRST_SWEEPS, False) or newton_on(data, memory)


@kernel
def find(data: SpatialContactData, memory: SpatialSolverMemory) -> bool:
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
    return mend_posed(data, memory) or sweep_posed(memory, SWEEPS, True)


@kernel
def solve_cones(data: SpatialContactData, memory: SpatialSolverMemory) -> int:
    """Solve a contact problem from the forces in ``memory``; 0 where solved. What is told of it goes there, too.

    The Delassus operator is symmetric. A few sweeps, Newton's method where they crawl, many sweeps where that fails.
    """
    solved = find(data, memory)
    tell(memory)
    return SOLVED if solved else ITERATION_LIMIT
