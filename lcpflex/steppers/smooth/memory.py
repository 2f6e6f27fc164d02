"""State of a run under continuous contact forces."""

from __future__ import annotations

from collections.abc import Sequence

from lcpflex.dynamics.acceleration import ContactSets, contact_sets
from lcpflex.force_laws.history import ContactMemory
from lcpflex.force_laws.layout import LawRow
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.model.layout import is_spatial
from lcpflex.steppers.runge_kutta import STAGES
from lcpflex.steppers.system import System

__all__ = ["SmoothMemory", "smooth_memory"]

FRICTION, CONTACT_DAMPING, DAMPING, WORK, IMPULSES = range(5)  # places in y behind q and u


@struct
class SmoothMemory:
    """State and stages of a run; ny = nq + ndof + 4 + 2 laws, + 2 places where friction has states of its own.

    In space 4 laws and 4 places.
    """

    y: FloatArray = array("ny")  # state at the start of the step
    end: FloatArray = array("ny")  # at its end
    slopes: FloatArray = array(STAGES, "ny")
    at: FloatArray = array("ny")  # state on the dense output
    slope: FloatArray = array("ny")
    sets: ContactSets  # of no contacts, for the projection onto joints
    states: int  # where in y the states of friction of each place begin; ny if there are none
    nq: int  # where velocities begin in y
    phase: int
    steps: int
    stored: int
    stalled: int  # steps in a row that were of no length
    time: float  # [s]
    step: float  # to try next [s]
    step_taken: float  # of the one whose stages these are [s]
    length: float  # of that one [s]
    error: float
    number: float  # explains what a loop returned
    frequency: float  # highest of a contact so far [rad/s]


def smooth_memory(system: System, history: ContactMemory, laws: Sequence[LawRow]) -> SmoothMemory:
    """Allocate for ``system`` at its initial state, with the law of each declared contact."""
    nq, base = len(system.q), len(system.q) + len(system.u)
    in_space = is_spatial(system.model)
    sums, each = (4, 4) if in_space else (2, 2)  # of a law, and states of friction of a place
    states = base + IMPULSES + sums * len(laws)
    ny = states + (each * len(history.feature) if any(law.bristles for law in laws) else 0)
    memory = allocate(SmoothMemory, {"ny": ny}, sets=contact_sets(1, in_space=in_space), states=states, nq=nq)
    memory.y[:nq] = system.q
    memory.y[nq:base] = system.u
    return memory
