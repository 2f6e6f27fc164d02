"""Runs that are broken off and resumed, and the comparison of their results to the bit."""

from __future__ import annotations

import math
import signal
import sys
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import BDF

import lcpflex as lf
from lcpflex.runs.checkpoint import Checkpoints
from tests.scenes import floor_of
from tests.spatial_flight import flexible_flight
from tests.spatial_tops import heavy_top
from tests.unit.runs.sensor_scenes import struck_beam

LAW = lf.ContactLaw(lf.laws.PowerLaw(1e4, 1.0), lf.laws.HysteresisDamping(0.5))
ADAPTIVE = lf.AdaptiveStep(rtol=1e-4, atol=1e-6, shortest=1e-6)
TIMINGS = ("wall_time", "compile_time", "python_time")


def thrown(law: Any = None) -> lf.Scene:
    """A disc and a box are thrown onto the ground; ``law``: of the disc."""
    scene = lf.Scene(gravity=(0.0, -10.0))
    ball = scene.add(
        lf.Disc(radius=0.1, mass=1.0), name="ball", position=(0.0, 0.13), velocity=(1.0, 0.0), angular_velocity=3.0
    )
    box = scene.add(lf.Box(0.3, 0.1, mass=1.0), name="box", position=(0.5, 0.11), angle=0.3)
    ground = floor_of(scene)
    if law is None:
        scene.contact_all(friction=0.3, restitution=0.5)
    else:
        scene.contact(ball.surface(), ground, friction=0.3, law=law)
        scene.contact(box.surface(), ground, friction=0.3, restitution=0.5)
    return scene


def thrown_with_sensors() -> lf.Scene:
    """The same with sensors, no Python function among them."""
    scene = thrown()
    for every in (0.0031, 0.002):
        scene.sensor(lf.sensors.Point(scene.body("box").at(0.1, 0.0), every=every))
        scene.sensor(lf.sensors.Contact("box.outline/ground.half_plane1", every=every))
        scene.sensor(lf.sensors.Energy(every=every))
    return scene


def heap() -> lf.Scene:
    """More discs than the first tables hold contacts."""
    scene = lf.Scene()
    for k in range(12):
        scene.add(lf.Disc(radius=0.1, mass=1.0), position=(0.05 * (k % 3) + 0.01 * k, 0.101 + 0.201 * k))
    floor_of(scene)
    scene.ground.half_plane((-0.3, 0.0), (1.0, 0.0))
    scene.contact_all(friction=0.3, restitution=0.2)
    return scene


def beam() -> lf.Scene:
    """A soft beam falls on the ground with one end."""
    scene = lf.Scene()
    reduced = lf.Beam(0.5, 0.02, 0.01, density=1000.0, youngs_modulus=1e7, elements=10).reduce(modes=4)
    body = scene.add(reduced, angle=0.3, position=(0.0, 0.02), angular_velocity=1.0)
    scene.contact(body.surface(), floor_of(scene), friction=0.3)
    return scene


def pushed(most: float = 20.0) -> lf.Scene:
    """A box on the ground under a Python force."""
    scene = thrown()
    scene.load(lf.Force(scene.body("box").point("center"), lambda t: (most * math.sin(60.0 * t), 0.0)))
    return scene


