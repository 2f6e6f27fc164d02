"""What a run writes down of contacts in the plane: touching points, and sums of forces and impulses."""

from __future__ import annotations

from lcpflex.contact.rows import contact_point
from lcpflex.dynamics.compliant_contacts import CompliantContacts
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import SLIP, STICK, Model
from lcpflex.steppers.recorder import Recorder

__all__ = [
    "INSIDE",
    "add_compliant_impulse",
    "add_impulse",
    "friction_state",
    "note_compliant",
    "note_contact",
]

INSIDE = 1.0 - 1e-6  # of the cone: friction of a contact that slides is on it to the tolerance of solvers


@kernel
def friction_state(normal: float, tangential: float, mu: float, slip: float, rest: float) -> int:
    """STICK or SLIP of a contact that carries ``normal``, with |F_T| ``tangential`` and a ``slip`` [m/s], both >= 0.

    One that slides is on its cone, |F_T| = mu F_N; so one inside of it sticks. Its velocity does not tell: a solver
    leaves a part of the free velocities, of which those of stiff modes are far larger than those of bodies, and at rows
    of the middle of a step a body that turns has some. On its cone it sticks if no faster than ``rest`` [m/s].
    """
    return STICK if tangential < INSIDE * mu * normal or slip <= rest else SLIP


@kernel
def note_contact(
    recorder: Recorder,
    law: int,
    place: tuple[float, float],
    normal: FloatArray,
    force_n: float,
    force_t: float,
    state: int,
) -> None:
    """Add one touching point to the instant about to be stored: to its declared contact and to those of the instant."""
    recorder.now_force[law, 0] += force_n
    recorder.now_force[law, 1] += force_t
    recorder.now_state[law] = max(recorder.now_state[law], state)
    row = recorder.n_points
    if row < len(recorder.points):
        recorder.points[row, 0] = recorder.n_instants
        recorder.points[row, 1] = law
        recorder.points[row, 2] = place[0]
        recorder.points[row, 3] = place[1]
        recorder.points[row, 4] = normal[0]
        recorder.points[row, 5] = normal[1]
        recorder.points[row, 6] = force_n
        recorder.points[row, 7] = force_t
        recorder.points[row, 8] = state
        recorder.n_points = row + 1


@in_space("lcpflex.steppers.spatial.records")
@kernel
def add_impulse(work: Workspace, r: int, p: float, recorder: Recorder) -> None:
    """Add the impulse p of contact row r, counted behind those of joints, to the sums of its declared contact."""
    n = work.rows.n_contacts
    if r < n:
        recorder.total_impulse[work.rows.table.law[r], 0] += p
    else:
        recorder.total_impulse[work.rows.table.law[work.rows.tangent[r - n]], 1] += p


@in_space("lcpflex.steppers.spatial.records")
@kernel
def add_compliant_impulse(contacts: CompliantContacts, k: int, step: float, recorder: Recorder) -> None:
    """Add what compliant contact k has given in a step to the sums of its declared contact."""
    for c in range(2):
        recorder.total_impulse[contacts.rows.table.law[k], c] += step * contacts.p[k, c]


@in_space("lcpflex.steppers.spatial.records")
@kernel
def note_compliant(
    model: Model, q: FloatArray, contacts: CompliantContacts, touching: bool, recorder: Recorder
) -> None:
    """Add the compliant contacts with the forces found at q; ``touching``: those without a force, too."""
    note_planar_compliant(model, q, contacts, touching, recorder)


@late_kernel
def note_planar_compliant(
    model: Model, q: FloatArray, contacts: CompliantContacts, touching: bool, recorder: Recorder
) -> None:
    """The same, in the plane."""
    table = contacts.rows.table
    for k in range(contacts.rows.n_contacts):
        if touching or table.gap[k] < 0.0:
            place = contact_point(model, q, table, k)
            state = STICK if contacts.sticks[k] == 1 and (touching or contacts.p[k, 0] > 0.0) else SLIP
            note_contact(recorder, table.law[k], place, table.normal[k], contacts.p[k, 0], contacts.p[k, 1], state)
