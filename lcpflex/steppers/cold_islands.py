"""Starts of large islands that nothing is remembered of, and that the compiled solver does not solve from nothing.

A pile that is declared at rest is one: its forces are those of hundreds of contacts that all stick, which Newton's
method and sweeps from no impulses at all may not find, and a step that goes on with the best point sets it in motion.
"""

from __future__ import annotations

import numpy as np

from lcpflex.basics import libs
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import IntArray
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.contact.operators.bodies import Bodies
from lcpflex.solvers.contact.problem import ContactProblem

__all__ = ["give_start"]


def give_start(work: Workspace) -> None:
    """Impulses to ``work.impulses.p`` of the present large island, which has no joints, by the whole chain of Auto.

    They are only where the compiled solver begins anew; what it makes of them is judged as always.
    """
    memory, large = work.impulses.large_solver, work.posed.large
    count = int(large.n_contacts)
    group = memory.group
    rough = np.flatnonzero(group.mu[:count] > 0.0)
    free = np.concatenate([group.free[:count, 0], group.free[rough, 1]])
    problem = ContactProblem(None, free, group.mu[:count], factor=_factor(memory.op, count, rough))
    normal, tangential = problem.forces(Auto(factors=int(memory.search.factor_limit)).solve(problem).z)
    scale, tangents = memory.scale[:count], large.tangent_row[:count]
    work.impulses.p[tangents[tangents >= 0]] = 0.0
    work.impulses.p[large.normal_row[:count]] = normal * scale
    work.impulses.p[tangents[rough]] = tangential * scale[rough]
    work.impulses.wants_start, work.impulses.has_start = 0, 1


def _factor(op: Bodies, count: int, rough: IntArray) -> libs.sparse.csr_array:
    """J (rows, unknowns) with G = J J^T: normals of all contacts, tangents of those with friction, in their units."""
    units = np.concatenate([np.arange(count), rough])
    kinds = np.repeat([0, 1], [count, len(rough)])
    places = np.arange(op.J.shape[3])
    rows, columns, entries = [], [], []
    for side in range(2):
        body = op.body[units, side]
        held = np.flatnonzero(body >= 0)
        first = op.pos[body[held]]
        inside = places < (op.pos[body[held] + 1] - first)[:, None]
        rows.append(np.broadcast_to(held[:, None], inside.shape)[inside])
        columns.append((first[:, None] + places)[inside])
        entries.append(op.J[units[held], side, kinds[held]][inside])
    place = np.concatenate(rows), np.concatenate(columns)
    return libs.sparse.csr_array((np.concatenate(entries), place), shape=(len(units), int(op.n_unknowns)))