def sliding_areas() -> lf.SpatialScene:
    """A block slides over another one by areas, whose means stand for some steps."""
    scene = lf.SpatialScene()
    solid = lf.Solid.box((0.2, 0.2, 0.1), elements=(5, 5, 3), density=1000.0, youngs_modulus=1e7, poissons_ratio=0.3)
    body = solid.reduce(4)
    below = scene.add(body, "below", (0.0, 0.0, 0.05))
    above = scene.add(body, "above", (0.01, 0.0, 0.15), velocity=(0.02, 0.0, 0.0))
    scene.contact(below.face("bottom"), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    scene.contact(above.face("bottom"), below.face("top"), points="areas", friction=0.001)
    return scene


def own_system(stiffness: float = 2.0) -> lf.UserSystem:
    return lf.UserSystem(
        q=[0.05, 0.0],
        u=[0.0, 1.0],
        mass=np.eye(2),
        force=lambda t, q, u: np.array([-9.81 + math.sin(50.0 * t), -stiffness * q[1]]),
        gaps=lambda q: np.array([q[0]]),
        normals=lambda q: np.array([[1.0], [0.0]]),
        tangents=np.array([[0.0], [1.0]]),
        friction=0.3,
        restitution=0.6,
    )


Build = Callable[[], "lf.Scene | lf.UserSystem"]
RUNS: dict[str, tuple[Build, float, Any]] = {
    "moreau": (heap, 0.1, lf.MoreauJean(1e-3)),
    "moreau by law": (lambda: thrown(LAW), 0.1, lf.MoreauJean(5e-4)),
    "moreau adaptive": (thrown, 0.2, lf.MoreauJean(1e-4, adaptive=ADAPTIVE)),
    "moreau, a solver in Python": (thrown, 0.1, lf.MoreauJean(2e-3, solver=lf.solvers.GaussSeidel())),
    "alpha": (heap, 0.1, lf.GeneralizedAlpha(1e-3)),
    "alpha adaptive": (thrown, 0.15, lf.GeneralizedAlpha(1e-4, adaptive=ADAPTIVE)),
    "event-driven": (thrown, 0.3, lf.EventDriven()),
    "event-driven by law": (lambda: thrown(LAW), 0.1, lf.EventDriven()),
    "massless": (beam, 0.01, lf.MasslessBoundary(step=1e-5)),
    "smooth": (thrown, 0.1, lf.Smooth(LAW)),
    "stiff": (thrown, 0.3, lf.Smooth(LAW, integrator=lf.Stiff())),
    "stiff, BDF": (thrown, 0.3, lf.Smooth(LAW, integrator=lf.Stiff(method=BDF))),
    "verlet": (thrown, 0.1, lf.Smooth(LAW, integrator=lf.Verlet(5e-4))),
    "python force": (pushed, 0.05, lf.MoreauJean(1e-3)),
    "own system": (own_system, 0.3, lf.MoreauJean(1e-3)),
    "sensors": (thrown_with_sensors, 0.1, lf.MoreauJean(1e-3)),
    "sensors adaptive": (thrown_with_sensors, 0.1, lf.GeneralizedAlpha(1e-4, adaptive=ADAPTIVE)),
    "sensors event-driven": (lambda: struck_beam(0.0031, 0.001, None, costly=False), 0.02, lf.EventDriven(rtol=1e-6)),
    "own system, event-driven": (own_system, 0.3, lf.EventDriven()),
    "space, event-driven": (lambda: heavy_top(0.0), 0.1, lf.EventDriven()),
    "space, stiff": (lambda: heavy_top(0.0), 0.1, lf.Smooth(integrator=lf.Stiff())),
    "space, verlet": (flexible_flight, 0.2, lf.Smooth(integrator=lf.Verlet(5e-4))),
    "space, areas": (sliding_areas, 0.1, lf.MoreauJean(1e-3)),
    "space, moreau adaptive": (flexible_flight, 0.2, lf.MoreauJean(1e-4, adaptive=lf.AdaptiveStep(rtol=1e-6))),
}


def values_of(value: Any, name: str = "result") -> Iterator[tuple[str, Any]]:
    """All numbers and texts of a result but its timings, by their names."""
    if is_dataclass(value):
        for field in fields(value):
            if field.name not in (*TIMINGS, "compiled", "origin"):
                yield from values_of(getattr(value, field.name), f"{name}.{field.name}")
    elif isinstance(value, tuple) and value and is_dataclass(value[0]):
        for k, part in enumerate(value):
            yield from values_of(part, f"{name}[{k}]")
    else:
        yield name, value


def assert_same_bits(one: lf.Result, other: lf.Result) -> None:
    for (name, a), (_, b) in zip(values_of(one), values_of(other), strict=True):
        if isinstance(a, np.ndarray):
            assert a.dtype == b.dtype, name
            np.testing.assert_array_equal(a, b, err_msg=name)
        else:
            assert a == b, name


class Breaks:
    """Ctrl-C in the midst of some chunks of steps, counted over all runs."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, at: set[int]) -> None:
        self._at, self.chunks = at, 0
        begins = Checkpoints.chunk_begins

        def begin(keeper: Checkpoints) -> None:
            begins(keeper)
            self.chunks += 1
            if self.chunks in self._at:
                signal.raise_signal(signal.SIGINT)  # to this thread, at once

        monkeypatch.setattr(Checkpoints, "chunk_begins", begin)
        monkeypatch.setattr(sys.modules["lcpflex.runs.simulate"], "CHUNK_SECONDS", 0.0)


def broken_off(path: Path, monkeypatch: pytest.MonkeyPatch, build: Any = thrown, stepper: Any = None) -> None:
    """A checkpoint in the midst of a run."""
    with monkeypatch.context() as patch:
        Breaks(patch, {5})
        result = lf.simulate(build(), 0.1, stepper or lf.MoreauJean(1e-3), checkpoint=path)
    assert not result.complete
