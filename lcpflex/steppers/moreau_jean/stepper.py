"""Moreau-Jean time stepping: velocities and impulses, one contact problem a step, no event location.

With q_m = q + theta h u and A = M(q_m) + theta h C + (theta h)^2 K,

    A (u+ - u) = h f(t_m, q_m, u) + J^T p_J + W p,     q+ = q + h (theta u+ + (1 - theta) u)

and the unilateral law of :mod:`lcpflex.dynamics.impulse` on every pair whose gap at q + activation h u is closed.
Order 1 across impacts; theta = 1/2 conserves the energy of linear elasticity. Of bodies stiffened by spin, f takes the
torque 2 omega q^T G qdot at q, where its mean is zero as it should be, and not at q_m.
Sources: Moreau 1988; Jean 1999; Acary & Brogliato 2008.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from lcpflex.basics.options import keep_flag, keep_number, keep_number_or_none
from lcpflex.dynamics.contact_forces_history import update_history
from lcpflex.dynamics.workspace import Workspace
from lcpflex.errors import ModelError, shown
from lcpflex.jit.dispatch import link
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.struct import allocate
from lcpflex.model.arrays import Model
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.problem import LcpSolver
from lcpflex.solvers.user_solver import as_solver
from lcpflex.steppers.adaptive import AdaptiveStep
from lcpflex.steppers.clock import StepCount
from lcpflex.steppers.driver import Rescue, solver_hooks, solver_method
from lcpflex.steppers.law_run import begin_laws, law_trouble, law_warnings, refuse_states
from lcpflex.steppers.moreau_jean.adaptive import ControlledMoreauJean
from lcpflex.steppers.moreau_jean.step import Settings, grown, record, spots_of, whole_step
from lcpflex.steppers.passing import may_pass, set_out
from lcpflex.steppers.recorder import Tape
from lcpflex.steppers.run import Records
from lcpflex.steppers.scales import Scales, scales_of
from lcpflex.steppers.several_motions import SeveralMotions
from lcpflex.steppers.status import RunStatus
from lcpflex.steppers.step_error import Sampling, carried, half_steps
from lcpflex.steppers.stepping_run import AdaptiveRun, FixedRun, contact_trouble
from lcpflex.steppers.system import System
from lcpflex.steppers.user_functions import watch_pair_laws

__all__ = ["MoreauJean"]


@kernel
def advance(
    model: Model,
    settings: Settings,
    start: float,
    clock: StepCount,
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
    last = clock.made + n_steps
    while True:
        t = start + clock.made * settings.step
        if clock.made % stride == 0 and clock.stored != clock.made:
            if tape.n_instants >= len(tape.times) or tape.n_points + spots_of(work) > len(tape.spots):
                return RunStatus.TAPE_FULL
            clock.number = record(model, settings.step, t, q, u, work, tape)
            if clock.number > len(tape.table.key):
                return RunStatus.GROW_TAPE
            clock.stored = clock.made
        if clock.made >= last:
            return RunStatus.DONE
        set_out(q, tape)
        status = whole_step(model, settings, t, q, u, work, tape, clock)
        if status != RunStatus.DONE:
            return status
        clock.made += 1
        if not update_history(model, t + settings.step, q, u, 0.0, True, work.compliant.states, work):
            return RunStatus.OUT_OF_RANGE
        if may_pass(model, q, tape):
            return RunStatus.PASSED


class MoreauJeanScheme:
    """A Moreau-Jean run's state and memory, with steps of one length."""

    within = 0.0
    impulsive = True

    def __init__(self, system: System, settings: Settings, solver: LcpSolver) -> None:
        self.records = Records(system)
        self.work = system.workspace(16)
        self.work.solver.method = solver_method(solver)
        begin_laws(system, self.work)
        self.records.indentation = self.work.compliant.history.worst
        self.records.missed_friction = self.work.compliant.missed
        self._product = 0.0  # largest sqrt(k G_nn) step of contacts by law
        self.clock = allocate(StepCount, {}, stored=-1)
        self._system, self._settings = system, settings
        self._q, self._u = system.q.copy(), system.u.copy()
        self._rescue = Rescue(solver, settings.tolerance)
        self._average()
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
            self.records.tape,
            n_steps,
            stride,
        )
        return status

    def change_step(self, step: float) -> None:
        """Go on with steps of another length."""
        self._settings = self._settings._replace(step=step)
        self._average()
        self.clock.made = self.clock.number = self.clock.stored = 0

    def _average(self) -> None:
        """Take the mean of loads over a step."""
        theta = self._settings.theta
        self.work.span[:] = theta * self.step, (1.0 - theta) * self.step

    def warn(self, steps: int) -> None:
        """Say so where contacts by law are too stiff for the step, or out of their range."""
        self.records.warnings[:] = [
            *law_warnings(self._system.names, self.work.compliant.history),
            *self._instability(),
            *self._several.remarks(self.work, self._system.contact_name),
            *self._rescue.remarks(self._system.contact_name),
        ]

    def _instability(self) -> list[str]:
        """That forces of contacts by law, explicit in the middle of a step, make the motion grow."""
        frequency, limit = float(self.work.compliant.stiffest), 2.0 / math.sqrt(4.0 * self._settings.theta - 1.0)
        self._product = max(self._product, frequency * self._settings.step)
        if self._product <= limit:
            return []
        return [
            f"the stiffest contact by law has frequency times step = {self._product:.4g} > {limit:.4g}: "
            f"its force is explicit, and unstable there (highest frequency, with damping, {frequency:.4g} rad/s)"
        ]

    def sampling(self, total: int) -> Sampling | None:
        """What measures the error of some of ``total`` steps; None where an own solver would see it."""
        return None if self._solving else Sampling(self, total)

    def state(self) -> tuple[Any, ...]:
        """All that a step changes, q and u first."""
        compliant = (self.work.compliant,) if self._system.by_law else ()
        return (self._q, self._u, self.clock, *carried(self.work), *compliant)

    def half_steps(self, time: float, done: int, count: int) -> int:
        """``count`` steps of half the length, after ``done`` ones since ``time`` [s]; what the loop returned."""
        return half_steps(self, time, done, count)

    def make_room(self, contacts: int) -> None:
        """A larger workspace."""
        self.work = grown(self._system, self.work, contacts)

    def trouble(self, status: int, time: float) -> str:
        """Why the loop cannot go on; empty where it can after all."""
        if status == RunStatus.OUT_OF_RANGE:
            return law_trouble(self._system.names, self.work)
        return contact_trouble(self.work, self._rescue, status, int(self.clock.number), self._settings.tolerance, time)


