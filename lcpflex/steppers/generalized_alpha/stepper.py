"""Nonsmooth generalised-alpha time stepping: order 2 in smooth motion, no drift, high modes damped as asked for.

Smooth motion includes joints, damping, and contacts that rest, slide, roll, or come to stick. Across impacts and where
a slip turns about the order is 1.

A step from (q, u) solves three problems, decoupled from each other:

1. smooth motion: M(q~) w = f(t + h, q~, v~) + J^T lambda_J + W lambda, (1 - alpha_m) a+ + alpha_m a =
   (1 - alpha_f) w + alpha_f w_last, q~ = q + h u + h^2 ((1/2 - beta) a + beta a+), v~ = u + h ((1 - gamma) a +
   gamma a+), with J w + b = 0 and the law of contact and friction at acceleration level for contacts that are closed
   and at rest at the start of the step;
2. position: q+ = q~ + dq with A dq = J^T nu_J + W nu, phi(q+) = 0, 0 <= g(q+) _|_ nu >= 0;
3. velocity: M (u+ - v~) = J^T Lambda_J + W Lambda, J u+ = -dphi/dt, 0 <= gdot_N+ + e_N gdot_N(start) _|_
   h lambda_N + Lambda_N >= 0 and Coulomb friction for h lambda + Lambda, on the pairs that are closed at q+.

The scheme starts anew, a = w = udot(t), where a contact closes, opens, comes to rest or changes its slip.
Sources: Chung & Hulbert 1993; Chen, Acary, Virlez & Bruels 2013; Bruels, Acary & Cardona 2014; Cosimo, Galvez,
Cavalieri, Cardona & Bruels 2020. Contact forces within the smooth motion are our own addition to those.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from lcpflex.basics.options import keep_number, keep_number_or_none
from lcpflex.dynamics.workspace import Workspace
from lcpflex.errors import ModelError, shown
from lcpflex.jit.dispatch import link
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.struct import allocate
from lcpflex.model.arrays import Model
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.contact.compiled import recall_basis, remember_basis, solve_contacts
from lcpflex.solvers.problem import LcpSolver
from lcpflex.solvers.user_solver import as_solver
from lcpflex.steppers.adaptive import AdaptiveStep
from lcpflex.steppers.clock import StepCount
from lcpflex.steppers.driver import Rescue, solver_hooks, solver_method
from lcpflex.steppers.generalized_alpha.adaptive import ControlledGeneralizedAlpha
from lcpflex.steppers.generalized_alpha.memory import (
    VELOCITY,
    AlphaMemory,
    alpha_memory,
    larger,
)
from lcpflex.steppers.generalized_alpha.smooth import AlphaSettings
from lcpflex.steppers.generalized_alpha.step import (
    AGAIN,
    STEPPED,
    correct,
    give_up_smooth,
    predict,
)
from lcpflex.steppers.law_run import refuse_laws
from lcpflex.steppers.moreau_jean.step import grown, record
from lcpflex.steppers.passing import may_pass, set_out_freely
from lcpflex.steppers.recorder import Tape
from lcpflex.steppers.run import Records
from lcpflex.steppers.scales import Scales, given_or, scales_of
from lcpflex.steppers.several_motions import SeveralMotions
from lcpflex.steppers.status import RunStatus
from lcpflex.steppers.step_error import Sampling, carried, half_steps
from lcpflex.steppers.stepping_run import (
    AdaptiveRun,
    FixedRun,
    contact_trouble,
)
from lcpflex.steppers.system import System

__all__ = ["GeneralizedAlpha"]


@kernel
def advance(
    model: Model,
    settings: AlphaSettings,
    start: float,
    clock: StepCount,
    q: FloatArray,
    u: FloatArray,
    work: Workspace,
    memory: AlphaMemory,
    tape: Tape,
    n_steps: int,
    stride: int,
) -> int:
    """At most n_steps steps from the state (q, u), which is stored before each ``stride``-th one.

    clock: steps made; a number that explains the return value; the step last stored. A step that could not be finished
    goes on, at the next call, at the problem where it stopped.
    """
    last = clock.made + n_steps
    while True:
        t = start + clock.made * settings.step
        if memory.between == 1:
            if clock.made % stride == 0 and clock.stored != clock.made:
                if tape.n_instants >= len(tape.times) or tape.n_points + work.n_contacts > len(tape.spots):
                    return RunStatus.TAPE_FULL
                clock.number = record(model, settings.step, t, q, u, work, tape)
                if clock.number > len(tape.table.key):
                    return RunStatus.GROW_TAPE
                clock.stored = clock.made
            if clock.made >= last:
                return RunStatus.DONE
            set_out_freely(model, q, u, settings.step, tape)
        clock.number = predict(model, settings, t, q, u, work, memory)
        if clock.number > len(work.table.key):
            return RunStatus.GROW
        if memory.warm == 1:
            recall_basis(work.problem, work.solver)
        clock.number = solve_contacts(work.problem, work.solver)
        if clock.number != 0 or not work.solver.residual <= settings.tolerance:
            if give_up_smooth(memory):
                continue
            return RunStatus.SOLVER_FAILED
        if memory.phase == VELOCITY:
            remember_basis(work.problem, work.solver)
        status = correct(model, settings, t, q, u, work, memory, tape)
        if status == STEPPED:
            clock.made += 1
            if may_pass(model, q, tape):
                return RunStatus.PASSED
        elif status != AGAIN:
            return status


class GeneralizedAlphaScheme:
    """A generalised-alpha run's state and memory, with steps of one length."""

    within = 0.0
    impulsive = True

    def __init__(self, system: System, settings: AlphaSettings, solver: LcpSolver) -> None:
        self.records = Records(system)
        self.work = system.workspace(16)
        self.work.solver.method = solver_method(solver)
        self.clock = allocate(StepCount, {}, stored=-1)
        self._system, self._settings = system, settings
        self._q, self._u = system.q.copy(), system.u.copy()
        self._memory = alpha_memory(system, 16)
        self.work.span[:] = 0.5 * settings.step  # loads by their mean about the end of a step
        self._rescue = Rescue(solver, settings.tolerance)
        self._several = SeveralMotions()
        self._solving = solver_hooks(self._rescue.solver, system.watch)
        self._advance = link(advance, {**system.hooks, **self._solving})

    @property
    def step(self) -> float:
        """Length of the steps [s]."""
        return self._settings.step

    def loop(self, start: float, n_steps: int, stride: int) -> int:
        """Up to ``n_steps`` steps; see ``advance``."""
        status: int = self._advance(
            self._system.model,
            self._settings,
            start,
            self.clock,
            self._q,
            self._u,
            self.work,
            self._memory,
            self.records.tape,
            n_steps,
            stride,
        )
        return status

    def change_step(self, step: float) -> None:
        """Go on with steps of another length; a stands for udot at t + (alpha_m - alpha_f) h."""
        memory = self._memory
        ratio = step / self._settings.step
        memory.a[:] = memory.w + (memory.a - memory.w) * ratio
        now = memory.start.contact
        memory.recursive[:] = now + (memory.recursive - now) * ratio
        self._settings = self._settings._replace(step=step)
        self.work.span[:] = 0.5 * step
        self.clock.made = self.clock.number = self.clock.stored = 0

    def warn(self, steps: int) -> None:
        """Of steps in which Newton's method did not converge, and of those that might have gone another way."""
        unsettled = int(self._memory.unsettled)
        name = self._system.contact_name
        self.records.warnings[:] = [*self._several.remarks(self.work, name), *self._rescue.remarks(name)]
        if unsettled:
            self.records.warnings.append(
                f"Newton's method on the smooth motion did not converge in {unsettled} of {steps} steps: "
                "a shorter step is needed for the forces of this scene"
            )

    def sampling(self, total: int) -> Sampling | None:
        """What measures the error of some of ``total`` steps; None where an own solver would see it."""
        return None if self._solving else Sampling(self, total)

    def state(self) -> tuple[Any, ...]:
        """All that a step changes, q and u first."""
        return (self._q, self._u, self.clock, *carried(self.work), self._memory)

    def half_steps(self, time: float, done: int, count: int) -> int:
        """``count`` steps of half the length, after ``done`` ones since ``time`` [s]; what the loop returned."""
        return half_steps(self, time, done, count)

    def make_room(self, contacts: int) -> None:
        """Larger memory with the same content."""
        self.work = grown(self._system, self.work, contacts)
        self._memory = larger(self._system, self._memory, contacts)

    def trouble(self, status: int, time: float) -> str:
        """Why the loop cannot go on; empty where it can after all."""
        return contact_trouble(self.work, self._rescue, status, int(self.clock.number), self._settings.tolerance, time)


