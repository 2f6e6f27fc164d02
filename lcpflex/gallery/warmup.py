"""Short runs that between them use nearly every kernel: what ``lcpflex warmup`` makes."""

from __future__ import annotations

from dataclasses import replace

from lcpflex.bodies.spatial.rigid import Capsule, Cuboid, Sphere
from lcpflex.dynamics.impact_laws import Poisson, Stronge
from lcpflex.force_laws.penalty import Penalty
from lcpflex.gallery.collection import scenes
from lcpflex.runs.case import Case
from lcpflex.scene.spatial.scene import SpatialScene
from lcpflex.steppers.adaptive import AdaptiveStep
from lcpflex.steppers.event_driven.stepper import EventDriven
from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
from lcpflex.steppers.moreau_jean.stepper import MoreauJean
from lcpflex.steppers.smooth.stepper import Smooth, Stiff, Verlet

__all__ = ["warmup_cases"]


def warmup_cases() -> tuple[Case, ...]:
    """Runs with every stepper, in the plane and in space: smooth, with declared contacts, with rules, many contacts.

    The first one of a kind has what most runs of that kind need; its kernels are those that a second process compiles
    (:mod:`lcpflex.jit.manifest`).
    """
    known = {**scenes(), "crowd": replace(scenes()["sliding_puck"], name="crowd", build=crowd)}
    coarse, alpha, control, spring = MoreauJean(step=1e-4), GeneralizedAlpha(step=1e-4), AdaptiveStep(), Penalty(1e5)
    runs = (
        ("pendulum", 0.41, MoreauJean(step=1e-5)),  # it touches at .4044 s
        ("stick_slip", 1e-2, EventDriven()),
        ("pendulum", 0.41, GeneralizedAlpha(step=1e-4)),
        ("double_pendulum", 1e-3, replace(coarse, adaptive=control)),
        ("double_pendulum", 1e-3, replace(alpha, adaptive=control)),
        ("pendulum", 1e-3, MasslessBoundary(step=1e-4)),
        ("stick_slip", 1e-3, Smooth(spring)),
        ("stick_slip", 1e-3, Smooth(spring, integrator=Stiff())),
        ("stick_slip", 1e-3, Smooth(spring, integrator=Verlet(1e-4))),
        ("sliding_puck", 1e-2, coarse),
        ("sliding_puck", 1e-2, EventDriven()),
        ("sliding_puck", 1e-2, alpha),
        ("sphere_on_plate", 1e-6, scenes()["sphere_on_plate"].stepper),
        ("oblique_bounce", 0.6, EventDriven()),  # it falls for .45 s
        ("oblique_bounce", 0.6, EventDriven(impact=Poisson())),
        ("oblique_bounce", 0.6, EventDriven(impact=Stronge())),
        ("stack", 1e-2, EventDriven()),
        ("stack", 1e-2, MoreauJean(step=1e-3)),
        ("stack", 1e-2, GeneralizedAlpha(step=1e-3)),
        ("heap", 0.3, MoreauJean(step=1e-3)),
        ("heap", 0.25, EventDriven()),
        ("link_chain", 1e-2, MoreauJean(step=1e-3)),
        ("sliding_beam", 1e-3, scenes()["sliding_beam"].stepper),
        ("impacting_bar", 1e-3, scenes()["impacting_bar"].stepper),
        ("elastic_stop", 1e-2, scenes()["elastic_stop"].stepper),
        ("driven_slider_crank", 1e-3, coarse),
        ("driven_slider_crank", 1e-2, EventDriven()),
        ("driven_slider_crank", 1e-3, alpha),
        ("crowd", 5e-2, MoreauJean(step=1e-3)),
        ("crowd", 5e-2, GeneralizedAlpha(step=1e-3)),
        ("crowd", 5e-2, EventDriven()),
    )
    return tuple(replace(known[name], duration=duration, stepper=stepper) for name, duration, stepper in runs)


def crowd() -> SpatialScene:
    """Two balls, a box and a capsule just above the ground, which may all touch each other."""
    scene = SpatialScene(gravity=(0.0, 0.0, -9.81))
    scene.contact_all(friction=0.3)
    scene.add(Sphere(radius=0.1, mass=1.0), position=(0.0, 0.0, 0.101))
    scene.add(Sphere(radius=0.1, mass=1.0), position=(0.205, 0.0, 0.102), velocity=(-1.0, 0.0, 0.0))
    scene.add(Cuboid(0.2, 0.2, 0.2, mass=1.0), position=(0.0, 0.5, 0.101))
    scene.add(Capsule(radius=0.05, length=0.2, mass=1.0), position=(0.0, 0.5, 0.353))
    scene.ground.plane((0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0))
    return scene
