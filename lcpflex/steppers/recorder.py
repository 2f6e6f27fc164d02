"""What a run writes down: flat buffers that compiled loops fill and the driver empties."""

from __future__ import annotations

import numpy as np

from lcpflex.contact.detection import SET_VALUED, ContactTable, detect
from lcpflex.contact.rows import contact_point
from lcpflex.dynamics.compliant_contacts import CompliantContacts
from lcpflex.dynamics.mechanics import energies
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, IntArray, kernel, late_kernel
from lcpflex.jit.struct import allocate, array, shapes_of, struct
from lcpflex.model.arrays import OPEN, SLIP, STICK, Model

__all__ = [
    "FIELDS",
    "RUNNING",
    "Counts",
    "Tape",
    "has_room",
    "note_certificate",
    "note_compliant",
    "note_contact",
    "note_gain",
    "store_contacts",
    "store_state",
    "tape",
]


@struct
class Counts:
    """What a run has counted so far; the worst ones since the last stored instant."""

    lost_friction: float  # energy lost to friction [J]
    lost_impacts: float  # to impacts and contact closing [J]
    lost_damping: float  # [J]
    supplied: float  # work of loads and drives [J]
    worst_residual: float  # natural-map residual
    worst_penetration: float  # [m]
    worst_drift: float  # of joints
    worst_size: float  # of the contact problem
    worst_relative: float  # residual relative to the free velocity alone
    gained: float  # energy created by contact impulses [J]
    largest_gain: float  # at once [J]
    gain_time: float  # of the largest one [s]


@struct
class Tape:
    """Room for ``capacity`` instants and for a number of touching points over all of them.

    What is stored of each instant is declared here, "capacity" being its first dimension, and written in
    :func:`store_state`; a field of the same name in ``Result`` shows it to the user. All between (pages, checkpoints,
    the file of a result) follows from the declaration.
    """

    n_instants: int  # written
    n_points: int
    times: FloatArray = array("capacity")
    q: FloatArray = array("capacity", "ndof")
    u: FloatArray = array("capacity", "ndof")
    force: FloatArray = array("capacity", "laws", 2)
    impulse: FloatArray = array("capacity", "laws", 2)
    state: IntArray = array("capacity", "laws")
    gap: FloatArray = array("capacity", "laws")
    energies: FloatArray = array("capacity", 7)  # kinetic, elastic, potential; lost to friction, impacts, damping; work
    residual: FloatArray = array("capacity")  # from here on the worst ones of Counts
    strict: FloatArray = array("capacity")
    penetration: FloatArray = array("capacity")
    joint_drift: FloatArray = array("capacity")
    size: IntArray = array("capacity")
    spots: FloatArray = array("spots", 9)  # instant, law, x, y, n_x, n_y, force N, force T, state
    table: ContactTable  # near contacts at the stored instant, for gaps
    margin: float  # gaps larger than this are not measured [m]
    # what bodies may pass through in a step (lcpflex.contact.thickness)
    thinnest: float  # [m]
    farthest: float  # point of a surface from its frame [m]
    pass_thickness: FloatArray  # of each pass [m]
    sway: FloatArray  # (bodies,) largest shape of a mode on a surface of the body
    before: FloatArray = array("ndof")  # configuration at the start of the step
    after: FloatArray = array("ndof")  # and at its end, where it is to be examined
    free: FloatArray = array(
        "ndof"
    )  # where its first velocity leads; NaN under schemes that move no body out of another
    # running values
    local: FloatArray = array(2, "ndof")  # magnitudes of the errors that error control has accepted, summed, of q, u
    counts: Counts
    total_impulse: FloatArray = array("laws", 2)
    now_force: FloatArray = array("laws", 2)
    now_state: IntArray = array("laws")


FIELDS = tuple(name for name, shape in shapes_of(Tape).items() if shape[0] == "capacity")  # stored of each instant
RUNNING = tuple(name for name, shape in shapes_of(Tape).items() if shape[0] not in ("capacity", "spots"))


def tape(
    ndof: int,
    n_laws: int,
    capacity: int,
    spots: int,
    table: ContactTable,
    margin: float,
    pass_thickness: FloatArray,
    farthest: float,
    sway: FloatArray,
) -> Tape:
    """Allocate an empty tape."""
    return allocate(
        Tape,
        {"ndof": ndof, "bodies": len(sway), "laws": n_laws, "capacity": capacity, "spots": spots},
        table=table,
        margin=margin,
        thinnest=pass_thickness.min(initial=np.inf),
        farthest=farthest,
        pass_thickness=pass_thickness,
        sway=sway,
        free=np.full(ndof, np.nan),
        counts=allocate(Counts, {}),
    )


@kernel
def has_room(work: Workspace, tape: Tape) -> bool:
    """Whether an instant with the contacts of the present step fits on the tape."""
    spots = tape.n_points + work.n_contacts + work.compliant.n_contacts
    return tape.n_instants < len(tape.times) and spots <= len(tape.spots)


