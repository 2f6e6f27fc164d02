"""The contact problem at position level: contacts that give way, as the massless boundary has them.

With the compliance F of the static modes and the gaps of the configuration without their share,

    0 <= lambda_N  _|_  g_free + F_NN lambda_N + F_NT lambda_T >= 0
    -lambda_T in mu lambda_N Sign(Delta g_T),   Delta g_T = W_T^T h u_h + F_T (lambda - lambda_old)

where Delta g_T is the slip of the step, of two components in space, and Sign(x) there x/|x|. Forces and torques of the
scene move the static modes, too: their share is in g_free and in the slip. It is the problem of Coulomb friction with F
for the Delassus matrix, in the plane an LCP, in space one of cones.
Gaps are measured in the largest of the problem and compliances in the largest of F, so that the residual of the
solver means the same at every scale. Elastic laws of contacts are in F: :mod:`lcpflex.dynamics.contact_compliance`.
Source: Monjaraz-Tec, Gross & Krack 2022 (massless boundary).
"""

from __future__ import annotations

from lcpflex.dynamics.contact_compliance import ContactCompliance, soften
from lcpflex.dynamics.contact_problem import describe_contacts, lay_as_one, rows_of_each
from lcpflex.dynamics.delassus import delassus, row_velocity, spread
from lcpflex.dynamics.mechanics import contact_biases, count_rows, fill_contact_rows
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.modal_places import first_amplitude, first_rate
from lcpflex.model.arrays import Model
from lcpflex.solvers.contact.algebra import PLANAR
from lcpflex.solvers.contact.compiled import slip_of, solve_contacts
from lcpflex.solvers.contact.recollection import recall_basis, remember_basis, turn_over

__all__ = [
    "RIGID",
    "friction_before",
    "given_energy",
    "held_give",
    "pose_position",
    "remember_friction",
    "slip_in",
    "solve_position",
    "split_forces",
    "static_response",
    "static_sway",
    "sway",
]

GIVE = 0.1  # part of a compliance that is itself a small part of that of the body: it changes that little
RIGID = 1e-12  # compliance below this part of the largest of the problem, and of the bodies, is none


@kernel
def static_sway(model: Model, flexibility: FloatArray, q: FloatArray) -> float:
    """Upper bound of the displacement [m] of any surface point by the static modes."""
    contacts = model.contacts
    largest = 0.0
    for s in range(len(contacts.surface_body)):
        largest = max(largest, sway(model, flexibility, s, q[:0], q))
    return largest


@kernel
def sway(model: Model, flexibility: FloatArray, s: int, before: FloatArray, q: FloatArray) -> float:
    """Upper bound of the way [m] of any point of surface s by the static modes, from ``before`` to q; (0,): from 0."""
    contacts, way = model.contacts, 0.0
    b = contacts.surface_body[s]
    if b >= 0:
        d, e = first_rate(model, b), first_amplitude(model, b)
        for k in range(model.bodies.dof[b + 1] - d):
            if flexibility[d + k] > 0.0:
                start = before[e + k] if len(before) > 0 else 0.0
                way += abs(q[e + k] - start) * contacts.surface_deflection[s, k]
    return way


@kernel
def static_part(model: Model, work: Workspace, flexibility: FloatArray, r: int, q: FloatArray) -> float:
    """Share of the static coordinates in what row r sees of q [m]; (0,): there are none."""
    total = 0.0
    for i in range(2 if len(q) > 0 else 0):
        b = work.rows.body[r, i]
        if b >= 0:
            d, e = first_rate(model, b), first_amplitude(model, b)
            rigid = d - work.rows.dof[b]
            for k in range(work.rows.dof[b + 1] - d):
                if flexibility[d + k] > 0.0:
                    total += work.rows.J[r, i, rigid + k] * q[e + k]
    return total


@kernel
def held_give(model: Model, work: Workspace, flexibility: FloatArray, held: FloatArray, r: int) -> float:
    """What row r gives way by itself [m/N]: what static modes lack of a part of the compliance of those that are held.

    ``held`` (ndof,) 1/omega^2 of the modes that joints and springs hold, else 0; (0,): none are. Where these act,
    static modes do not move: what has mass would strike there.
    """
    total = 0.0
    static = 0.0
    for i in range(2 if len(held) > 0 else 0):
        b = work.rows.body[r, i]
        if b >= 0:
            d = work.rows.dof[b]
            for k in range(first_rate(model, b) - d, work.rows.dof[b + 1] - d):
                if held[d + k] > 0.0:
                    total += held[d + k] * work.rows.J[r, i, k] ** 2
                elif flexibility[d + k] > 0.0:
                    static += flexibility[d + k] * work.rows.J[r, i, k] ** 2
    return max(0.0, GIVE * total - static)


