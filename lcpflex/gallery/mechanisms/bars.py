"""Elastic bars: waves, impact without restitution, friction at a foot. All have exact solutions.

A bar has its impedance Z = A sqrt(E rho) [N s/m] and wave speed c = sqrt(E/rho) [m/s].
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from lcpflex.bodies.bar import Bar
from lcpflex.gallery.mechanisms.arguments import checked
from lcpflex.runs.case import Case
from lcpflex.scene.functions_of_time import Table
from lcpflex.scene.joints.driven_displacement import DrivenDisplacement
from lcpflex.scene.joints.point_on_line import PointOnLine
from lcpflex.scene.joints.weld import Weld
from lcpflex.scene.loads.force import Force
from lcpflex.scene.scene import Scene
from lcpflex.steppers.moreau_jean.stepper import MoreauJean

__all__ = ["bar_with_foot", "courant_step", "elastic_bar", "prestressed_bar", "two_bars"]

LENGTH = 10.0  # the bar of Doyen, Ern & Piperno (2011): c = 30, Z = 30
MODULUS = 900.0


def courant_step(element: float, wave_speed: float) -> float:
    """Step [s] at which the leading errors of linear elements and of the trapezoidal rule cancel.

    The wave speed of linear elements of length l with consistent mass is too large by (k l)^2/24, that of the
    trapezoidal rule too small by (omega h)^2/12: c h = l/sqrt(2).
    """
    return element / wave_speed / math.sqrt(2.0)


@checked
def elastic_bar(
    elements: int = 400, modes: int | None = None, speed: float = 10.0, gap: float = 5.0, restitution: float = 0.0
) -> Scene:
    """A free bar flies against a wall. ``modes=None`` keeps every mode of the mesh: its nodal coordinates."""
    scene = Scene(gravity=(0.0, 0.0))
    material = Bar(length=LENGTH, area=1.0, density=1.0, youngs_modulus=MODULUS, elements=elements)
    body = material.reduce(modes=modes)
    if modes is not None:
        body = replace(body, statics=None)  # the modes are the model: what they lose of the mesh is what is looked at
    bar = scene.add(body, name="bar", position=(gap, 0.0), velocity=(-speed, 0.0))
    wall = scene.ground.half_plane((0.0, 0.0), (1.0, 0.0))
    scene.contact(bar.node(0.0, 0.0), wall, restitution=restitution, name="wall")
    return scene


@checked
def two_bars(elements: int = 200, speed: float = 10.0, gap: float = 1.0) -> Scene:
    """A bar strikes an equal one at rest."""
    scene = Scene(gravity=(0.0, 0.0))
    body = Bar(length=LENGTH, area=1.0, density=1.0, youngs_modulus=MODULUS, elements=elements).reduce(modes=None)
    striker = scene.add(body, name="striker", position=(-LENGTH - gap, 0.0), velocity=(speed, 0.0))
    struck = scene.add(body, name="struck", position=(0.0, 0.0))
    scene.contact(striker.node(LENGTH, 0.0), struck.half_plane((0.0, 0.0), (-1.0, 0.0)), name="ends")
    return scene


@checked
def prestressed_bar(elements: int = 100) -> Scene:
    """A bar of unit properties, clamped at x = 1, is let go stretched by (1 - x)/2 above a stop at its end x = 0."""
    scene = Scene(gravity=(0.0, 0.0))
    body = Bar(length=1.0, area=1.0, density=1.0, youngs_modulus=1.0, elements=elements).reduce(modes=None)
    dx, dy, dangle, modal = body.project(lambda x, y: (0.5 * (1.0 - x), 0.0))
    bar = scene.add(body, name="bar", position=(dx, dy), angle=dangle, modal=modal)
    scene.join(Weld(bar.point("right"), scene.ground.at(1.0, 0.0), name="clamp"))
    stop = scene.ground.half_plane((0.0, 0.0), (1.0, 0.0))
    scene.contact(bar.node(0.0, 0.0), stop, name="stop")
    return scene


@checked
def bar_with_foot(elements: int = 400, speed: float = 1.0, ratio: float = 1.5, duration: float = 10.0) -> Scene:
    """A bar with a Coulomb foot at x = 0 is pulled at x = L; friction limit of the foot = ``ratio`` Z ``speed``."""
    impedance = float(np.sqrt(MODULUS))
    scene = Scene(gravity=(0.0, 0.0))
    body = Bar(length=LENGTH, area=1.0, density=1.0, youngs_modulus=MODULUS, elements=elements).reduce(modes=None)
    jerk = np.zeros((elements + 1, 2))  # the pulled end moves at once, all else is at rest
    jerk[-1, 0] = speed
    dx, dy, dangle, modal = body.project(jerk)
    bar = scene.add(
        body, name="bar", position=(0.0, 0.0), velocity=(dx, dy), angular_velocity=dangle, modal_velocity=modal
    )
    pull = Table([0.0, duration], [0.0, speed * duration])
    end = scene.ground.at(LENGTH, 0.0)
    scene.join(DrivenDisplacement(bar.point("right"), end, pull, (1.0, 0.0), name="pull"))
    scene.join(PointOnLine(bar.point("right"), end, (1.0, 0.0), name="guide"))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.load(Force(bar.point("left"), (0.0, -ratio * impedance * speed)))
    scene.contact(bar.node(0.0, 0.0), floor, friction=1.0, name="foot")
    return scene


def cases() -> tuple[Case, ...]:
    """The cases of this module."""
    exact = "exact solution of the wave equation"
    modal = "exact: effective mass m/(2N+1) of a free bar with N modes at its end"
    contact_time = 2.0 * LENGTH / 30.0
    return (
        Case(
            "elastic_bar",
            "elastic bar on a wall, nodal coordinates: constant force for the time of a wave",
            elastic_bar,
            1.5,
            MoreauJean(step=courant_step(LENGTH / 400, 30.0)),
            {
                "first_contact": 0.5,
                "last_contact": 0.5 + contact_time,
                "force": 300.0,
                "rebound": 10.0,
                "impulse": 200.0,
            },
            f"{exact}; parameters of Doyen, Ern & Piperno 2011",
        ),
        *(
            Case(
                f"modal_bar_{n}",
                f"bar on a wall with {n} mode{'s' if n > 1 else ''}: the energy that too few modes lose",
                partial(elastic_bar, elements=200, modes=n),
                1.5,
                MoreauJean(step=2e-5),
                {
                    "energy_loss": 1.0 / (2.0 * n + 1.0),
                    "rebound": 20.0 * n / (2.0 * n + 1.0),
                    "last_contact": 0.5 + ratio * contact_time,
                },
                modal,
            )
            for n, ratio in ((1, 0.8660), (2, 0.9160), (3, 0.9390))
        ),
        Case(
            "two_bars",
            "elastic bar strikes an equal one: they exchange their velocities",
            two_bars,
            1.2,
            MoreauJean(step=courant_step(LENGTH / 200, 30.0)),
            {"interface_speed": 5.0, "force": 150.0, "contact_time": contact_time, "struck": 10.0, "striker": 0.0},
            exact,
        ),
        Case(
            "prestressed_bar",
            "stretched bar is let go above a stop: motion of period 3",
            prestressed_bar,
            12.0,
            MoreauJean(step=courant_step(0.01, 1.0)),
            {"energy": 0.125, "period": 3.0, "force": 0.5},
            "exact; GetFEM demo, Dabaghi et al. 2014",
        ),
        Case(
            "bar_with_foot",
            "pulled bar with a Coulomb foot: the foot runs slow and fast in turn",
            bar_with_foot,
            3.0,
            MoreauJean(step=courant_step(LENGTH / 400, 30.0)),
            {"slow": 0.5, "fast": 1.5},
            exact,
        ),
    )
