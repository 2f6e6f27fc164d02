"""Friction of compliant contacts in a step of Moreau-Jean: balanced at its end; explicit steps would be tiny.

The slope of friction at rest, mu N over the slip speed, is too steep for an explicit step. With the velocities u_f that
the step would have at its end without friction, and G_TT with the joints, the slip v at the end solves

    v = w_T . u_f + h G_TT F_T(v)

for each contact, the others given, in sweeps. Where friction falls with the slip faster than 1 / (h G_TT), there are up
to three solutions, two of them stable. The one taken is the first that the slip comes to from where it was: as long as
there is a solution on the branch that it is on, it stays there, and it jumps where that branch ends. Without the rule
the force would jump back and forth between the branches, and no stick-slip would be seen.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.compliant_contacts import CompliantContacts
from lcpflex.dynamics.contact_forces import add_contact_forces, add_force, add_friction, add_normal_forces
from lcpflex.dynamics.contact_forces_history import condensed_mobility, factor_joints
from lcpflex.dynamics.delassus import apply_impulses, row_velocity
from lcpflex.dynamics.joint_response import solve_joints
from lcpflex.dynamics.mechanics import solve_rows, solve_vector
from lcpflex.dynamics.workspace import Workspace
from lcpflex.force_laws.friction.kernels import BENGISU_AKAY, BROWN_MCPHEE, friction_force
from lcpflex.force_laws.history import ContactMemory
from lcpflex.force_laws.layout import FRICTION, FRICTION_KIND
from lcpflex.jit.kernel import FloatArray, IntArray, kernel, late_kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model

__all__ = ["add_balanced_forces", "balanced_friction", "compare_friction", "forces_after"]

SWEEPS = 10  # over the friction of several contacts, at most
SETTLED = 1e-4  # of a contact's mu N: changes of a sweep that end them
HALVINGS = 60
STEEPEST = math.sqrt(3.0)  # of slip over slip speed: where Brown and McPhee's peak falls fastest, by 4/9
FAR = 48.0  # times x^-4 it falls slower there


@kernel
def rise(kind: int, p: FloatArray, mu: float, speed: float) -> float:
    """Slope d(F_T / N)/dv [s/m] at a slip speed > 0 of laws that fall somewhere."""
    first = p[FRICTION]
    static = max(p[FRICTION + 1], mu)
    if kind == BENGISU_AKAY:
        return -(static - mu) * p[FRICTION + 2] * math.exp(-p[FRICTION + 2] * (speed - first))  # beyond the peak
    x = speed / first
    steady = 1.0 / math.cosh(min(4.0 * x, 300.0)) ** 2
    peaked = 0.75 * (1.0 - x * x) / (0.25 * x * x + 0.75) ** 3
    return (4.0 * mu * steady + (static - mu) * peaked) / first + p[FRICTION + 2]


@kernel
def turn(kind: int, p: FloatArray, mu: float, weight: float, low: float, high: float) -> float:
    """Slip speed between ``low`` and ``high`` where v + ``weight`` F_T/N turns."""
    falls = 1.0 + weight * rise(kind, p, mu, low) < 0.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if (1.0 + weight * rise(kind, p, mu, middle) < 0.0) == falls:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@kernel
def fold(kinds: IntArray, p: FloatArray, mu: float, weight: float) -> tuple[float, float]:
    """Slip speeds between which v + ``weight`` F_T/N falls; infinite ones where it never does."""
    kind = kinds[FRICTION_KIND]
    if kind != BENGISU_AKAY and kind != BROWN_MCPHEE:
        return math.inf, math.inf
    first = p[FRICTION]
    drop = weight * (max(p[FRICTION + 1], mu) - mu)
    if kind == BENGISU_AKAY:
        steepness = drop * p[FRICTION + 2]
        if steepness <= 1.0:
            return math.inf, math.inf
        return first, first + math.log(steepness) / p[FRICTION + 2]
    if 1.0 + weight * rise(kind, p, mu, STEEPEST * first) >= 0.0:
        return math.inf, math.inf
    far = max(STEEPEST, (FAR * drop / first) ** 0.25) * first
    return turn(kind, p, mu, weight, first, STEEPEST * first), turn(kind, p, mu, weight, STEEPEST * first, far)


@kernel
def excess(kinds: IntArray, p: FloatArray, mu: float, normal: float, free: float, share: float, slip: float) -> float:
    """By how much friction leaves more slip than ``slip`` [m/s] of the ``free`` one."""
    return free + share * friction_force(kinds, p, slip, normal, mu, 0.0, 0.0) - slip


@kernel
def balanced_friction(
    memory: ContactMemory, law: int, mu: float, normal: float, before: float, free: float, share: float
) -> float:
    """The friction f [N] with f = F_T(free + share f) that the slip ``before`` leads to; ``share`` = h G_TT [s/kg].

    The slip at the end is the first balanced one on the way from ``before`` in the direction in which the force drives
    it. As friction opposes, it lies on the near side of the ``free`` one, or of 0.
    """
    kinds = memory.kinds[law]
    p = memory.parameters[law]
    if share == 0.0:
        return friction_force(kinds, p, free, normal, mu, 0.0, 0.0)
    up = 1.0 if excess(kinds, p, mu, normal, free, share, before) >= 0.0 else -1.0
    peak, valley = fold(kinds, p, mu, share * normal)
    low = before
    high = up * max(up * free, 0.0)
    if up * (high - low) < 0.0:
        high = low
    for k in range(4):  # bounds of the branches, in the order in which they are met
        bound = up * (-valley if k == 0 else -peak if k == 1 else peak if k == 2 else valley)
        if math.isfinite(bound) and up * (bound - low) > 0.0 and up * (high - bound) > 0.0:
            if up * excess(kinds, p, mu, normal, free, share, bound) <= 0.0:
                high = bound
                break
            low = bound
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        if up * excess(kinds, p, mu, normal, free, share, middle) > 0.0:
            low = middle
        else:
            high = middle
    return friction_force(kinds, p, 0.5 * (low + high), normal, mu, 0.0, 0.0)


@kernel
def recall(contacts: CompliantContacts, k: int) -> float:
    """Friction over normal force that entry k had in the step before: from there the sweeps set out."""
    for i in range(contacts.n_before):
        if contacts.before[i, 0] == contacts.rows.table.key[k]:
            return contacts.before[i, 1]
    return 0.0


@kernel
def free_velocities(model: Model, t: float, q: FloatArray, u: FloatArray, h: float, work: Workspace) -> None:
    """contacts.free: velocities at the end of a step without friction and rigid contacts, but with the joints."""
    contacts = work.compliant
    n_joint = contacts.rows.n_joint
    for i in range(len(u)):
        contacts.push[i] = h * (work.free.conservative[i] + work.free.dissipative[i] + work.free.driving[i])
    solve_vector(model, work, contacts.push)
    for i in range(len(u)):
        contacts.free[i] = u[i] + contacts.push[i]
    if n_joint == 0:
        return
    factor_joints(model, t, q, u, work)
    impulses = contacts.rows.joints.answer
    for r in range(n_joint):
        velocity = row_velocity(contacts.rows.J, contacts.rows.body, r, contacts.rows.dof, contacts.free)
        impulses[r] = -contacts.rows.rate[r] - velocity
    solve_joints(contacts.rows, impulses)
    apply_impulses(
        contacts.rows.solved, contacts.rows.body, 0 * n_joint, n_joint, impulses, contacts.rows.dof, contacts.free
    )


@late_kernel
def balance(model: Model, t: float, q: FloatArray, u: FloatArray, h: float, work: Workspace) -> None:
    """Friction of the contacts whose normal forces are known, to ``contacts.p`` and ``contacts.friction``.

    At the end of a step of h > 0 [s], as it would be without rigid contacts; M is factorised.
    """
    contacts = work.compliant
    n = contacts.rows.n_contacts
    n_joint = contacts.rows.n_joint
    first = n_joint + n
    dof = contacts.rows.dof
    for i in range(len(u)):
        contacts.friction[i] = 0.0
    if contacts.rows.n_tangents > 0:
        free_velocities(model, t, q, u, h, work)
    solve_rows(model, contacts.rows, first, first + contacts.rows.n_tangents)
    sweeps = SWEEPS if n > 1 else 1
    for sweep in range(-1 if sweeps > 1 else 0, sweeps):  # before the first, what they had in the step before
        worst = 0.0
        for j in range(contacts.rows.n_tangents):
            k = contacts.rows.tangent[j]
            law = contacts.rows.table.law[k]
            mu = contacts.rows.mu[k]
            normal = contacts.p[k, 0]
            if not normal > 0.0:
                continue
            r = first + j
            share = h * max(condensed_mobility(contacts, r), 0.0)
            force = recall(contacts, k) * normal
            if sweep >= 0:
                slip = (
                    row_velocity(contacts.rows.J, contacts.rows.body, r, dof, contacts.free) - share * contacts.p[k, 1]
                )
                start = row_velocity(contacts.rows.J, contacts.rows.body, r, dof, u)
                force = balanced_friction(contacts.history, law, mu, normal, start, slip, share)
                contacts.sticks[k] = 1 if abs(slip + share * force) < contacts.history.slip_speed[law] else 0
            change = force - contacts.p[k, 1]
            contacts.p[k, 1] = force
            add_force(contacts, contacts.rows.J, r, change, contacts.friction)
            worst = max(worst, abs(change) / (mu * normal))
            add_force(contacts, contacts.rows.solved, r, h * change, contacts.free)
            impulses = contacts.rows.joints.answer
            for i in range(n_joint):
                impulses[i] *= -h * change
            apply_impulses(contacts.rows.solved, contacts.rows.body, 0 * n_joint, n_joint, impulses, dof, contacts.free)
        if sweep >= 0 and worst <= SETTLED:
            break
    contacts.n_before = n
    for k in range(n):
        contacts.before[k, 0] = contacts.rows.table.key[k]
        contacts.before[k, 1] = contacts.p[k, 1] / contacts.p[k, 0] if contacts.p[k, 0] > 0.0 else 0.0


@in_space("lcpflex.dynamics.spatial.contact_forces_friction")
@kernel
def find_balance(model: Model, t: float, q: FloatArray, u: FloatArray, h: float, work: Workspace) -> None:
    """:func:`balance`."""
    balance(model, t, q, u, h, work)


@kernel
def add_balanced_forces(model: Model, t: float, q: FloatArray, u: FloatArray, h: float, work: Workspace) -> None:
    """Add the forces of compliant contacts to those in ``work``: normal ones at (q, u), friction at the end of a step.

    h [s]: the step, whose matrix is factorised.
    """
    if len(work.compliant.friction) == 0:
        return
    add_normal_forces(model, q, u, work)
    find_balance(model, t, q, u, h, work)
    add_friction(work)


@in_space("lcpflex.dynamics.spatial.contact_forces_friction")
@kernel
def forces_after(model: Model, q: FloatArray, u: FloatArray, work: Workspace) -> None:
    """Forces of compliant contacts in the state (q, u) that a step with ``add_balanced_forces`` led to, with the
    friction of it.

    Part of the slip at its end is what rigid contacts did not let happen: friction of that slip did not act.
    """
    planar_forces_after(model, q, u, work)


@late_kernel
def planar_forces_after(model: Model, q: FloatArray, u: FloatArray, work: Workspace) -> None:
    """The same, in the plane."""
    contacts = work.compliant
    n = contacts.rows.n_contacts
    for k in range(n):
        contacts.last[k, 0] = contacts.rows.table.key[k] if contacts.p[k, 0] > 0.0 else -1.0
        contacts.last[k, 1] = contacts.p[k, 1] / contacts.p[k, 0] if contacts.p[k, 0] > 0.0 else 0.0
        contacts.last[k, 2] = contacts.sticks[k]
    add_contact_forces(model, q, u, work)
    for k in range(contacts.rows.n_contacts):
        for i in range(n):
            if contacts.last[i, 0] == contacts.rows.table.key[k]:
                contacts.p[k, 1] = contacts.last[i, 1] * contacts.p[k, 0]
                contacts.sticks[k] = 1 if contacts.last[i, 2] > 0.0 else 0


@in_space("lcpflex.dynamics.spatial.contact_forces_friction")
@kernel
def compare_friction(u: FloatArray, h: float, work: Workspace) -> None:
    """Add up how far the friction of a step is from that of the slip at its end, where the velocities are u.

    ``balance`` knows nothing of rigid contacts: what they hold, friction of compliant ones was made to hold, too.
    """
    if work.compliant.rows.n_tangents > 0:
        add_missed_friction(u, h, work.compliant)


@late_kernel
def add_missed_friction(u: FloatArray, h: float, contacts: CompliantContacts) -> None:
    """``compare_friction`` where there are contacts with friction."""
    history = contacts.history
    for j in range(contacts.rows.n_tangents):
        k = contacts.rows.tangent[j]
        law = contacts.rows.table.law[k]
        mu = contacts.rows.mu[k]
        normal = contacts.p[k, 0]
        if normal > 0.0:
            r = contacts.rows.n_joint + contacts.rows.n_contacts + j
            slip = row_velocity(contacts.rows.J, contacts.rows.body, r, contacts.rows.dof, u)
            force = friction_force(history.kinds[law], history.parameters[law], slip, normal, mu, 0.0, 0.0)
            contacts.missed[law, 0] += h * abs(force - contacts.p[k, 1])
            contacts.missed[law, 1] += h * mu * normal
