"""The contact problem of an island in space with its Delassus operator: block Gauss-Seidel, and what judges it.

A sweep solves each contact by itself, exactly, with the forces of the others as they are; velocities are kept up to
date by columns. It ends where the certificate holds: within the tolerance where something slides; where all that press
stick, to rounding if that can be had, so that what rests does not creep.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import kernel
from lcpflex.solvers.balance import DEAD, contact_units
from lcpflex.solvers.certificate import (
    OWN,
    ROUNDED,
    ROUNDING,
    guarded_residual,
    own_share,
    strict_residual,
    terms_residual,
)
from lcpflex.solvers.contact.cones.certificate import contact_parts
from lcpflex.solvers.contact.cones.memory import (
    NOTHING_KNOWN,
    SOLUTION_KNOWN,
    WEDGED_KNOWN,
    SpatialContactData,
    SpatialSolverMemory,
)
from lcpflex.solvers.contact.cones.newton import newton, proximal
from lcpflex.solvers.contact.laws.disc import NONE, solve_cone
from lcpflex.solvers.status import ITERATION_LIMIT, SOLVED

__all__ = [
    "CRAWLING",
    "LOOK",
    "POLISH",
    "POLISHED",
    "SETTLED",
    "SLIDING",
    "SWEEPS",
    "is_good",
    "is_settled",
    "lags",
    "left_over",
    "newton_on",
    "solve_cones",
    "sweep_on",
    "weigh_forces",
]

FLOOR = 1e-3  # of the terms of which free velocities are made: less of them is no measure of a residual
SETTLED = 5e-14  # of the free velocities: what is left where nothing creeps, unless it is rounding of the terms
POLISHED = 3e-16  # sweeps that are made end there: those of the next step, which is like this one, are spared
SLIDING = 1e-6  # of the free velocities: a contact that slips by more is no resting one
LOOK = 8  # sweeps between two judgements
FIRST_SWEEPS, SWEEPS = 200.0, 2000.0  # at most: before Newton's method, and behind it
SYSTEMS, PROXIMAL_SYSTEMS = 40, 400  # that Newton's method solves, and proximal points
EXACT, PROXIMAL = 1e-15, 0.1  # of Alart and Curnier's function; of the tolerance
POLISH = 40  # at most beyond the tolerance
CRAWLING = 0.7  # of the residual left by LOOK sweeps: too much to go on for its sake


@kernel
def is_good(memory: SpatialSolverMemory) -> bool:
    """Whether the present point is within the tolerance as a whole, and near it by the own load of each contact.

    A light body beside heavy ones is nothing in the residual of the whole, and goes astray where that alone counts.
    """
    return bool(memory.residual <= memory.tolerance and memory.missed <= OWN * memory.tolerance)


@kernel
def lags(memory: SpatialSolverMemory) -> bool:
    """Whether the present point is within the tolerance as a whole, and some contact is not."""
    return bool(memory.residual <= memory.tolerance and not is_good(memory))


@kernel
def left_over(memory: SpatialSolverMemory, lagging: bool) -> float:
    """What is to become less: what is left of the whole, or where contacts are ``lagging``, of their own loads."""
    return memory.missed if lagging else memory.worst


@kernel
def is_settled(memory: SpatialSolverMemory) -> bool:
    """Whether what is left of the present point is rounding.

    Forces that were polished have cancelled what was left of the velocities as well, and would bring it back with the
    other sign: in the step behind they are polished to the end, to those that keep still what is at rest.
    """
    share = POLISHED if memory.polished == 1 else SETTLED
    return bool(memory.worst <= max(share * memory.load, ROUNDED * ROUNDING * memory.terms))


@kernel
def describe(data: SpatialContactData, memory: SpatialSolverMemory) -> None:
    """Own blocks and units of the contacts, and the load."""
    G, own, unit, n = data.delassus, memory.own, memory.unit, data.n_contacts
    for k in range(n):
        i = 3 * k
        own[k, 0], own[k, 1], own[k, 2] = G[i, i], G[i, i + 1], G[i, i + 2]
        own[k, 3], own[k, 4], own[k, 5] = G[i + 1, i + 1], G[i + 1, i + 2], G[i + 2, i + 2]
        unit[k] = max(own[k, 0], max(own[k, 3], own[k, 5]))
    contact_units(unit, n, DEAD)
    load = 0.0
    for k in range(n):
        load = max(load, load_of(data, memory, k))
    memory.load = load


@kernel
def load_of(data: SpatialContactData, memory: SpatialSolverMemory, k: int) -> float:
    """The free velocity of contact k in its unit, or what its terms make it worth."""
    load = 0.0
    for r in range(3 * k, 3 * k + 3):
        load = max(load, memory.unit[k] * max(abs(data.free[r]), FLOOR * data.terms[r]))
    return load


@kernel
def weigh_forces(data: SpatialContactData, memory: SpatialSolverMemory) -> None:
    """Velocities under ``memory.force``, made anew, the residual in its two sizes, and whether something slides."""
    G, free, force, n = data.delassus, data.free, memory.force, data.n_contacts
    velocity, sums = memory.velocity, memory.sums
    for r in range(3 * n):
        total, size = free[r], abs(free[r])
        for s in range(3 * n):
            part = G[r, s] * force[s]
            total += part
            size += abs(part)
        velocity[r], sums[r] = total, size
    worst, terms, missed = 0.0, 0.0, 0.0
    for k in range(n):
        miss, size, _ = contact_parts(force, velocity, sums, free, data.friction, memory.unit, k)
        worst, terms = max(worst, miss), max(terms, size)
        share = own_share(miss, size, load_of(data, memory, k), memory.load)
        if share > missed:
            missed, memory.behind = share, k
    memory.worst, memory.terms, memory.missed = worst, terms, missed
    speed = 0.0
    for k in range(n):
        if force[3 * k] > 0.0:
            speed = max(speed, memory.unit[k] * (abs(velocity[3 * k + 1]) + abs(velocity[3 * k + 2])))
    memory.sliding = 1 if speed > SLIDING * memory.load else 0
    if worst < np.inf:
        memory.residual = guarded_residual(worst, max(terms, memory.load), memory.load)
        memory.strict = strict_residual(worst, memory.load)
    else:
        memory.residual, memory.strict, memory.missed = np.inf, np.inf, np.inf


@kernel
def sweep(data: SpatialContactData, memory: SpatialSolverMemory) -> float:
    """One sweep over the contacts; the largest change of a force in its unit."""
    G, friction, n = data.delassus, data.friction, data.n_contacts
    force, velocity, own, unit, slip = memory.force, memory.velocity, memory.own, memory.unit, memory.slip
    largest = 0.0
    for k in range(n):
        i = 3 * k
        nn, n1, n2, aa, ab, bb = own[k, 0], own[k, 1], own[k, 2], own[k, 3], own[k, 4], own[k, 5]
        p, p1, p2 = force[i], force[i + 1], force[i + 2]
        r, r1, r2, s = solve_cone(
            nn,
            n1,
            n2,
            aa,
            ab,
            bb,
            velocity[i] - (nn * p + n1 * p1 + n2 * p2),
            velocity[i + 1] - (n1 * p + aa * p1 + ab * p2),
            velocity[i + 2] - (n2 * p + ab * p1 + bb * p2),
            friction[k],
            slip[k],
        )
        if s == NONE:  # wedged by itself: the others may help
            largest = np.inf
            continue
        slip[k] = s
        d, d1, d2 = r - p, r1 - p1, r2 - p2
        if d != 0.0 or d1 != 0.0 or d2 != 0.0:
            largest = max(largest, max(abs(d), max(abs(d1), abs(d2))) / unit[k])
            force[i], force[i + 1], force[i + 2] = r, r1, r2
            for e in range(3 * n):
                velocity[e] += G[i, e] * d + G[i + 1, e] * d1 + G[i + 2, e] * d2
    return largest


@kernel
def sweep_on(data: SpatialContactData, memory: SpatialSolverMemory, most: float, patient: bool) -> bool:
    """Sweeps until the forces are good enough, ``most`` in all, fewer where they crawl and one is not ``patient``."""
    polished, tolerance = 0, memory.tolerance
    rested = is_good(memory)
    while memory.iterations < most:
        if is_good(memory):
            if memory.sliding == 1 or polished >= POLISH or is_settled(memory):
                break
            polished += LOOK
        lagging = lags(memory)
        before = left_over(memory, lagging)
        goal = POLISHED * memory.load if memory.residual <= tolerance else 0.1 * tolerance * memory.load
        for _ in range(LOOK):
            memory.iterations += 1.0
            if sweep(data, memory) <= goal:
                break
        weigh_forces(data, memory)
        if left_over(memory, lagging) > CRAWLING * before and not patient:
            break
    note_polish(memory, rested and polished > 0)
    return is_good(memory)


@kernel
def note_polish(memory: SpatialSolverMemory, polished: bool) -> None:
    """Forces were good enough before they were ``polished``: those of the next step are polished to the end, once."""
    memory.polished = 1 if polished and memory.polished == 0 else 0


@kernel
def newton_on(data: SpatialContactData, memory: SpatialSolverMemory) -> bool:
    """Newton's method from the forces in ``memory``, then proximal points; whether they are good enough.

    What does not make them better is not kept.
    """
    n, unit, G, work = data.n_contacts, memory.unit, data.delassus, memory.newton
    W, free, force = memory.alike, memory.alike_free, memory.alike_force
    for r in range(3 * n):
        own = unit[r // 3]
        free[r] = own * data.free[r]
        for s in range(3 * n):
            W[r, s] = own * unit[s // 3] * G[r, s]
    for way in range(2):
        lagging = lags(memory)
        before = left_over(memory, lagging)
        for r in range(3 * n):
            force[r] = memory.force[r] / unit[r // 3]
            memory.aside[r] = memory.force[r]
        if way == 0:
            _, solved = newton(W, free, data.friction, n, 0.0, force, EXACT * memory.load, SYSTEMS, work)
        else:
            _, solved = proximal(W, free, data.friction, n, force, PROXIMAL * memory.tolerance, PROXIMAL_SYSTEMS, work)
        memory.iterations += 1.0 * solved
        for r in range(3 * n):
            memory.force[r] = unit[r // 3] * force[r]
        weigh_forces(data, memory)
        if not (left_over(memory, lagging) <= before and (lags(memory) or is_good(memory) or not lagging)):
            for r in range(3 * n):
                memory.force[r] = memory.aside[r]
            weigh_forces(data, memory)
        if is_good(memory):
            return True
    return False


@kernel
def begin(data: SpatialContactData, memory: SpatialSolverMemory) -> None:
    """Describe the problem and weigh the forces that it begins from."""
    n = data.n_contacts
    memory.size, memory.iterations = 3 * n, 0.0
    describe(data, memory)
    for k in range(n):
        if data.friction[k] == 0.0:
            memory.force[3 * k + 1], memory.force[3 * k + 2] = 0.0, 0.0
    weigh_forces(data, memory)


@kernel
def solve_cones(data: SpatialContactData, memory: SpatialSolverMemory) -> int:
    """Solve a contact problem from the forces in ``memory``; 0 where solved. Residuals and iterations go there, too.

    The Delassus operator is symmetric. A few sweeps, Newton's method where they crawl, many sweeps where that fails.
    """
    known = memory.known
    memory.known = NOTHING_KNOWN
    begin(data, memory)
    if known == WEDGED_KNOWN:
        rounding = max(memory.worst, ROUNDING * memory.terms)
        memory.residual = terms_residual(rounding, max(memory.terms, memory.load), memory.load)
        return SOLVED if memory.residual <= memory.tolerance else ITERATION_LIMIT
    if known == SOLUTION_KNOWN and memory.residual <= memory.tolerance:
        return SOLVED
    if sweep_on(data, memory, FIRST_SWEEPS, False) or newton_on(data, memory):
        return SOLVED
    return SOLVED if sweep_on(data, memory, memory.iterations + SWEEPS, True) else ITERATION_LIMIT
