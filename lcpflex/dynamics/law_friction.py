"""Friction of contacts by a continuous law in a step of Moreau-Jean: balanced at its end; explicit steps would be tiny.

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

from lcpflex.dynamics.delassus import apply_impulses, cholesky_solve, row_velocity
from lcpflex.dynamics.inertia import solve_block
from lcpflex.dynamics.law_memory import LawContacts
from lcpflex.dynamics.law_rows import couple_joints, factor_joints, lay, mobility, push
from lcpflex.dynamics.workspace import Workspace
from lcpflex.force_laws.friction.kernels import friction_force
from lcpflex.force_laws.history import ContactMemory
from lcpflex.force_laws.layout import BENGISU_AKAY, BROWN_MCPHEE, FRICTION, FRICTION_KIND
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.model.arrays import Model

__all__ = ["balanced_friction", "compare_friction", "rub"]

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
def recall(laws: LawContacts, k: int) -> float:
    """Friction over normal force that entry k had in the step before: from there the sweeps set out."""
    for i in range(laws.n_before):
        if laws.before[i, 0] == laws.table.key[k]:
            return laws.before[i, 1]
    return 0.0


@kernel
def free_velocities(model: Model, t: float, q: FloatArray, u: FloatArray, h: float, work: Workspace) -> None:
    """laws.free: velocities at the end of a step without friction and set-valued contacts, but with the joints."""
    laws = work.laws
    dof = model.bodies.dof
    n_joint = len(laws.joint)
    for i in range(len(q)):
        laws.free[i] = u[i]
        laws.push[i] = h * (work.conservative[i] + work.dissipative[i] + work.driving[i])
    for b in range(len(dof) - 1):
        block = laws.push[dof[b] : dof[b + 1]]
        solve_block(model.bodies, work.arrow, b, block, block)
    for i in range(len(q)):
        laws.free[i] += laws.push[i]
    if n_joint == 0:
        return
    factor_joints(model, t, q, u, work)
    for r in range(n_joint):
        laws.joint[r] = -laws.bias[0, r] - row_velocity(laws.rows, laws.row_body, r, dof, laws.free)
    cholesky_solve(laws.lower, n_joint, laws.joint)
    apply_impulses(laws.solved, laws.row_body, 0 * n_joint, n_joint, laws.joint, dof, laws.free)


@kernel
def rub(model: Model, t: float, q: FloatArray, u: FloatArray, h: float, work: Workspace) -> None:
    """Friction of the contacts whose normal forces are known, to ``laws.p`` and ``laws.friction``.

    Explicit at h = 0. In a step of h > 0 [s] at its end, as it would be without set-valued contacts; then M is to be
    factorised.
    """
    laws = work.laws
    n = laws.n_touching
    n_joint = len(laws.joint)
    dof = model.bodies.dof
    for i in range(len(q)):
        laws.free[i] = u[i]
        laws.friction[i] = 0.0
    if h > 0.0:
        free_velocities(model, t, q, u, h, work)
    sweeps = SWEEPS if h > 0.0 and n > 1 else 1
    for sweep in range(-1 if sweeps > 1 else 0, sweeps):  # before the first, what they had in the step before
        worst = 0.0
        for k in range(n):
            law = laws.table.law[k]
            mu = model.contacts.friction[law]
            normal = laws.p[k, 0]
            if not (normal > 0.0 and mu > 0.0):
                continue
            r = lay(model, q, k, laws) + 1
            share = 0.0
            if h > 0.0:
                inverse = mobility(model, laws, r, work)
                share = h * max(inverse - couple_joints(laws, r), 0.0)
            force = recall(laws, k) * normal
            if sweep >= 0:
                slip = row_velocity(laws.rows, laws.row_body, r, dof, laws.free) - share * laws.p[k, 1]
                begun = row_velocity(laws.rows, laws.row_body, r, dof, u)
                force = balanced_friction(laws.memory, law, mu, normal, begun, slip, share)
                laws.sticks[k] = 1 if abs(slip + share * force) < laws.memory.slip_speed[law] else 0
            change = force - laws.p[k, 1]
            laws.p[k, 1] = force
            push(model, laws, laws.rows, r, change, laws.friction)
            worst = max(worst, abs(change) / (mu * normal))
            if h > 0.0:
                push(model, laws, laws.solved, r, h * change, laws.free)
                for j in range(n_joint):
                    laws.joint[j] *= h * change
                apply_impulses(laws.solved, laws.row_body, 0 * n_joint, n_joint, laws.joint, dof, laws.free)
        if sweep >= 0 and worst <= SETTLED:
            break
    if h > 0.0:
        laws.n_before = n
        for k in range(n):
            laws.before[k, 0] = laws.table.key[k]
            laws.before[k, 1] = laws.p[k, 1] / laws.p[k, 0] if laws.p[k, 0] > 0.0 else 0.0


@kernel
def compare_friction(model: Model, q: FloatArray, u: FloatArray, h: float, work: Workspace) -> None:
    """Add up how far the friction of a step at q is from that of the slip at its end, where the velocities are u.

    ``rub`` knows nothing of set-valued contacts: what they hold, friction by law was made to hold, too.
    """
    laws = work.laws
    for k in range(laws.n_touching):
        law = laws.table.law[k]
        mu = model.contacts.friction[law]
        normal = laws.p[k, 0]
        if normal > 0.0 and mu > 0.0:
            r = lay(model, q, k, laws) + 1
            slip = row_velocity(laws.rows, laws.row_body, r, model.bodies.dof, u)
            force = friction_force(laws.memory.kinds[law], laws.memory.parameters[law], slip, normal, mu, 0.0, 0.0)
            laws.missed[law, 0] += h * abs(force - laws.p[k, 1])
            laws.missed[law, 1] += h * mu * normal
