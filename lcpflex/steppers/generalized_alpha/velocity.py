"""The velocity problem of a generalised-alpha step: the impact law, and friction, at its end.

See :mod:`lcpflex.steppers.generalized_alpha.stepper` for the scheme. Where several contacts close in a step there are
several problems, in the order of :mod:`lcpflex.steppers.strike_order`; the last one, of all contacts, ends the step.
"""

from __future__ import annotations

from lcpflex.dynamics.contact_problem import lay_contacts, list_tangents
from lcpflex.dynamics.delassus import apply_impulses, free_velocities, row_velocity
from lcpflex.dynamics.large_island import prepare_large
from lcpflex.dynamics.mechanics import multiply
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model
from lcpflex.steppers.generalized_alpha.memory import AlphaScheme, match
from lcpflex.steppers.generalized_alpha.smooth import assemble_rows
from lcpflex.steppers.strike_order import begin_order, choose_strikes, needs_order

__all__ = ["pose_velocity", "resting_load"]


@kernel
def numerical_damping(model: Model, work: Workspace, scheme: AlphaScheme) -> float:
    """Energy that the smooth motion has lost by not being that of the trapezoidal rule, which conserves it [J].

    dv M (u + v~)/2 - dq (f + f~)/2 with dv = v~ - u - h (w + w~)/2 and dq = q~ - q - h (u + v~)/2.
    """
    h, u = scheme.step, scheme.u
    for i in range(len(u)):
        scheme.mean[i] = 0.5 * (u[i] + scheme.v_new[i])
    multiply(model, scheme.q_new, scheme.mean, work, scheme.momentum)
    gained = 0.0
    for i in range(len(u)):
        a = scheme.a[i]
        a_new = scheme.a_new[i]
        dv = (1.0 - scheme.gamma) * a + scheme.gamma * a_new - 0.5 * (scheme.w[i] + scheme.w_new[i])
        dq = (0.5 - scheme.beta) * a + scheme.beta * a_new - 0.5 * ((1.0 - scheme.gamma) * a + scheme.gamma * a_new)
        force = 0.5 * (scheme.start.conservative[i] + scheme.end.conservative[i])
        gained += h * (dv * scheme.momentum[i] - h * dq * force)
    return -gained


@in_space("lcpflex.steppers.spatial.alpha")
@kernel
def resting_load(work: Workspace, scheme: AlphaScheme, k: int, r: int) -> float:
    """Force of the smooth motion on row r, of contact k [N]; 0 where it did not rest."""
    i = scheme.matched[k]
    if i < 0:
        return 0.0
    return float(scheme.resting.load[i, 0 if r < work.rows.n_joint + work.rows.n_contacts else 1])


@kernel
def find_closing(model: Model, n: int, work: Workspace, scheme: AlphaScheme) -> None:
    """Which of n contacts close in this step, and whether their order is to be looked at."""
    order = scheme.order
    for k in range(n):
        order.closes[k] = 1 if scheme.matched[k] < 0 else 0
    order.goes_on = 1 if needs_order(model.contacts.restitution, work.rows.table.law, n, order.closes) else 0
    if order.goes_on == 1:
        begin_order(model, scheme.q, scheme.q_new, scheme.u, scheme.v_new, work, order)


@kernel
def lay_free(n: int, n_tangent: int, work: Workspace, scheme: AlphaScheme) -> None:
    """``work.free.u``: velocity without any contact impulse; after strikes, with those."""
    n_joint, h, order = work.rows.n_joint, scheme.step, scheme.order
    total = n_joint + n + n_tangent
    first = order.rounds == 0
    for i in range(len(scheme.u)):
        work.free.u[i] = scheme.v_new[i] if first else order.after[i]
    for r in range(n_joint + n, total):
        work.impulses.p[r] = 0.0
    for k in range(n):
        i = scheme.matched[k]
        work.impulses.p[n_joint + k] = -h * scheme.resting.load[i, 0] if i >= 0 and first else 0.0
    list_tangents(work.rows, work.posed.tangent_of)
    for j in range(n_tangent):
        k = work.rows.tangent[j]
        if scheme.matched[k] >= 0 and first:
            work.impulses.p[n_joint + n + j] = -h * resting_load(work, scheme, k, n_joint + n + j)
    if first:
        apply_impulses(work.rows.solved, work.rows.body, n_joint, total, work.impulses.p, work.rows.dof, work.free.u)
    free_velocities(
        work.rows.J, work.rows.body, n_joint, total, work.rows.dof, work.free.u, work.free.v, work.free.terms
    )
    for r in range(n_joint):
        work.free.v[r] += work.rows.rate[r]


@kernel
def reflect(model: Model, n: int, n_tangent: int, work: Workspace, scheme: AlphaScheme) -> None:
    """Restitution of the n contacts, or of those struck now, in the right-hand side."""
    n_joint, order = work.rows.n_joint, scheme.order
    u = order.before if order.rounds + order.goes_on > 0 else scheme.u
    for k in range(n):
        e_n = model.contacts.restitution[work.rows.table.law[k]]
        if e_n > 0.0 and scheme.matched[k] < 0:
            before = min(row_velocity(work.rows.J, work.rows.body, n_joint + k, work.rows.dof, u), 0.0)
            scheme.approach = max(scheme.approach, -before)
            gained = abs(work.free.v[n_joint + k] - before)
            if -before > scheme.rebound + scheme.settle * gained:
                work.free.v[n_joint + k] += e_n * before
            else:
                scheme.stopped = max(scheme.stopped, -before)
    for j in range(n_tangent):
        k = work.rows.tangent[j]
        e_t = model.contacts.tangential_restitution[work.rows.table.law[k]]
        if e_t > 0.0 and scheme.matched[k] < 0:
            r = n_joint + n + j
            work.free.v[r] += e_t * row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, u)


@kernel
def pose_velocity(model: Model, t: float, work: Workspace, scheme: AlphaScheme) -> None:
    """Impact law and friction at the end of the step, for the whole impulses of the step, or the next strike in it.

    A contact that came to the step at rest has no restitution: its approach is that of a curved surface.
    """
    n, order = scheme.n_found, scheme.order
    n_tangent = assemble_rows(model, t, 0.0, 0.0, n, work, scheme)
    if order.rounds == 0:
        scheme.numerical = numerical_damping(model, work, scheme)
    match(work.rows.table, n, scheme.resting, scheme.matched)
    if order.rounds == 0:
        find_closing(model, n, work, scheme)
    lay_free(n, n_tangent, work, scheme)
    lay_contacts(work)
    reflect(model, n, n_tangent, work, scheme)
    if order.goes_on == 1:
        closed, slow = scheme.gap_tolerance, scheme.velocity_threshold + scheme.rebound
        choose_strikes(work, order, model.contacts.restitution, closed, slow)
    prepare_large(model, work)
    scheme.warm = 1 - order.goes_on
