"""Moreau-Jean time stepping: velocities and impulses, one contact problem a step, no event location.

With q_m = q + theta h u and A = M(q_m) + theta h C + (theta h)^2 K,

    A (u+ - u) = h f(t_m, q_m, u) + J^T p_J + W p,     q+ = q + h (theta u+ + (1 - theta) u)

and the unilateral law of :mod:`lcpflex.dynamics.impulse` on every pair whose gap at q + activation h u is closed.
Order 1 across impacts; theta = 1/2 conserves the energy of linear elasticity.
Sources: Moreau 1988; Jean 1999; Acary & Brogliato 2008.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from lcpflex.compiled import FloatArray, kernel
from lcpflex.dynamics.impulse import METHOD, recall_basis, remember_basis, solve_lcp
from lcpflex.dynamics.workspace import Workspace
from lcpflex.errors import ModelError, in_range
from lcpflex.model import Model
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.problem import LcpSolver
from lcpflex.steppers.adaptive import AdaptiveStep
from lcpflex.steppers.driver import Rescue, link, solver_hooks, solver_method, unsolved
from lcpflex.steppers.moreau_jean_adaptive import AdaptiveMoreauJeanRun
from lcpflex.steppers.moreau_jean_step import (
    DONE,
    GROW,
    GROW_TAPE,
    NOT_FINITE,
    SOLVER_FAILED,
    TAPE_FULL,
    Settings,
    correct,
    grown,
    predict,
    record,
    stages,
)
from lcpflex.steppers.run import Records
from lcpflex.steppers.system import System
from lcpflex.steppers.tape import Tape

__all__ = ["MoreauJean", "MoreauJeanRun"]


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
            clock[1] = record(model, settings.step, t, q, u, work, tape)
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
        self._settings = stepper.settings()
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
        self._advance = link([*stages(), advance], hooks)

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
                self._work = grown(self.system, self._work, 2 * int(self._clock[1]))
            elif status == SOLVER_FAILED:
                if self._rescue(self._work, self.time):
                    continue
                return unsolved(self._work, int(self._clock[1]), self._settings.tolerance)
            else:
                return "the state is no longer finite: the step is too long for the forces of this scene"


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
    adaptive
        Step control (:class:`AdaptiveStep`); ``step`` is then the first one.
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
    adaptive: AdaptiveStep | None = None
    solver: LcpSolver = field(default_factory=Auto)
    solver_tolerance: float = 1e-9

    def __post_init__(self) -> None:
        in_range("step", self.step, 0.0, math.inf, open_ends=True)
        in_range("theta", self.theta, 0.5, 1.0)
        in_range("activation", self.activation, 0.0, 1.0)
        in_range("gap_tolerance", self.gap_tolerance, 0.0, math.inf)
        in_range("solver_tolerance", self.solver_tolerance, 0.0, math.inf, open_ends=True)
        if not isinstance(self.adaptive, AdaptiveStep | None):
            raise ModelError(f"adaptive: {self.adaptive!r} was given, expected an AdaptiveStep or None")
        if not hasattr(self.solver, "solve"):
            raise ModelError(
                f"solver: {self.solver!r} was given, expected an object with solve(problem), such as Auto()"
            )

    def settings(self) -> Settings:
        """The numbers that compiled loops need."""
        return Settings(
            self.step, self.theta, self.activation, self.gap_tolerance, self.projection, self.solver_tolerance
        )

    def start(self, system: System, duration: float, interval: float) -> MoreauJeanRun | AdaptiveMoreauJeanRun:
        """A run over ``duration`` [s] that stores an instant about every ``interval`` [s]."""
        if self.adaptive is None:
            return MoreauJeanRun(system, self, duration, interval)
        return AdaptiveMoreauJeanRun(system, self.settings(), self.adaptive, self.solver, duration, interval)
