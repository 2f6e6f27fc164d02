"""Massless boundary: modes of a body are its contact compliance, the others are advanced explicitly.

Without inertia at the contact there is nothing that could strike: no impulse, no coefficient of restitution. Contact
forces lambda solve a problem at position level (:mod:`lcpflex.dynamics.position`), the rest is velocity Verlet,

    u_h = u + h/2 a,   q+ = q + h u_h,   lambda = lambda(q+),   M a+ = f(t+, q+, u+) + J^T lambda_J + W lambda
    u+ = u_h + h/2 a+

with the joints fulfilled by q+ and by u+ (RATTLE) and modal damping taken at u+. Order 2 as long as contacts stay as
they are, and nearly energy-conserving, as long as h omega < 2 for every omega of the system with its contacts closed.
In space q+ = q (+) h u_h turns frames by the exponential of h omega_h, and u+ has the momenta that all but inertial
forces leave, to rounding; where the direction of a slip turns, the order is 1.
A contact may give way by an elastic law of its own, too (:mod:`lcpflex.dynamics.contact_compliance`): then rigid bodies
may take part.
Source: Monjaraz-Tec, Gross & Krack 2022.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import ClassVar

import numpy as np

from lcpflex.basics.options import keep_flag, keep_number, keep_number_or_none
from lcpflex.bodies.body import whole_number
from lcpflex.dynamics import start
from lcpflex.dynamics.contact_compliance import ContactCompliance, contact_compliance
from lcpflex.dynamics.held_modes import PartedModes, part_modes
from lcpflex.dynamics.mass_matrix import mass_matrix
from lcpflex.dynamics.mechanics import supply
from lcpflex.dynamics.position import RIGID
from lcpflex.dynamics.stable_step import HeldRows
from lcpflex.dynamics.static_modes import amplitudes, check_compliance, flexibilities, softest, with_static_modes
from lcpflex.dynamics.step_guess import Mobility, contact_stiffness, highest_square, spring_rates
from lcpflex.dynamics.workspace import Workspace
from lcpflex.errors import ModelError
from lcpflex.force_laws.layout import ElasticLaw
from lcpflex.jit.dispatch import Hooks, link
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import allocate, lengthen
from lcpflex.model.arrays import Model
from lcpflex.model.layout import dimension, is_spatial, sums_of_contacts
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.problem import LcpSolver
from lcpflex.steppers.fixed_steps import FixedSteps
from lcpflex.steppers.law_run import law_warnings, refuse_laws, too_deep
from lcpflex.steppers.massless_boundary.compliance import checked_compliance, compliance_rows, expected_compliance
from lcpflex.steppers.massless_boundary.memory import BoundaryScheme
from lcpflex.steppers.massless_boundary.step import MOST_PARTS, short_enough
from lcpflex.steppers.options import keep_solver
from lcpflex.steppers.run import Run
from lcpflex.steppers.scales import scales_of
from lcpflex.steppers.status import RunStatus
from lcpflex.steppers.system import System
from lcpflex.steppers.time_stepping import FIRST_ROOM, Support, TimeStepping

__all__ = ["MasslessBoundary"]

ROWS = 3  # of a contact, at the most
SHORTEST = 1e-4  # part of a step: contacts that need a shorter one have next to no compliance of their own
SEVERAL = 0.7  # of the step that one closed contact admits: several that close have higher frequencies
FINER = 16.0  # steps where a law alone gives way: its contact lasts 4/omega, and no mode has a shorter period
UNSOLVED = (
    "; if more contacts close at a time than there are static modes, lower dynamic_modes or reduce the bodies to more "
    "modes"
)
LOST = 0.01  # part of the initial energy in static modes above which the result warns


@dataclass(frozen=True, slots=True)
class Remarks:
    """What is to be said of a run (see :class:`MasslessBoundary`); ``lost``: of its start."""

    system: System
    asked: float | None  # step [s]
    lost: list[str]

    def warnings(self, scheme: BoundaryScheme, work: Workspace, steps: int | None) -> list[str]:
        """Of what the start lost, and of steps that were divided."""
        outside = law_warnings(self.system.names, scheme.compliance.history)
        return [*self.lost, *outside, *self._divided(scheme, steps)]

    def _divided(self, scheme: BoundaryScheme, steps: int | None) -> list[str]:
        if self.asked is None or scheme.n_split == 0:
            return []
        return [
            f"{scheme.n_split} of {steps} steps were divided, into up to {scheme.finest:.0f} parts: with its contacts "
            f"closed the system has frequencies beyond the limit 2/h of the step h = {self.asked:g} s"
        ]

    def trouble(self, status: int, number: int, scheme: BoundaryScheme, work: Workspace) -> str:
        """Why the run cannot go on, for reasons of this scheme."""
        if status == RunStatus.STIFF:
            return (
                f"contact {self.system.contact_name(work.rows.table.law[number])} closes in a direction in which "
                "neither body has any compliance: use more modes or fewer dynamic_modes, or MoreauJean or EventDriven"
            )
        if status == RunStatus.TOO_LONG:
            return _limit(self.system.model, scheme, work)
        if status == RunStatus.OUT_OF_RANGE:
            return too_deep(self.system.names, scheme.compliance.history, number)
        return ""


def _pose_cones(stepping: TimeStepping) -> None:
    """Have problems posed with three rows a contact, where nothing rubs as well: so whoever is told knows them."""
    from lcpflex.solvers.contact.cones.memory import POSED  # which the plane does without

    stepping.work.impulses.solver.method = POSED


def _limit(model: Model, scheme: BoundaryScheme, work: Workspace) -> str:
    """What step the posed problem admits, by bisection."""
    low, high = 0.0, scheme.step
    for _ in range(50):
        h = 0.5 * (low + high)
        if short_enough(model, scheme, h, work):
            low = h
        else:
            high = h
    if low < SHORTEST * scheme.step:
        return (
            "the contacts that close now have too little compliance for any step: their bodies have fewer static "
            "modes than these contacts have closed normal and sticking tangential directions; lower "
            "dynamic_modes, or reduce the bodies to more modes"
        )
    parts = int(scheme.most_parts)
    return (
        f"the step {scheme.step:g} s is too long for the system with the contacts that close now, which "
        f"admits {low:.6g} s (with safety {scheme.safety:g}): shorten it, "
        + ("allow substeps, " if parts == 1 else f"for {parts} parts are the most, ")
        + "or keep fewer dynamic modes"
    )


@dataclass(frozen=True, slots=True)
class MasslessBoundary:
    """Massless-boundary scheme: no impulse, no restitution, the energy of a contact goes into the modes.

    For scenes of the plane and of space.

    solver_tolerance: largest residual of a contact problem that counts as solved [-].

    Attributes
    ----------
    step
        Step length h [s], > 0. None: 0.7 ``safety`` times the limit of the system with one contact closed, as estimated
        at the start, and at most a thousandth of the duration.
    dynamic_modes
        Number of lowest modes that keep their mass, of each body with a contact; those above are its compliance at
        contacts and under forces, but for what gives way to joints and springs, which keeps its mass, too, where it is
        no faster than these: a body has the static compliance of all its modes wherever something acts. None: all modes
        that were asked for, where the body has residual modes for its contacts besides, as ``scene.add(body, modes=8)``
        gives it; half of its modes, rounded down and with those of joints, where it has none. Fewer allow longer steps;
        1/omega^2 of the modes above them must hold enough compliance for all the contacts of the body that close
        together.
    substeps
        Divide steps that the stability limit 2/omega does not admit, where omega is the highest frequency of the
        system with its contacts closed as they are and its joints held. False: stop instead, with the admissible step.
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
        object.__setattr__(self, "compliance", checked_compliance(self.compliance))
        keep_solver(self)

    def indents(self, name: str) -> bool:
        """Whether contact ``name`` gives way by an elastic law, on whose indentation a body may rest at the start."""
        return name in self.compliance

    def start(self, system: System, duration: float, interval: float) -> Run:
        """A run over ``duration`` [s] that stores an instant about every ``interval`` [s].

        system: what a scene or a system of the user's own is compiled to.
        """
        reason = "its contacts carry forces at massless points; an elastic law goes into compliance={contact: law}"
        refuse_laws(system, "MasslessBoundary", reason)
        _refuse(system)
        compliance = contact_compliance(
            system.model.contacts, compliance_rows(self.compliance, system.names, system.n_laws)
        )
        given = system
        system, parted = self._with_static_modes(system, compliance)
        scheme = self._scheme(system, parted, compliance, duration)
        remarks = Remarks(system, self.step, _lost(given, parted))
        support = Support(
            grown=_grown,
            warnings=remarks.warnings,
            trouble=remarks.trouble,
            hint=UNSOLVED,
            impulsive=False,
        )
        stepping = TimeStepping(system, scheme, self.solver, support)
        if system.watch is not None and is_spatial(system.model):
            _pose_cones(stepping)
        stepping.records.compliant = tuple(name for name in system.names if name in self.compliance)
        scheme.q[:], scheme.u[:] = _consistent(system, stepping.work)
        return Run(FixedSteps(stepping, duration, interval, (0.5, 0.5), begun=False))

    def _with_static_modes(self, system: System, compliance: ContactCompliance) -> tuple[System, PartedModes]:
        """The system whose bodies have static modes, and the modes of the given one, parted."""
        soft = compliance.soft
        flexibility = flexibilities(system.model, self.dynamic_modes, soft, system.residual_modes, system.q)
        _refuse_shortening(system.model, flexibility)
        parted = part_modes(system.model, flexibility, system.q)
        model = with_static_modes(parted.model, parted.flexibility)
        check_compliance(model, parted.flexibility, system.q, soft, system.contact_name)
        gives = tuple(soft.tolist()) if soft.any() and not soft.all() else ()
        hooks = _asked_in_former(system.hooks, parted)
        q, u = parted.coordinates(system.q), parted.velocities(system.u)
        return replace(system, model=model, q=q, u=u, soft=gives, hooks=hooks), parted

    def _scheme(
        self, system: System, parted: PartedModes, compliance: ContactCompliance, duration: float
    ) -> BoundaryScheme:
        """Numbers, state and memory at the start: everything at rest, no contact closed."""
        model, flexibility = system.model, parted.flexibility
        spring, damper = spring_rates(model, flexibility)
        highest = highest_square(model, system.q, flexibility)
        give = expected_compliance(system, compliance) / FINER**2  # and forces that do not matter, in ``compliance``
        step = self.step
        if step is None:
            step = duration / 1000.0
            is_held = np.array([T is not None for T in parted.turn], dtype=bool)
            mobility = Mobility(model, flexibility, system.q, bool(is_held.any() and system.n_joint))
            if (square := spring + highest + contact_stiffness(model, flexibility, give, mobility, is_held)) > 0.0:
                step = min(step, SEVERAL * 2.0 * self.safety / math.sqrt(square))
            if damper > 0.0:
                step = min(step, self.safety / damper)
        parts = step * max(0.5 * math.sqrt(spring + highest), damper) / self.safety
        parts = float(min(max(1, math.ceil(parts)), MOST_PARTS)) if self.substeps else 1.0
        turned = [np.zeros(0) if T is None else T.ravel() for T in parted.turn]
        pushed = model.points.body[model.loads.force_point]
        return allocate(
            BoundaryScheme,
            {
                "ndof": len(flexibility),
                "nq": len(system.q),
                "laws": len(compliance.soft),
                "sums": sums_of_contacts(model),
                "carried": len(model.bodies.mass) if is_spatial(model) else 0,
                "foreseen": len(system.q) if is_spatial(model) else 0,
            },
            step=step,
            safety=self.safety,
            least_parts=parts,
            parts=parts,
            most_parts=MOST_PARTS if self.substeps else 1.0,
            gap_tolerance=scales_of(system, duration).gap(self.gap_tolerance),
            least=RIGID * softest(model, flexibility),
            tolerance=self.solver_tolerance,
            spring=spring,
            damper=damper,
            q=system.q,
            u=system.u,
            flexibility=np.array(flexibility),
            held_flexibility=np.array(parted.held) if np.any(parted.held) else np.zeros(0),
            loaded=int(any(flexibility[slice(*model.bodies.dof[b : b + 2])].any() for b in pushed[pushed >= 0])),
            turn_start=np.cumsum([0, *(len(flat) for flat in turned)]),
            turn=np.concatenate([np.zeros(0), *turned]),
            unit=np.ones(2),
            compliance=compliance,
            held=_held_rows(system),
        )


