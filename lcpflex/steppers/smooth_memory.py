"""State of a run under continuous contact forces, and its account of contacts between steps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lcpflex.compiled import FloatArray, IntArray, kernel
from lcpflex.contact.detection import SEGMENT, ContactTable, detect
from lcpflex.contact.laws.layout import LawRow
from lcpflex.contact.laws.memory import PLACES, ContactMemory, contact_memory
from lcpflex.dynamics.acceleration import ContactSets, condense_rows, contact_sets
from lcpflex.dynamics.constraint_rows import joint_rows
from lcpflex.dynamics.contact_memory import settle, unsettled
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.mechanics import factorise, fill_contact_rows, solve_rows
from lcpflex.dynamics.workspace import Workspace
from lcpflex.model import Model
from lcpflex.packed import pack
from lcpflex.steppers.runge_kutta import STAGES
from lcpflex.steppers.system import System

__all__ = ["SmoothMemory", "look", "note", "smooth_memory", "yield_to_deeper"]

FRICTION, CONTACT_DAMPING, DAMPING, WORK, IMPULSES = range(5)  # places in y behind q and u
# number
PHASE, STEPS, STORED = range(3)
# clock: LENGTH of the step whose stages these are, TAKEN of it; FREQUENCY: highest of a contact so far [rad/s]
TIME, STEP, TAKEN, ERROR, DETAIL, FREQUENCY, LENGTH = range(7)

SHALLOW = 0.98  # cosine of 0.2 rad: of two segments that meet in a hollow of less turn, one holds a slave at a time
YIELDED = 1e-300  # [m] gap of the other one: it does not touch


class SmoothMemory(NamedTuple):
    """State, stages and laws of a run; ny = 2 ndof + 4 + 2 laws, + 2 places where friction has states of its own."""

    y: FloatArray  # (ny,) state at the start of the step
    end: FloatArray  # (ny,) at its end
    slopes: FloatArray  # (7, ny)
    at: FloatArray  # (ny,) state on the dense output
    slope: FloatArray  # (ny,)
    sets: ContactSets  # of no contacts, for the projection onto joints
    contacts: ContactMemory  # laws, and what contacts remember
    states: IntArray  # (1,) where in y the two states of friction of each place begin; ny if there are none
    number: IntArray  # (3,) see the names above
    clock: FloatArray  # (7,) see the names above


def smooth_memory(system: System, laws: Sequence[LawRow]) -> SmoothMemory:
    """Allocate for ``system`` at its initial state, with the law of each declared contact."""
    ndof = len(system.q)
    contacts = contact_memory(system.model.contacts, laws)
    states = 2 * ndof + IMPULSES + 2 * len(laws)
    ny = states + (2 * len(contacts.feature) if any(law.bristles for law in laws) else 0)
    arrays = SmoothMemory(
        y=np.zeros(ny),
        end=np.zeros(ny),
        slopes=np.zeros((STAGES, ny)),
        at=np.zeros(ny),
        slope=np.zeros(ny),
        sets=contact_sets(1),
        contacts=contacts,
        states=np.array([states]),
        number=np.zeros(3, dtype=np.int64),
        clock=np.zeros(7),
    )
    arrays.y[:ndof] = system.q
    arrays.y[ndof : 2 * ndof] = system.u
    return pack(arrays)


@kernel
def yield_to_deeper(table: ContactTable, n: int) -> None:
    """In a shallow hollow of two segments, leave a slave the deeper of its two indentations: the other one ends.

    A slave comes over the second segment when it is already below it. Both forces together would begin there with a
    jump, and the second spring would be found compressed by nobody. The deeper of two indentations has no jumps.
    """
    deepest = 0
    for k in range(1, n):
        one_hollow = (
            table.slave[k] == table.slave[deepest]
            and table.law[k] == table.law[deepest]
            and table.kind[k] == SEGMENT
            and table.kind[deepest] == SEGMENT
            and table.normal[k, 0] * table.normal[deepest, 0] + table.normal[k, 1] * table.normal[deepest, 1] > SHALLOW
        )
        if one_hollow and table.gap[k] >= table.gap[deepest]:
            table.gap[k] = max(table.gap[k], YIELDED)
            continue
        if one_hollow:
            table.gap[deepest] = max(table.gap[deepest], YIELDED)
        deepest = k


@kernel
def look(model: Model, q: FloatArray, u: FloatArray, work: Workspace, memory: SmoothMemory) -> int:
    """Touching pairs at q with their rows and, in ``work.free``, the rates of their gaps; returns as ``detect``."""
    n = detect(model, q, 0.0, work.table)
    if n > len(work.table.key):
        return n
    yield_to_deeper(work.table, n)
    n_joint = len(work.residual)
    work.step_size[0] = n_joint
    work.step_size[1] = n
    work.step_size[2] = fill_contact_rows(model, q, n, n_joint, work)
    for k in range(n):
        work.free[n_joint + k] = row_velocity(work.rows, work.row_body, n_joint + k, work.dof, u)
    return n


@kernel
def early(model: Model, work: Workspace, memory: SmoothMemory) -> bool:
    """Whether the state just looked at lies behind the beginning or the turn of a contact that is remembered."""
    n_joint = work.step_size[0]
    n = work.step_size[1]
    return unsettled(model, memory.contacts, work.table, n, work.free[n_joint : n_joint + n])


@kernel
def note(model: Model, t: float, y: FloatArray, work: Workspace, memory: SmoothMemory) -> tuple[int, int]:
    """Let contacts take note of the accepted state y of time t.

    Returns the touching pairs, as ``detect``, and the contact whose indentation is out of the range of its law, or -1.
    """
    ndof = len(work.free_u)
    q = y[:ndof]
    u = y[ndof : 2 * ndof]
    n = look(model, q, u, work, memory)
    if n > len(work.table.key):
        return n, -1
    n_joint = work.step_size[0]
    contacts = memory.contacts
    if early(model, work, memory):  # one begins: effective masses, with joints
        factorise(model, q, 0.0, 0.0, work)
        if n_joint > 0:
            joint_rows(model, t, q, u, work.external, work.rows, work.row_body, work.rate, work.bias)
        solve_rows(model, work, int(np.int64(0)), n_joint + n + work.step_size[2])  # no literal, see dot
        condense_rows(work)
    states = y[memory.states[0] :].reshape(-1, PLACES)
    rates = work.free[n_joint : n_joint + n]
    return n, settle(model, contacts, work.table, n, rates, work.Gc, states)
