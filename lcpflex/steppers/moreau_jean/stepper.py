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
from functools import partial

from lcpflex.basics.options import keep_flag, keep_number, keep_number_or_none
from lcpflex.dynamics.workspace import Workspace
from lcpflex.errors import ModelError, shown
from lcpflex.jit.struct import copy_parts, with_parts
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.problem import LcpSolver
from lcpflex.steppers.adaptive import AdaptiveStep
from lcpflex.steppers.coarse_touches import rounded_down
from lcpflex.steppers.law_run import refuse_states
from lcpflex.steppers.moreau_jean import (
    adaptive as _adaptive,  # noqa: F401  (what error control asks)
    step as _step,  # noqa: F401  (the kernels of the scheme)
)
from lcpflex.steppers.moreau_jean.memory import MoreauJeanScheme
from lcpflex.steppers.options import keep_budget, keep_solver
from lcpflex.steppers.run import Run
from lcpflex.steppers.scales import scales_of
from lcpflex.steppers.start import started
from lcpflex.steppers.strike_order import order_remarks, strike_order
from lcpflex.steppers.system import System
from lcpflex.steppers.time_stepping import FIRST_ROOM, Support, TimeStepping
from lcpflex.steppers.user_functions import watch_pair_laws

__all__ = ["MoreauJean"]

CORRECTED, SOLVED = "corrected", "solved"  # inertial forces of a step in space
MOST_PASSES = 40
PASSES = {CORRECTED: 1, SOLVED: MOST_PASSES}


def _remarks(scheme: MoreauJeanScheme, work: Workspace, steps: int | None) -> list[str]:
    """What a run is warned of."""
    unstable = [] if steps is None else _instability(scheme, work)
    return [*_unsettled(scheme, steps), *unstable, *order_remarks(scheme.order, steps)]


def _larger(system: System, scheme: MoreauJeanScheme, capacity: int) -> MoreauJeanScheme:
    """The scheme with room for the order of ``capacity`` contacts."""
    order = strike_order(system, capacity)
    copy_parts(scheme.order, order)
    return with_parts(scheme, {"order": order})


def _unsettled(scheme: MoreauJeanScheme, steps: int | None) -> list[str]:
    """Steps whose inertial forces were not met to rounding."""
    if not scheme.unsettled:
        return []
    count = f"{scheme.unsettled} steps or halves of steps" if steps is None else f"{scheme.unsettled} of {steps} steps"
    return [
        f'gyroscopic="solved": the inertial forces of {count} were not met to rounding in '
        f"{MOST_PASSES} passes: a shorter step is needed for bodies that turn as fast"
    ]


def _instability(scheme: MoreauJeanScheme, work: Workspace) -> list[str]:
    """That forces of compliant contacts, explicit in the middle of a step, make the motion grow."""
    frequency, limit = float(work.compliant.stiffest), 2.0 / math.sqrt(4.0 * scheme.theta - 1.0)
    product = frequency * scheme.step
    if product <= limit:
        return []
    return [
        f"the stiffest compliant contact has frequency times step = {product:.4g} > {limit:.4g}: "
        f"its force is explicit, and unstable there (highest frequency, with damping, {frequency:.4g} rad/s; take "
        f"steps of at most {rounded_down(limit / frequency):.2g} s)"
    ]


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
    on_unsolved
        What a step does where an island of more than 128 contacts is not solved to ``solver_tolerance`` within its
        budget, as may happen in piles while they collapse: "continue" with the best point, which the residual of the
        result and a warning tell, or "raise". Smaller islands that are not solved end the run in any case.
    budget
        Sparse factors that an island of more than 20 contacts may take in a step. None: by their cost, 100 to 600.
        In space, sweeps of Gauss-Seidel count by the time they take. They take the place of factors where the budget is
        below 10, and where a factor takes as long as 40 sweeps, as in heaps of some hundred spheres; None is then by
        cost alone, 10 or more.
    gyroscopic
        Of spatial scenes alone, inertial forces as omega x J omega, which change with the velocity within a step.
        "corrected": taken at the old velocity, and once more at the mean of the old and the new one, as that comes out
        by then, with what joints and contacts that go on add: energy drifts by h^3 in a given time. "solved": repeated
        until that mean is met to rounding, with a warning where 40 passes do not do. A rigid body with J = (1, 2, 3) kg
        m^2 that turns over about its middle axis at 5 rad/s, 4 s at h = 1/250: energy off by 2.4e-2 without either,
        9e-7 corrected, 1e-14 solved; its angle by .12, 5e-5 and 8e-5 rad. After 400 s the energy is off by 8e-5 and
        8e-13.

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
    on_unsolved: str = "continue"
    budget: int | None = None
    gyroscopic: str = CORRECTED

    def __post_init__(self) -> None:
        keep_number(self, "step", 0.0, math.inf, open_ends=True)
        keep_number(self, "theta", 0.5, 1.0)
        keep_number(self, "activation", 0.0, 1.0)
        keep_number_or_none(self, "gap_tolerance", 0.0, math.inf)
        keep_flag(self, "projection")
        if not isinstance(self.gyroscopic, str) or self.gyroscopic not in PASSES:
            raise ModelError(f'gyroscopic: {shown(self.gyroscopic)} was given, expected "{CORRECTED}" or "{SOLVED}"')
        keep_solver(self)
        keep_budget(self)

    def start(self, system: System, duration: float, interval: float) -> Run:
        """A run over ``duration`` [s] that stores an instant about every ``interval`` [s].

        system: what a scene or a system of the user's own is compiled to.
        """
        refuse_states(system)
        scheme = MoreauJeanScheme(
            step=self.step,
            theta=self.theta,
            activation=self.activation,
            gap_tolerance=scales_of(system, duration).gap(self.gap_tolerance),
            projection=self.projection,
            tolerance=self.solver_tolerance,
            velocity_threshold=0.0,
            gyroscopic=PASSES[self.gyroscopic],
            unsettled=0,
            q=system.q.copy(),
            u=system.u.copy(),
            order=strike_order(system, FIRST_ROOM),
        )
        support = Support(grown=partial(_larger, system), warnings=_remarks)
        stepping = TimeStepping(system, scheme, self.solver, support, self.on_unsolved, self.budget)
        run = started(stepping, self.adaptive, duration, interval, (self.theta, 1.0 - self.theta))
        watch_pair_laws(run.records, system)
        return run