def _held_rows(system: System) -> HeldRows:
    """Memory for the joints of a system."""
    dof = system.model.bodies.dof
    sizes = {"joints": system.n_joint, "width": int(np.max(np.diff(dof), initial=1)), "bodies": len(dof) - 1}
    sizes["reaction"] = dimension(system.model.bodies).rigid
    return allocate(HeldRows, {**sizes, "pairs": ROWS * FIRST_ROOM}, admitted=math.inf)


def _grown(scheme: BoundaryScheme, contacts: int) -> BoundaryScheme:
    """The same with room for more contacts."""
    lengthen(scheme, "pairs", len(scheme.held.coupling), ROWS * contacts)
    return scheme


def _asked_in_former(hooks: Hooks, parted: PartedModes) -> Hooks:
    """The same, Python functions of the state asked in the coordinates that bodies came with."""
    given = hooks.get(supply)
    if given is None or all(T is None for T in parted.turn):
        return hooks

    def asked(model: Model, t: float, q: FloatArray, u: FloatArray, work: Workspace) -> None:
        given(model, t, parted.former(q), parted.former_rates(u), work)

    return {**hooks, supply: asked}


def _elastic(system: System) -> IntArray:
    """Places of the rates of modal coordinates."""
    rigid = dimension(system.model.bodies).rigid
    return np.concatenate([np.arange(a + rigid, b) for a, b in pairwise(system.model.bodies.dof)])


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
    for b in [] if is_spatial(model) else np.flatnonzero(np.diff(model.bodies.shortening_start)).tolist():
        if flexibility[model.bodies.dof[b] : model.bodies.dof[b + 1]].any():
            raise ModelError(
                'stepper: MasslessBoundary was given for a beam with contacts and Stiffening(axial_force="actual"), '
                "whose modes are not to be static; expected GeneralizedAlpha, MoreauJean or EventDriven"
            )


def _lost(system: System, parted: PartedModes) -> list[str]:
    """A warning where the initial state holds much of its energy in modes that are static from now on."""
    static = parted.flexibility > 0.0
    K = np.zeros(len(system.u))
    K[_elastic(system)] = parted.model.bodies.stiffness
    q, u, left = amplitudes(system.model, parted.coordinates(system.q)), system.u, parted.velocities(system.u)
    stored = 0.5 * (float(K @ q**2) + float(u @ mass_matrix(system.model, system.q) @ u))
    lost = 0.5 * (float(K[static] @ q[static] ** 2) + float(u @ u - left @ left))
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
    return start.project(system.model, q, u, work.free.external, np.full(system.n_joint, 1e-12 * scale))
