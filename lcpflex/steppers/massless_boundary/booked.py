"""Work, impulses and touching points of the massless-boundary scheme, as they are written down."""

from __future__ import annotations

from lcpflex.contact.rows import contact_point
from lcpflex.dynamics.position import friction_before, remember_friction, slip_in
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model
from lcpflex.steppers.massless_boundary.memory import BoundaryScheme
from lcpflex.steppers.recorded_contacts import friction_state, note_contact
from lcpflex.steppers.recorder import Recorder, note_certificate

__all__ = ["STICKING", "audit", "note_forces"]

STICKING = 1e-9  # part of the largest gap or slip of a problem below which a contact counts as sticking


@kernel
def audit(h: float, drives: float, scheme: BoundaryScheme, work: Workspace, recorder: Recorder) -> None:
    """Add the step's work by kind, and its impulses, to the recorder; trapezoidal in time, as Verlet's own balance is.

    Friction: the mean of the forces at both ends times the slip, which is exact for the contact compliance.
    """
    u = scheme.u
    lost = 0.0
    for i in range(len(u)):
        lost -= work.free.dissipative[i] * u[i]
        drives += work.free.driving[i] * u[i]
    recorder.counts.lost_damping += 0.5 * h * (scheme.power[0] + lost)
    recorder.counts.supplied += 0.5 * h * (scheme.power[1] + drives)
    scheme.power[0] = lost
    scheme.power[1] = drives
    add_impulses(h, scheme, recorder)
    for law in range(len(scheme.force)):
        for i in range(scheme.force.shape[1]):
            scheme.force[law, i] = 0.0
    sum_forces(scheme, work, recorder)
    length = scheme.unit[0] * scheme.unit[1]
    for j in range(work.rows.n_tangents):
        before = friction_before(work, j)
        if h > 0.0 and (before != 0.0 or work.impulses.tangential[j] != 0.0):
            recorder.counts.lost_friction -= 0.5 * (before + work.impulses.tangential[j]) * slip_in(work, j) * length
    remember_friction(work)
    add_impulses(h, scheme, recorder)
    note_certificate(work, recorder)


@kernel
def add_impulses(h: float, scheme: BoundaryScheme, recorder: Recorder) -> None:
    """Add what the contact forces ``scheme.force`` give in half a step to the sums of the declared contacts."""
    for law in range(len(scheme.force)):
        for i in range(scheme.force.shape[1]):
            recorder.total_impulse[law, i] += 0.5 * h * scheme.force[law, i]


@in_space("lcpflex.steppers.spatial.massless")
@kernel
def sum_forces(scheme: BoundaryScheme, work: Workspace, recorder: Recorder) -> None:
    """Add the present contact forces to ``scheme.force``, of the declared contacts."""
    for k in range(work.rows.n_contacts):
        scheme.force[work.rows.table.law[k], 0] += work.impulses.normal[k]
    for j in range(work.rows.n_tangents):
        scheme.force[work.rows.table.law[work.rows.tangent[j]], 1] += work.impulses.tangential[j]


@in_space("lcpflex.steppers.spatial.massless")
@kernel
def note_forces(model: Model, q: FloatArray, work: Workspace, recorder: Recorder) -> None:
    """Add the touching points with their forces to the instant about to be stored."""
    table, normal = work.rows.table, work.impulses.normal
    tangent = 0
    for k in range(work.rows.n_contacts):
        force_t = 0.0
        slip = 1.0
        if tangent < work.rows.n_tangents and work.rows.tangent[tangent] == k:
            force_t = work.impulses.tangential[tangent]
            slip = slip_in(work, tangent)
            tangent += 1
        if normal[k] > 0.0:
            state = friction_state(normal[k], abs(force_t), work.rows.mu[k], abs(slip), STICKING)
            place = contact_point(model, q, table, k)
            note_contact(recorder, table.law[k], place, table.normal[k], normal[k], force_t, state)
