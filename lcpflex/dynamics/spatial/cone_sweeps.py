"""Contacts of an island without joints in the velocities of its bodies: their forces judged, and swept.

No Delassus operator is made: see :mod:`lcpflex.solvers.contact.operators.scene`. The size of the terms of a contact is
that of its own force.
"""

from __future__ import annotations

from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import kernel
from lcpflex.solvers.contact.algebra import IN_SPACE
from lcpflex.solvers.contact.judging import weigh
from lcpflex.solvers.contact.sweeping import sweep_on

__all__ = ["judge_island", "sweep_island"]


@kernel
def judge_island(work: SpatialWork) -> None:
    """Judge the forces ``work.impulses.p`` of the island described last, the velocities by them made anew."""
    group, scene, p = work.impulses.solver.group, work.impulses.solver.scene, work.impulses.p
    for c in range(group.n):
        s = scene.tangent[c]
        group.p[c, 0] = p[scene.normal[c]]
        group.p[c, 1], group.p[c, 2] = (p[s], p[s + 1]) if s >= 0 else (0.0, 0.0)
    weigh(scene, group, work.impulses.solver.judged, group.p, IN_SPACE)


@kernel
def sweep_island(work: SpatialWork, count: int, patient: bool) -> bool:
    """Up to ``count`` sweeps from the forces judged last, to ``work.impulses.p``; whether they are good enough.

    Fewer where they crawl and one is not ``patient``: :func:`lcpflex.solvers.contact.sweeping.sweep_on`.
    """
    memory, p = work.impulses.solver, work.impulses.p
    group, scene = memory.group, memory.scene
    good = sweep_on(scene, group, memory.judged, memory.sweeping, memory.best, IN_SPACE, count, patient)
    for c in range(group.n):
        s = scene.tangent[c]
        p[scene.normal[c]] = group.p[c, 0]
        if s >= 0:
            p[s], p[s + 1] = group.p[c, 1], group.p[c, 2]
    return good
