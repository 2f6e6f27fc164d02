"""The contact problem at impulse level: one step of a time-stepping scheme, or one collision.

    A (u+ - u_free) = J^T p_J + W_N p_N + W_T p_T,   J u+ = -rate
    0 <= p_N  _|_  gdot_N+ + e_N gdot_N- >= 0,   p_T in mu p_N Sign(-(gdot_T+ + e_T gdot_T-))

Unknowns: n_N + 2 n_H for n_N closed contacts, n_H of them with friction; joints are condensed.
Sources: Moreau 1988; Glocker & Studer 2005 (the LCP of planar Coulomb friction).
"""

from __future__ import annotations

from lcpflex.dynamics.delassus import (
    cholesky,
    condense,
    delassus,
    free_velocities,
    joint_impulses,
    row_velocity,
)
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.arrays import Model
from lcpflex.solvers.auto import TARGET, auto
from lcpflex.solvers.balance import contact_units, in_units
from lcpflex.solvers.certificate import ROUNDING, guarded_residual, residual_parts, strict_residual, terms_residual
from lcpflex.solvers.contact.lcp_forms import assemble_friction_lcp, split_friction_solution
from lcpflex.solvers.lcp.lemke import lemke
from lcpflex.solvers.problem import SOLVED

__all__ = [
    "AUTO",
    "LEMKE",
    "SOLUTION_KNOWN",
    "WEDGED_KNOWN",
    "distribute",
    "measure",
    "pose",
    "recall_basis",
    "remember_basis",
    "solve_lcp",
]

LEMKE, AUTO = 0, 1  # Workspace.method
NOTHING_KNOWN, BASIS_KNOWN, SOLUTION_KNOWN, WEDGED_KNOWN = 0, 1, 2, 3  # solving[KNOWN]
FLOOR = 1e-3  # of the terms of which free velocities are made: less of them is no measure of a residual
RESCUED = 1e-8  # natural-map residual of a solution found elsewhere that is worth handing on


@kernel
def pose(model: Model, work: Workspace, u_before: FloatArray, lead: float, velocity_threshold: float) -> None:
    """Assemble M, q of the LCP from rows, solved rows and the free velocity in ``work``.

    ``lead``: time [s] from the configuration of the rows to the end of the step; all rows are carried
    there by their bias, W(q+)^T u+ ~ W^T u+ + lead w, so that a hinge or a rolling contact loses no energy to the
    linearisation. Normal velocity below ``velocity_threshold`` [m/s] is not reflected (e_N = 0).
    """
    n_joint = work.n_joint
    n = work.n_contacts
    n_tangent = work.n_tangents
    total = n_joint + n + n_tangent
    free_velocities(work.rows, work.row_body, n_joint, total, work.dof, work.free_u, work.free, work.terms)
    if lead > 0.0:
        for r in range(total):
            work.free[r] += lead * work.bias[r]
    for r in range(n_joint):
        work.free[r] += work.rate[r]
    for k in range(n):
        law = work.table.law[k]
        e_n = model.contacts.restitution[law]
        if e_n > 0.0:
            before = row_velocity(work.rows, work.row_body, n_joint + k, work.dof, u_before)
            if abs(before) > velocity_threshold:
                work.free[n_joint + k] += e_n * before
            else:
                work.stopped = max(work.stopped, -before)
    for j in range(n_tangent):
        e_t = model.contacts.tangential_restitution[work.table.law[work.tangent[j]]]
        if e_t > 0.0:
            r = n_joint + n + j
            work.free[r] += e_t * row_velocity(work.rows, work.row_body, r, work.dof, u_before)
    delassus(work.rows, work.solved, work.row_body, total, work.G)
    cholesky(work.G, n_joint, work.lower)
    condense(work.G, work.free, n_joint, total, work.lower, work.share, work.Gc, work.bc)
    assemble_friction_lcp(work.Gc, work.bc, work.mu, work.tangent, n, n_tangent, work.M, work.q)
    work.lcp_size = n + 2 * n_tangent


@kernel
def recall_basis(work: Workspace) -> None:
    """Start the present problem from the basis of the last one, contact by contact; a contact that is new starts open.

    Not from which forces were positive: the basic unknowns of a degenerate contact may be zero.
    """
    n = work.n_contacts
    n_tangent = work.n_tangents
    count = work.n_remembered
    if work.known >= SOLUTION_KNOWN:
        return
    for i in range(work.lcp_size):
        work.basis[i] = 0
    j = 0
    place = 0
    for k in range(n):
        frictional = j < n_tangent and work.tangent[j] == k
        for _ in range(count):  # contacts keep their order: the next one is nearly always the one looked for
            if work.last_key[place] == work.table.key[k]:
                work.basis[k] = work.last_basis[place, 0]
                if frictional:
                    work.basis[n + j] = work.last_basis[place, 1]
                    work.basis[n + n_tangent + j] = work.last_basis[place, 2]
                place = (place + 1) % count
                break
            place = (place + 1) % count
        if frictional:
            j += 1
    work.known = BASIS_KNOWN


