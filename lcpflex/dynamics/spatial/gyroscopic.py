"""Inertial forces of spatial bodies within a step of the Moreau-Jean scheme.

In the plane a rigid body has no inertial force that depends on its velocity. In space it has omega x J omega, and taken
at the velocity of the start of a step it gains energy in each: a body that spins about its middle axis for 4 s at
h = 1/250 ends 2.4 % richer. With the mean of the velocities at both ends it is the implicit midpoint rule; a single
correction towards that, with the factors of the step, leaves 8e-7. The velocity at the end is that with the impulses of
the joints: without them a top on a ball joint would be of order 1. So would be bodies that roll without those of the
contacts, which are not known yet: the forces of the last step stand for them where they carried in the one before, too
(a first force is an impact, and tells nothing of the next).
"""

from __future__ import annotations

import math
from typing import Any

from lcpflex.dynamics.delassus import apply_impulses, row_velocity
from lcpflex.dynamics.joint_response import solve_joints
from lcpflex.dynamics.mechanics import solve_vector
from lcpflex.dynamics.spatial.body_forces import inertial_forces
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.dynamics.spatial.mechanics import multiply
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.spatial import SpatialModel
from lcpflex.solvers.contact.cones.recollection import known_force
from lcpflex.solvers.contact.operators.scene import push_rows
from lcpflex.solvers.contact.recollection import place_of

__all__ = ["spare_spin", "turn_on"]

SETTLED = 2.0**-49  # change of a velocity, relative to it, that is rounding
STILL = 1e-9  # [rad] a body that turns by less in a step has no inertial forces that contacts change
STALLED = 2.0**-36  # so little of it is rounding where it does not become less


@kernel
def turn_on(model: SpatialModel, passes: int, h: float, u: FloatArray, work: SpatialWork) -> bool:
    """Correct the problem posed for inertial forces h(q, u), which ``forces`` has taken at u, in up to ``passes``.

    u_free <- u_free + A^-1 h (h(q, u_mean) - h(q, before)) at ``work.free.middle``, with the forces by kind and the
    right-hand side of all rows; u_mean = (u + u_free - A^-1 J^T S^-1 b)/2 + u_c/2, b the rates that the joints cancel
    and u_c what contacts add. False where several passes do not settle.
    """
    recall_contacts(work)
    touch_bodies(model, h, u, work)
    last = 1.0
    for _ in range(passes):
        correct_once(model, h, u, work)
        if passes == 1:
            return True
        largest = relative_change(model, work)
        if largest <= SETTLED or (largest <= STALLED and largest > 0.5 * last):
            return True
        last = largest
    return False


@kernel
def correct_once(model: Any, h: float, u: FloatArray, work: SpatialWork) -> None:
    """One pass for ``work.free.u``, which changes by ``work.rows.arrow.shift``."""
    spin, mean, change = work.rows.arrow.spin, work.rows.arrow.mean, work.rows.arrow.shift
    for i in range(len(u)):
        mean[i] = 0.5 * (u[i] + work.free.u[i] + work.rows.arrow.touch[i])
    join_mean(work, mean)
    inertial_forces(model.bodies, work.free.middle, mean, work.rows.arrow, change)
    for i in range(len(u)):
        more = change[i] - spin[i]
        spin[i] = change[i]
        work.free.conservative[i] += more
        work.free.total[i] += more
        change[i] = h * more
    solve_vector(model, work, change)
    some = False
    for i in range(len(u)):
        before = work.free.u[i]
        work.free.u[i] += change[i]
        some = some or work.free.u[i] != before
    if some:
        tell_rows(work, change)


@kernel
def recall_contacts(work: SpatialWork) -> None:
    """``known.before``: the normal force of each present contact in the last step, 0 of those that are new."""
    known, guess = work.impulses.remembered, 0
    for k in range(work.rows.n_contacts):
        place = place_of(known, work.rows.table.key[k], guess)
        known.place[k] = place
        known.before[k] = known.force[known.now, place, 0] if place >= 0 else 0.0
        if place >= 0:
            guess = place + 1 if place + 1 < known.n else 0


