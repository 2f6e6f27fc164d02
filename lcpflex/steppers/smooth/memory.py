"""State of a run under continuous contact forces, and its account of contacts between steps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lcpflex.contact.concave_corners import yield_to_deeper
from lcpflex.contact.detection import detect
from lcpflex.dynamics.acceleration import ContactSets, contact_sets
from lcpflex.dynamics.contact_memory import settle, unsettled
from lcpflex.dynamics.contact_problem import pose_contacts
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.mechanics import factorise, fill_contact_rows, solve_rows
from lcpflex.dynamics.workspace import Workspace
from lcpflex.force_laws.history import PLACES, ContactMemory, contact_memory
from lcpflex.force_laws.layout import LawRow
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.kinematics.joint_rows import joint_rows
from lcpflex.model.arrays import Model
from lcpflex.steppers.runge_kutta import STAGES
from lcpflex.steppers.system import System

__all__ = ["SmoothMemory", "begun", "early", "look", "note", "smooth_memory"]

FRICTION, CONTACT_DAMPING, DAMPING, WORK, IMPULSES = range(5)  # places in y behind q and u

ROUNDING = 1e-14  # of the largest coordinate, at least of 1: contacts nearer than that are taken note of


@struct
class SmoothMemory:
    """State, stages and laws of a run; ny = 2 ndof + 4 + 2 laws, + 2 places where friction has states of its own."""

    y: FloatArray = array("ny")  # state at the start of the step
    end: FloatArray = array("ny")  # at its end
    slopes: FloatArray = array(STAGES, "ny")
    at: FloatArray = array("ny")  # state on the dense output
    slope: FloatArray = array("ny")
    sets: ContactSets  # of no contacts, for the projection onto joints
    contacts: ContactMemory  # laws, and what contacts remember
    states: int  # where in y the two states of friction of each place begin; ny if there are none
    phase: int
    steps: int
    stored: int
    stalled: int  # steps in a row that were of no length
    time: float  # [s]
    step: float  # to try next [s]
    step_taken: float  # of the one whose stages these are [s]
    length: float  # of that one [s]
    error: float
    detail: float  # explains what a loop returned
    frequency: float  # highest of a contact so far [rad/s]


def smooth_memory(system: System, laws: Sequence[LawRow]) -> SmoothMemory:
    """Allocate for ``system`` at its initial state, with the law of each declared contact."""
    ndof = len(system.q)
    contacts = contact_memory(system.model.contacts, laws)
    states = 2 * ndof + IMPULSES + 2 * len(laws)
    ny = states + (2 * len(contacts.feature) if any(law.bristles for law in laws) else 0)
    memory = allocate(SmoothMemory, {"ny": ny}, sets=contact_sets(1), contacts=contacts, states=states)
    memory.y[:ndof] = system.q
    memory.y[ndof : 2 * ndof] = system.u
    return memory


@kernel
def look(model: Model, q: FloatArray, u: FloatArray, slack: float, work: Workspace, memory: SmoothMemory) -> int:
    """Touching pairs at q with their rows and, in ``work.free``, the rates of their gaps; returns as ``detect``.

    Gaps count as smaller by ``slack`` [m] than they are.
    """
    n = detect(model, q, slack, work.table)
    if n > len(work.table.key):
        return n
    for k in range(n):
        work.table.gap[k] -= slack
    yield_to_deeper(work.table, n)
    n_joint = len(work.residual)
    work.n_joint = n_joint
    work.n_contacts = n
    work.n_tangents = fill_contact_rows(model, q, n, n_joint, work)
    for k in range(n):
        work.free[n_joint + k] = row_velocity(work.rows, work.row_body, n_joint + k, work.dof, u)
    return n


@kernel
def early(model: Model, work: Workspace, memory: SmoothMemory) -> bool:
    """Whether the state just looked at lies behind the beginning or the turn of a contact that is remembered."""
    n_joint = work.n_joint
    n = work.n_contacts
    return unsettled(model, memory.contacts, work.table, n, work.free[n_joint : n_joint + n])


@kernel
def begun(model: Model, y: FloatArray, work: Workspace, memory: SmoothMemory) -> int:
    """1 where the state y is ``early``, 0 where not; the number of touching pairs, negative, if that is too large."""
    ndof = len(work.free_u)
    n = look(model, y[:ndof], y[ndof : 2 * ndof], 0.0, work, memory)
    if n > len(work.table.key):
        return -n
    return 1 if early(model, work, memory) else 0


@kernel
def roundings(values: FloatArray) -> float:
    """What may be lost by rounding in a sum of ``values`` and numbers of order 1, amply."""
    largest = 1.0
    for value in values:
        largest = max(largest, abs(value))
    return ROUNDING * largest


@kernel
def note(model: Model, t: float, y: FloatArray, work: Workspace, memory: SmoothMemory) -> tuple[int, int]:
    """Let contacts take note of the accepted state y of time t.

    A step ends where a contact begins or turns, up to rounding: what is short of it by no more counts as there, or the
    next step would end at once, and so for ever. Returns the touching pairs, as ``detect``, and the contact whose
    indentation is out of the range of its law, or -1.
    """
    ndof = len(work.free_u)
    q = y[:ndof]
    u = y[ndof : 2 * ndof]
    n = look(model, q, u, roundings(q), work, memory)
    if n > len(work.table.key):
        return n, -1
    n_joint = work.n_joint
    turned = roundings(u)
    for k in range(n):
        work.free[n_joint + k] += turned
    contacts = memory.contacts
    if early(model, work, memory):  # one begins: effective masses, with joints
        factorise(model, q, 0.0, 0.0, work)
        if n_joint > 0:
            joint_rows(model, t, q, u, work.external, work.rows, work.row_body, work.rate, work.bias)
        solve_rows(model, work, int(np.int64(0)), n_joint + n + work.n_tangents)  # no literal, see dot
        pose_contacts(work)
    states = y[memory.states :].reshape(-1, PLACES)
    rates = work.free[n_joint : n_joint + n]
    return n, settle(model, contacts, work.table, n, rates, work.problem.delassus, states)
