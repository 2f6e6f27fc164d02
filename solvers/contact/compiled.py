"""Contact problems solved inside compiled steppers: posed as an LCP, solved by a compiled method, certified.

The unknowns are three a frictional contact (:mod:`lcpflex.solvers.contact.lcp_forms`), on index sets three a contact
that may stick; they are solved in units of their contacts (:mod:`lcpflex.solvers.balance`).

To add a compiled method: a file with its solver class and its kernel, a number, an entry in ``METHODS`` and a branch
in :func:`find`. The kernel gets the contact problem and the memory, in which the LCP stands in units of its contacts
(``alike``, ``load``, ``size`` unknowns). It leaves z there, and returns its status and iterations; what it found is
certified afterwards.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.auto import TARGET, Auto, auto
from lcpflex.solvers.balance import DEAD, contact_units, in_units, unknown_units
from lcpflex.solvers.certificate import ROUNDING, guarded_residual, residual_parts, strict_residual, terms_residual
from lcpflex.solvers.contact.index_sets import STICKING, reduce_columns, sliding_sign
from lcpflex.solvers.contact.judging import FLOOR
from lcpflex.solvers.contact.lcp_forms import assemble_friction_lcp
from lcpflex.solvers.contact.memory import (
    BASIS_KNOWN,
    NOTHING_KNOWN,
    SOLUTION_KNOWN,
    WEDGED_KNOWN,
    ContactData,
    SolverMemory,
)
from lcpflex.solvers.lcp.lemke import Lemke, lemke, pivot_budget
from lcpflex.solvers.status import SOLVED

__all__ = [
    "AUTO", "METHODS", "motion_of", "pose_lcp", "read_forces", "row_forces", "slip_of", "solve_contacts",
    "solve_normals", "sticks",
]  # fmt: skip

LEMKE, AUTO = 0, 1  # SolverMemory.method
METHODS: dict[type, int] = {Lemke: LEMKE, Auto: AUTO}
RESCUED = 1e-8  # natural-map residual of a solution found elsewhere that is worth handing on


@kernel
def find(data: ContactData, memory: SolverMemory, warm: bool) -> tuple[int, int]:
    """z by the method of ``memory``, from its basis if ``warm``; (status, iterations)."""
    m = memory.size
    if memory.method == AUTO:
        symmetric = data.n_tangents == 0
        return auto(memory.alike, memory.load, m, memory.z, memory.tableau, memory.basis, symmetric, warm)
    return lemke(memory.alike, memory.load, m, memory.z, memory.tableau, memory.basis, pivot_budget(m))


@kernel
def assemble(data: ContactData, memory: SolverMemory) -> None:
    """M, q of the LCP, its ``size`` and the contacts ``stick`` that have a tangential unknown."""
    n, n_stick = data.n_contacts, data.n_tangents
    G, free = data.delassus, data.free
    for j in range(n_stick):
        memory.stick[j] = data.tangent[j]
    if data.on_sets == 1:
        for k in range(n):
            memory.tangent_of[k] = -1
        for j in range(data.n_tangents):
            memory.tangent_of[data.tangent[j]] = j
        G, free = memory.alike, memory.load  # written anew below
        n_stick = reduce_columns(data, data.mode, memory.tangent_of, True, True, memory.stick, G, free)
    memory.n_stick = n_stick
    memory.size = assemble_friction_lcp(G, free, data.friction, memory.stick, n, n_stick, memory.M, memory.q)
    if data.shifted == 1:  # the unknown is then lambda_N - least
        for i in range(memory.size):
            for k in range(n):
                memory.q[i] += memory.M[i, k] * data.least[k]


@kernel
def pose_lcp(data: ContactData, memory: SolverMemory) -> None:
    """The LCP, and the same in units of its contacts, each by its own diagonal: alike = d M d, load = d q, d in units.

    Its residual, and what an algorithm makes of it, are then the same in any units of mass, length and time. D_k is
    read off the Delassus operator, where M may hold the friction of sliding contacts.
    """
    assemble(data, memory)
    n = data.n_contacts
    own, tangent, G = memory.contact_units, data.tangent, data.delassus
    for k in range(n):
        own[k] = G[k, k]
    for j in range(data.n_tangents):
        own[tangent[j]] = max(own[tangent[j]], G[n + j, n + j])
    contact_units(own, n, DEAD)
    unknown_units(own, memory.stick, n, memory.n_stick, memory.units)
    in_units(memory.M, memory.q, memory.units, 1.0, memory.size, memory.alike, memory.load)


@kernel
def judge(data: ContactData, memory: SolverMemory, wedged: bool) -> None:
    """Both sizes of the residual of z, in the units of :func:`pose_lcp`, to ``memory``.

    Relative to the terms that cancel in w, and to the free velocity alone, which counts as no less than 1e-3 of the
    terms of which it is made: what is left of it below that may be rounding. wedged: by the terms alone, whatever they
    leave of the free velocity.
    """
    n = data.n_contacts
    own, tangent, terms = memory.contact_units, data.tangent, data.terms
    worst, size, load = residual_parts(memory.alike, memory.load, memory.z, memory.size)
    for k in range(n):
        load = max(load, FLOOR * own[k] * terms[k])
    for j in range(data.n_tangents):
        load = max(load, FLOOR * own[tangent[j]] * terms[n + j])
    if wedged:
        worst = max(worst, ROUNDING * size)  # w is not known any better
        memory.residual = terms_residual(worst, max(size, load), load)
    else:
        memory.residual = guarded_residual(worst, max(size, load), load)
    memory.strict = strict_residual(worst, load)


@kernel
def solve_contacts(data: ContactData, memory: SolverMemory) -> int:
    """Solve a contact problem; 0 where solved. Forces, residuals and iterations go to ``memory``.

    By the compiled method ``memory.method``. What is known beforehand, ``memory.known``, counts once: nothing, the
    basis to start from in ``memory.basis``, the solution in ``memory.z``, or there the best that could be found of
    wedged bodies.
    """
    known = memory.known
    memory.known = NOTHING_KNOWN
    pose_lcp(data, memory)
    if known >= SOLUTION_KNOWN:
        for i in range(memory.size):
            memory.z[i] /= memory.units[i]
        judge(data, memory, known == WEDGED_KNOWN)
        if memory.residual <= RESCUED:  # and the caller judges it by his own tolerance
            finish(data, memory)
            return SOLVED
    status, iterations = find(data, memory, known == BASIS_KNOWN)
    judge(data, memory, False)
    memory.iterations = iterations
    if memory.residual <= TARGET:
        status = SOLVED
    finish(data, memory)
    return status


@kernel
def finish(data: ContactData, memory: SolverMemory) -> None:
    """z in the units of the posed problem; what was known of the terms of its free velocities was for it alone."""
    z, d, terms = memory.z, memory.units, data.terms
    for i in range(memory.size):
        z[i] *= d[i]
    for r in range(data.n_contacts + data.n_tangents):
        terms[r] = 0.0
    read_forces(data, memory)


@kernel
def read_forces(data: ContactData, memory: SolverMemory) -> None:
    """Forces ``normal`` and ``tangential`` from z, inside of the friction cone, which rounding may leave."""
    n = data.n_contacts
    for k in range(n):
        memory.normal[k] = memory.z[k] + data.least[k] if data.shifted == 1 else memory.z[k]
    for j in range(memory.n_stick):
        k = memory.stick[j]
        bound = data.friction[k] * memory.normal[k]
        memory.tangential[j] = min(max(memory.z[n + j] - bound, -bound), bound)


@kernel
def row_forces(data: ContactData, memory: SolverMemory, z: FloatArray, p: FloatArray) -> None:
    """Forces p of all contact rows, normals and tangents, at a point z of the LCP of the problem posed."""
    n = data.n_contacts
    stuck = 0
    for k in range(n):
        p[k] = z[k]
    for j in range(data.n_tangents):
        k = data.tangent[j]
        if data.on_sets == 1 and data.mode[k] != STICKING:
            p[n + j] = -sliding_sign(data.mode[k]) * data.friction[k] * z[k]
        else:
            p[n + j] = z[n + stuck] - data.friction[k] * z[k]
            stuck += 1


@kernel
def motion_of(data: ContactData, memory: SolverMemory, j: int) -> int:
    """What tangential row j does in the solution of a problem without index sets: four numbers for four kinds.

    0: slides forth, or is open and moves so; 1: is open and moves back; 2: sticks; 3: slides back.
    """
    n = data.n_contacts
    pushed, back = memory.z[n + j] > 0.0, memory.z[n + data.n_tangents + j] > 0.0
    return (2 if pushed else 0) + (1 if back else 0)


@kernel
def slip_of(memory: SolverMemory, r: int) -> float:
    """Velocity of the tangential row r, behind the normals, in the solution of a problem without index sets."""
    slip: float = memory.q[r]
    for s in range(memory.size - memory.n_stick):
        slip += memory.M[r, s] * memory.z[s]
    return slip


@kernel
def sticks(data: ContactData, memory: SolverMemory, j: int) -> bool:
    """Whether tangential row j is inside of its cone in the solution of a problem without index sets."""
    n, k = data.n_contacts, data.tangent[j]
    return bool(0.0 < memory.z[n + j] < 2.0 * data.friction[k] * memory.z[k])


@kernel
def solve_normals(data: ContactData, chosen: IntArray, x: FloatArray, m: int, memory: SolverMemory) -> int:
    """Forces of m ``chosen`` contacts alone, without friction, for other free velocities; 0 where solved.

    0 <= z _|_ G_NN z + free >= 0; not certified, for corrections that may as well be left out. x (m,): in, the free
    velocities; out, the forces.
    """
    for i in range(m):
        memory.q[i] = x[i]
        for j in range(m):
            memory.M[i, j] = data.delassus[chosen[i], chosen[j]]
    symmetric, warm = True, False
    status, _ = auto(memory.M, memory.q, m, memory.z, memory.tableau, memory.basis, symmetric, warm)
    for i in range(m):
        x[i] = memory.z[i]
    return status
