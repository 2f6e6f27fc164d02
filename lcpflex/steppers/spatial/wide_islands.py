"""Islands in space whose contacts move many velocities each: those of bodies with many modes, without joints.

A sweep in the velocities of the bodies takes the rows of each contact twice, a sweep by the Delassus operator a column:
where bodies have more modes than points that touch, that is less. Without friction there is no need of sweeps: the
contacts that carry are found by exchanges, from those of the last step on (:mod:`lcpflex.solvers.lcp`).
"""

from __future__ import annotations

from lcpflex.dynamics.delassus import delassus
from lcpflex.dynamics.spatial.contact_blocks import fill_by_blocks
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import kernel, late_kernel
from lcpflex.solvers.contact.cones.normals import exchange

__all__ = ["exchange_normals", "lacks_places"]

SPARE = 5  # rows that the work memory of exchanges has beyond the unknowns


@kernel
def lacks_places(work: SpatialWork, n: int) -> bool:
    """Whether there is no room for the operator of n contacts without friction; what is needed goes to ``most``."""
    if n + SPARE <= len(work.impulses.solver.dense.free):
        return False
    work.impulses.most = max(work.impulses.most, (n + SPARE + 2) // 3)
    return True


@late_kernel
def exchange_normals(work: SpatialWork, i: int) -> None:
    """Forces ``work.impulses.p`` of island i, without friction and judged, by exchanges from those that it has.

    They stay as they are where exchanges find nothing.
    """
    memory, islands, rows = work.impulses.solver, work.posed.islands, work.rows
    group, dense, basis = memory.group, memory.dense, memory.basis
    n, n_joint, G, unit = group.n, rows.n_joint, memory.dense.columns, memory.group.unit
    contact = islands.contact[islands.start[i] : islands.start[i + 1]]
    if not fill_by_blocks(work, contact, 1, n, 1, G):
        delassus(rows.J[n_joint:], rows.solved[n_joint:], rows.body[n_joint:], contact, n, G)
    for a in range(n):
        row, scale = G[a], unit[a]
        for b in range(n):
            row[b] *= scale * unit[b]
        dense.free[a] = scale * group.free[a, 0]
        basis[a] = 1 if group.p[a, 0] > 0.0 or group.y[a, 0] < 0.0 else 0
    if exchange(memory, G, dense.free, n):
        for a in range(n):
            work.impulses.p[n_joint + contact[a]] = unit[a] * dense.y[a]