@in_space("lcpflex.dynamics.spatial.position")
@kernel
def friction_before(work: Workspace, j: int) -> float:
    """Friction along tangential row j at the end of the step before [N]."""
    k = work.rows.tangent[j]
    for i in range(work.impulses.n_held):
        if work.impulses.held_key[0, i] == work.rows.table.key[k]:
            return work.impulses.held_gap[0, i]
    return 0.0


@in_space("lcpflex.dynamics.spatial.position")
@kernel
def remember_friction(work: Workspace) -> None:
    """Keep the friction of this step for the next one."""
    for j in range(work.rows.n_tangents):
        work.impulses.held_key[1, j] = work.rows.table.key[work.rows.tangent[j]]
        work.impulses.held_gap[1, j] = work.impulses.tangential[j]
    work.impulses.n_held = work.rows.n_tangents
    for j in range(work.rows.n_tangents):
        work.impulses.held_key[0, j] = work.impulses.held_key[1, j]
        work.impulses.held_gap[0, j] = work.impulses.held_gap[1, j]


@kernel
def given_energy(model: Model, work: Workspace, flexibility: FloatArray, held: FloatArray, soft: IntArray) -> float:
    """Energy that contacts store by what they give way by themselves [J]."""
    total = 0.0
    first = work.rows.n_joint
    for r in range(first, first + work.rows.n_contacts + work.rows.n_tangents):
        if work.impulses.p[r] != 0.0 and (
            r - first >= work.rows.n_contacts or soft[work.rows.table.law[r - first]] == 0
        ):
            total += 0.5 * held_give(model, work, flexibility, held, r) * work.impulses.p[r] ** 2
    return total


@in_space("lcpflex.dynamics.spatial.contact_blocks")
@kernel
def fill_compliance(
    model: Model, q: FloatArray, work: Workspace, flexibility: FloatArray, size: int, G: FloatArray
) -> None:
    """G of the ``size`` rows ``posed.part``: W^T diag(flexibility) W, ``flexibility`` of all velocities."""
    n_joint, rows = work.rows.n_joint, work.rows
    spread(work, flexibility, n_joint, n_joint + rows.n_contacts + rows.n_tangents)
    delassus(rows.J[n_joint:], rows.solved[n_joint:], rows.body[n_joint:], work.posed.part, size, G)


@in_space("lcpflex.dynamics.spatial.position")
@kernel
def describe(work: Workspace) -> None:
    """Friction, names and rows of the contacts laid, as one problem."""
    describe_contacts(work, 0, PLANAR)


@kernel
def pose_position(
    model: Model,
    step: float,
    n: int,
    before: FloatArray,
    flexibility: FloatArray,
    held: FloatArray,
    load: FloatArray,
    compliance: ContactCompliance,
    unit: FloatArray,
    slack: float,
    least: float,
    work: Workspace,
) -> int:
    """Pose the problem of the first n contacts of the table at ``work.free.middle``, reached with ``work.free.u``.

    Linearised about the static coordinates there, and about the gaps, which must be those there; ``before`` (nq,) has
    the static coordinates before the step, ``load`` those that forces and torques of the scene make, or none; ``held``
    is for :func:`held_give`. Scaled F and gaps go to posed.problem; unit: the unit of force [N], and the largest
    compliance [m/N]. Returns -1, or the contact that closes without compliance, that is with up to ``least`` [m/N] or a
    trillionth of the largest; one whose gap is no less than -``slack`` stays open.
    """
    q = work.free.middle
    n_joint = len(work.scratch.residual)
    n_tangent = fill_contact_rows(model, q, n, n_joint, work.rows)
    count_rows(work.rows, n_joint, n, n_tangent)
    lay_as_one(work)
    describe(work)
    if n_tangent > 0:
        contact_biases(model, q, work.free.u, n, n_tangent, n_joint, work.rows)
    problem, part = work.posed.problem, work.posed.part
    size = problem.n_contacts + problem.n_tangents
    fill_compliance(model, q, work, flexibility, size, problem.delassus)
    softest = 0.0
    for i in range(size):
        problem.free[i] = 0.0
        r = part[i]
        if r < 0:
            continue
        give = held_give(model, work, flexibility, held, n_joint + r)
        if r < n and compliance.soft[work.rows.table.law[r]] == 1:  # gives way by its law, which asks for its gap
            give = 0.0
        if r >= n and step == 0.0:  # at the start, where static coordinates alone remember friction
            give = 0.0
        problem.delassus[i, i] += give
        b = 0.0
        if r < n:
            b = work.rows.table.gap[r] - static_part(model, work, flexibility, n_joint + r, q)
            b += static_part(model, work, flexibility, n_joint + r, load)
        else:  # with the row half a step ago, to second order
            slip = row_velocity(work.rows.J, work.rows.body, n_joint + r, work.rows.dof, work.free.u)
            b = step * (slip - 0.5 * step * work.rows.bias[n_joint + r])
            b -= static_part(model, work, flexibility, n_joint + r, before)
            b -= give * friction_before(work, r - n)
            b += static_part(model, work, flexibility, n_joint + r, load)
        problem.free[i] = b
        softest = max(softest, problem.delassus[i, i])
    stiff = contact_without(compliance, work, max(RIGID * softest, least), slack, size)
    if stiff >= 0:
        return stiff
    soften(compliance, work, n, size)
    scale_problem(work, size, softest, unit)
    return -1


