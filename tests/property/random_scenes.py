"""Random scenes of plane and space from seeds: bodies, joints, loads in time, contacts, a stepper and its step.

A scene is drawn as a description of plain numbers (:class:`Drawn`), which can be built as often as needed
(:mod:`tests.property.built_scenes`), printed, and made smaller part by part where it fails (:func:`smaller`). Vectors
have as many components as the scene has dimensions, and the last one points up. Which kind of scene a seed has is
fixed: of each twenty seeds each kind of :mod:`tests.property.kinds` has its share.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from tests.property.kinds import KINDS, Layout
from tests.property.yard import GRAVITY, Push, Shape, Vector, Wall, Yard

__all__ = ["FIXED", "Drawn", "draw", "smaller"]

FIXED = ("moreau", "alpha", "verlet")  # of one step length
RIGID = {"moreau": 0.3, "alpha": 0.2, "moreau controlled": 0.15, "alpha controlled": 0.1, "events": 0.25}
BY_LAW = {"moreau": 0.25, "moreau controlled": 0.15, "events": 0.2, "runge-kutta": 0.2, "stiff": 0.05, "verlet": 0.15}
UNITS = 0.15  # share of the scenes that are in mm, tonnes and seconds


@dataclass(frozen=True)
class Drawn:
    """A scene, a duration and a stepper, in plain numbers."""

    dimension: int
    seed: int
    kind: str  # of KINDS
    length: float  # typical extent [m]
    metre: float  # in its unit of length
    gravity: Vector
    shapes: tuple[Shape, ...]
    pushes: tuple[Push, ...]
    walls: tuple[Wall, ...]
    friction: float
    restitution: float
    stiffness: float  # of contacts by law [N/m]; 0: by complementarity
    law_damping: float  # [s/m]
    system: tuple[str, tuple[float, ...]]  # of the user's own: its name and numbers; then there are no bodies
    duration: float
    stepper: str
    fineness: float  # step [s] of fixed steps, tolerance of others

    @property
    def fixed(self) -> bool:
        """Whether the stepper has steps of one length."""
        return self.stepper in FIXED

    @property
    def speed(self) -> float:
        """What gravity makes of the length [m/s]."""
        return float(np.sqrt(GRAVITY * self.metre * self.length))

    @property
    def shortest(self) -> float:
        """Shortest time over which a load, a drive or a spring changes [s]."""
        times = [push.period for push in self.pushes if push.kind != "constant"]
        times += [shape.hold_numbers[0] for shape in self.shapes if shape.hold in ("spring", "drive")]
        return min(times, default=self.duration)

    def joined(self, first: int, second: int) -> bool:
        """Whether a hinge joins two bodies, so that they are no contact."""
        low, high = sorted((first, second))
        return self.shapes[high].hold == "hinge" and low == high - 1

    def may_touch(self, first: int, second: int) -> bool:
        """Whether a contact of two bodies is declared: under the massless boundary one of them must be flexible."""
        soft = self.stepper != "massless" or "beam" in (self.shapes[first].kind, self.shapes[second].kind)
        return soft and not self.joined(first, second)


def draw(dimension: int, seed: int) -> Drawn:
    """The scene of that seed."""
    kind = KINDS[seed % len(KINDS)]
    rng = np.random.default_rng([37, dimension, seed])
    yard = Yard(rng, dimension, metre=1e3 if rng.random() < UNITS else 1.0)
    layout = kind(yard)
    shares = _steppers(layout)
    stepper = str(rng.choice(list(shares), p=np.array(list(shares.values())) / sum(shares.values())))
    low, high = (-4.3, -1.8) if stepper in FIXED else (-9.0, -3.0)
    if stepper.endswith("controlled"):
        low = -6.0  # of order 1 at impacts: tighter ones take millions of steps
    fineness = 10.0 ** rng.uniform(low, high)
    if layout.touch and stepper in FIXED:  # so many steps a touch
        fineness = layout.touch / 10.0 ** rng.uniform(0.3, 2.0)
    friction = float(rng.choice([0.0, rng.uniform(0.05, 1.0)], p=[0.25, 0.75]))
    restitution = float(rng.choice([0.0, rng.uniform(0.1, 0.9)]))
    rigid = not layout.touch and stepper != "massless"
    drawn = Drawn(
        dimension=dimension,
        seed=seed,
        kind=kind.__name__,
        length=yard.length,
        metre=yard.metre,
        gravity=layout.gravity,
        shapes=layout.shapes,
        pushes=layout.pushes,
        walls=layout.walls,
        friction=friction if layout.friction is None else layout.friction,
        restitution=(restitution if layout.restitution is None else layout.restitution) if rigid else 0.0,
        stiffness=layout.shapes[0].mass * (np.pi / layout.touch) ** 2 if layout.touch else 0.0,
        law_damping=float(rng.choice([0.0, rng.uniform(0.05, 0.5)])) / yard.speed,
        system=layout.system,
        duration=float(rng.uniform(0.25, 0.45)),
        stepper=stepper,
        fineness=float(fineness),
    )
    if drawn.fixed and fineness >= 3e-4:
        return drawn
    quick = tuple(replace(push, kind="harmonic") if push.kind == "function" else push for push in drawn.pushes)
    return replace(drawn, pushes=quick)  # a loop in Python takes ten milliseconds a step


def _steppers(layout: Layout) -> dict[str, float]:
    """Those that take the scene, with their shares of the draws."""
    if layout.touch:
        return BY_LAW
    planar_beam = len(layout.gravity) == 2 and layout.shapes[:1] and layout.shapes[0].kind == "beam"
    return {**RIGID, "massless": 0.5} if layout.held and planar_beam else RIGID


def smaller(drawn: Drawn) -> Iterator[Drawn]:
    """The scene with one part less: what a failure is shrunk by, by hand."""
    for k in range(len(drawn.pushes)):
        yield replace(drawn, pushes=drawn.pushes[:k] + drawn.pushes[k + 1 :])
    for k in range(len(drawn.walls)):
        yield replace(drawn, walls=drawn.walls[:k] + drawn.walls[k + 1 :])
    last = len(drawn.shapes) - 1
    if last > 0 and all(push.body < last for push in drawn.pushes):
        yield replace(drawn, shapes=drawn.shapes[:last])
    for k, shape in enumerate(drawn.shapes):
        if shape.hold != "free":
            yield replace(drawn, shapes=(*drawn.shapes[:k], replace(shape, hold="free"), *drawn.shapes[k + 1 :]))