@dataclass(frozen=True, slots=True)
class MoreauJean:
    """Moreau-Jean time stepping.

    solver_tolerance: largest residual of a contact problem that counts as solved [-].

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
        None: 1e-9 of the size of the scene (extent of the largest body), or rounding of places.
    projection
        Take the drift out of contacts that stay closed, after each step. Joints are always projected.
    adaptive
        Step control (:class:`AdaptiveStep`); ``step`` is then the first one.
    solver
        One of this package, a function of (M, q) or of (problem) that returns z, or an object with ``solve(problem)``:
        see :class:`lcpflex.solvers.UserSolver`. ``Auto()`` and ``Lemke()`` keep the whole loop compiled.

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    step: float
    theta: float = 0.5
    activation: float = 0.5
    gap_tolerance: float | None = None
    projection: bool = True
    adaptive: AdaptiveStep | None = None
    solver: LcpSolver = field(default_factory=Auto)
    solver_tolerance: float = 1e-9

    def __post_init__(self) -> None:
        keep_number(self, "step", 0.0, math.inf, open_ends=True)
        keep_number(self, "theta", 0.5, 1.0)
        keep_number(self, "activation", 0.0, 1.0)
        keep_number_or_none(self, "gap_tolerance", 0.0, math.inf)
        keep_flag(self, "projection")
        keep_number(self, "solver_tolerance", 0.0, math.inf, open_ends=True)
        if not isinstance(self.adaptive, AdaptiveStep | None):
            raise ModelError(f"adaptive: {shown(self.adaptive)} was given, expected an AdaptiveStep or None")
        as_solver(self.solver)

    def settings(self, scales: Scales) -> Settings:
        """The numbers that compiled loops need, in a scene of such scales."""
        gap = scales.gap(self.gap_tolerance)
        return Settings(self.step, self.theta, self.activation, gap, self.projection, self.solver_tolerance, 0.0)

    def start(self, system: System, duration: float, interval: float) -> FixedRun | AdaptiveRun:
        """A run over ``duration`` [s] that stores an instant about every ``interval`` [s].

        system: what a scene or a system of the user's own is compiled to.
        """
        refuse_states(system)
        run: FixedRun | AdaptiveRun
        settings = self.settings(scales_of(system, duration))
        if self.adaptive is None:
            run = FixedRun(MoreauJeanScheme(system, settings, self.solver), duration, interval)
        else:
            limits = self.adaptive.limits(system, duration, interval)
            run = AdaptiveRun(ControlledMoreauJean(system, settings, limits, self.solver), limits)
        watch_pair_laws(run.records, system)
        return run