@kernel
def turns(model: SpatialModel, h: float, u: FloatArray, free: FloatArray) -> bool:
    """Whether a body turns in a step, or would without contacts: one that bends where it is pressed does, at rest."""
    for b in range(len(model.bodies.mass)):
        d = model.bodies.dof[b]
        now, then = 0.0, 0.0
        for i in range(d + 3, d + 6):
            now += abs(u[i])
            then += abs(free[i])
        if h * max(now, then) > STILL:
            return True
    return False


@kernel
def touch_bodies(model: SpatialModel, h: float, u: FloatArray, work: SpatialWork) -> None:
    """``rows.arrow.touch``: what contacts that go on add to the velocities of the bodies, with what joints answer."""
    touch, known, n_joint = work.rows.arrow.touch, work.impulses.remembered, work.rows.n_joint
    for i in range(len(touch)):
        touch[i] = 0.0
    if known.n == 0 or not turns(model, h, u, work.free.u):
        return
    table, forces = work.rows.table, work.rows.joints.rates
    for k in range(work.rows.n_contacts):
        place = known.place[k]
        if place < 0 or known.carried[known.now, place] == 0:
            continue
        f, f1, f2, _ = known_force(known, place, table.normal, table.tangent, k, work.rows.mu[k])
        r, j = n_joint + k, work.posed.tangent_of[k]
        s = n_joint + work.rows.n_contacts + j if j >= 0 else -1
        push_rows(work.rows.solved, work.rows.body, work.rows.dof, r, s, f, f1, f2, touch)
    if n_joint > 0:
        for r in range(n_joint):
            forces[r] = -row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, touch)
        solve_joints(work.rows, forces)
        apply_impulses(work.rows.solved, work.rows.body, 0, n_joint, forces, work.rows.dof, touch)


@kernel
def join_mean(work: SpatialWork, mean: FloatArray) -> None:
    """mean -= A^-1 J^T S^-1 b / 2: the joints as they answer without contacts."""
    impulses = work.rows.joints.rates
    for r in range(work.rows.n_joint):
        impulses[r] = -0.5 * work.rows.joints.answer[r]
    apply_impulses(work.rows.solved, work.rows.body, 0, work.rows.n_joint, impulses, work.rows.dof, mean)


@kernel
def tell_rows(work: SpatialWork, change: FloatArray) -> None:
    """Change the right-hand side of all rows, and what joints answer, by that of the free velocity."""
    n_joint = work.rows.n_joint
    rates = work.rows.joints.rates
    for r in range(n_joint + work.rows.n_contacts + work.rows.n_tangents):
        moved = row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, change)
        work.free.v[r] += moved
        if r < n_joint:
            rates[r] = moved
    if n_joint > 0:
        solve_joints(work.rows, rates)
        for r in range(n_joint):
            work.rows.joints.answer[r] += rates[r]


@kernel
def relative_change(model: SpatialModel, work: SpatialWork) -> float:
    """The largest change of a body in the last pass over its velocity, both by the energy that they would have."""
    mean, change, momentum = work.rows.arrow.mean, work.rows.arrow.shift, work.scratch.velocity
    n_bodies = len(model.bodies.mass)
    energy = work.rows.arrow.energy
    multiply(model, work.free.middle, change, work, momentum)
    for b in range(n_bodies):
        energy[b] = product(work, b, change)
    multiply(model, work.free.middle, mean, work, momentum)
    worst = 0.0
    for b in range(n_bodies):
        if energy[b] > 0.0:
            worst = max(worst, math.sqrt(energy[b] / max(product(work, b, mean), energy[b])))
    return worst


@kernel
def product(work: SpatialWork, b: int, u: FloatArray) -> float:
    """u^T M u of body b, M u being in ``work.scratch.velocity``."""
    total = 0.0
    for i in range(work.rows.dof[b], work.rows.dof[b + 1]):
        total += u[i] * work.scratch.velocity[i]
    return total


@kernel
def spare_spin(model: SpatialModel, lean: float, u: FloatArray, work: SpatialWork) -> None:
    """Nothing: the force that stiffens is taken again at the mean velocity, where its torque has no mean."""
