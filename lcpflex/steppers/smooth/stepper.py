"""Stepping under continuous contact forces: bodies penetrate a little, and each contact is a spring-damper.

    M udot = h + J^T lambda_J + sum W_N lambda_N(delta, deltadot) + W_T lambda_T(lambda_N, gdot_T)

No complementarity, no impacts, no events: any method for ordinary differential equations serves, with a step that the
stiffness of the contacts limits (explicit) or not (implicit). The result depends on the stiffness, and approaches that
of rigid contact as it grows; friction creeps instead of sticking (:mod:`lcpflex.force_laws.penalty`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from lcpflex.basics.options import keep_at_least, keep_number, keep_number_or_none
from lcpflex.errors import ModelError, shown
from lcpflex.force_laws.contact_law import ContactLaw
from lcpflex.force_laws.law import Law
from lcpflex.force_laws.layout import LawRow
from lcpflex.steppers.run import Run
from lcpflex.steppers.scales import ABSOLUTE, given_or, scales_of
from lcpflex.steppers.smooth.explicit import SmoothSettings
from lcpflex.steppers.smooth.run import SmoothSteps
from lcpflex.steppers.state_numbers import tolerance_of_numbers
from lcpflex.steppers.system import System
from lcpflex.steppers.user_functions import watch_laws

__all__ = ["ExplicitRungeKutta", "Smooth", "Stiff", "Verlet"]


@dataclass(frozen=True, slots=True)
class ExplicitRungeKutta:
    """Runge-Kutta steps of order 5(4) with error control: the choice for contacts of moderate stiffness.

    Attributes
    ----------
    rtol, atol
        Tolerances of a step: root mean square of error / (atol + rtol |y|) over q and u at most 1. atol None: a
        hundredth of rtol times what is usual in the scene, of lengths, angles and velocities each.
    max_step
        Longest step [s].
    first_step
        First step [s]; chosen if omitted.

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    rtol: float = 1e-8
    atol: float | None = None
    max_step: float = math.inf
    first_step: float | None = None

    def __post_init__(self) -> None:
        _keep_tolerances(self)
        if self.first_step is not None:
            keep_number(self, "first_step", 0.0, math.inf, open_ends=True)


@dataclass(frozen=True, slots=True)
class Stiff:
    """Implicit steps with error control, by an integrator of SciPy: where contacts or modes are very stiff.

    Its loop is in Python, only the right-hand side is compiled: a step costs far more, and there are far fewer.

    Attributes
    ----------
    rtol, atol
        Tolerances on q and u, as the integrator takes them; atol None: see :class:`ExplicitRungeKutta`.
    max_step
        Longest step [s].
    method
        ``scipy.integrate.Radau`` (order 5; where None) or ``scipy.integrate.BDF`` (order 1 to 5).

    Raises
    ------
    ModelError
        For a number out of its range, or another method.
    """

    rtol: float = 1e-6
    atol: float | None = None
    max_step: float = math.inf
    method: type[Any] | None = None

    def __post_init__(self) -> None:
        from scipy.integrate import BDF, Radau

        _keep_tolerances(self)
        if not any(self.method is known for known in (None, Radau, BDF)):
            raise ModelError(f"method: {shown(self.method)} was given, expected scipy.integrate.Radau or BDF")


@dataclass(frozen=True, slots=True)
class Verlet:
    """Explicit steps of fixed length: half a drift, a kick, half a drift. Order 2, symplectic without damping.

    Stable up to step = 2 / omega_max only, with contacts closed: beyond it the motion blows up, and the result warns.
    With forces that depend on velocities (damping, friction, rotation) of order 1. In space the kick is made a second
    time, with the mean of the velocities before and behind it, and is of order 2 with them, too. A body that moves by
    more than its extent in a step may pass over others.

    Attributes
    ----------
    step
        Step length [s], > 0.

    Raises
    ------
    ModelError
        For a step that is not > 0.
    """

    step: float

    def __post_init__(self) -> None:
        keep_number(self, "step", 0.0, math.inf, open_ends=True)


Integrator = ExplicitRungeKutta | Stiff | Verlet


