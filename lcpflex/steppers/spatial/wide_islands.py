"""Islands in space whose contacts move many velocities each: those of bodies with many modes, without joints.

A sweep in the velocities of the bodies takes the rows of each contact twice, a sweep by the Delassus operator a column:
where bodies have more modes than points that touch, that is less. Without friction there is no need of sweeps: the
contacts that carry are found by exchanges, from those of the last step on (:mod:`lcpflex.solvers.lcp`).
"""

from __future__ import annotations

from lcpflex.dynamics.delassus import delassus
from lcpflex.dynamics.spatial.cone_sweeps import judge_island
from lcpflex.dynamics.spatial.contact_blocks import WIDE, fill_by_blocks, moved_by
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import kernel, late_kernel
from lcpflex.solvers.auto import TARGET
from lcpflex.solvers.contact.judging import is_good
from lcpflex.solvers.contact.sweeping import is_settled
from lcpflex.solvers.lcp.principal_pivoting import principal_pivoting
from lcpflex.solvers.status import SOLVED

__all__ = ["exchange_normals", "is_rough", "is_wide", "lacks_places"]

FEWEST, MOST = 4, 256  # contacts; the operator of more takes tens of megabytes
PIVOTS = 100, 20  # of the exchanges at most, and for each contact besides
SPARE = 5  # rows that the work memory of exchanges has beyond the unknowns


@kernel
def is_rough(work: SpatialWork, i: int) -> bool:
    """Whether island i has friction."""
    islands = work.posed.islands
    rough = False
    for c in range(islands.start[i], islands.start[i + 1]):
        rough = rough or work.posed.tangent_of[islands.contact[c]] >= 0
    return rough


@kernel
def is_wide(work: SpatialWork, i: int, rough: bool) -> bool:
    """Whether the Delassus operator of island i costs less than the rows of its contacts; ``rough``: with friction."""
    islands = work.posed.islands
    n = islands.start[i + 1] - islands.start[i]
    if not FEWEST <= n <= MOST or work.posed.on_sets == 1 or work.posed.shifted == 1:
        return False
    moved = moved_by(work, islands.contact[islands.start[i] : islands.start[i + 1]], 1, n)
    return bool(moved >= WIDE * n and (3 if rough else 1) * n * n <= moved)


@kernel
def lacks_places(work: SpatialWork, n: int) -> bool:
    """Whether there is no room for the operator of n contacts without friction; what is needed goes to ``most``."""
    if n + SPARE <= len(work.impulses.solver.dense.free):
        return False
    work.impulses.most = max(work.impulses.most, (n + SPARE + 2) // 3)
    return True


@late_kernel
def exchange_normals(work: SpatialWork, i: int) -> None:
    """Forces ``work.impulses.p`` of island i, without friction and judged before, by exchanges, and judged again.

    They stay as they are where they solve it to rounding already, and where exchanges find nothing.
    """
    memory, islands, rows = work.impulses.solver, work.posed.islands, work.rows
    if is_good(memory.judged) and is_settled(memory.judged, memory.sweeping):
        return
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
    basis[len(basis) - 1] = 0  # nobody calls
    most = PIVOTS[0] + PIVOTS[1] * n
    status, pivots = principal_pivoting(G, dense.free, n, dense.y, dense.table, basis, True, TARGET, most)
    memory.sweeping.iterations += pivots
    if status == SOLVED:
        for a in range(n):
            work.impulses.p[n_joint + contact[a]] = unit[a] * dense.y[a]
        judge_island(work)
