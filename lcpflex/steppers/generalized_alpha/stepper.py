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
   h lambda_N + Lambda_N >= 0 and Coulomb friction for h lambda + Lambda, on the pairs that are closed at q+. Where
   several have closed that share a body, one after the other (:mod:`lcpflex.steppers.strike_order`).

Newton's matrix holds inertia, modes, joints and contacts, not springs, dampers and inertial forces; where that makes
its passes slow, and nothing touches, they are combined (:mod:`lcpflex.steppers.generalized_alpha.mixing`).
The scheme starts anew, a = w = udot(t), where a contact closes, opens, comes to rest or changes its slip.
Sources: Chung & Hulbert 1993; Chen, Acary, Virlez & Bruels 2013; Bruels, Acary & Cardona 2014; Cosimo, Galvez,
Cavalieri, Cardona & Bruels 2020. Contact forces within the smooth motion are our own addition to those.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from lcpflex.basics.options import keep_number, keep_number_or_none
from lcpflex.dynamics.workspace import Workspace
from lcpflex.model.layout import is_spatial
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.problem import LcpSolver
from lcpflex.steppers.adaptive import AdaptiveStep
from lcpflex.steppers.generalized_alpha import (
    adaptive as _adaptive,  # noqa: F401  (what error control asks)
    step as _step,  # noqa: F401  (the kernels of the scheme)
)
from lcpflex.steppers.generalized_alpha.memory import AlphaScheme, alpha_scheme, larger
from lcpflex.steppers.law_run import refuse_laws
from lcpflex.steppers.not_finite import not_finite
from lcpflex.steppers.options import keep_budget, keep_solver
from lcpflex.steppers.run import Run
from lcpflex.steppers.scales import SUNK, given_or, scales_of
from lcpflex.steppers.start import started
from lcpflex.steppers.status import RunStatus
from lcpflex.steppers.strike_order import order_remarks
from lcpflex.steppers.system import System
from lcpflex.steppers.time_stepping import Support, TimeStepping

__all__ = ["GeneralizedAlpha"]


# light modes that contacts strike move by half of v h under impacts of M alone; Moreau-Jean has damping in them
BY_IMPULSES = (
    "friction rubs on bodies with modes here: expected a shorter step, or MoreauJean(step), whose friction is that of "
    "impulses, with theta=1.0 where vibrations are to die out"
)


def _is_rubbed(system: System) -> bool:
    """Whether contacts in space have friction, and bodies modes that it excites."""
    model = system.model
    return is_spatial(model) and bool(len(model.bodies.stiffness)) and bool(np.any(model.contacts.friction))


def _remarks(rubbed: bool, scheme: AlphaScheme, work: Workspace, steps: int | None) -> list[str]:
    """What a run is warned of."""
    return [*_unsettled(rubbed, scheme, steps), *order_remarks(scheme.order, steps)]


def _trouble(system: System, status: int, number: int, scheme: AlphaScheme, work: Workspace) -> str:
    """Why a run with friction on bodies with modes cannot go on where its state is lost; else empty."""
    if status not in (RunStatus.NOT_FINITE, RunStatus.SOLVER_FAILED) or not _is_rubbed(system):
        return ""
    named = not_finite(system, work)
    return f"the state is no longer finite ({named}): {BY_IMPULSES}" if named else ""


def _unsettled(rubbed: bool, scheme: AlphaScheme, steps: int | None) -> list[str]:
    """Steps of one length in which Newton's method did not converge; error control shortens such steps."""
    if not scheme.unsettled or steps is None:
        return []
    return [
        f"Newton's method on the smooth motion did not converge in {scheme.unsettled} of {steps} steps: "
        + (BY_IMPULSES if rubbed else "a shorter step is needed for the forces of this scene")
    ]


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
    on_unsolved
        What a step does where an island of more than 128 contacts is not solved to ``solver_tolerance`` within its
        budget, as may happen in piles while they collapse: "continue" with the best point, which the residual of the
        result and a warning tell, or "raise". Smaller islands that are not solved end the run in any case.
    budget
        Sparse factors that an island of more than 20 contacts may take in a step. None: by their cost, 100 to 600.
        In space, sweeps of Gauss-Seidel count by the time they take. They take the place of factors where the budget is
        below 10, and where a factor takes as long as 40 sweeps, as in heaps of some hundred spheres; None is then by
        cost alone, 10 or more.

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
    on_unsolved: str = "continue"
    budget: int | None = None

    def __post_init__(self) -> None:
        keep_number(self, "step", 0.0, math.inf, open_ends=True)
        keep_number(self, "rho_inf", 0.0, 1.0)
        for name in ("gap_tolerance", "velocity_threshold"):
            keep_number_or_none(self, name, 0.0, math.inf, open_ends=True)
        keep_solver(self)
        keep_budget(self)

    def start(self, system: System, duration: float, interval: float) -> Run:
        """A run over ``duration`` [s] that stores an instant about every ``interval`` [s].

        system: what a scene or a system of the user's own is compiled to.
        """
        refuse_laws(system, "GeneralizedAlpha", "its implicit steps have no derivatives of such laws")
        alpha_m = (2.0 * self.rho_inf - 1.0) / (self.rho_inf + 1.0)
        alpha_f = self.rho_inf / (self.rho_inf + 1.0)
        gamma = 0.5 + alpha_f - alpha_m
        scales = scales_of(system, duration)
        scheme = alpha_scheme(
            system,
            16,
            step=self.step,
            alpha_m=alpha_m,
            alpha_f=alpha_f,
            gamma=gamma,
            beta=0.25 * (gamma + 0.5) ** 2,
            gap_tolerance=scales.gap(self.gap_tolerance),
            velocity_threshold=given_or(self.velocity_threshold, 1e-8 * scales.speed),
            tolerance=self.solver_tolerance,
            sunk=SUNK * scales.length,
        )
        support = Support(
            grown=partial(larger, system),
            warnings=partial(_remarks, _is_rubbed(system)),
            trouble=partial(_trouble, system),
        )
        stepping = TimeStepping(system, scheme, self.solver, support, self.on_unsolved, self.budget)
        if is_spatial(system.model):  # its steps end anywhere, also on a seam: it strikes what closes at their ends
            table: Any = stepping.work.rows.table
            table.seams = 1
        return started(stepping, self.adaptive, duration, interval, (0.5, 0.5))
