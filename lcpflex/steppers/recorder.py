"""What a run writes down: flat buffers that compiled loops fill and the driver empties.

Sums (per run): energy lost to 0 friction, 1 impacts and contact closing, 2 damping; 3 work of loads and drives [J].
Peaks (since the last stored instant): 0 natural-map residual, 1 penetration [m], 2 joint drift, 3 size of the contact
problem, 4 pivots, 5 the residual relative to the free velocity alone.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lcpflex.contact.detection import SET_VALUED, ContactTable, detect
from lcpflex.contact.rows import contact_point
from lcpflex.dynamics.law_memory import LawContacts
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import pack
from lcpflex.model.arrays import OPEN, SLIP, STICK, Model

__all__ = [
    "FARTHEST",
    "LEAST",
    "PASSES",
    "Tape",
    "note_certificate",
    "note_contact",
    "note_gain",
    "note_laws",
    "store_contacts",
    "store_state",
    "tape",
]

LEAST, FARTHEST, PASSES = range(3)  # entries of Tape.thin


class Tape(NamedTuple):
    """Room for ``capacity`` instants and for a number of touching points over all of them."""

    filled: IntArray  # (2,) instants and spots written
    times: FloatArray  # (capacity,)
    q: FloatArray  # (capacity, ndof)
    u: FloatArray  # (capacity, ndof)
    force: FloatArray  # (capacity, laws, 2)
    impulse: FloatArray  # (capacity, laws, 2)
    state: IntArray  # (capacity, laws)
    gap: FloatArray  # (capacity, laws)
    energies: FloatArray  # (capacity, 7) kinetic, elastic, potential, then the sums
    peaks: FloatArray  # (capacity, 6)
    spots: FloatArray  # (spot capacity, 9) instant, law, x, y, n_x, n_y, force N, force T, state
    table: ContactTable  # near contacts at the stored instant, for gaps
    margin: FloatArray  # (1,) gaps larger than this are not measured [m]
    # what bodies may pass through in a step (lcpflex.contact.thickness)
    thin: FloatArray  # (2 + passes,) least thickness; farthest point of a surface from its frame; of each pass [m]
    sway: FloatArray  # (bodies,) largest shape of a mode on a surface of the body
    before: FloatArray  # (ndof,) configuration at the start of the step
    after: FloatArray  # (ndof,) and at its end, where it is to be examined
    free: FloatArray  # (ndof,) where its first velocity leads; NaN under schemes that move no body out of another
    # running values
    local: FloatArray  # (2, ndof) magnitudes of the errors that error control has accepted, summed, of q and of u
    sums: FloatArray  # (4,)
    worst: FloatArray  # (6,)
    gain: FloatArray  # (3,) energy created by contact impulses: total [J], largest at once [J], its time [s]
    total_impulse: FloatArray  # (laws, 2)
    now_force: FloatArray  # (laws, 2)
    now_state: IntArray  # (laws,)


def tape(
    ndof: int,
    n_laws: int,
    capacity: int,
    spots: int,
    table: ContactTable,
    margin: float,
    thin: FloatArray,
    sway: FloatArray,
) -> Tape:
    """Allocate an empty tape."""
    zeros = np.zeros
    arrays = Tape(
        filled=np.zeros(2, dtype=np.int64),
        times=zeros(capacity),
        q=zeros((capacity, ndof)),
        u=zeros((capacity, ndof)),
        force=zeros((capacity, n_laws, 2)),
        impulse=zeros((capacity, n_laws, 2)),
        state=np.zeros((capacity, n_laws), dtype=np.int64),
        gap=zeros((capacity, n_laws)),
        energies=zeros((capacity, 7)),
        peaks=zeros((capacity, 6)),
        spots=zeros((spots, 9)),
        table=table,
        margin=np.array([margin]),
        thin=thin,
        sway=sway,
        before=zeros(ndof),
        after=zeros(ndof),
        free=np.full(ndof, np.nan),
        local=zeros((2, ndof)),
        sums=zeros(4),
        worst=zeros(6),
        gain=zeros(3),
        total_impulse=zeros((n_laws, 2)),
        now_force=zeros((n_laws, 2)),
        now_state=np.zeros(n_laws, dtype=np.int64),
    )
    return pack(arrays)


@kernel
def note_contact(
    tape: Tape, law: int, place: tuple[float, float], normal: FloatArray, force_n: float, force_t: float, state: int
) -> None:
    """Add one touching point to the instant about to be stored: to its declared contact and to the spots."""
    tape.now_force[law, 0] += force_n
    tape.now_force[law, 1] += force_t
    tape.now_state[law] = max(tape.now_state[law], state)
    row = tape.filled[1]
    if row < len(tape.spots):
        tape.spots[row, 0] = tape.filled[0]
        tape.spots[row, 1] = law
        tape.spots[row, 2] = place[0]
        tape.spots[row, 3] = place[1]
        tape.spots[row, 4] = normal[0]
        tape.spots[row, 5] = normal[1]
        tape.spots[row, 6] = force_n
        tape.spots[row, 7] = force_t
        tape.spots[row, 8] = state
        tape.filled[1] = row + 1


@kernel
def note_laws(model: Model, q: FloatArray, laws: LawContacts, tape: Tape) -> None:
    """Add the contacts by law, with the forces that ``law_forces`` found at q."""
    for k in range(laws.found[0]):
        if laws.table.gap[k] < 0.0:
            place = contact_point(model, q, laws.table, k)
            state = STICK if laws.sticks[k] == 1 else SLIP
            note_contact(tape, laws.table.law[k], place, laws.table.normal[k], laws.p[k, 0], laws.p[k, 1], state)


@kernel
def note_gain(tape: Tape, t: float, work: float) -> None:
    """Keep account of contact impulses that together did positive work: no passive contact does."""
    if work > 0.0:
        tape.gain[0] += work
        if work > tape.gain[1]:
            tape.gain[1] = work
            tape.gain[2] = t


@kernel
def note_certificate(work: Workspace, tape: Tape) -> None:
    """Keep the worst residuals, size and pivots of the contact problems."""
    tape.worst[0] = max(tape.worst[0], work.certificate[0])
    tape.worst[3] = max(tape.worst[3], work.step_size[3])
    tape.worst[4] = max(tape.worst[4], work.certificate[1])
    tape.worst[5] = max(tape.worst[5], work.certificate[2])


@kernel
def store_contacts(model: Model, q: FloatArray, tape: Tape) -> int:
    """Smallest gap of each declared contact; returns the entries that the table of the tape must hold.

    A set-valued contact below zero counts as penetration: a step that ends there may be the last one.
    """
    row = tape.filled[0]
    for law in range(len(tape.total_impulse)):
        tape.gap[row, law] = np.nan
    n = detect(model, q, tape.margin[0], tape.table)
    if n > len(tape.table.key):
        return n
    for k in range(n):
        law = tape.table.law[k]
        if not tape.table.gap[k] >= tape.gap[row, law]:
            tape.gap[row, law] = tape.table.gap[k]
            if len(tape.table.by_law) == 0 or tape.table.by_law[law] == SET_VALUED:
                tape.worst[1] = max(tape.worst[1], -tape.table.gap[k])
    return n


@kernel
def store_state(
    tape: Tape, t: float, q: FloatArray, u: FloatArray, kinetic: float, elastic: float, potential: float
) -> None:
    """Close the instant: copy the state, energies, sums and peaks, and reset what is counted per instant."""
    row = tape.filled[0]
    tape.times[row] = t
    for i in range(len(q)):
        tape.q[row, i] = q[i]
        tape.u[row, i] = u[i]
    tape.energies[row, 0] = kinetic
    tape.energies[row, 1] = elastic
    tape.energies[row, 2] = potential
    for i in range(4):
        tape.energies[row, 3 + i] = tape.sums[i]
    for i in range(6):
        tape.peaks[row, i] = tape.worst[i]
        tape.worst[i] = 0.0
    for law in range(len(tape.total_impulse)):
        for i in range(2):
            tape.impulse[row, law, i] = tape.total_impulse[law, i]
            tape.force[row, law, i] = tape.now_force[law, i]
            tape.now_force[law, i] = 0.0
        tape.state[row, law] = tape.now_state[law]
        tape.now_state[law] = OPEN
    tape.filled[0] = row + 1
