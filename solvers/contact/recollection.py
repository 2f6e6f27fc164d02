"""What the contacts of the last step tell the problems of the next one: their basis, and their forces.

Contacts are told apart by their keys. They keep their order from step to step: the next one is nearly always the one
looked for; where it is not, a table of slots finds it (open addressing), in a time that does not grow with contacts.
"""

from __future__ import annotations

from typing import Any, TypeVar, cast

from lcpflex.jit.kernel import IntArray, kernel
from lcpflex.jit.struct import allocate, copy_parts
from lcpflex.solvers.contact.large.memory import BodyContacts
from lcpflex.solvers.contact.memory import BASIS_KNOWN, SOLUTION_KNOWN, ContactData, Remembered, SolverMemory

__all__ = [
    "enlarged",
    "fill_slots",
    "place_of",
    "recall_basis",
    "remember_basis",
    "remember_forces",
    "remembered",
    "turn_over",
]

M = TypeVar("M")

FEW = 32  # contacts that are looked through one by one


def remembered(capacity: int, before: Remembered | None = None) -> Remembered:
    """Room for so many contacts; what a smaller one holds goes on."""
    return enlarged(Remembered, capacity, before)


def enlarged(kind: type[M], capacity: int, before: M | None) -> M:
    """The same of any kind that has ``key`` and ``slot``, in the plane or in space."""
    memory: Any = allocate(kind, {"contacts": capacity, "slots": 2 * capacity + 1})
    if before is not None:
        copy_parts(before, memory)
        memory.n_next = 0
        fill_slots(memory)
    return cast(M, memory)


@kernel
def fill_slots(known: Remembered) -> None:
    """The table of the contacts of the last step; of several with one key the first comes first."""
    slot, size, key = known.slot, len(known.slot), known.key[known.now]
    for s in range(size):
        slot[s] = 0
    for k in range(known.n):
        s = key[k] % size
        while slot[s] > 0:
            s = s + 1 if s + 1 < size else 0
        slot[s] = k + 1


@kernel
def place_of(known: Remembered, key: int, guess: int) -> int:
    """Where the contact ``key`` was in the last step, beginning at ``guess``; -1 if it is new."""
    count, keys = known.n, known.key[known.now]
    if count == 0:
        return -1
    if guess < count and keys[guess] == key:
        return guess
    if count <= FEW:
        for step in range(count):
            place = (guess + step) % count
            if keys[place] == key:
                return place
        return -1
    slot, size = known.slot, len(known.slot)
    s = key % size
    while slot[s] > 0:
        if keys[slot[s] - 1] == key:
            return int(slot[s] - 1)
        s = s + 1 if s + 1 < size else 0
    return -1


@kernel
def recall_basis(data: ContactData, memory: SolverMemory, known: Remembered) -> None:
    """Start the present problem from the basis of the last step, contact by contact; a contact that is new starts open.

    Not from which forces were positive: the basic unknowns of a degenerate contact may be zero. For problems without
    sliding contacts on index sets.
    """
    n, n_tangent = data.n_contacts, data.n_tangents
    basis = known.basis[known.now]
    if memory.known >= SOLUTION_KNOWN:
        return
    for i in range(n + 2 * n_tangent):
        memory.basis[i] = 0
    j = 0
    guess = 0
    for k in range(n):
        frictional = j < n_tangent and data.tangent[j] == k
        place = place_of(known, data.key[k], guess)
        if place >= 0:
            memory.basis[k] = basis[place, 0]
            if frictional:
                memory.basis[n + j] = basis[place, 1]
                memory.basis[n + n_tangent + j] = basis[place, 2]
            guess = place + 1 if place + 1 < known.n else 0
        if frictional:
            j += 1
    memory.known = BASIS_KNOWN


@kernel
def remember_basis(data: ContactData, memory: SolverMemory, known: Remembered) -> None:
    """Add the contacts of the problem just solved to those of the present step."""
    n, n_tangent = data.n_contacts, data.n_tangents
    first, row = known.n_next, 1 - known.now
    j = 0
    for k in range(n):
        at = first + k
        known.key[row, at] = data.key[k]
        known.basis[row, at, 0] = memory.basis[k]
        known.basis[row, at, 1] = 0
        known.basis[row, at, 2] = 0
        known.force[row, at, 0] = memory.normal[k]
        known.force[row, at, 1] = 0.0
        if j < n_tangent and data.tangent[j] == k:
            known.basis[row, at, 1] = memory.basis[n + j]
            known.basis[row, at, 2] = memory.basis[n + n_tangent + j]
            known.force[row, at, 1] = memory.tangential[j]
            j += 1
    known.n_next = first + n


@kernel
def remember_forces(large: BodyContacts, key: IntArray, first: int, known: Remembered) -> None:
    """Add the contacts of a large problem; ``key`` of the contact whose normal row is ``first``, and of those behind.

    Where the island gets smaller, those that press are taken to stick.
    """
    row = 1 - known.now
    for c in range(large.n_contacts):
        at = known.n_next + c
        r, s = large.normal_row[c], large.tangent_row[c]
        known.key[row, at] = key[r - first]
        known.force[row, at, 0] = large.p[r]
        known.force[row, at, 1] = large.p[s] if s >= 0 else 0.0
        pressed = 1 if large.p[r] > 0.0 else 0
        known.basis[row, at, 0] = pressed
        known.basis[row, at, 1] = pressed if s >= 0 else 0
        known.basis[row, at, 2] = 0
    known.n_next += large.n_contacts


@kernel
def turn_over(known: Remembered) -> None:
    """All problems of the step are solved: what they have left is now what the next one begins from."""
    known.now = 1 - known.now
    known.n = known.n_next
    known.n_next = 0
    if known.n > FEW:
        fill_slots(known)