@dataclass(frozen=True, slots=True)
class Smooth:
    """Stepping under continuous contact forces.

    Contacts count as sticking in the records below the slip speed of their law, as slipping above it. The restitution
    of a declared contact is not used, and the result says so.

    Attributes
    ----------
    law
        Force law of every declared contact that has no other: ``Penalty(stiffness=1e6)``, or a :class:`ContactLaw`.
        None: all have one, in ``laws`` or in the scene.
    laws
        Other laws for some of them, by the name of the declared contact; they go before those of the scene.
    integrator
        :class:`ExplicitRungeKutta`, :class:`Stiff` or :class:`Verlet`.

    Raises
    ------
    ModelError
        For what is no law or integrator; when started, for a name that no declared contact has, and for a declared
        contact without a law.
    """

    law: Law | None = None
    laws: Mapping[str, Law] = field(default_factory=dict)
    integrator: Integrator = field(default_factory=ExplicitRungeKutta)

    def __post_init__(self) -> None:
        if not isinstance(self.laws, Mapping):
            raise ModelError(f"laws: {shown(self.laws)} was given, expected a dict of laws by names of contacts")
        for name, law in (("law", self.law), *((f"laws[{key!r}]", value) for key, value in self.laws.items())):
            if not isinstance(law, Law) and (law is not None or name != "law"):
                raise ModelError(
                    f"{name}: {shown(law)} was given, "
                    f"expected a force law such as Penalty(stiffness=1e6) or ContactLaw(...)"
                )
        if not isinstance(self.integrator, Integrator):
            raise ModelError(
                f"integrator: {shown(self.integrator)} was given, "
                f"expected ExplicitRungeKutta(), Stiff() or Verlet(step)"
            )
        object.__setattr__(self, "laws", dict(self.laws))

    def indents(self, name: str) -> bool:
        """Whether contact ``name`` has a force law here, on whose indentation a body may rest at the start: all do."""
        return True

    def start(self, system: System, duration: float, interval: float) -> Run:
        """A run over ``duration`` [s] that stores an instant about every ``interval`` [s].

        system: what a scene or a system of the user's own is compiled to.
        """
        laws = [law.row() for law in self._chosen(system)]
        system = replace(system, laws=())  # no contact is left out of detection for being compliant
        run = Run(self._steps(system, laws, duration, interval))
        watch_laws(run.records, system.names, laws)
        return run

    def _steps(self, system: System, laws: Sequence[LawRow], duration: float, interval: float) -> SmoothSteps:
        """The steps of the integrator."""
        integrator = self.integrator
        if isinstance(integrator, Verlet):
            stride = max(1, round(interval / integrator.step))
            none = np.zeros(len(system.q) + len(system.u))  # tolerances of a step that nothing controls
            settings = SmoothSettings(duration, interval, 0.0, none, 0.0, integrator.step, system.margin, stride)
            return SmoothSteps(system, laws, settings, fixed_step=integrator.step)
        scales = scales_of(system, duration)
        atol = tolerance_of_numbers(integrator.atol, integrator.rtol, system, scales)
        of_state = given_or(integrator.atol, ABSOLUTE * integrator.rtol * scales.length)
        settings = SmoothSettings(
            duration, interval, integrator.rtol, atol, of_state, integrator.max_step, system.margin, 1
        )
        if isinstance(integrator, Stiff):
            from scipy.integrate import Radau

            from lcpflex.steppers.smooth.implicit import ImplicitSteps

            implicit = partial(ImplicitSteps, method=integrator.method or Radau)
            return SmoothSteps(system, laws, settings, implicit=implicit)
        return SmoothSteps(system, laws, settings, integrator.first_step or 0.0)

    def _chosen(self, system: System) -> list[Law]:
        """The law of each declared contact."""
        for name in self.laws:
            if name not in system.names:
                known = ", ".join(system.names) or "none"
                raise ModelError(f"laws: {shown(name)} was given, expected names of declared contacts: {known}")
        own = system.laws or (None,) * len(system.names)
        mus = system.model.contacts.friction.tolist()
        chosen = []
        for name, of_scene, mu in zip(system.names, own, mus, strict=True):
            law = self.laws.get(name, of_scene or self.law)
            if law is None:
                raise ModelError(
                    f"law: None was given, and contact {name!r} has no force law of its own. Smooth has no "
                    "complementarity: give it a law, or use EventDriven/MoreauJean, which take compliant and rigid "
                    "contacts in one scene"
                )
            if isinstance(law, ContactLaw):
                law.friction.check(mu, name)
            chosen.append(law)
        return chosen


def _keep_tolerances(integrator: ExplicitRungeKutta | Stiff) -> None:
    """Keep them as floats; raise ModelError where one is out of its range."""
    keep_number(integrator, "rtol", 0.0, math.inf, open_ends=True)
    keep_number_or_none(integrator, "atol", 0.0, math.inf, open_ends=True)
    keep_at_least(integrator, "max_step", 0.0, "a number > 0 (seconds)", open_end=True)