@dataclass(frozen=True, slots=True)
class GeneralizedAlpha:
    """Nonsmooth generalised-alpha time stepping (decoupled position and velocity problems).

    alpha_m = (2 rho - 1)/(rho + 1), alpha_f = rho/(rho + 1), gamma = 1/2 + alpha_f - alpha_m,
    beta = (gamma + 1/2)^2 / 4 for rho = ``rho_inf``.

    Attributes
    ----------
    step
        Step length h [s], > 0.
    rho_inf
        0 ... 1: by how much modes far above 1/h shrink in a step. 1 conserves the energy of linear elasticity, 0 takes
        such modes out at once. What that takes is part of ``energies.damping``.
    gap_tolerance
        Gaps up to this count as closed [m], > 0: positions are met to rounding.
        None: 1e-9 of the size of the scene (extent of the largest body), or rounding of places.
    velocity_threshold
        A closed contact with a slower normal velocity [m/s] is at rest, one with a slower slip may stick.
        None: 1e-8 of the speed of the scene, the larger of sqrt(gravity size) / pi and the fastest initial speed of
        a body.
    adaptive
        Step control (:class:`AdaptiveStep`); ``step`` is then the first one.
    solver
        One of this package, a function of (M, q) or of (problem) that returns z, or an object with ``solve(problem)``:
        see :class:`lcpflex.solvers.UserSolver`. ``Auto()`` and ``Lemke()`` keep the whole loop compiled.
    solver_tolerance
        Largest natural-map residual accepted.

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    step: float
    rho_inf: float = 0.8
    gap_tolerance: float | None = None
    velocity_threshold: float | None = None
    adaptive: AdaptiveStep | None = None
    solver: LcpSolver = field(default_factory=Auto)
    solver_tolerance: float = 1e-9

    def __post_init__(self) -> None:
        keep_number(self, "step", 0.0, math.inf, open_ends=True)
        keep_number(self, "rho_inf", 0.0, 1.0)
        for name in ("gap_tolerance", "velocity_threshold"):
            keep_number_or_none(self, name, 0.0, math.inf, open_ends=True)
        keep_number(self, "solver_tolerance", 0.0, math.inf, open_ends=True)
        if not isinstance(self.adaptive, AdaptiveStep | None):
            raise ModelError(f"adaptive: {shown(self.adaptive)} was given, expected an AdaptiveStep or None")
        as_solver(self.solver)

    def settings(self, scales: Scales) -> AlphaSettings:
        """The numbers that compiled loops need, in a scene of such scales."""
        alpha_m = (2.0 * self.rho_inf - 1.0) / (self.rho_inf + 1.0)
        alpha_f = self.rho_inf / (self.rho_inf + 1.0)
        gamma = 0.5 + alpha_f - alpha_m
        beta = 0.25 * (gamma + 0.5) ** 2
        return AlphaSettings(
            self.step,
            alpha_m,
            alpha_f,
            gamma,
            beta,
            scales.gap(self.gap_tolerance),
            given_or(self.velocity_threshold, 1e-8 * scales.speed),
            self.solver_tolerance,
            0.0,
            0.0,
        )

    def start(self, system: System, duration: float, interval: float) -> FixedRun | AdaptiveRun:
        """A run over ``duration`` [s] that stores an instant about every ``interval`` [s].

        system: what a scene or a system of the user's own is compiled to.
        """
        refuse_laws(system, "GeneralizedAlpha", "its implicit steps have no derivatives of such laws")
        settings = self.settings(scales_of(system, duration))
        if self.adaptive is None:
            return FixedRun(GeneralizedAlphaScheme(system, settings, self.solver), duration, interval)
        limits = self.adaptive.limits(system, duration, interval)
        return AdaptiveRun(ControlledGeneralizedAlpha(system, settings, limits, self.solver), limits)
