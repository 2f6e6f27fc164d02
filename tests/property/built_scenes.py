"""Scenes of the package from random drawings, the stepper that is judged, and the references that tell the truth."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.property.own_systems import own_system
from tests.property.random_scenes import Drawn
from tests.property.yard import GRAVITY, STEEL, Push, Shape, Wall, turned

__all__ = ["build", "references", "stepper_of"]

MODES = {2: 4, 3: 6}  # of beams


def build(drawn: Drawn, exact: bool = False, finer: int = 1) -> Any:
    """The scene; ``exact``: with loads that lcpflex knows instead of Python functions of the same values.

    ``finer``: so many times as many modes of planar beams.
    """
    if drawn.system[0]:
        return own_system(drawn)
    scene: Any = (lf.Scene if drawn.dimension == 2 else lf.SpatialScene)(gravity=drawn.gravity)
    placed: list[Any] = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lf.ModelWarning)  # wave speeds of no material
        for k, shape in enumerate(drawn.shapes):
            placed.append(_put(scene, drawn, shape, f"body {k}", finer))
            _hold(scene, drawn, shape, placed)
    for push in drawn.pushes:
        scene.load(_load(drawn, placed[push.body], push, exact))
    _contacts(scene, drawn, placed)
    return scene


def _put(scene: Any, drawn: Drawn, shape: Shape, name: str, finer: int) -> Any:
    model = _body(drawn, shape)
    place = np.array(shape.place)
    options: dict[str, Any] = {"velocity": shape.speed}
    if drawn.dimension == 3:
        turn = None if not any(shape.turn) else Rotation.from_rotvec(shape.turn)
        return scene.add(model, name, place, turn, angular_velocity=shape.spin, **options)
    if shape.kind == "beam":  # its frame is at its left end
        place = place - turned(shape.turn, [0.5 * shape.numbers[0], 0.0])
        options |= {"modes": finer * MODES[2], "damping": 0.02}
    return scene.add(model, name, position=place, angle=shape.turn[0], angular_velocity=shape.spin[0], **options)


def _body(drawn: Drawn, shape: Shape) -> Any:
    numbers, space = shape.numbers, drawn.dimension == 3
    if shape.kind == "beam":
        return _beam(drawn, shape)
    if shape.kind == "hull":
        corners = np.reshape(numbers, (-1, drawn.dimension))
        return lf.ConvexHull(corners, mass=shape.mass) if space else lf.Polygon(corners, mass=shape.mass)
    makers: dict[str, Any] = {"drum": lf.Cylinder, "capsule": lf.Capsule}
    makers |= {"ball": lf.Sphere, "box": lf.Cuboid} if space else {"ball": lf.Disc, "box": lf.Box}
    return makers[shape.kind](*numbers, mass=shape.mass)


def _beam(drawn: Drawn, shape: Shape) -> Any:
    length, thickness, young = shape.numbers
    density = STEEL / drawn.metre**4
    width = shape.mass / (density * length * thickness)
    if drawn.dimension == 2:
        return lf.Beam(length, width, thickness, density, young, elements=8, axial=False)
    second = width * thickness**3 / 12.0  # alike in both directions, as of a square section: no slower, stiffer one
    beam = lf.SpatialBeam(
        length, width * thickness, (second, second), 2.0 * second, density, young, poissons_ratio=0.3, elements=8
    )
    return beam.reduce(modes=MODES[3], damping=0.02)


def _hold(scene: Any, drawn: Drawn, shape: Shape, placed: list[Any]) -> None:
    if shape.hold == "free":
        return
    body, space = placed[-1], drawn.dimension == 3
    P = body.point("left") if shape.kind == "beam" else body.at(*shape.at)
    here = np.array(shape.place) + turned(shape.turn, shape.at)
    Q = scene.ground.at(*here)
    about: dict[str, Any] = {"axis": (0.0, 1.0, 0.0)} if space else {}
    up, along = np.eye(drawn.dimension)[[-1, 0]] * drawn.length
    if shape.hold == "weld":
        scene.join(lf.Weld(P, Q))
    elif shape.hold == "pin":
        scene.join(lf.Ball(P, Q) if space else lf.Revolute(P, Q))
    elif shape.hold == "drive":
        period, amplitude = shape.hold_numbers
        motion = lf.Harmonic(amplitude, 2.0 * math.pi / period, 0.5 * math.pi, -amplitude)  # starts at rest
        scene.join(lf.Revolute(P, Q, **about))
        scene.join(lf.DrivenAngle(P, Q, motion, **about))
    elif shape.hold == "rod":
        scene.join(lf.Distance(P, scene.ground.at(*(here + 0.3 * along + up))))
    elif shape.hold == "spring":
        period, ratio = shape.hold_numbers
        omega = 2.0 * math.pi / period
        stiffness, damping = shape.mass * omega**2, 2.0 * ratio * shape.mass * omega
        scene.load(lf.Spring(P, scene.ground.at(*(here + up)), stiffness=stiffness, damping=damping))
    elif shape.hold == "guide":
        scene.join(lf.PointOnLine(P, Q, axis=tuple(along / drawn.length)))
    elif shape.hold == "hinge":
        first = drawn.shapes[len(placed) - 2]
        back = turned(tuple(-x for x in first.turn), here - np.array(first.place))
        scene.join(lf.Revolute(P, placed[-2].at(*back), **about))


def _load(drawn: Drawn, body: Any, push: Push, exact: bool) -> Any:
    signal = _signal(push, exact)
    point = body.at(*push.at) if push.at else body.point("center")
    if push.turns and drawn.dimension == 2:
        return lf.Torque(point, signal)
    made = lf.Torque if push.turns else lf.Force
    count, way = drawn.dimension, push.way
    if callable(signal):  # one Python function for all components
        return made(point, lambda t: tuple(signal(t) if k == way else 0.0 for k in range(count)))
    return made(point, tuple(signal if k == way else 0.0 for k in range(count)))


def _signal(push: Push, exact: bool) -> Any:
    """The load as lcpflex takes it; ``exact``: without Python functions."""
    omega = 2.0 * math.pi / push.period
    if push.kind == "constant":
        return push.size
    if push.kind == "function" and not exact:
        return lambda t: push.size * math.sin(omega * t + 0.3)
    if push.kind in ("harmonic", "function"):
        return lf.Harmonic(push.size, omega, 0.3)
    shares = {"ramp": [0.0, 1.0], "pulse": [0.0, 1.0, 0.0], "steps": [0.0, 1.0, 1.0, -1.0, -1.0, 1.0, 0.0]}[push.kind]
    width = 0.5 if push.kind == "pulse" else 1.0
    times = push.start + push.period * width * np.arange(len(shares))
    return lf.Table(times, push.size * np.array(shares))


def _contacts(scene: Any, drawn: Drawn, placed: list[Any]) -> None:
    """Every body with every wall and every other one but those it is hinged to."""
    numbers: dict[str, Any] = {"friction": drawn.friction, "restitution": drawn.restitution}
    walls = [_wall(scene, wall) for wall in drawn.walls]
    if drawn.kind == "flat":
        scene.contact_all(**numbers)
        return
    if drawn.stiffness:
        slip = 0.02 * drawn.speed
        numbers["law"] = lf.Penalty(drawn.stiffness, damping=drawn.law_damping, slip_speed=slip)
    surfaces = [_surfaces(body, shape) for body, shape in zip(placed, drawn.shapes, strict=True)]
    for k, shape in enumerate(drawn.shapes):
        sides = {f"wall {w}": [wall] for w, wall in enumerate(walls) if _gives(drawn, shape)}
        sides |= {f"{j}": surfaces[j] for j in range(k) if drawn.may_touch(k, j)}
        for name, others in sides.items():
            for n, (mine, other) in enumerate(product(surfaces[k], others)):
                scene.contact(mine, other, name=f"{k} {name}" + (f" {n}" if n else ""), **numbers)


def _gives(drawn: Drawn, shape: Shape) -> bool:
    """Whether it may touch walls: under the massless boundary what is flexible."""
    return drawn.stepper != "massless" or shape.kind == "beam"


def _surfaces(body: Any, shape: Shape) -> list[Any]:
    """Of the whole body; beams of space have balls at three places."""
    if shape.kind == "beam" and len(shape.place) == 3:
        return [body.sphere(point, 0.5 * shape.numbers[1]) for point in ("left", "center", "right")]
    return [body.surface()]


def _wall(scene: Any, wall: Wall) -> Any:
    """Plane, post or thin box on the ground."""
    place, numbers = np.array(wall.place), np.array(wall.numbers)
    space = len(place) == 3
    if wall.kind == "plane":
        return (scene.ground.plane if space else scene.ground.half_plane)(place, numbers)
    if wall.kind == "post":
        return (scene.ground.sphere if space else scene.ground.circle)(place, numbers[0])
    if space:
        return scene.ground.box(place + 0.5 * numbers, numbers)
    corners = [place + numbers * share for share in ((0, 0), (1, 0), (1, 1), (0, 1))]
    return scene.ground.chain(corners, closed=True)


def stepper_of(drawn: Drawn) -> Any:
    """The stepper to be judged."""
    f = drawn.fineness
    scale = min(drawn.length, drawn.metre)
    control = lf.AdaptiveStep(rtol=min(f, 1e-3), atol=1e-2 * min(f, 1e-3) * scale)
    makers: dict[str, Callable[[], Any]] = {
        "moreau": lambda: lf.MoreauJean(step=f),
        "alpha": lambda: lf.GeneralizedAlpha(step=f),
        "moreau controlled": lambda: lf.MoreauJean(step=1e-4, adaptive=control),
        "alpha controlled": lambda: lf.GeneralizedAlpha(step=1e-4, adaptive=control),
        "events": lambda: lf.EventDriven(rtol=min(f, 1e-4), atol=1e-2 * min(f, 1e-4) * scale),
        "massless": lf.MasslessBoundary,
        "runge-kutta": lambda: lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=f, atol=1e-2 * f * scale)),
        "stiff": lambda: lf.Smooth(integrator=lf.Stiff(rtol=min(f, 1e-4), atol=1e-2 * min(f, 1e-4) * scale)),
        "verlet": lambda: lf.Smooth(integrator=lf.Verlet(f)),
    }
    return makers[drawn.stepper]()


def references(drawn: Drawn) -> tuple[Any, ...]:
    """Event-driven at 1e-12 and others fine enough to confirm it, in the order in which they are asked.

    Each sees every load, and none has the step of the run that is judged.
    """
    scale = min(drawn.length, drawn.metre)
    # of the time of a fall 1e-4: an impact at the end of a step is off by less than .1 % of a body
    fine = min(1e-4 * math.pi * math.sqrt(drawn.length / (GRAVITY * drawn.metre)), 0.025 * drawn.shortest, 4e-5)
    seen = min(0.05 * drawn.shortest, 1e-3)
    events = lf.EventDriven(rtol=1e-12, atol=1e-14 * scale, max_step=seen)
    if drawn.stiffness:
        smooth = lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=1e-11, atol=1e-13 * scale, max_step=seen))
        return events, smooth
    if drawn.system[0]:  # every step calls Python; without corners an impact is off by no more than it is late
        return events, lf.MoreauJean(step=4.0 * fine)
    if drawn.stepper == "massless":
        return events, lf.MasslessBoundary(safety=0.1)
    return events, lf.MoreauJean(step=max(fine, 2e-6)), lf.GeneralizedAlpha(step=max(fine, 4e-6))
