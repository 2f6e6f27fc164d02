"""Scenes with sensors of all kinds, and the steppers that run them."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

import lcpflex as lf

DURATION = 0.04
SLOW = 0.0031  # s between measurements: no multiple of a step or of the record
COSTLY = ("section", "stress")  # in Python: at one rate alone
STEPPERS: dict[str, Any] = {
    "moreau": lf.MoreauJean(step=1e-4),
    "moreau adaptive": lf.MoreauJean(step=1e-4, adaptive=lf.AdaptiveStep(rtol=1e-4)),
    "alpha": lf.GeneralizedAlpha(step=1e-4),
    "alpha adaptive": lf.GeneralizedAlpha(step=1e-4, adaptive=lf.AdaptiveStep(rtol=1e-4)),
    "event-driven": lf.EventDriven(rtol=1e-6),
    "massless": lf.MasslessBoundary(step=1e-5),
    "explicit": lf.Smooth(lf.Penalty(stiffness=1e5), integrator=lf.ExplicitRungeKutta(rtol=1e-5)),
    "stiff": lf.Smooth(lf.Penalty(stiffness=1e5), integrator=lf.Stiff(rtol=1e-4)),
    "verlet": lf.Smooth(lf.Penalty(stiffness=1e5), integrator=lf.Verlet(step=1e-5)),
}


def weighed(now: Any) -> tuple[float, float]:
    """A function of the user's of state and forces."""
    return float(now.time + now.q @ now.u), float(now.force[0, 0] + np.nansum(now.joint_force))


def struck_beam(*every: float | None, costly: bool = True) -> lf.Scene:
    """A hinged beam that falls onto a stop, with a sensor of each kind for each interval; none: without sensors."""
    scene = lf.Scene()
    bar = scene.add(lf.Beam(0.5, 0.02, 0.01, 1000.0, 1e9, axial=False), "bar", angular_velocity=-1.0, modes=2)
    scene.join(lf.Revolute(bar.point("left"), scene.ground.at(0.0, 0.0), name="hinge"))
    stop = scene.ground.circle((0.45, -0.03), 0.005)
    scene.contact(bar.surface(), stop, friction=0.2, name="stop")
    scene.sensor(lf.sensors.Energy(name="unasked", every=DURATION)) if every else None
    for k, each in enumerate(every):
        for name, (kind, *given) in kinds(bar).items():
            if name not in COSTLY or (costly and k == 0):
                scene.sensor(kind(*given, every=each, name=f"{name} {k}"))
    return scene


def kinds(bar: Any) -> dict[str, Any]:
    """Sensors of the beam and what they are given."""
    of = lf.sensors
    return {
        "tip": (of.Point, bar.point("right")),
        "body": (of.Body, bar),
        "modes": (of.Coordinates, ("bar.mode 2", "bar.angle")),
        "energy": (of.Energy,),
        "hinge": (of.Reaction, "hinge"),
        "turned": (of.Reaction, "hinge", "body"),
        "stop": (of.Contact, "stop"),
        "section": (of.Section, "bar", 0.2),
        "stress": (of.Stress, "bar", (0.25, 0.005)),
        "own": (of.Function, weighed, ("a", "b"), ("s", "N")),
    }


def assert_same_result(a: lf.Result, b: lf.Result) -> None:
    """All that a result tells, to the bit, but for sensors and times of the clock on the wall."""
    for field in fields(a):
        x, y = getattr(a, field.name), getattr(b, field.name)
        if field.name in ("energies", "contact_points"):
            for part in fields(x):
                np.testing.assert_array_equal(getattr(x, part.name), getattr(y, part.name), part.name)
        elif isinstance(x, np.ndarray):
            np.testing.assert_array_equal(x, y, field.name)
        elif field.name not in ("wall_time", "compile_time", "python_time", "compiled", "origin", "sensors"):
            assert x == y, field.name
