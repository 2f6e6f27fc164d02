"""Moreau-Jean time stepping: velocities and impulses, one contact problem a step, no event location.

With q_m = q + theta h u and A = M(q_m) + theta h C + (theta h)^2 K,

    A (u+ - u) = h f(t_m, q_m, u) + J^T p_J + W p,     q+ = q + h (theta u+ + (1 - theta) u)

and the unilateral law of :mod:`lcpflex.dynamics.impulse` on every pair whose gap at q + activation h u is closed.
Order 1 across impacts; theta = 1/2 conserves the energy of linear elasticity.
Sources: Moreau 1988; Jean 1999; Acary & Brogliato 2008.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from lcpflex.compiled import FloatArray, kernel
from lcpflex.contact.detection import detect, refresh
from lcpflex.contact.kinematics import contact_point
from lcpflex.dynamics.constraint_rows import joint_rows
from lcpflex.dynamics.delassus import apply_impulses, row_velocity
from lcpflex.dynamics.impulse import METHOD, distribute, pose, recall_basis, remember_basis, solve_lcp
from lcpflex.dynamics.mechanics import (
    contact_biases,
    energies,
    factorise,
    fill_contact_rows,
    forces,
    solve_rows,
    solve_vector,
    supply,
)
from lcpflex.dynamics.workspace import Workspace
from lcpflex.errors import ModelError, in_range
from lcpflex.model import SLIP, STICK, Model
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.problem import LcpSolver
from lcpflex.steppers.driver import Rescue, link, solver_hooks, solver_method, unsolved
from lcpflex.steppers.projection import project_contacts, project_joints
from lcpflex.steppers.run import Records
from lcpflex.steppers.system import System
from lcpflex.steppers.tape import Tape, note_contact, note_gain, store_contacts, store_state

__all__ = ["MoreauJean", "MoreauJeanRun", "Settings", "advance", "correct", "predict", "record"]

DONE = 0
TAPE_FULL = 1
GROW = 2
GROW_TAPE = 3
SOLVER_FAILED = 4
NOT_FINITE = 5
STICKING_SPEED = 1e-9  # [m/s] below which a touching point counts as sticking in the record


class Settings(NamedTuple):
    """Numbers of the scheme, as the compiled loop takes them."""

    step: float
    theta: float
    activation: float
    gap_tolerance: float
    projection: bool
    tolerance: float


@kernel
def predict(model: Model, settings: Settings, t: float, q: FloatArray, u: FloatArray, work: Workspace) -> int:
    """First half of a step: free motion, closed contacts, and the LCP they pose. Returns the contacts found."""
    h = settings.step
    lean = settings.theta * h
    for i in range(len(q)):
        work.middle[i] = q[i] + lean * u[i]
        work.ahead[i] = q[i] + settings.activation * h * u[i]
    n = detect(model, work.ahead, settings.gap_tolerance, work.table)
    if n > len(work.table.key):
        return n
    if settings.activation != settings.theta:
        for k in range(n):
            refresh(model, work.middle, work.table, k)
    supply(model, t + lean, work.middle, u, work)
    forces(model, t + lean, work.middle, u, work)
    factorise(model, work.middle, lean, lean * lean, work)
    for i in range(len(q)):
        work.free_u[i] = h * work.total[i]
    solve_vector(model, work, work.free_u)
    for i in range(len(q)):
        work.free_u[i] += u[i]
    n_joint = len(work.residual)
    if n_joint > 0:
        joint_rows(model, t + lean, work.middle, u, work.external, work.rows, work.row_body, work.rate, work.bias)
    n_tangent = fill_contact_rows(model, work.middle, n, n_joint, work)
    contact_biases(model, work.middle, u, n, n_tangent, n_joint, work)
    solve_rows(model, work, 0, n_joint + n + n_tangent)
    work.step_size[0] = n_joint
    work.step_size[1] = n
    work.step_size[2] = n_tangent
    pose(model, work, u, (1.0 - settings.theta) * h, 0.0)
    return n


@kernel
def audit(model: Model, settings: Settings, t: float, work: Workspace, u: FloatArray, tape: Tape) -> None:
    """Add the step's work by kind, with the mean velocity (u + u+)/2, and its impulses to the tape.

    ``work.free_u`` holds u+. Work of an impulse p on a row: p (w . u + w . u+)/2.
    """
    n_joint = work.step_size[0]
    n = work.step_size[1]
    half = 0.5 * settings.step
    gained = 0.0
    for i in range(len(u)):
        both = u[i] + work.free_u[i]
        tape.sums[2] -= half * work.dissipative[i] * both
        tape.sums[3] += half * work.driving[i] * both
    for r in range(n_joint + n + work.step_size[2]):
        p = work.p[r]
        if p == 0.0:
            continue
        before = row_velocity(work.rows, work.row_body, r, work.dof, u)
        after = row_velocity(work.rows, work.row_body, r, work.dof, work.free_u)
        done = 0.5 * p * (before + after)
        if r < n_joint:
            if work.rate[r] != 0.0:
                tape.sums[3] += done
        elif r < n_joint + n:
            gained += done
            tape.sums[1] -= done
            tape.total_impulse[work.table.law[r - n_joint], 0] += p
        else:
            gained += done
            tape.sums[0] -= done
            tape.total_impulse[work.table.law[work.tangent[r - n_joint - n]], 1] += p
    note_gain(tape, t, gained)
    tape.worst[0] = max(tape.worst[0], work.certificate[0])
    tape.worst[3] = max(tape.worst[3], work.step_size[3])
    tape.worst[4] = max(tape.worst[4], work.certificate[1])


@kernel
def correct(
    model: Model, settings: Settings, t: float, q: FloatArray, u: FloatArray, work: Workspace, tape: Tape
) -> bool:
    """Second half of a step: impulses from the solution z, then u+ and q+ in place. False where they are not finite."""
    h = settings.step
    distribute(work)
    total = work.step_size[0] + work.step_size[1] + work.step_size[2]
    apply_impulses(work.solved, work.row_body, 0, total, work.p, work.dof, work.free_u)
    audit(model, settings, t, work, u, tape)
    largest = 0.0
    for i in range(len(q)):
        q[i] += h * (settings.theta * work.free_u[i] + (1.0 - settings.theta) * u[i])
        u[i] = work.free_u[i]
        largest = max(largest, abs(q[i]))
        if not math.isfinite(q[i] + u[i]):
            return False
    tolerance = 1e-12 * (1.0 + largest)
    project_joints(model, t + h, q, u, work, tape, tolerance)
    if project_contacts(model, h, settings.gap_tolerance, settings.projection, q, work, tape):
        project_joints(model, t + h, q, u, work, tape, tolerance)
    return True


@kernel
def record(
    model: Model, settings: Settings, t: float, q: FloatArray, u: FloatArray, work: Workspace, tape: Tape
) -> int:
    """Store the present instant; the contact forces are the impulses of the last step over its length."""
    needed = store_contacts(model, q, tape)
    if needed > len(tape.table.key):
        return needed
    n_joint = work.step_size[0]
    n = work.step_size[1]
    tangent = 0
    for k in range(n):
        p_t = 0.0
        slip = 1.0
        if tangent < work.step_size[2] and work.tangent[tangent] == k:
            r = n_joint + n + tangent
            p_t = work.p[r]
            slip = row_velocity(work.rows, work.row_body, r, work.dof, u)
            tangent += 1
        p_n = work.p[n_joint + k]
        if p_n > 0.0:
            state = STICK if abs(slip) <= STICKING_SPEED else SLIP
            place = contact_point(model, q, work.table, k)
            note_contact(
                tape, work.table.law[k], place, work.table.normal[k], p_n / settings.step, p_t / settings.step, state
            )
    kinetic, elastic, potential = energies(model, q, u, work)
    store_state(tape, t, q, u, kinetic, elastic, potential)
    return needed


@kernel
def advance(
    model: Model,
    settings: Settings,
    start: float,
    clock: FloatArray,
    q: FloatArray,
    u: FloatArray,
    work: Workspace,
    tape: Tape,
    n_steps: int,
    stride: int,
) -> int:
    """At most n_steps steps from the state (q, u), which is stored before each ``stride``-th one.

    clock: steps made; a number that explains the return value; the step last stored. Returns DONE, or why the next step
    or record could not be made; the state is then that of the last whole step (but NOT_FINITE).
    """
    last = clock[0] + n_steps
    while True:
        t = start + clock[0] * settings.step
        if clock[0] % stride == 0 and clock[2] != clock[0]:
            if tape.filled[0] >= len(tape.times) or tape.filled[1] + work.step_size[1] > len(tape.spots):
                return TAPE_FULL
            clock[1] = record(model, settings, t, q, u, work, tape)
            if clock[1] > len(tape.table.key):
                return GROW_TAPE
            clock[2] = clock[0]
        if clock[0] >= last:
            return DONE
        clock[1] = predict(model, settings, t, q, u, work)
        if clock[1] > len(work.table.key):
            return GROW
        recall_basis(work)
        clock[1] = solve_lcp(work)
        if clock[1] != 0 or not work.certificate[0] <= settings.tolerance:
            return SOLVER_FAILED
        remember_basis(work)
        if not correct(model, settings, t, q, u, work, tape):
            return NOT_FINITE
        clock[0] += 1.0


class MoreauJeanRun:
    """A Moreau-Jean run in progress (see :class:`MoreauJean`)."""

    def __init__(self, system: System, stepper: MoreauJean, duration: float, interval: float) -> None:
        self.system = system
        self.records = Records(system)
        self.q = system.q.copy()
        self.u = system.u.copy()
        self.duration = duration
        self._settings = Settings(
            stepper.step,
            stepper.theta,
            stepper.activation,
            stepper.gap_tolerance,
            stepper.projection,
            stepper.solver_tolerance,
        )
        self._rescue = Rescue(stepper.solver, stepper.solver_tolerance)
        self._work = system.workspace(16)
        self._work.solving[METHOD] = solver_method(stepper.solver)
        whole = math.floor(duration / stepper.step * (1.0 + 1e-12) + 1e-9)
        rest = duration - whole * stepper.step
        self._phases = [(stepper.step, whole)] + ([(rest, 1)] if rest > 1e-9 * stepper.step else [])
        self._stride = max(1, round(interval / stepper.step))
        self._start = 0.0
        self._clock = np.array([0.0, 0.0, -1.0])
        self._made = 0
        hooks = {**system.hooks, **solver_hooks(stepper.solver, system.watch)}
        parts: list[Callable[..., Any]] = [project_joints, project_contacts, predict, correct, store_contacts, record]
        self._advance = link([*parts, advance], hooks)

    @property
    def time(self) -> float:
        """Time reached [s]."""
        return self._start + float(self._clock[0]) * self._settings.step if self._phases else self.duration

    @property
    def steps(self) -> int:
        """Steps made."""
        return self._made + int(self._clock[0])

    @property
    def finished(self) -> bool:
        """Whether the run has reached its end and stored it."""
        return not self._phases

    @property
    def touching(self) -> list[int]:
        """Declared contacts that the last contact problem held."""
        return sorted(set(self._work.table.law[: self._work.step_size[1]].tolist()))

    @property
    def events(self) -> list[tuple[float, str, int, float]]:
        """Time stepping locates no events."""
        return []

    def advance(self, n_steps: int) -> str:
        """Make up to ``n_steps`` steps; empty where all went well, else why the run cannot go on."""
        step, whole = self._phases[0]
        message = self._loop(min(n_steps, whole - int(self._clock[0])), self._stride)
        if message or self._clock[0] < whole:
            return message
        if len(self._phases) == 1:
            message = self._loop(0, 1)  # the end is stored even where the stride would skip it
        else:  # a last, shorter step ends the run on its duration
            self._made += whole
            self._start += whole * step
            self._settings = self._settings._replace(step=self._phases[1][0])
            self._clock[:] = (0.0, 0.0, 0.0)
        if not message:
            self._phases.pop(0)
        return message

    def _loop(self, n_steps: int, stride: int) -> str:
        target = self._clock[0] + n_steps
        while True:
            status = self._advance(
                self.system.model,
                self._settings,
                self._start,
                self._clock,
                self.q,
                self.u,
                self._work,
                self.records.tape,
                int(target - self._clock[0]),
                stride,
            )
            if status == DONE:
                return ""
            if status == TAPE_FULL:
                self.records.empty()
            elif status == GROW_TAPE:
                self.records.grow(int(self._clock[1]))
            elif status == GROW:
                self._grow(2 * int(self._clock[1]))
            elif status == SOLVER_FAILED:
                if self._rescue(self._work, self.time):
                    continue
                return unsolved(self._work, int(self._clock[1]), self._settings.tolerance)
            else:
                return "the state is no longer finite: the step is too long for the forces of this scene"

    def _grow(self, capacity: int) -> None:
        """A larger workspace; the contacts that are held stay so."""
        old = self._work
        held = int(old.step_size[4])
        self._work = self.system.workspace(capacity)
        self._work.step_size[4] = held
        self._work.held_key[:, :held] = old.held_key[:, :held]
        self._work.held_gap[:, :held] = old.held_gap[:, :held]
        self._work.solving[:] = old.solving
        self._work.last_key[: len(old.last_key)] = old.last_key
        self._work.last_basis[: len(old.last_basis)] = old.last_basis


@dataclass(frozen=True, slots=True)
class MoreauJean:
    """Moreau-Jean time stepping.

    Attributes
    ----------
    step
        Step length h [s], > 0.
    theta
        0.5 ... 1: weight of the end of the step; 1/2 conserves the energy of linear elasticity.
    activation
        A pair enters the problem of a step if its gap at q + activation h u is closed; 0 uses the present gap.
    gap_tolerance
        Gaps up to this count as closed [m].
    projection
        Take the drift out of contacts that stay closed, after each step. Joints are always projected.
    solver
        Any object with ``solve(problem)``; ``Auto()`` and ``Lemke()`` keep the whole loop compiled.

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    step: float
    theta: float = 0.5
    activation: float = 0.5
    gap_tolerance: float = 1e-9
    projection: bool = True
    solver: LcpSolver = field(default_factory=Auto)
    solver_tolerance: float = 1e-9

    def __post_init__(self) -> None:
        in_range("step", self.step, 0.0, math.inf, open_ends=True)
        in_range("theta", self.theta, 0.5, 1.0)
        in_range("activation", self.activation, 0.0, 1.0)
        in_range("gap_tolerance", self.gap_tolerance, 0.0, math.inf)
        in_range("solver_tolerance", self.solver_tolerance, 0.0, math.inf, open_ends=True)
        if not hasattr(self.solver, "solve"):
            raise ModelError(
                f"solver: {self.solver!r} was given, expected an object with solve(problem), such as Auto()"
            )

    def start(self, system: System, duration: float, interval: float) -> MoreauJeanRun:
        """A run over ``duration`` [s] that stores an instant about every ``interval`` [s]."""
        return MoreauJeanRun(system, self, duration, interval)
