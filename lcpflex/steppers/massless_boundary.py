"""Massless boundary: the highest modes of a body are its contact compliance, the others are advanced explicitly.

Without inertia at the contact there is nothing that could strike: no impulse, no coefficient of restitution. Contact
forces lambda solve a problem at position level (:mod:`lcpflex.dynamics.position`), the rest is velocity Verlet,

    u_h = u + h/2 a,   q+ = q + h u_h,   lambda = lambda(q+),   M a+ = f(t+, q+, u+) + J^T lambda_J + W lambda
    u+ = u_h + h/2 a+

with the joints fulfilled by q+ and by u+ (RATTLE) and modal damping taken at u+. Order 2 as long as contacts stay as
they are, and nearly energy-conserving, as long as h omega < 2 for every omega of the system with its contacts closed.
Source: Monjaraz-Tec, Gross & Krack 2022.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from lcpflex.bodies.body import whole_number
from lcpflex.compiled import FloatArray, kernel
from lcpflex.contact.detection import detect, refresh
from lcpflex.contact.kinematics import contact_point
from lcpflex.dynamics import start
from lcpflex.dynamics.constraint_rows import joint_rows
from lcpflex.dynamics.delassus import apply_impulses, cholesky, cholesky_solve, delassus, row_velocity
from lcpflex.dynamics.impulse import METHOD, recall_basis, remember_basis, solve_lcp
from lcpflex.dynamics.mechanics import energies, factorise, fill_contact_rows, forces, solve_rows, solve_vector, supply
from lcpflex.dynamics.mass_matrix import mass_matrix
from lcpflex.dynamics.position import admissible, pose_position, split_forces, static_response, static_sway
from lcpflex.dynamics.static_modes import (
    check_compliance,
    contact_stiffness,
    flexibilities,
    spring_rates,
    with_static_modes,
)
from lcpflex.dynamics.workspace import Workspace
from lcpflex.errors import ModelError, in_range
from lcpflex.model import SLIP, STICK, Model
from lcpflex.packed import pack
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.problem import LcpSolver
from lcpflex.steppers.driver import Rescue, link, solver_hooks, solver_method, unsolved
from lcpflex.steppers.moreau_jean_step import grown
from lcpflex.steppers.projection import project_joints
from lcpflex.steppers.run import Records
from lcpflex.steppers.system import System
from lcpflex.steppers.tape import Tape, note_contact, store_contacts, store_state

__all__ = ["MasslessBoundary"]

DONE = 0
TAPE_FULL = 1
GROW = 2
GROW_TAPE = 3
SOLVER_FAILED = 4
NOT_FINITE = 5
TOO_LONG = 6
STIFF = 7
STICKING = 1e-9  # part of the largest gap or slip of a problem below which a contact counts as sticking
MOST_PASSES = 6  # of the contact problem in a step, each linearised about the static coordinates of the last
CURVED = 1e-3  # gap left by the linearisation, relative to the static displacement, that ends them
MOST_PARTS = 1000.0  # of a step; beyond, the contacts are all but rigid
LOST = 0.01  # part of the initial energy in static modes above which the result warns
MADE, NUMBER, STORED, WITHIN, BEGUN, PARTS, CLOSED_THEN = 0, 1, 2, 3, 4, 5, 6  # entries of the clock
SPLIT, FINEST, CLOSED = 0, 1, 2  # entries of Boundary.count


class Settings(NamedTuple):
    """Numbers of the scheme, as the compiled loop takes them."""

    step: float
    safety: float
    parts: float  # into which every step is divided, and at the most
    most_parts: float
    gap_tolerance: float
    tolerance: float
    spring: float
    damper: float


class Boundary(NamedTuple):
    """What goes from step to step besides the state."""

    flexibility: FloatArray  # (ndof,) 1/omega^2 of static coordinates, else 0 [s^2]
    acceleration: FloatArray  # (ndof,)
    rate: FloatArray  # (ndof,) of change of the static coordinates, of which contacts are linearised about a guess
    guess: FloatArray  # (ndof,) velocity at which forces are evaluated
    unit: FloatArray  # (2,) of force [N] and of compliance [m/N], of the present problem
    power: FloatArray  # (2,) of dissipative forces, and of loads and drives [W]
    force: FloatArray  # (laws, 2) contact forces [N]
    count: FloatArray  # (3,) steps that were divided, most parts of one, contacts closed


@kernel
def predict(
    model: Model,
    settings: Settings,
    t: float,
    h: float,
    q: FloatArray,
    u: FloatArray,
    boundary: Boundary,
    work: Workspace,
    tape: Tape,
) -> int:
    """q+ in ``work.middle`` and u_h in ``work.free_u``, at time t = end of the step; returns the contacts near."""
    largest = 0.0
    for i in range(len(q)):
        work.free_u[i] = u[i] + 0.5 * h * boundary.acceleration[i]
        work.middle[i] = q[i] + h * (work.free_u[i] + boundary.rate[i])
        work.ahead[i] = work.middle[i]
        largest = max(largest, abs(q[i]))
    if h > 0.0 and len(work.residual) > 0:
        project_joints(model, t, work.middle, work.free_u, work, tape, 1e-12 * (1.0 + largest))
        for i in range(len(q)):
            work.free_u[i] += (work.middle[i] - work.ahead[i]) / h
    sway = static_sway(model, boundary.flexibility, q) + static_sway(model, boundary.flexibility, work.middle)
    return detect(model, work.middle, settings.gap_tolerance + sway, work.table)


@kernel
def hold_joints(model: Model, t: float, h: float, boundary: Boundary, work: Workspace) -> float:
    """Change the acceleration such that u_h + h/2 a fulfils the joints; power of the drives [W].

    Without a step (h = 0) the acceleration itself fulfils them.
    """
    n_joint = len(work.residual)
    if n_joint == 0:
        return 0.0
    a = boundary.acceleration
    joint_rows(model, t, work.middle, boundary.guess, work.external, work.rows, work.row_body, work.rate, work.bias)
    solve_rows(model, work, 0, n_joint)
    delassus(work.rows, work.solved, work.row_body, n_joint, work.G)
    cholesky(work.G, n_joint, work.lower)
    for j in range(n_joint):
        work.p[j] = -row_velocity(work.rows, work.row_body, j, work.dof, a)
        if h > 0.0:
            velocity = row_velocity(work.rows, work.row_body, j, work.dof, work.free_u)
            work.p[j] -= 2.0 / h * (velocity + work.rate[j])
        else:
            work.p[j] -= work.bias[j]
    cholesky_solve(work.lower, n_joint, work.p)
    apply_impulses(work.solved, work.row_body, 0, n_joint, work.p, work.dof, a)
    power = 0.0
    for j in range(n_joint):
        power -= work.p[j] * work.rate[j]
    return power


@kernel
def accelerate(model: Model, t: float, h: float, boundary: Boundary, work: Workspace) -> float:
    """a+ at ``work.middle`` under all forces but those of joints; modal damping is implicit.

    Velocities for the forces: u_h + h/2 a, to second order; the diagonal of the damping acts on u+ itself.
    """
    a = boundary.acceleration
    guess = boundary.guess
    for i in range(len(a)):
        guess[i] = work.free_u[i] + 0.5 * h * a[i]
    supply(model, t, work.middle, guess, work)
    forces(model, t, work.middle, guess, work)
    factorise(model, work.middle, 0.5 * h, 0.0, work)
    for i in range(len(a)):
        a[i] = work.total[i]
    for b in range(len(model.bodies.mass)):
        for k in range(work.dof[b] + 3, work.dof[b + 1]):
            a[k] += model.bodies.damping[k - 3 * (b + 1)] * (guess[k] - work.free_u[k])
    n_joint = len(work.residual)
    total = n_joint + work.step_size[1] + work.step_size[2]
    apply_impulses(work.rows, work.row_body, n_joint, total, work.p, work.dof, a)
    for i in range(len(a)):
        if boundary.flexibility[i] > 0.0:
            a[i] = 0.0
    solve_vector(model, work, a)
    drives = hold_joints(model, t, h, boundary, work)
    return drives


@kernel
def audit(h: float, drives: float, u: FloatArray, boundary: Boundary, work: Workspace, tape: Tape) -> None:
    """Add the step's work by kind, and its impulses, to the tape; trapezoidal in time, as Verlet's own balance is.

    Friction: the mean of the forces at both ends times the slip, which is exact for the contact compliance.
    """
    lost = 0.0
    for i in range(len(u)):
        lost -= work.dissipative[i] * u[i]
        drives += work.driving[i] * u[i]
    tape.sums[2] += 0.5 * h * (boundary.power[0] + lost)
    tape.sums[3] += 0.5 * h * (boundary.power[1] + drives)
    boundary.power[0] = lost
    boundary.power[1] = drives
    for law in range(len(boundary.force)):
        for i in range(2):
            tape.total_impulse[law, i] += 0.5 * h * boundary.force[law, i]
            boundary.force[law, i] = 0.0
    n = work.step_size[1]
    for k in range(n):
        boundary.force[work.table.law[k], 0] += work.normal[k]
    length = boundary.unit[0] * boundary.unit[1]
    held = work.step_size[4]
    for j in range(work.step_size[2]):
        k = work.tangent[j]
        boundary.force[work.table.law[k], 1] += work.tangential[j]
        before = 0.0
        for i in range(held):
            if work.held_key[0, i] == work.table.key[k]:
                before = work.held_gap[0, i]
        work.held_key[1, j] = work.table.key[k]
        work.held_gap[1, j] = work.tangential[j]
        if h > 0.0 and (before != 0.0 or work.tangential[j] != 0.0):
            tape.sums[0] -= 0.5 * (before + work.tangential[j]) * slip_of(work, n + j) * length
    work.step_size[4] = work.step_size[2]
    for j in range(work.step_size[2]):
        work.held_key[0, j] = work.held_key[1, j]
        work.held_gap[0, j] = work.held_gap[1, j]
    for law in range(len(boundary.force)):
        for i in range(2):
            tape.total_impulse[law, i] += 0.5 * h * boundary.force[law, i]
    tape.worst[0] = max(tape.worst[0], work.certificate[0])
    tape.worst[3] = max(tape.worst[3], work.step_size[3])
    tape.worst[4] = max(tape.worst[4], work.certificate[1])


@kernel
def slip_of(work: Workspace, r: int) -> float:
    """Slip of a step on contact row r, in the unit of the problem."""
    n = work.step_size[1]
    m = work.step_size[2]
    slip = work.q[r]
    for s in range(n + m):
        slip += work.M[r, s] * work.z[s]
    return slip


@kernel
def correct(
    model: Model,
    t: float,
    h: float,
    q: FloatArray,
    u: FloatArray,
    boundary: Boundary,
    work: Workspace,
    tape: Tape,
) -> bool:
    """Forces, accelerations and the state at the end t of the step, in place. False where they are not finite."""
    # rows of the deformed surfaces: with others, forces do work that is not stored
    fill_contact_rows(model, work.middle, work.step_size[1], len(work.residual), work)
    boundary.count[CLOSED] = 0.0
    for k in range(work.step_size[1]):
        tape.worst[1] = max(tape.worst[1], -work.table.gap[k])
        if work.normal[k] > 0.0:
            boundary.count[CLOSED] += 1.0
    drives = accelerate(model, t, h, boundary, work)
    finite = True
    for i in range(len(q)):
        boundary.rate[i] = 0.0
        if boundary.flexibility[i] > 0.0 and h > 0.0 and boundary.count[CLOSED] > 0.0:
            boundary.rate[i] = (work.middle[i] - q[i]) / h
        q[i] = work.middle[i]
        u[i] = work.free_u[i] + 0.5 * h * boundary.acceleration[i]
        finite = finite and math.isfinite(q[i] + u[i])
    audit(h, drives, u, boundary, work, tape)
    return finite


@kernel
def record(
    model: Model, t: float, q: FloatArray, u: FloatArray, boundary: Boundary, work: Workspace, tape: Tape
) -> int:
    """Store the present instant with its contact forces."""
    needed = store_contacts(model, q, tape)
    if needed > len(tape.table.key):
        return needed
    n = work.step_size[1]
    tangent = 0
    for k in range(n):
        force_t = 0.0
        slip = 1.0
        if tangent < work.step_size[2] and work.tangent[tangent] == k:
            force_t = work.tangential[tangent]
            slip = slip_of(work, n + tangent)
            tangent += 1
        if work.normal[k] > 0.0:
            state = STICK if abs(slip) <= STICKING else SLIP
            place = contact_point(model, q, work.table, k)
            note_contact(tape, work.table.law[k], place, work.table.normal[k], work.normal[k], force_t, state)
    kinetic, elastic, potential = energies(model, q, u, work)
    store_state(tape, t, q, u, kinetic, elastic, potential)
    return needed


@kernel
def part_length(settings: Settings, boundary: Boundary, work: Workspace, clock: FloatArray) -> float:
    """Length of the next part of the step [s]; 0 for the start, which only finds forces.

    A step is divided anew whenever another number of contacts is closed.
    """
    if clock[BEGUN] == 0.0:
        return 0.0
    if clock[WITHIN] == 0.0 and boundary.count[CLOSED] != clock[CLOSED_THEN]:
        clock[PARTS] = settings.parts
    clock[CLOSED_THEN] = boundary.count[CLOSED]
    remaining = settings.step - clock[WITHIN]
    return remaining / max(1.0, math.ceil(remaining / settings.step * clock[PARTS] - 1e-9))


@kernel
def deform(model: Model, boundary: Boundary, work: Workspace) -> float:
    """Static coordinates by the solution; gap that the curvature of the geometry leaves in closed contacts.

    Relative to the largest static displacement of them.
    """
    split_forces(work, boundary.unit)
    static_response(work, boundary.flexibility, work.middle)
    left = 0.0
    displaced = 0.0
    for k in range(work.step_size[1]):
        refresh(model, work.middle, work.table, k)
        if work.normal[k] > 0.0:
            left = max(left, abs(work.table.gap[k]))
            displaced = max(displaced, boundary.unit[1] * work.Gc[k, k] * work.normal[k])
    return left / displaced if displaced > 0.0 else 0.0


@kernel
def short_enough(model: Model, settings: Settings, h: float, boundary: Boundary, work: Workspace) -> bool:
    """Whether the scheme is stable with steps h [s] and the contacts that the present problem closes."""
    square = (2.0 * settings.safety / h) ** 2 - settings.spring
    if square <= 0.0 or h * settings.damper > settings.safety:
        return False
    return admissible(model, work.middle, square, boundary.flexibility, boundary.unit, work)


@kernel
def advance(
    model: Model,
    settings: Settings,
    start: float,
    clock: FloatArray,
    q: FloatArray,
    u: FloatArray,
    boundary: Boundary,
    work: Workspace,
    tape: Tape,
    n_steps: int,
    stride: int,
) -> int:
    """At most n_steps steps from the state (q, u), which is stored before each ``stride``-th one.

    clock: steps made; a number that explains the return value; the step last stored; time made of the present step;
    whether forces are known; the parts of a step; contacts closed when that was chosen. Returns DONE, or why the next
    step or record could not be made; the state is then that of the last whole part of a step (but NOT_FINITE).
    """
    last = clock[MADE] + n_steps
    while True:
        t = start + clock[MADE] * settings.step + clock[WITHIN]
        if clock[BEGUN] > 0.0 and clock[WITHIN] == 0.0:
            if clock[MADE] % stride == 0 and clock[STORED] != clock[MADE]:
                if tape.filled[0] >= len(tape.times) or tape.filled[1] + work.step_size[1] > len(tape.spots):
                    return TAPE_FULL
                clock[NUMBER] = record(model, t, q, u, boundary, work, tape)
                if clock[NUMBER] > len(tape.table.key):
                    return GROW_TAPE
                clock[STORED] = clock[MADE]
            if clock[MADE] >= last:
                return DONE
        h = part_length(settings, boundary, work, clock)
        clock[NUMBER] = predict(model, settings, t + h, h, q, u, boundary, work, tape)
        if clock[NUMBER] > len(work.table.key):
            return GROW
        n = int(clock[NUMBER])
        for _ in range(MOST_PASSES):
            clock[NUMBER] = pose_position(model, h, n, q, boundary.flexibility, boundary.unit, work)
            if clock[NUMBER] >= 0.0:
                return STIFF
            recall_basis(work)
            clock[NUMBER] = solve_lcp(work)
            if clock[NUMBER] != 0 or not work.certificate[0] <= settings.tolerance:
                return SOLVER_FAILED
            remember_basis(work)
            if deform(model, boundary, work) <= CURVED:
                break
        if h > 0.0 and not short_enough(model, settings, h, boundary, work):
            if clock[PARTS] >= settings.most_parts:
                return TOO_LONG
            clock[PARTS] = min(math.ceil(1.1 * clock[PARTS] + 0.1), settings.most_parts)
            continue
        if not correct(model, t + h, h, q, u, boundary, work, tape):
            return NOT_FINITE
        if h == 0.0:
            clock[BEGUN] = 1.0
        elif clock[WITHIN] + h >= settings.step * (1.0 - 1e-9):
            if clock[PARTS] > 1.0:
                boundary.count[SPLIT] += 1.0
                boundary.count[FINEST] = max(boundary.count[FINEST], clock[PARTS])
            clock[MADE] += 1.0
            clock[WITHIN] = 0.0
        else:
            clock[WITHIN] += h


class MasslessBoundaryRun:
    """A run in progress (see :class:`MasslessBoundary`)."""

    def __init__(self, system: System, stepper: MasslessBoundary, duration: float, interval: float) -> None:
        _refuse(system)
        flexibility = flexibilities(system.model, stepper.dynamic_modes)
        model = with_static_modes(system.model, flexibility)
        check_compliance(model, flexibility, system.q)
        self.system = replace(system, model=model, q=system.q.copy(), u=np.where(flexibility > 0.0, 0.0, system.u))
        self.records = Records(self.system)
        self._work = self.system.workspace(16)
        self._work.solving[METHOD] = solver_method(stepper.solver)
        self._notes = _lost(system, flexibility)
        self.q, self.u = _consistent(self.system, self._work)
        self.duration = duration
        self._asked = stepper.step
        self._settings = _settings(model, flexibility, stepper, duration / 1000.0)
        self._boundary = _boundary(flexibility, system.n_laws)
        self._rescue = Rescue(stepper.solver, stepper.solver_tolerance)
        step = self._settings.step
        whole = math.floor(duration / step * (1.0 + 1e-12) + 1e-9)
        rest = duration - whole * step
        self._phases = [(step, whole)] + ([(rest, 1)] if rest > 1e-9 * step else [])
        self._stride = max(1, round(interval / step))
        self._start = 0.0
        self._clock = np.array([0.0, 0.0, -1.0, 0.0, 0.0, self._settings.parts, 0.0])
        self._made = 0
        hooks = {**system.hooks, **solver_hooks(stepper.solver, system.watch)}
        parts: list[Callable[..., Any]] = [project_joints, predict, accelerate, correct]
        self._advance = link([*parts, advance], hooks)

    @property
    def time(self) -> float:
        """Time reached [s]."""
        if not self._phases:
            return self.duration
        return self._start + float(self._clock[MADE]) * self._settings.step + float(self._clock[WITHIN])

    @property
    def steps(self) -> int:
        """Steps made."""
        return self._made + int(self._clock[MADE])

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
        """The scheme locates no events."""
        return []

    def advance(self, n_steps: int) -> str:
        """Make up to ``n_steps`` steps; empty where all went well, else why the run cannot go on."""
        step, whole = self._phases[0]
        message = self._loop(min(n_steps, whole - int(self._clock[MADE])), self._stride)
        if message or self._clock[MADE] < whole:
            return message
        if len(self._phases) == 1:
            message = self._loop(0, 1)  # the end is stored even where the stride would skip it
        else:  # a last, shorter step ends the run on its duration
            self._made += whole
            self._start += whole * step
            self._settings = self._settings._replace(step=self._phases[1][0])
            self._clock[:5] = (0.0, 0.0, 0.0, 0.0, 1.0)
        if not message:
            self._phases.pop(0)
        return message

    def _loop(self, n_steps: int, stride: int) -> str:
        target = self._clock[MADE] + n_steps
        while True:
            status = self._advance(
                self.system.model,
                self._settings,
                self._start,
                self._clock,
                self.q,
                self.u,
                self._boundary,
                self._work,
                self.records.tape,
                int(target - self._clock[MADE]),
                stride,
            )
            number = int(self._clock[NUMBER])
            self.records.warnings[:] = [*self._notes, *self._divided()]
            if status == DONE:
                return ""
            if status == TAPE_FULL:
                self.records.empty()
            elif status == GROW_TAPE:
                self.records.grow(number)
            elif status == GROW:
                self._work = grown(self.system, self._work, 2 * number)
            elif status == SOLVER_FAILED:
                if self._rescue(self._work, self.time):
                    continue
                return (
                    f"{unsolved(self._work, number, self._settings.tolerance)}; if more contacts close at a time than "
                    "there are static modes, lower dynamic_modes or reduce the bodies to more modes"
                )
            elif status == STIFF:
                return (
                    f"contact number {self._work.table.law[number] + 1} closes in a direction in which neither body "
                    "has any compliance: use more modes, or MoreauJean or EventDriven"
                )
            elif status == TOO_LONG:
                return self._too_long()
            else:
                return "the state is no longer finite: the step is too long for the forces of this scene"

    def _divided(self) -> list[str]:
        split, finest = int(self._boundary.count[SPLIT]), int(self._boundary.count[FINEST])
        if self._asked is None or split == 0:
            return []
        return [
            f"{split} of {self.steps} steps were divided, into up to {finest} parts: with its contacts closed the "
            f"system has frequencies beyond the limit 2/h of the step h = {self._asked:g} s"
        ]

    def _too_long(self) -> str:
        """What step the posed problem admits, by bisection."""
        low, high = 0.0, self._settings.step
        for _ in range(50):
            h = 0.5 * (low + high)
            if short_enough(self.system.model, self._settings, h, self._boundary, self._work):
                low = h
            else:
                high = h
        parts = int(self._settings.most_parts)
        return (
            f"the step {self._settings.step:g} s is too long for the system with the contacts that close now, which "
            f"admits {low:.6g} s (with safety {self._settings.safety:g}): shorten it, "
            + ("allow substeps, " if parts == 1 else f"for {parts} parts are the most, ")
            + "or keep fewer dynamic modes"
        )


@dataclass(frozen=True, slots=True)
class MasslessBoundary:
    """Massless-boundary scheme: no impulse, no restitution, the energy of a contact goes into the modes.

    Attributes
    ----------
    step
        Step length h [s], > 0. None: ``safety`` times the limit of the system with one contact closed, as estimated
        at the start.
    dynamic_modes
        Number of lowest modes that keep their mass, of each body with a contact; those above are its compliance at
        contacts. None: half of its modes, rounded down. Fewer allow longer steps; 1/omega^2 of the modes above them
        must hold enough compliance for all the contacts of the body that close together.
    substeps
        Divide steps that the stability limit 2/omega does not admit, where omega is the highest frequency of the
        system with its contacts closed as they are. False: stop instead, with the admissible step.
    safety
        In (0, 1]: part of that limit that a step may use.
    gap_tolerance
        Gaps up to this, besides those within reach of the static modes, enter the contact problem [m].
    solver
        Any object with ``solve(problem)``; ``Auto()`` and ``Lemke()`` keep the whole loop compiled.

    Raises
    ------
    ModelError
        For a number out of its range; when a run is started: for a user's own system (it has no modes), a contact with
        restitution (here it is a result), a contact without compliance, and dynamic_modes that leave no static mode.
    """

    step: float | None = None
    dynamic_modes: int | None = None
    substeps: bool = True
    safety: float = 0.3
    gap_tolerance: float = 1e-9
    solver: LcpSolver = field(default_factory=Auto)
    solver_tolerance: float = 1e-9

    def __post_init__(self) -> None:
        if self.step is not None:
            in_range("step", self.step, 0.0, math.inf, open_ends=True)
        if self.dynamic_modes is not None:
            whole_number("dynamic_modes", self.dynamic_modes, 0)
        if not isinstance(self.substeps, bool):
            raise ModelError(f"substeps: {self.substeps!r} was given, expected True or False")
        in_range("safety", self.safety, 1e-3, 1.0)
        in_range("gap_tolerance", self.gap_tolerance, 0.0, math.inf)
        in_range("solver_tolerance", self.solver_tolerance, 0.0, math.inf, open_ends=True)
        if not hasattr(self.solver, "solve"):
            raise ModelError(
                f"solver: {self.solver!r} was given, expected an object with solve(problem), such as Auto()"
            )

    def start(self, system: System, duration: float, interval: float) -> MasslessBoundaryRun:
        """A run over ``duration`` [s] that stores an instant about every ``interval`` [s]."""
        return MasslessBoundaryRun(system, self, duration, interval)


def _refuse(system: System) -> None:
    """Raise ModelError for what the scheme cannot be asked."""
    if system.dense:
        raise ModelError(
            "stepper: MasslessBoundary was given for a user's own system, which has no modes that could give way; "
            "expected MoreauJean or EventDriven"
        )
    contacts = system.model.contacts
    for name in ("restitution", "tangential_restitution"):
        values = getattr(contacts, name)
        if values.size and values.max() > 0.0:
            raise ModelError(
                f"{name}: contact number {int(values.argmax()) + 1} in the order of declaration has {values.max():g}, "
                "expected 0: with a massless boundary nothing is reflected by a law, the rebound is a result; use "
                "MoreauJean or EventDriven for a coefficient"
            )


def _lost(system: System, flexibility: FloatArray) -> list[str]:
    """A warning where the initial state holds much of its energy in modes that are static from now on."""
    static = flexibility > 0.0
    K = np.zeros(len(system.q))
    dof = system.model.bodies.dof
    elastic = np.concatenate([np.arange(a + 3, b) for a, b in pairwise(dof)])
    K[elastic] = system.model.bodies.stiffness
    u = system.u
    stored = 0.5 * (float(K @ system.q**2) + float(u @ mass_matrix(system.model, system.q) @ u))
    lost = 0.5 * (float(K[static] @ system.q[static] ** 2) + float(u[static] @ u[static]))
    if lost <= LOST * stored:
        return []
    return [
        f"{lost:.4g} J of the initial {stored:.4g} J of motion and deformation are in modes that are static here, "
        "which follow the contact forces instead: keep more dynamic modes"
    ]


def _consistent(system: System, work: Workspace) -> tuple[FloatArray, FloatArray]:
    """The initial state that fulfils the joints without the static modes."""
    q, u = system.q.copy(), system.u.copy()
    if system.n_joint == 0:
        return q, u
    if "supply" in system.hooks:
        system.hooks["supply"](system.model, 0.0, q, u, work)
    scale = 1.0 + float(np.abs(q).max())
    return start.project(system.model, q, u, work.external, np.full(system.n_joint, 1e-12 * scale))


def _settings(model: Model, flexibility: FloatArray, stepper: MasslessBoundary, longest: float) -> Settings:
    """The numbers of the loop; ``longest``: the step where nothing else limits it."""
    spring, damper = spring_rates(model)
    static = flexibility[np.concatenate([np.arange(a + 3, b) for a, b in pairwise(model.bodies.dof)])] > 0.0
    highest = float(np.max(model.bodies.stiffness[~static], initial=0.0))
    step = stepper.step
    if step is None:
        step = longest
        if (square := spring + highest + contact_stiffness(model, flexibility)) > 0.0:
            step = min(step, 2.0 * stepper.safety / math.sqrt(square))
        if damper > 0.0:
            step = min(step, stepper.safety / damper)
    parts = step * max(0.5 * math.sqrt(spring + highest), damper) / stepper.safety
    return Settings(
        step=step,
        safety=stepper.safety,
        parts=float(min(max(1, math.ceil(parts)), MOST_PARTS)) if stepper.substeps else 1.0,
        most_parts=MOST_PARTS if stepper.substeps else 1.0,
        gap_tolerance=stepper.gap_tolerance,
        tolerance=stepper.solver_tolerance,
        spring=spring,
        damper=damper,
    )


def _boundary(flexibility: FloatArray, n_laws: int) -> Boundary:
    n = len(flexibility)
    return pack(
        Boundary(
            flexibility=np.array(flexibility),
            acceleration=np.zeros(n),
            rate=np.zeros(n),
            guess=np.zeros(n),
            unit=np.ones(2),
            power=np.zeros(2),
            force=np.zeros((n_laws, 2)),
            count=np.zeros(3),
        )
    )