@kernel
def remember_basis(work: Workspace) -> None:
    """Keep the basis of the problem just solved, for :func:`recall_basis`."""
    n = work.n_contacts
    n_tangent = work.n_tangents
    j = 0
    for k in range(n):
        work.last_key[k] = work.table.key[k]
        work.last_basis[k, 0] = work.basis[k]
        work.last_basis[k, 1] = 0
        work.last_basis[k, 2] = 0
        if j < n_tangent and work.tangent[j] == k:
            work.last_basis[k, 1] = work.basis[n + j]
            work.last_basis[k, 2] = work.basis[n + n_tangent + j]
            j += 1
    work.n_remembered = n


@kernel
def measure(work: Workspace) -> None:
    """The posed LCP in units of its contacts, each by its own diagonal: alike = d M d and load = d q, d in ``units``.

    Its residual, and what an algorithm makes of it, are then the same in any units of mass, length and time. D_k is
    read off the condensed operator Gc, where M may hold the friction of sliding contacts.
    """
    n = work.n_contacts
    m = work.lcp_size
    own, tangent, Gc, M, d = work.contact_units, work.tangent, work.Gc, work.M, work.units
    for k in range(n):
        own[k] = Gc[k, k]
    for j in range(work.n_tangents):
        own[tangent[j]] = max(own[tangent[j]], Gc[n + j, n + j])
    contact_units(own, n)
    n_tangent = (m - n) // 2
    k = 0
    for i in range(n):
        d[i] = own[i]
    for j in range(n_tangent):
        i = n + n_tangent + j
        while k < n - 1 and M[i, k] == 0.0:  # 2 mu of its contact, in the order of the contacts
            k += 1
        d[n + j] = own[k]
        d[i] = 1.0 / own[k]
        k += 1
    in_units(M, work.q, d, 1.0, m, work.alike, work.load)


@kernel
def judge(work: Workspace, wedged: bool) -> None:
    """Both sizes of the residual of z, in the units of :func:`measure`, to ``work``.

    Relative to the terms that cancel in w, and to the free velocity alone, which counts as no less than 1e-3 of the
    terms of which it is made: what is left of it below that may be rounding. wedged: by the terms alone, whatever they
    leave of the free velocity.
    """
    n = work.n_contacts
    own, tangent, terms = work.contact_units, work.tangent, work.terms
    worst, size, load = residual_parts(work.alike, work.load, work.z, work.lcp_size)
    for k in range(n):
        load = max(load, FLOOR * own[k] * terms[k])
    for j in range(work.n_tangents):
        load = max(load, FLOOR * own[tangent[j]] * terms[n + j])
    if wedged:
        worst = max(worst, ROUNDING * size)  # w is not known any better
        work.certified = terms_residual(worst, max(size, load), load)
    else:
        work.certified = guarded_residual(worst, max(size, load), load)
    work.relative_residual = strict_residual(worst, load)


@kernel
def solve_lcp(work: Workspace) -> int:
    """Solve the posed LCP in units of its contacts; 0 where solved. Residuals and pivots go to ``work``.

    By Lemke's method, or as :class:`lcpflex.solvers.Auto` does (``work.method``). What is known beforehand,
    ``work.known``, counts once: nothing, the basis to start from in ``work.basis``, the solution in ``work.z``, or
    there the best that could be found of wedged bodies.
    """
    m = work.lcp_size
    known = work.known
    work.known = NOTHING_KNOWN
    measure(work)
    if known >= SOLUTION_KNOWN:
        for i in range(m):
            work.z[i] /= work.units[i]
        judge(work, known == WEDGED_KNOWN)
        if work.certified <= RESCUED:  # and the caller judges it by his own tolerance
            finish(work)
            return SOLVED
    status, pivots = SOLVED, m
    if work.method == AUTO:
        symmetric = work.n_tangents == 0
        warm = known == BASIS_KNOWN
        status, pivots = auto(work.alike, work.load, m, work.z, work.tableau, work.basis, symmetric, warm)
    else:
        status, pivots = lemke(work.alike, work.load, m, work.z, work.tableau, work.basis, 1000 + 50 * m)
    judge(work, False)
    work.pivots = pivots
    if work.certified <= TARGET:
        status = SOLVED
    finish(work)
    return status


@kernel
def finish(work: Workspace) -> None:
    """z in the units of the posed problem; what was known of the terms of its free velocities was for it alone."""
    z, d, terms = work.z, work.units, work.terms
    for i in range(work.lcp_size):
        z[i] *= d[i]
    for r in range(work.n_contacts + work.n_tangents):
        terms[r] = 0.0


@kernel
def distribute(work: Workspace) -> None:
    """Impulses p of all rows (joints, normals, tangents) from the solution z of the LCP."""
    n_joint = work.n_joint
    n = work.n_contacts
    n_tangent = work.n_tangents
    split_friction_solution(work.z, work.mu, work.tangent, n, n_tangent, work.normal, work.tangential)
    for k in range(n):
        work.p[n_joint + k] = work.normal[k]
    for j in range(n_tangent):
        work.p[n_joint + n + j] = work.tangential[j]
    joint_impulses(work.free, n_joint, n_joint + n + n_tangent, work.lower, work.share, work.p)
