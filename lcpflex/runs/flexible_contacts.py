"""Whether contacts of bodies with modes close flat or point by point, told before a run, and what steps the latter.

A massless boundary takes what closes point by point at less cost than any scheme that meets each point as an impact,
and without what these gain where residual modes are stiff: a bar on a roller with 20 modes and 50 residual ones, at .4
m/s, keeps its energy with the steps that a massless boundary chooses by itself, and has 81 times as much with those of
generalised-alpha (60 modes: forces off by .6 and 3 %; rubbing, friction by 1.4 and 45 %). Over what closes flat its
force rings.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.basics.blas import one_thread
from lcpflex.checks.first_touch import answer_times, first_touches
from lcpflex.checks.resolution_rules import PAIRS
from lcpflex.errors import ModelError
from lcpflex.model.layout import dimension
from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.runs.setup import Stepper

__all__ = ["suited"]

FLAT, POINTWISE = "flat", "point by point"
RHO = 0.5  # of flat contacts: with .8, steps of 5 us give a bar at a wall 7 % more energy, with .5 none


def suited(
    source: CompiledScene, duration: float, other: Stepper, most: float
) -> tuple[Stepper, MasslessBoundary | None]:
    """``other`` as suits the contacts of a scene, and a massless boundary of at most ``most`` steps where that does."""
    closing = _closing(source)
    if closing == FLAT and isinstance(other, GeneralizedAlpha):
        return replace(other, rho_inf=RHO), None
    return other, _massless(source, duration, most) if closing == POINTWISE else None


def _closing(source: CompiledScene) -> str:
    """FLAT where a contact of bodies with modes closes so first; POINTWISE where all contacts of the scene are such.

    POINTWISE asks more: contacts that are declared one by one, all of which close first, with as many points as a
    contact needs to be resolved, of bodies that have residual modes for as many. A corner is not enough: what begins
    with it may end flat. Empty where neither is known.
    """
    contacts = source.model.contacts
    if not len(contacts.friction) or not len(source.model.bodies.stiffness):
        return ""
    touches = first_touches(source)
    if any(touch.flat for touch in touches):
        return FLAT
    size, residual = np.diff(source.model.bodies.dof) - dimension(source.model.bodies).rigid, source.layout.residual
    given = all(touch.points >= PAIRS for touch in touches)
    given &= all(residual[b][1] >= PAIRS for touch in touches for b in touch.bodies if b >= 0 and size[b])
    every = not len(contacts.rule_rank) and {touch.law for touch in touches} == set(range(len(contacts.friction)))
    return POINTWISE if given and every else ""


def _massless(source: CompiledScene, duration: float, most: float) -> MasslessBoundary | None:
    """The stepper, with a step of its own choice; None where it takes more than ``most``, or not these contacts."""
    asked = MasslessBoundary()
    fastest, _ = answer_times(source.model, source.layout.residual)
    if 2.0 * asked.safety * float(fastest[fastest > 0.0].min()) / math.pi * most < duration:
        return None  # the free modes alone take shorter steps
    try:
        with one_thread(len(source.model.bodies.stiffness)):
            step = getattr(asked.start(source.system(), duration, duration), "fixed_step", 0.0)
    except ModelError:
        return None  # contacts with restitution, bodies that do not give way where they touch, ...
    # the step is given, for it takes a while to find
    return MasslessBoundary(step=float(f"{step:.3g}")) if step * most >= duration else None
