"""Massless boundary: the highest modes of a body are its contact compliance, the others are advanced explicitly.

Without inertia at the contact there is nothing that could strike: no impulse, no coefficient of restitution. Contact
forces lambda solve a problem at position level (:mod:`lcpflex.dynamics.position`), the rest is velocity Verlet,

    u_h = u + h/2 a,   q+ = q + h u_h,   lambda = lambda(q+),   M a+ = f(t+, q+, u+) + J^T lambda_J + W lambda
    u+ = u_h + h/2 a+

with the joints fulfilled by q+ and by u+ (RATTLE) and modal damping taken at u+. Order 2 as long as contacts stay as
they are, and nearly energy-conserving, as long as h omega < 2 for every omega of the system with its contacts closed.
A contact may give way by an elastic law of its own, too (:mod:`lcpflex.dynamics.contact_compliance`): then rigid bodies
may take part.
Source: Monjaraz-Tec, Gross & Krack 2022.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np

from lcpflex.basics.options import keep_flag, keep_number, keep_number_or_none
from lcpflex.bodies.body import whole_number
from lcpflex.dynamics import start
from lcpflex.dynamics.contact_compliance import contact_compliance
from lcpflex.dynamics.mass_matrix import mass_matrix
from lcpflex.dynamics.mechanics import supply
from lcpflex.dynamics.static_modes import (
    check_compliance,
    contact_stiffness,
    flexibilities,
    spring_rates,
    with_static_modes,
)
from lcpflex.dynamics.workspace import Workspace
from lcpflex.errors import ModelError
from lcpflex.force_laws.layout import ElasticLaw
from lcpflex.jit.dispatch import link
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import allocate
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.problem import LcpSolver
from lcpflex.solvers.user_solver import as_solver
from lcpflex.steppers.clock import StepCount
from lcpflex.steppers.driver import Rescue, solver_hooks, solver_method
from lcpflex.steppers.law_run import law_warnings, refuse_laws, too_deep
from lcpflex.steppers.massless_boundary.compliance import (
    checked_compliance,
    compliance_rows,
    expected_compliance,
)
from lcpflex.steppers.massless_boundary.memory import Settings, boundary_of
from lcpflex.steppers.massless_boundary.step import (
    MOST_PARTS,
    advance,
    short_enough,
)
from lcpflex.steppers.moreau_jean.step import grown
from lcpflex.steppers.run import Records
from lcpflex.steppers.scales import scales_of
from lcpflex.steppers.status import RunStatus
from lcpflex.steppers.step_error import Sampling, half_steps
from lcpflex.steppers.stepping_run import FixedRun, contact_trouble
from lcpflex.steppers.system import System

__all__ = ["MasslessBoundary"]

SHORTEST = 1e-4  # part of a step: contacts that need a shorter one have next to no compliance of their own
SEVERAL = 0.7  # of the step that one closed contact admits: several that close have higher frequencies
FINER = 16.0  # steps where a law alone gives way: its contact lasts 4/omega, and no mode has a shorter period
LOST = 0.01  # part of the initial energy in static modes above which the result warns


class MasslessBoundaryScheme:
    """A run's state and memory (see :class:`MasslessBoundary`)."""

    impulsive = False

    def __init__(self, system: System, stepper: MasslessBoundary, duration: float) -> None:
        _refuse(system)
        self._compliance = contact_compliance(
            system.model.contacts, compliance_rows(stepper.compliance, system.names, system.n_laws)
        )
        soft = self._compliance.soft
        flexibility = flexibilities(system.model, stepper.dynamic_modes, soft, system.contact_modes)
        _refuse_shortening(system.model, flexibility)
        model = with_static_modes(system.model, flexibility)
        check_compliance(model, flexibility, system.q, soft, system.contact_name)
        u = np.where(flexibility > 0.0, 0.0, system.u)
        gives = tuple(soft.tolist()) if soft.any() and not soft.all() else ()
        self._system = replace(system, model=model, q=system.q.copy(), u=u, soft=gives)
        self.records = Records(self._system)
        self.records.by_law = tuple(name for name in system.names if name in stepper.compliance)
        self.work = self._system.workspace(16)
        self.work.solver.method = solver_method(stepper.solver)
        self._notes = _lost(system, flexibility)
        self._q, self._u = _consistent(self._system, self.work)
        self._asked = stepper.step
        give = expected_compliance(self._system, self._compliance)
        gap = scales_of(system, duration).gap(stepper.gap_tolerance)
        self._settings = _settings(model, flexibility, give, stepper, duration / 1000.0, gap)
        self.work.span[:] = 0.5 * self._settings.step  # loads by their mean about the end of a step
        self._boundary = boundary_of(flexibility, self._compliance)
        self._rescue = Rescue(stepper.solver, stepper.solver_tolerance)
        self.clock = allocate(StepCount, {}, stored=-1, parts=self._settings.parts)
        self._solving = solver_hooks(self._rescue.solver, system.watch)
        self._advance = link(advance, {**system.hooks, **self._solving})

    @property
    def step(self) -> float:
        """Length of the steps [s]."""
        return self._settings.step

    @property
    def within(self) -> float:
        """Time made of the present step [s]."""
        return self.clock.within

    def loop(self, start: float, n_steps: int, stride: int) -> int:
        """Up to ``n_steps`` steps; see ``advance``."""
        last = self.clock.made + n_steps
        while True:
            status: int = self._advance(
                self._system.model,
                self._settings,
                start,
                self.clock,
                self._q,
                self._u,
                self._boundary,
                self.work,
                self.records.tape,
                int(last - self.clock.made),
                stride,
            )
            if status != RunStatus.PASSED:
                return status
            time = start + self.clock.made * self.step + self.within
            self.records.examine(time, self.step / self.clock.parts)  # it is a part that passed

    def change_step(self, step: float) -> None:
        """Go on with steps of another length; its forces are known: it begins where the steps so far ended."""
        self._settings = self._settings._replace(step=step)
        self.work.span[:] = 0.5 * step
        self.clock.made = self.clock.number = self.clock.stored = 0
        self.clock.within = 0.0

    def sampling(self, total: int) -> Sampling | None:
        """What measures the error of some of ``total`` steps; None where an own solver would see it."""
        return None if self._solving else Sampling(self, total)

    def state(self) -> tuple[Any, ...]:
        """All that a step changes, q and u first."""
        return (self._q, self._u, self.clock, self.work, self._boundary)

    def half_steps(self, time: float, done: int, count: int) -> int:
        """``count`` steps of half the length, after ``done`` ones since ``time`` [s]; what the loop returned."""
        return half_steps(self, time, done, count)

    def make_room(self, contacts: int) -> None:
        """A larger workspace."""
        self.work = grown(self._system, self.work, contacts)

    def trouble(self, status: int, time: float) -> str:
        """Why the loop cannot go on; empty where it can after all."""
        number = int(self.clock.number)
        if status == RunStatus.STIFF:
            return (
                f"contact {self._system.contact_name(self.work.table.law[number])} closes in a direction in which "
                "neither body has any compliance: use more modes, or MoreauJean or EventDriven"
            )
        if status == RunStatus.TOO_LONG:
            return self._limit()
        if status == RunStatus.OUT_OF_RANGE:
            return too_deep(self._system.names, self._compliance.history, number)
        if status == RunStatus.UNSETTLED:
            return RunStatus.UNSETTLED.sentence
        message = contact_trouble(self.work, self._rescue, status, number, self._settings.tolerance, time)
        if message and status == RunStatus.SOLVER_FAILED:
            message += (
                "; if more contacts close at a time than there are static modes, lower dynamic_modes or reduce the "
                "bodies to more modes"
            )
        return message

    def warn(self, steps: int) -> None:
        """Of what the start lost, and of steps that were divided."""
        outside = law_warnings(self._system.names, self._compliance.history)
        wedged = self._rescue.remarks(self._system.contact_name)
        self.records.warnings[:] = [*self._notes, *outside, *self._divided(steps), *wedged]

    def _divided(self, steps: int) -> list[str]:
        split, finest = self._boundary.n_split, int(self._boundary.finest)
        if self._asked is None or split == 0:
            return []
        return [
            f"{split} of {steps} steps were divided, into up to {finest} parts: with its contacts closed the "
            f"system has frequencies beyond the limit 2/h of the step h = {self._asked:g} s"
        ]

    def _limit(self) -> str:
        """What step the posed problem admits, by bisection."""
        low, high = 0.0, self._settings.step
        for _ in range(50):
            h = 0.5 * (low + high)
            if short_enough(self._system.model, self._settings, h, self._boundary, self.work):
                low = h
            else:
                high = h
        if low < SHORTEST * self._settings.step:
            return (
                "the contacts that close now have too little compliance for any step: their bodies have fewer static "
                "modes than these contacts have closed normal and sticking tangential directions; lower "
                "dynamic_modes, or reduce the bodies to more modes"
            )
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

    solver_tolerance: largest residual of a contact problem that counts as solved [-].

    Attributes
    ----------
    step
        Step length h [s], > 0. None: 0.7 ``safety`` times the limit of the system with one contact closed, as estimated
        at the start, and at most a thousandth of the duration.
    dynamic_modes
        Number of lowest modes that keep their mass, of each body with a contact; those above are its compliance at
        contacts. None: all modes that were asked for, where the body has residual modes for its contacts besides, as
        ``scene.add(body, modes=8)`` gives it; half of its modes, rounded down, where it has none. Fewer allow longer
        steps; 1/omega^2 of the modes above them must hold enough compliance for all the contacts of the body that
        close together.
    substeps
        Divide steps that the stability limit 2/omega does not admit, where omega is the highest frequency of the
        system with its contacts closed as they are. False: stop instead, with the admissible step.
    safety
        In (0, 1]: part of that limit that a step may use. Stable up to 1 with contacts that stay closed or open; one
        that closes or opens within a step changes the energy by order (h omega)^2. Sliding friction is not in it.
    gap_tolerance
        Gaps up to this, besides those within reach of the static modes, enter the contact problem [m].
        None: 1e-9 of the size of the scene (extent of the largest body), or rounding of places.
    solver
        One of this package, a function of (M, q) or of (problem) that returns z, or an object with ``solve(problem)``:
        see :class:`lcpflex.solvers.UserSolver`. ``Auto()`` and ``Lemke()`` keep the whole loop compiled.
    compliance
        Elastic laws of contacts that give way by themselves besides what their bodies do, by the name of the declared
        contact: ``{"ball": Hertz.sphere_on_plane(...)}``. Their energy counts as elastic, and indentations as
        penetration. Bodies of such contacts need no static mode: they may be rigid, or all their modes dynamic. Along
        the normal only: friction needs a tangential compliance of the bodies.

    Raises
    ------
    ModelError
        For a number out of its range; when a run is started: for a user's own system (it has no modes), a contact with
        restitution (here it is a result), a contact without compliance, dynamic_modes that leave no static mode, and a
        compliance that is no elastic law, or of a name that no declared contact has.
    """

    step: float | None = None
    dynamic_modes: int | None = None
    substeps: bool = True
    safety: float = 0.3
    gap_tolerance: float | None = None
    solver: LcpSolver = field(default_factory=Auto)
    solver_tolerance: float = 1e-9
    compliance: Mapping[str, ElasticLaw] = field(default_factory=dict, hash=False)
    gives_way: ClassVar[bool] = True  # bodies do so at every contact: reduced with their scene, they get modes for it

    def __post_init__(self) -> None:
        if self.step is not None:
            keep_number(self, "step", 0.0, math.inf, open_ends=True)
        if self.dynamic_modes is not None:
            object.__setattr__(self, "dynamic_modes", whole_number("dynamic_modes", self.dynamic_modes, 0))
        keep_flag(self, "substeps")
        keep_number(self, "safety", 1e-3, 1.0)
        keep_number_or_none(self, "gap_tolerance", 0.0, math.inf)
        keep_number(self, "solver_tolerance", 0.0, math.inf, open_ends=True)
        object.__setattr__(self, "compliance", checked_compliance(self.compliance))
        as_solver(self.solver)

    def indents(self, name: str) -> bool:
        """Whether contact ``name`` gives way by an elastic law, on whose indentation a body may rest at the start."""
        return name in self.compliance

    def start(self, system: System, duration: float, interval: float) -> FixedRun:
        """A run over ``duration`` [s] that stores an instant about every ``interval`` [s].

        system: what a scene or a system of the user's own is compiled to.
        """
        reason = "its contacts carry forces at massless points; an elastic law goes into compliance={contact: law}"
        refuse_laws(system, "MasslessBoundary", reason)
        return FixedRun(MasslessBoundaryScheme(system, self, duration), duration, interval)


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
                f"{name}: contact {system.contact_name(int(values.argmax()))} has {values.max():g}, "
                "expected 0: with a massless boundary nothing is reflected by a law, the rebound is a result; use "
                "MoreauJean or EventDriven for a coefficient"
            )


def _refuse_shortening(model: Model, flexibility: FloatArray) -> None:
    """Static modes follow from contact forces alone, which those of a beam that feels its axial force do not."""
    for b in np.flatnonzero(np.diff(model.bodies.shortening_start)).tolist():
        if flexibility[model.bodies.dof[b] : model.bodies.dof[b + 1]].any():
            raise ModelError(
                'stepper: MasslessBoundary was given for a beam with contacts and Stiffening(axial_force="actual"), '
                "whose modes are not to be static; expected GeneralizedAlpha, MoreauJean or EventDriven"
            )


def _lost(system: System, flexibility: FloatArray) -> list[str]:
    """A warning where the initial state holds much of its energy in modes that are static from now on."""
    static = flexibility > 0.0
    K = np.zeros(len(system.q))
    dof = system.model.bodies.dof
    elastic = np.concatenate([np.arange(a + N_RIGID, b) for a, b in pairwise(dof)])
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
    link(supply, system.hooks)(system.model, 0.0, q, u, work)
    scale = 1.0 + float(np.abs(q).max())
    return start.project(system.model, q, u, work.external, np.full(system.n_joint, 1e-12 * scale))


def _settings(
    model: Model, flexibility: FloatArray, give: FloatArray, stepper: MasslessBoundary, longest: float, gap: float
) -> Settings:
    """The numbers of the loop; ``longest``: the step where nothing else limits it; ``gap``: the tolerance of gaps."""
    spring, damper = spring_rates(model, flexibility)
    static = flexibility[np.concatenate([np.arange(a + N_RIGID, b) for a, b in pairwise(model.bodies.dof)])] > 0.0
    highest = float(np.max(model.bodies.stiffness[~static], initial=0.0))
    step = stepper.step
    if step is None:
        step = longest
        if (square := spring + highest + contact_stiffness(model, flexibility, give / FINER**2)) > 0.0:
            step = min(step, SEVERAL * 2.0 * stepper.safety / math.sqrt(square))
        if damper > 0.0:
            step = min(step, stepper.safety / damper)
    parts = step * max(0.5 * math.sqrt(spring + highest), damper) / stepper.safety
    return Settings(
        step=step,
        safety=stepper.safety,
        parts=float(min(max(1, math.ceil(parts)), MOST_PARTS)) if stepper.substeps else 1.0,
        most_parts=MOST_PARTS if stepper.substeps else 1.0,
        gap_tolerance=gap,
        tolerance=stepper.solver_tolerance,
        spring=spring,
        damper=damper,
    )
