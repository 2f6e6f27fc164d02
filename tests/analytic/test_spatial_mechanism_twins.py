"""A planar scene and its spatial twin move alike, where the motion stays in the plane: to 1e-8."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from tests.spatial import about_z, twin

Z = (0.0, 0.0, 1.0)
STEPPERS: dict[str, Callable[[], Any]] = {
    "event-driven": partial(lf.EventDriven, rtol=1e-11),
    "Runge-Kutta": lambda: lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=1e-11)),
    "generalised-alpha": partial(lf.GeneralizedAlpha, step=1e-4),
}


class Twins:
    """A planar scene and the same in space, made part by part."""

    def __init__(self) -> None:
        self.planar = lf.Scene(gravity=(0.0, -9.81))
        self.spatial = lf.SpatialScene(gravity=(0.0, -9.81, 0.0))
        self.bodies: list[str] = []

    def add(self, body: Any, name: str, position: tuple[float, float], angle: float, modal: Any = None) -> None:
        self.planar.add(body, name=name, position=position, angle=angle, modal=modal)
        place = (*position, 0.0)
        self.spatial.add(twin(body), name=name, position=place, orientation=about_z(angle), modal=modal)
        self.bodies.append(name)

    def hinge(self, body: str, point: str, other: str | tuple[float, float], at: str = "") -> None:
        """A hinge between two bodies, or a body and the ground."""
        plane, space = self.planar.body(body).point(point), self.spatial.body(body).point(point)
        if isinstance(other, str):
            self.planar.join(lf.Revolute(plane, self.planar.body(other).point(at)))
            self.spatial.join(lf.Revolute(space, self.spatial.body(other).point(at), axis=Z))
        else:
            self.planar.join(lf.Revolute(plane, self.planar.ground.at(*other)))
            self.spatial.join(lf.Revolute(space, self.spatial.ground.at(*other, 0.0), axis=Z))

    def differences(self, duration: float, make: Callable[[], Any], project: bool = False) -> tuple[float, float]:
        """Largest difference of places of frames, and how far the twin leaves the plane."""
        flat = lf.simulate(self.planar, duration, make(), record=duration / 20.0, project=project)
        full = lf.simulate(self.spatial, duration, make(), record=duration / 20.0, project=project)
        worst, out = 0.0, 0.0
        for name in self.bodies:
            r = np.array([np.interp(flat.times, full.times, part) for part in full.point(name, ends(name)).T]).T
            worst = max(worst, float(np.abs(r[:, :2] - flat.point(name, ends(name))).max()))
            out = max(out, float(np.abs(r[:, 2]).max()))
        return worst, out


def ends(name: str) -> str:
    """The point of each body that is compared."""
    return "center" if name == "slider" else "right"


def pendulum() -> Twins:
    made = Twins()
    made.add(lf.Beam(1.0, 0.05, 0.05, 2700.0, 7e10).reduce(0), "arm", (0.0, 0.0), 0.0)
    made.hinge("arm", "left", (0.0, 0.0))
    return made


def slider_crank() -> Twins:
    made = Twins()
    crank, rod = (lf.Beam(length, 0.02, 0.02, 7800.0, 2.1e11).reduce(0) for length in (0.2, 0.5))
    angle = 0.7
    pin = (0.2 * math.cos(angle), 0.2 * math.sin(angle))
    lean = -math.asin(pin[1] / 0.5)
    made.add(crank, "crank", (0.0, 0.0), angle)
    made.add(rod, "rod", pin, lean)
    made.add(lf.Disc(radius=0.03, mass=0.4), "slider", (pin[0] + 0.5 * math.cos(lean), 0.0), 0.0)
    made.hinge("crank", "left", (0.0, 0.0))
    made.hinge("rod", "left", "crank", "right")
    made.hinge("slider", "center", "rod", "right")
    made.planar.join(lf.Prismatic(made.planar.body("slider").point("center"), made.planar.ground.at(0.0, 0.0)))
    center, origin = made.spatial.body("slider").point("center"), made.spatial.ground.at(0.0, 0.0, 0.0)
    made.spatial.join(lf.Prismatic(center, origin, axis=(1.0, 0.0, 0.0)))
    return made


def crank_rocker() -> Twins:
    """Four bars, the coupler and the rocker with four modes each."""
    made = Twins()
    lengths, ground = (0.2, 0.5, 0.4), 0.55
    crank = lf.Beam(lengths[0], 0.02, 0.02, 2700.0, 7e10).reduce(0)
    soft = [lf.Beam(length, 0.02, 0.004, 2700.0, 7e10).reduce(4) for length in lengths[1:]]
    angle = 1.0
    a = np.array([lengths[0] * math.cos(angle), lengths[0] * math.sin(angle)])
    b = np.array([ground, 0.0])
    apart = float(np.linalg.norm(b - a))
    along = (lengths[1] ** 2 - lengths[2] ** 2 + apart**2) / (2.0 * apart)
    way = (b - a) / apart
    c = a + along * way + math.sqrt(lengths[1] ** 2 - along**2) * np.array([-way[1], way[0]])
    for body, name, first, last in (
        (crank, "crank", (0.0, 0.0), a),
        (soft[0], "coupler", a, c),
        (soft[1], "rocker", b, c),
    ):
        line = np.asarray(last) - first
        made.add(body, name, (float(first[0]), float(first[1])), math.atan2(line[1], line[0]))
    made.hinge("crank", "left", (0.0, 0.0))
    made.hinge("coupler", "left", "crank", "right")
    made.hinge("rocker", "left", (ground, 0.0))
    made.hinge("rocker", "right", "coupler", "right")
    return made


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize("build", [pendulum, slider_crank, crank_rocker])
def test_twins_move_alike(build: Callable[[], Twins], stepper: str) -> None:
    worst, out = build().differences(0.05 if build is crank_rocker else 0.5, STEPPERS[stepper], project=True)
    assert worst < 1e-8
    assert out < 1e-10


@pytest.mark.parametrize("build", [pendulum, slider_crank, crank_rocker])
def test_twins_under_moreau_jean(build: Callable[[], Twins]) -> None:
    """In space forces that depend on velocities are corrected within the step; in the plane they are explicit, order 1.

    So the twins differ by order 1 where frames are not in the mass centre, or modes move.
    """
    coarse, fine = (build().differences(0.05, partial(lf.MoreauJean, step=h), project=True)[0] for h in (1e-4, 5e-5))
    assert fine < 5e-8
    assert fine < 1e-12 or 1.8 < coarse / fine < 2.2
