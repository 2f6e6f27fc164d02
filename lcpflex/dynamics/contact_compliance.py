"""Contacts that give way by themselves: an elastic law between two surfaces, in the problem at position level.

    0 <= lambda_N  _|_  g + F lambda + delta(lambda_N) >= 0,   delta: inverse of the elastic law F(delta)

Newton's method, one LCP a pass: the law is replaced by its tangent at the indentation d = -g of the configuration of
the last pass, that is by the compliance 1/k(d) and an indentation of d - F(d)/k(d) without force. Indentations are what
goes from pass to pass, not forces: seen as functions of them, gaps are convex, so that a pass never falls short of the
solution by more than it is away from it, and a contact with d > 0 that a tangent opens is found closed by the next.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lcpflex.contact.concave_corners import YIELDED, yield_to_deeper
from lcpflex.contact.narrow_phase.feature import refresh
from lcpflex.dynamics.contact_forces import pair_energy, pair_force, pair_stiffness
from lcpflex.dynamics.contact_problem import rows_of_each
from lcpflex.dynamics.workspace import Workspace
from lcpflex.force_laws.elastic.kernels import indentation_at
from lcpflex.force_laws.history import ContactMemory, contact_memory
from lcpflex.force_laws.layout import LawRow
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import pack
from lcpflex.model.arrays import Contacts, Model

__all__ = [
    "ALL",
    "HARD",
    "ContactCompliance",
    "choose",
    "compliance_energy",
    "contact_compliance",
    "misfit",
    "note_depths",
    "soften",
]

ACCURATE = 1e-9  # error of a force, relative to the largest of those that laws give, that ends the passes
ROUNDING = 2e-15  # of an indentation, relative to coordinates
ALL = 2  # ContactCompliance.some
NO_PLACE = -1  # in the history: these laws do without
HARD, FOLLOWS, YIELDS = 0, 1, 2  # Workspace.closed: no law; follows its law; yields to another pair of one hollow


class ContactCompliance(NamedTuple):
    """Elastic laws of the declared contacts that have one."""

    some: IntArray  # (1,) 0: none has, 1: some, ALL
    soft: IntArray  # (laws,) whether it has one
    least: FloatArray  # (laws,) force that does not matter, only those smaller by ACCURATE need not be right [N]
    history: ContactMemory  # the laws, and the largest indentations so far: they remember nothing else


def contact_compliance(contacts: Contacts, laws: Sequence[LawRow | None]) -> ContactCompliance:
    """The elastic ``laws`` of all declared contacts, None for those without, as kernels take them."""
    soft = np.array([law is not None for law in laws], dtype=np.int64)
    some = ALL if soft.all() and soft.any() else int(soft.any())
    return pack(ContactCompliance(np.array([some]), soft, np.zeros(len(laws)), contact_memory(contacts, laws)))


@kernel
def law_force(compliance: ContactCompliance, work: Workspace, k: int) -> float:
    """Force of the law of contact k at its present gap [N]."""
    return pair_force(compliance.history, work.rows.table.law[k], NO_PLACE, -work.rows.table.gap[k], 0.0)[1]


@kernel
def choose(model: Model, compliance: ContactCompliance, work: Workspace, n: int) -> None:
    """closed[k] <- whether the first n contacts follow a law: of two in a shallow hollow, the deeper one alone."""
    if compliance.some[0] == 0:
        return
    yield_to_deeper(work.rows.table, n)
    for k in range(n):
        soft = compliance.soft[work.rows.table.law[k]] == 1
        work.scratch.closed[k] = FOLLOWS if soft else HARD
        if work.rows.table.gap[k] == YIELDED:
            work.scratch.closed[k] = YIELDS if soft else HARD
            refresh(model, work.free.middle, work.rows.table, k)


@kernel
def soften(compliance: ContactCompliance, work: Workspace, n: int, size: int) -> None:
    """Add the laws, linearised about the present gaps of the first n contacts, to their Gc and bc [m/N, m].

    ``size``: rows of the problem. Not about less than some depth, where a law has next to no stiffness: its force
    there does not matter any more.
    """
    if compliance.some[0] == 0:
        return
    largest = 0.0
    for k in range(n):
        if work.scratch.closed[k] == FOLLOWS:
            largest = max(largest, law_force(compliance, work, k))
    wide = rows_of_each(work)
    for k in range(n):
        normal = wide * k
        law = work.rows.table.law[k]
        if work.scratch.closed[k] == FOLLOWS:
            history = compliance.history
            force = 0.5 * ACCURATE * max(largest, compliance.least[law])
            depth = max(-work.rows.table.gap[k], indentation_at(history.kinds[law], history.parameters[law], force))
            stiffness = pair_stiffness(history, law, NO_PLACE, depth)
            work.posed.problem.delassus[normal, normal] += 1.0 / stiffness
            work.posed.problem.free[normal] += depth - pair_force(history, law, NO_PLACE, depth, 0.0)[1] / stiffness
        elif work.scratch.closed[k] == YIELDS:
            for r in range(size):
                if r != normal:
                    work.posed.problem.delassus[normal, r] = 0.0
                    work.posed.problem.delassus[r, normal] = 0.0
            work.posed.problem.free[normal] = abs(work.rows.table.gap[k])


@kernel
def misfit(compliance: ContactCompliance, unit: FloatArray, work: Workspace) -> float:
    """How far the forces of the present solution are from those of the laws; up to 1: equal as far as can be."""
    if compliance.some[0] == 0:
        return 0.0
    largest = 0.0
    extent = 1.0
    for i in range(len(work.free.middle)):
        extent = max(extent, abs(work.free.middle[i]))
    for k in range(work.rows.n_contacts):
        if work.scratch.closed[k] == FOLLOWS:
            largest = max(largest, work.impulses.normal[k], compliance.least[work.rows.table.law[k]])
    allowed = ACCURATE * largest + work.impulses.solver.residual * unit[0]
    worst = 0.0
    for k in range(work.rows.n_contacts):
        if work.scratch.closed[k] == FOLLOWS:
            stiffness = pair_stiffness(compliance.history, work.rows.table.law[k], NO_PLACE, -work.rows.table.gap[k])
            wrong = abs(work.impulses.normal[k] - law_force(compliance, work, k))
            worst = max(worst, wrong / (allowed + ROUNDING * extent * stiffness))
    return worst


@kernel
def note_depths(compliance: ContactCompliance, work: Workspace) -> int:
    """Keep the largest indentation of each law; returns the first that has left its range, or -1."""
    history = compliance.history
    if compliance.some[0] != 0:
        for k in range(work.rows.n_contacts):
            law = work.rows.table.law[k]
            if work.scratch.closed[k] == FOLLOWS and -work.rows.table.gap[k] > history.worst[law]:
                history.worst[law] = -work.rows.table.gap[k]
                if history.worst[law] > history.stop[law]:
                    return law
    return -1


@kernel
def compliance_energy(compliance: ContactCompliance, work: Workspace) -> float:
    """Energy that the laws store at the present gaps [J]."""
    total = 0.0
    if compliance.some[0] != 0:
        for k in range(work.rows.n_contacts):
            if work.scratch.closed[k] == FOLLOWS:
                total += pair_energy(compliance.history, work.rows.table.law[k], NO_PLACE, -work.rows.table.gap[k])
    return total