@kernel
def contact_without(compliance: ContactCompliance, work: Workspace, rigid: float, slack: float, size: int) -> int:
    """The first contact that closes in a direction with a compliance of up to ``rigid``, -1: none.

    Those that are open by -``slack`` at least count as open.
    """
    problem, n = work.posed.problem, work.rows.n_contacts
    wide = rows_of_each(work)
    for i in range(size):
        r = work.posed.part[i]
        if r < 0:
            continue
        k = r if r < n else work.rows.tangent[r - n]
        if not problem.delassus[i, i] > rigid and (r >= n or compliance.soft[work.rows.table.law[k]] == 0):
            normal = wide * k
            if problem.delassus[normal, normal] > rigid or problem.free[normal] < -slack:
                return k
            problem.free[normal] = max(problem.free[normal], 0.0)
    return -1


@kernel
def scale_problem(work: Workspace, size: int, softest: float, unit: FloatArray) -> None:
    """Divide gaps by the largest of them, and F by its own; ``unit`` as :func:`pose_position` has it."""
    problem = work.posed.problem
    largest = 0.0
    for r in range(size):
        largest = max(largest, abs(problem.free[r]))
        softest = max(softest, problem.delassus[r, r])
    if largest == 0.0:
        largest = 1.0
    if softest == 0.0:
        softest = 1.0
    if size > 0:
        unit[0] = largest / softest
        unit[1] = softest
    for r in range(size):
        problem.free[r] /= largest
        for s in range(size):
            problem.delassus[r, s] /= softest


@in_space("lcpflex.dynamics.spatial.position")
@kernel
def solve_position(work: Workspace, unit: FloatArray, again: bool, tolerance: float) -> int:
    """Solve the problem posed from what contacts did last; 0 where solved, but for the residual.

    again: it is another pass of one step. unit: as of :func:`pose_position`.
    """
    problem, solver, remembered = work.posed.problem, work.impulses.solver, work.impulses.remembered
    recall_basis(problem, solver, remembered)
    status = solve_contacts(problem, solver)
    if status == 0 and solver.residual <= tolerance:
        remember_basis(problem, solver, remembered)
        turn_over(remembered)
    return status


@in_space("lcpflex.dynamics.spatial.position")
@kernel
def slip_in(work: Workspace, j: int) -> float:
    """Slip of tangential row j in the solution of the problem posed, in its largest gap."""
    return slip_of(work.impulses.solver, work.rows.n_contacts + j)


@in_space("lcpflex.dynamics.spatial.position")
@kernel
def split_forces(work: Workspace, unit: FloatArray) -> None:
    """Forces [N] of the contact rows, impulses.normal, impulses.tangential and impulses.p, from the solution."""
    n_joint = work.rows.n_joint
    n = work.rows.n_contacts
    for k in range(n):
        work.impulses.normal[k] = work.impulses.solver.normal[k] * unit[0]
        work.impulses.p[n_joint + k] = work.impulses.normal[k]
    for j in range(work.rows.n_tangents):
        work.impulses.tangential[j] = work.impulses.solver.tangential[j] * unit[0]
        work.impulses.p[n_joint + n + j] = work.impulses.tangential[j]


@kernel
def static_response(model: Model, work: Workspace, flexibility: FloatArray, load: FloatArray, q: FloatArray) -> None:
    """The static coordinates in q under the forces impulses.p of the contact rows, beside those that ``load`` holds."""
    for b in range(len(model.bodies.mass)):
        d, e = first_rate(model, b), first_amplitude(model, b)
        for k in range(model.bodies.dof[b + 1] - d):
            if flexibility[d + k] > 0.0:
                q[e + k] = load[e + k]
    n_joint = work.rows.n_joint
    for r in range(n_joint, n_joint + work.rows.n_contacts + work.rows.n_tangents):
        if work.impulses.p[r] != 0.0:
            for i in range(2):
                b = work.rows.body[r, i]
                if b >= 0:
                    d, e = first_rate(model, b), first_amplitude(model, b)
                    rigid = d - work.rows.dof[b]
                    for k in range(work.rows.dof[b + 1] - d):
                        q[e + k] += flexibility[d + k] * work.rows.J[r, i, rigid + k] * work.impulses.p[r]
