"""Memory of a run by the nonsmooth generalised-alpha scheme: what a step needs of the last one, and its iterates."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lcpflex.contact.detection import ContactTable
from lcpflex.dynamics.acceleration import ContactSets, contact_sets
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, copy_parts, pack, struct
from lcpflex.steppers.event_driven.memory import copy_entry
from lcpflex.steppers.system import System

__all__ = ["AlphaMemory", "Held", "alpha_memory", "hold", "larger", "match"]

RESTART, SMOOTH, POSITION, VELOCITY = 0, 1, 2, 3  # what is solved next, number[PHASE]
PHASE, PASS, BETWEEN, SKIP, FOUND, WARM, UNSETTLED = range(7)  # entries of AlphaMemory.number
CHANGE, NUMERICAL, LIFTED, APPROACH, STRUCK, STOPPED = range(6)  # entries of AlphaMemory.value
NOW, NEXT, RECURSIVE = range(3)  # the last: what the acceleration a of the scheme is to w
FRICTION, NORMAL, DAMPING, DRIVE, STORED = range(5)  # entries of AlphaMemory.working, first as the sums of a tape


@struct
class Held:
    """Contacts that carry something, with what they carry."""

    table: ContactTable
    count: int
    load: FloatArray = array("contacts", 2)  # normal and tangential
    mode: IntArray = array("contacts")  # of the sets SMOOTH, STICKING, SLIDE_FORTH, SLIDE_BACK


class AlphaMemory(NamedTuple):
    """Work arrays for ``capacity`` contacts."""

    a: FloatArray  # (ndof,) the recursive acceleration of the scheme
    w: FloatArray  # (ndof,) udot at the start of the step
    a_new: FloatArray  # (ndof,)
    w_new: FloatArray  # (ndof,) iterate of udot at its end
    q_new: FloatArray  # (ndof,) configuration at its end
    v_new: FloatArray  # (ndof,) velocity at its end without impulses
    push: FloatArray  # (ndof,) a product with M
    mean: FloatArray  # (ndof,) velocity over the step
    sets: ContactSets
    resting: Held  # contacts of the smooth motion with their forces [N]
    pressed: Held  # contacts that carry something in the present pass of the position problem [N s]
    matched: IntArray  # (capacity,) the resting contact that each one of the table is, or -1
    total: FloatArray  # (capacity,) nu of each contact of the table [N s]
    law_force: FloatArray  # (3, laws, 2) smooth contact forces at start and end of the step, and their share in a [N]
    working: FloatArray  # (2, 5, ndof) generalised forces that do work, at start and end of the step
    value: FloatArray  # (6,) last change of an acceleration; energy lost to numerical damping in this step [J]; deepest
    # penetration that a position problem has taken out [m]; fastest approach of a pair that closed [m/s] and how deep
    # it was [m]; fastest one stopped [m/s]
    number: IntArray  # (7,)


def held(system: System, capacity: int) -> Held:
    """An empty list of contacts."""
    return allocate(Held, {"contacts": capacity}, table=system.table(capacity))


def alpha_memory(system: System, capacity: int) -> AlphaMemory:
    """Allocate for ``system``, before its first step."""
    ndof = len(system.q)
    zeros = np.zeros
    arrays = AlphaMemory(
        a=zeros(ndof),
        w=zeros(ndof),
        a_new=zeros(ndof),
        w_new=zeros(ndof),
        q_new=zeros(ndof),
        v_new=zeros(ndof),
        push=zeros(ndof),
        mean=zeros(ndof),
        sets=contact_sets(capacity),
        resting=held(system, capacity),
        pressed=held(system, capacity),
        matched=np.zeros(capacity, dtype=np.int64),
        total=zeros(capacity),
        law_force=zeros((3, system.n_laws, 2)),
        working=zeros((2, 5, ndof)),
        value=zeros(6),
        number=np.zeros(7, dtype=np.int64),
    )
    arrays.number[BETWEEN] = 1
    return pack(arrays)


def larger(system: System, old: AlphaMemory, capacity: int) -> AlphaMemory:
    """The same content with room for ``capacity`` contacts."""
    new = alpha_memory(system, capacity)
    copy_parts(old, new)
    return new


@kernel
def match(table: ContactTable, k: int, held: Held) -> int:
    """Which of the held contacts entry k of the table is; -1 for none.

    The same pair of slave and feature, or the same slave where it has passed from one feature of a surface to the next.
    """
    for i in range(held.count):
        if held.table.key[i] == table.key[k]:
            return i
    for i in range(held.count):
        if held.table.law[i] == table.law[k] and held.table.slave[i] == table.slave[k]:
            return i
    return -1


@kernel
def hold(table: ContactTable, k: int, normal: float, tangential: float, mode: int, held: Held) -> None:
    """Add entry k of the table with its load."""
    i = held.count
    copy_entry(table, k, held.table, i)
    held.load[i, 0] = normal
    held.load[i, 1] = tangential
    held.mode[i] = mode
    held.count = i + 1
