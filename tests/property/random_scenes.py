"""Random scenes from seeds: bodies, joints, loads in time, contacts, a stepper and its step.

A scene is drawn as a description of plain numbers (:class:`Drawn`), which can be built as often as needed, printed,
and made smaller part by part where it fails (:func:`tests.property.judge.smaller`).
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import lcpflex as lf

GRAVITY = 9.81
STEEL = (7800.0, 2.1e11)  # density [kg/m^3], Young's modulus [Pa]


@dataclass(frozen=True)
class Shape:
    """A body and how it starts."""

    kind: str  # disc, box, polygon, beam
    numbers: tuple[float, ...]  # radius; width, height; x, y, x, y, ...; length, thickness, Young's modulus
    mass: float
    place: tuple[float, float, float]  # x, y, angle
    speed: tuple[float, float, float]
    hold: str = "free"  # pin, rod, spring, drive, guide, hinge to the body before it
    at: tuple[float, float] = (0.0, 0.0)  # where it is held, body frame [m]
    hold_numbers: tuple[float, ...] = ()


@dataclass(frozen=True)
class Push:
    """A load in time."""

    body: int
    way: str  # x, y, turn
    kind: str  # constant, harmonic, pulse, steps, function
    size: float  # [N] or [N m]
    period: float  # [s] of a harmonic, width of a pulse or of a step
    start: float  # [s]


@dataclass(frozen=True)
class Drawn:
    """A scene, a duration and a stepper, in plain numbers."""

    seed: int
    length: float  # typical extent [m]
    gravity: tuple[float, float]
    shapes: tuple[Shape, ...]
    pushes: tuple[Push, ...]
    walls: tuple[tuple[float, ...], ...]  # ("floor": y), thin box: x, y, width, height; post: x, y, radius
    friction: float
    restitution: float
    stiffness: float  # of contacts by law [N/m]; 0: by complementarity
    law_damping: float
    duration: float
    stepper: str
    fineness: float  # step [s] of fixed steps, tolerance of others

    @property
    def fixed(self) -> bool:
        """Whether the stepper has steps of one length."""
        return self.stepper in FIXED

    @property
    def shortest(self) -> float:
        """Shortest time over which a load, a drive or a spring changes [s]."""
        times = [push.period for push in self.pushes if push.kind != "constant"]
        times += [shape.hold_numbers[0] for shape in self.shapes if shape.hold in ("spring", "drive")]
        return min(times, default=self.duration)


FIXED = ("moreau", "alpha", "verlet")
STEPPERS = {  # share of the draws: with contacts by complementarity, by law
    "moreau": (0.3, 0.25),
    "alpha": (0.2, 0.0),
    "moreau controlled": (0.15, 0.15),
    "alpha controlled": (0.1, 0.0),
    "events": (0.25, 0.2),
    "runge-kutta": (0.0, 0.2),
    "stiff": (0.0, 0.05),
    "verlet": (0.0, 0.15),
}


def draw(seed: int) -> Drawn:
    """The scene of that seed."""
    rng = np.random.default_rng([20, seed])
    L = 10.0 ** rng.uniform(-1.7, 0.3)
    g = GRAVITY if rng.random() < 0.8 else 0.0
    lean = rng.uniform(-0.4, 0.4) if rng.random() < 0.3 else 0.0
    speed = math.sqrt(GRAVITY * L)
    count = int(rng.choice([1, 2, 3], p=[0.45, 0.35, 0.2]))
    shapes = _shapes(rng, L, speed, count)
    duration = float(rng.uniform(0.25, 0.45))
    walls = _walls(rng, L, count)
    mass = min(shape.mass for shape in shapes)
    pushes = tuple(_push(rng, int(rng.integers(count)), shapes, L, duration) for _ in range(rng.integers(0, 3)))
    by_law = rng.random() < 0.25
    names = list(STEPPERS)
    shares = np.array([STEPPERS[name][by_law] for name in names])
    stepper = str(rng.choice(names, p=shares / shares.sum()))
    fineness = 10.0 ** (rng.uniform(-4.3, -1.8) if stepper in FIXED else rng.uniform(-9.0, -3.0))
    if stepper.endswith("controlled"):
        fineness = max(fineness, 1e-7)  # of order 1 at impacts: tighter ones take millions of steps
    if stepper not in FIXED or fineness < 3e-4:  # a loop in Python: ten milliseconds a step
        pushes = tuple(replace(push, kind="harmonic") if push.kind == "function" else push for push in pushes)
    contact_time = 10.0 ** rng.uniform(-2.7, -1.7)  # [s]
    return Drawn(
        seed=seed,
        length=L,
        gravity=(-g * math.sin(lean), -g * math.cos(lean)),
        shapes=shapes,
        pushes=pushes,
        walls=walls,
        friction=float(rng.choice([0.0, rng.uniform(0.05, 1.0)], p=[0.25, 0.75])),
        restitution=0.0 if by_law else float(rng.choice([0.0, rng.uniform(0.1, 0.9)])),
        stiffness=mass * (math.pi / contact_time) ** 2 if by_law else 0.0,
        law_damping=float(rng.choice([0.0, rng.uniform(0.05, 0.5)])) / speed,
        duration=duration,
        stepper=stepper,
        fineness=fineness,
    )


def _shapes(rng: np.random.Generator, L: float, speed: float, count: int) -> tuple[Shape, ...]:
    """Bodies side by side, none touching another nor the floor."""
    shapes: list[Shape] = []
    for k in range(count):
        kind = str(rng.choice(["disc", "box", "polygon", "beam"], p=[0.35, 0.35, 0.15, 0.15]))
        # half the extent of the largest is .4 L: turned by any angle they stay clear of each other
        if kind == "disc":
            numbers: tuple[float, ...] = (float(rng.uniform(0.1, 0.35)) * L,)
            area = math.pi * numbers[0] ** 2
        elif kind == "box":
            numbers = tuple(float(x) * L for x in rng.uniform(0.1, 0.5, 2))
            area = numbers[0] * numbers[1]
        elif kind == "polygon":
            corners = int(rng.integers(3, 7))
            angles = 2.0 * math.pi * (np.arange(corners) + rng.uniform(-0.25, 0.25, corners)) / corners
            ring = 0.3 * L * np.column_stack([np.cos(angles), np.sin(angles)])
            numbers = tuple(float(x) for x in ring.ravel())
            area = 0.2 * L * L
        else:
            thickness = float(rng.uniform(0.01, 0.04)) * L
            first = 10.0 ** rng.uniform(1.0, 2.5)  # [Hz] its first free frequency
            density = STEEL[0]
            stiffness = density * (2.0 * math.pi * first * (0.75 * L) ** 2 / 22.37) ** 2 * 12.0 / thickness**2
            numbers = (0.75 * L, thickness, stiffness)
            area = 0.75 * L * thickness
        mass = area * L * 10.0 ** rng.uniform(2.0, 3.9)
        if kind == "beam":
            mass = STEEL[0] * area * 0.1 * L
        place = (1.2 * L * k, float(rng.uniform(0.45, 0.8)) * L, float(rng.uniform(-math.pi, math.pi)))
        velocity = (float(rng.uniform(-1.5, 1.5)) * speed, float(rng.uniform(-2.0, 0.5)) * speed)
        if count > 1:  # towards each other
            velocity = (float(rng.uniform(-0.3, 1.5)) * speed * (1.0 if 2 * k < count - 1 else -1.0), velocity[1])
        spin = float(rng.uniform(-1.0, 1.0)) * speed / L * 5.0
        shapes.append(_held(rng, Shape(kind, numbers, mass, place, (*velocity, spin)), L, k, shapes))
    return tuple(shapes)


def _held(rng: np.random.Generator, shape: Shape, L: float, k: int, before: list[Shape]) -> Shape:
    """The body free or held somehow; its speeds are then made to fit."""
    holds = ["free", "pin", "rod", "spring", "drive", "guide", "hinge"]
    hold = str(rng.choice(holds, p=[0.55, 0.1, 0.07, 0.1, 0.06, 0.06, 0.06]))
    rigid = shape.kind != "beam"
    if hold == "hinge" and (k == 0 or not rigid or before[-1].kind == "beam"):
        hold = "free"
    at = (0.0, 0.0)
    if hold in ("pin", "rod", "spring", "drive") and rigid:
        at = tuple(float(x) * L for x in rng.uniform(-0.3, 0.3, 2))  # type: ignore[assignment]
    x, y, angle = shape.place
    vx, vy, spin = shape.speed
    if not rigid:  # the frame of a beam is at its left end: that its middle is at the place
        half = 0.5 * shape.numbers[0]
        x, y = x - half * math.cos(angle), y - half * math.sin(angle)
    if hold == "hinge":
        at = (0.5 * (before[-1].place[0] - x), 0.0)
        angle = 0.0
    numbers: tuple[float, ...] = ()
    if hold == "spring":
        numbers = (float(10.0 ** rng.uniform(-2.5, -0.3)), float(rng.uniform(0.0, 0.1)))  # period [s], damping ratio
    elif hold == "drive":
        numbers = (float(10.0 ** rng.uniform(-1.8, 0.0)), float(rng.uniform(0.05, 0.6)))  # period [s], amplitude [rad]
    if hold in ("rod", "drive", "guide", "hinge") or (before and before[-1].hold == "hinge"):
        vx, vy, spin = 0.0, 0.0, 0.0
    if hold == "guide":
        vx = shape.speed[0]
    if hold == "pin":
        arm = (math.cos(angle) * at[0] - math.sin(angle) * at[1], math.sin(angle) * at[0] + math.cos(angle) * at[1])
        vx, vy = spin * arm[1], -spin * arm[0]
    return replace(shape, place=(x, y, angle), speed=(vx, vy, spin), hold=hold, at=at, hold_numbers=numbers)


def _walls(rng: np.random.Generator, L: float, count: int) -> tuple[tuple[float, ...], ...]:
    """Floor (1 number), thin box (4), post (3)."""
    walls: list[tuple[float, ...]] = [(0.0,)] if rng.random() < 0.85 else []
    if rng.random() < 0.5 or not walls:
        thin = float(10.0 ** rng.uniform(-2.0, -0.5)) * L
        side = -0.75 * L - thin if rng.random() < 0.5 else (1.2 * count - 0.45) * L
        walls.append((side, -0.5 * L, thin, 3.0 * L))
    if rng.random() < 0.25:
        walls.append((float(rng.uniform(0.0, 1.2 * (count - 1))) * L, -0.05 * L, float(rng.uniform(0.05, 0.12)) * L))
    return tuple(walls)


def _push(rng: np.random.Generator, body: int, shapes: tuple[Shape, ...], L: float, duration: float) -> Push:
    """A load that moves its body by something like its size."""
    kinds = ["constant", "harmonic", "pulse", "steps", "function"]
    kind = str(rng.choice(kinds, p=[0.1, 0.35, 0.3, 0.15, 0.1]))
    way = str(rng.choice(["x", "y", "turn"], p=[0.4, 0.3, 0.3]))
    period = float(10.0 ** rng.uniform(-3.5, -0.5))
    start = float(rng.uniform(0.0, 0.7)) * duration
    size = shapes[body].mass * float(rng.uniform(-1.0, 1.0)) * math.sqrt(GRAVITY * L)  # an impulse [N s]
    if way == "turn":
        size *= 0.2 * L
    time = duration if kind in ("constant", "steps") else period
    # a harmonic throws its body off by its first half period, on the average, however short that is
    return Push(body, way, kind, size / time, period, start)


def _signal(push: Push, exact: bool) -> Any:
    """The load as lcpflex takes it; ``exact``: without Python functions."""
    if push.kind == "constant":
        return push.size
    if push.kind == "harmonic" or (push.kind == "function" and exact):
        return lf.Harmonic(push.size, 2.0 * math.pi / push.period, 0.3)
    if push.kind == "function":
        omega = 2.0 * math.pi / push.period
        return lambda t: push.size * math.sin(omega * t + 0.3)
    times = push.start + push.period * np.array([0.0, 0.5, 1.0])
    values = np.array([0.0, push.size, 0.0])
    if push.kind == "steps":
        times = push.start + push.period * np.arange(7.0)
        values = push.size * np.array([0.0, 1.0, 1.0, -1.0, -1.0, 1.0, 0.0])
    return lf.Table(times, values)


def _body(shape: Shape) -> Any:
    if shape.kind == "disc":
        return lf.Disc(shape.numbers[0], mass=shape.mass)
    if shape.kind == "box":
        return lf.Box(*shape.numbers, mass=shape.mass)
    if shape.kind == "polygon":
        return lf.Polygon(np.reshape(shape.numbers, (-1, 2)), mass=shape.mass)
    length, thickness, stiffness = shape.numbers
    width = shape.mass / (STEEL[0] * length * thickness)
    return lf.Beam(length, width, thickness, STEEL[0], stiffness, elements=8, axial=False)


def build(drawn: Drawn, exact: bool = False) -> lf.Scene:
    """The scene; ``exact``: with loads that lcpflex knows instead of Python functions of the same values."""
    scene = lf.Scene(gravity=drawn.gravity)
    placed: list[Any] = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lf.ModelWarning)  # wave speeds of no material
        for shape in drawn.shapes:
            x, y, angle = shape.place
            model = _body(shape)
            flexible = {"modes": 4, "damping": 0.02} if isinstance(model, lf.Beam) else {}
            body = scene.add(
                model,
                position=(x, y),
                angle=angle,
                velocity=shape.speed[:2],
                angular_velocity=shape.speed[2],
                **flexible,
            )
            placed.append(body)
            _hold(scene, drawn, shape, placed)
    for push in drawn.pushes:
        body, signal = placed[push.body], _signal(push, exact)
        if push.way == "turn":
            scene.load(lf.Torque(body.point("center"), signal))
        else:
            value = (signal, 0.0) if push.way == "x" else (0.0, signal)
            if callable(signal):
                # one Python function for both components
                value = (lambda t, f=signal: (f(t), 0.0)) if push.way == "x" else (lambda t, f=signal: (0.0, f(t)))
            scene.load(lf.Force(body.point("center"), value))
    _contacts(scene, drawn, placed)
    return scene


def _hold(scene: lf.Scene, drawn: Drawn, shape: Shape, placed: list[Any]) -> None:
    body = placed[-1]
    x, y, angle = shape.place
    cos, sin = math.cos(angle), math.sin(angle)
    rigid = shape.kind != "beam"
    P = body.at(*shape.at) if rigid else body.point("left")
    here = (x + cos * shape.at[0] - sin * shape.at[1], y + sin * shape.at[0] + cos * shape.at[1])
    if shape.hold in ("pin", "drive"):
        scene.join(lf.Revolute(P, scene.ground.at(*here)))
    if shape.hold == "drive":
        period, amplitude = shape.hold_numbers
        motion = lf.Harmonic(amplitude, 2.0 * math.pi / period, 0.5 * math.pi, -amplitude)  # starts at rest
        scene.join(lf.DrivenAngle(P, scene.ground.at(*here), motion))
    elif shape.hold == "rod":
        scene.join(lf.Distance(P, scene.ground.at(here[0] + 0.3 * drawn.length, here[1] + drawn.length)))
    elif shape.hold == "spring":
        period, ratio = shape.hold_numbers
        omega = 2.0 * math.pi / period
        anchor = scene.ground.at(here[0], here[1] + drawn.length)
        scene.load(lf.Spring(P, anchor, stiffness=shape.mass * omega**2, damping=2.0 * ratio * shape.mass * omega))
    elif shape.hold == "guide":
        scene.join(lf.PointOnLine(P, scene.ground.at(*here), axis=(1.0, 0.0)))
    elif shape.hold == "hinge":
        first = drawn.shapes[len(placed) - 2]
        dx, dy = here[0] - first.place[0], here[1] - first.place[1]
        c, s = math.cos(first.place[2]), math.sin(first.place[2])
        scene.join(lf.Revolute(P, placed[-2].at(c * dx + s * dy, -s * dx + c * dy)))


def _contacts(scene: lf.Scene, drawn: Drawn, placed: list[Any]) -> None:
    """Every body with every wall and every other one but those it is hinged to."""
    law = None
    if drawn.stiffness:
        slip = 0.02 * math.sqrt(GRAVITY * drawn.length)
        law = lf.Penalty(drawn.stiffness, damping=drawn.law_damping, slip_speed=slip)
    numbers: dict[str, Any] = {"friction": drawn.friction, "restitution": drawn.restitution, "law": law}
    surfaces = [wall_surface(scene, wall) for wall in drawn.walls]
    for k, body in enumerate(placed):
        for w, surface in enumerate(surfaces):
            scene.contact(body.surface(), surface, name=f"{k} wall {w}", **numbers)
        for j in range(k):
            hinged = drawn.shapes[k].hold == "hinge" and j == k - 1
            if not hinged:
                scene.contact(body.surface(), placed[j].surface(), name=f"{k} {j}", **numbers)


def wall_surface(scene: lf.Scene, wall: tuple[float, ...]) -> Any:
    """Floor, post or thin box on the ground."""
    if len(wall) == 1:
        return scene.ground.half_plane((0.0, wall[0]), (0.0, 1.0))
    if len(wall) == 3:
        return scene.ground.circle(wall[:2], wall[2])
    return scene.ground.chain(box_corners(wall), closed=True)


def box_corners(wall: tuple[float, ...]) -> list[tuple[float, float]]:
    """Corners of a thin box, counter-clockwise."""
    x, y, width, height = wall
    return [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]


def stepper_of(drawn: Drawn) -> Any:
    """The stepper to be judged."""
    f = drawn.fineness
    scale = min(drawn.length, 1.0)
    control = lf.AdaptiveStep(rtol=min(f, 1e-3), atol=1e-2 * min(f, 1e-3) * scale)
    makers: dict[str, Callable[[], Any]] = {
        "moreau": lambda: lf.MoreauJean(step=f),
        "alpha": lambda: lf.GeneralizedAlpha(step=f),
        "moreau controlled": lambda: lf.MoreauJean(step=1e-4, adaptive=control),
        "alpha controlled": lambda: lf.GeneralizedAlpha(step=1e-4, adaptive=control),
        "events": lambda: lf.EventDriven(rtol=min(f, 1e-4), atol=1e-2 * min(f, 1e-4) * scale),
        "runge-kutta": lambda: lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=f, atol=1e-2 * f * scale)),
        "stiff": lambda: lf.Smooth(integrator=lf.Stiff(rtol=min(f, 1e-4), atol=1e-2 * min(f, 1e-4) * scale)),
        "verlet": lambda: lf.Smooth(integrator=lf.Verlet(f)),
    }
    return makers[drawn.stepper]()


def references(drawn: Drawn) -> tuple[Any, Any]:
    """Two steppers of other methods, ten and twenty times finer, that see every load."""
    nominal = drawn.fineness if drawn.fixed else 2e-4
    ten = min(0.1 * nominal, 0.05 * drawn.shortest, 2e-4)
    twenty = min(0.05 * nominal, 0.025 * drawn.shortest, 2e-5)
    scale = min(drawn.length, 1.0)
    tight = 1e-10 if drawn.fixed else min(1e-10, 0.05 * drawn.fineness)
    events = lf.EventDriven(rtol=tight, atol=1e-2 * tight * scale, max_step=ten)
    moreau = lf.MoreauJean(step=twenty)
    if not drawn.stiffness:
        alpha = lf.GeneralizedAlpha(step=max(ten, 1e-5))
        others = {"moreau": (events, alpha), "alpha": (events, moreau), "events": (moreau, alpha)}
        return others[drawn.stepper.split()[0]]
    smooth = lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=tight, atol=1e-2 * tight * scale, max_step=ten))
    if drawn.stepper == "events":
        return smooth, moreau
    return (events, smooth) if drawn.stepper.startswith("moreau") else (events, moreau)