@kernel
def note_contact(
    tape: Tape, law: int, place: tuple[float, float], normal: FloatArray, force_n: float, force_t: float, state: int
) -> None:
    """Add one touching point to the instant about to be stored: to its declared contact and to the spots."""
    tape.now_force[law, 0] += force_n
    tape.now_force[law, 1] += force_t
    tape.now_state[law] = max(tape.now_state[law], state)
    row = tape.n_points
    if row < len(tape.spots):
        tape.spots[row, 0] = tape.n_instants
        tape.spots[row, 1] = law
        tape.spots[row, 2] = place[0]
        tape.spots[row, 3] = place[1]
        tape.spots[row, 4] = normal[0]
        tape.spots[row, 5] = normal[1]
        tape.spots[row, 6] = force_n
        tape.spots[row, 7] = force_t
        tape.spots[row, 8] = state
        tape.n_points = row + 1


@late_kernel
def note_compliant(model: Model, q: FloatArray, contacts: CompliantContacts, touching: bool, tape: Tape) -> None:
    """Add the compliant contacts with the forces found at q; ``touching``: those without a force, too."""
    table = contacts.table
    for k in range(contacts.n_contacts):
        if touching or table.gap[k] < 0.0:
            place = contact_point(model, q, table, k)
            state = STICK if contacts.sticks[k] == 1 and (touching or contacts.p[k, 0] > 0.0) else SLIP
            note_contact(tape, table.law[k], place, table.normal[k], contacts.p[k, 0], contacts.p[k, 1], state)


@kernel
def note_gain(tape: Tape, t: float, work: float) -> None:
    """Keep account of contact impulses that together did positive work: no passive contact does."""
    if work > 0.0:
        tape.counts.gained += work
        if work > tape.counts.largest_gain:
            tape.counts.largest_gain = work
            tape.counts.gain_time = t


@kernel
def note_certificate(work: Workspace, tape: Tape) -> None:
    """Keep the worst residuals and size of the contact problems."""
    tape.counts.worst_residual = max(tape.counts.worst_residual, work.solver.residual)
    tape.counts.worst_size = max(tape.counts.worst_size, work.solver.size)
    tape.counts.worst_relative = max(tape.counts.worst_relative, work.solver.strict)


@kernel
def store_contacts(model: Model, q: FloatArray, tape: Tape) -> int:
    """Smallest gap of each declared contact; returns the entries that the table of the tape must hold.

    A rigid contact below zero counts as penetration: a step that ends there may be the last one.
    """
    row = tape.n_instants
    for law in range(len(tape.total_impulse)):
        tape.gap[row, law] = np.nan
    n = detect(model, q, tape.margin, tape.table)
    if n > len(tape.table.key):
        return n
    for k in range(n):
        law = tape.table.law[k]
        if not tape.table.gap[k] >= tape.gap[row, law]:
            tape.gap[row, law] = tape.table.gap[k]
            if len(tape.table.by_law) == 0 or tape.table.by_law[law] == SET_VALUED:
                tape.counts.worst_penetration = max(tape.counts.worst_penetration, -tape.table.gap[k])
    return n


@kernel
def forget_worst(counts: Counts) -> None:
    """Begin to count the worst ones anew."""
    counts.worst_residual = 0.0
    counts.worst_penetration = 0.0
    counts.worst_drift = 0.0
    counts.worst_size = 0.0
    counts.worst_relative = 0.0


@kernel
def store_state(
    model: Model, t: float, q: FloatArray, u: FloatArray, work: Workspace, in_contacts: float, tape: Tape
) -> None:
    """Close the instant: store the state, energies, sums and worst ones, and reset what is counted per instant.

    in_contacts: elastic energy of compliant contacts [J].
    """
    row = tape.n_instants
    kinetic, elastic, potential = energies(model, q, u, work)
    tape.times[row] = t
    for i in range(len(q)):
        tape.q[row, i] = q[i]
        tape.u[row, i] = u[i]
    tape.energies[row, 0] = kinetic
    tape.energies[row, 1] = elastic + in_contacts
    tape.energies[row, 2] = potential
    counts = tape.counts
    tape.energies[row, 3] = counts.lost_friction
    tape.energies[row, 4] = counts.lost_impacts
    tape.energies[row, 5] = counts.lost_damping
    tape.energies[row, 6] = counts.supplied
    tape.residual[row] = counts.worst_residual
    tape.strict[row] = counts.worst_relative
    tape.penetration[row] = counts.worst_penetration
    tape.joint_drift[row] = counts.worst_drift
    tape.size[row] = int(counts.worst_size)
    forget_worst(counts)
    for law in range(len(tape.total_impulse)):
        for i in range(2):
            tape.impulse[row, law, i] = tape.total_impulse[law, i]
            tape.force[row, law, i] = tape.now_force[law, i]
            tape.now_force[law, i] = 0.0
        tape.state[row, law] = tape.now_state[law]
        tape.now_state[law] = OPEN
    tape.n_instants = row + 1
