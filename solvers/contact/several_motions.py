"""Whether a small contact problem has solutions that move contacts differently (Painleve's paradox)."""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.solvers.contact.compiled import pose_lcp, row_forces
from lcpflex.solvers.contact.memory import ContactData, SolverMemory
from lcpflex.solvers.lcp.enumeration import enumerate_active_sets, enumeration_workspace

__all__ = ["Trials", "several_motions", "trials"]

TESTED = 6  # unknowns of the largest problem that is tested
KEPT = 8  # solutions told apart
APART = 1e-6  # relative distance of two motions


@struct
class Trials:
    """Solutions of a problem, and what enumeration works in."""

    found: FloatArray = array(KEPT, TESTED)
    codes: IntArray = array(KEPT)
    singular: IntArray = array(1)
    table: FloatArray
    order: IntArray
    change: FloatArray = array(2 * TESTED)  # of the forces, from the first solution to another one


def trials() -> Trials:
    """Room to test problems in."""
    table, order = enumeration_workspace(TESTED)
    return allocate(Trials, {}, table=table, order=order)


@kernel
def several_motions(data: ContactData, memory: SolverMemory, tolerance: float, room: Trials) -> bool:
    """Whether velocities (or accelerations) of the contacts differ between solutions of the problem solved last.

    False for what is too large to be tested. tolerance: largest residual of a solution.
    """
    m = memory.size
    if m > TESTED or data.n_tangents == 0:
        return False
    pose_lcp(data, memory)
    found, change = room.found, room.change
    kept, _ = enumerate_active_sets(
        memory.alike, memory.load, m, tolerance, found, room.codes, room.singular, room.table, room.order
    )
    for i in range(min(kept, KEPT)):
        for c in range(m):
            found[i, c] *= memory.units[c]
    for i in range(1, min(kept, KEPT)):
        for c in range(m):
            found[i, c] = found[0, c] - found[i, c]
        row_forces(data, memory, found[i], change)
        if effect(data, change) > APART:
            return True
    return False


@kernel
def effect(data: ContactData, change: FloatArray) -> float:
    """How far a change of the forces moves contacts, relative to its terms."""
    rows = data.n_contacts + data.n_tangents
    far, size = 0.0, 0.0
    for r in range(rows):
        moved, terms = 0.0, 0.0
        for c in range(rows):
            moved += data.delassus[r, c] * change[c]
            terms += abs(data.delassus[r, c] * change[c])
        far = max(far, abs(moved))
        size = max(size, max(terms, abs(data.free[r])))
    return far / size if size > 0.0 else 0.0
