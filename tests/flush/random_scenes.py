"""Random scenes of flat bodies: flush faces, equal sizes and aligned edges are drawn on purpose.

A scene is drawn as plain numbers (:class:`Drawn`), which can be built as often as needed, and printed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.flush.pairs import BRICK, Shape, above, box, drum, gem, prism
from tests.flush.scenes import STEP, level

__all__ = ["Drawn", "Put", "build", "draw", "references", "shape_of", "stepper_of"]

YAWS = (0.0, 0.5 * math.pi, 1e-9, 1e-6, 1e-3)  # and any [rad]
ASIDE = (0.0, 0.0, 1e-10, 1e-8, 1e-6, 1e-4, 0.02, 0.1)  # over the width
GAPS = (0.0, 0.0, 1e-4, 0.02)  # [m]
DURATION = 0.25  # [s]


@dataclass(frozen=True)
class Put:
    """A body and how it starts."""

    kind: str  # box, prism, gem, drum
    numbers: tuple[float, ...]  # three edges; sides, radius, height; seed; radius, length
    place: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]  # scalar last
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    spin: float = 0.0  # about z [rad/s]


@dataclass(frozen=True)
class Drawn:
    """A scene above a floor, and a stepper."""

    seed: int
    bodies: tuple[Put, ...]
    friction: float
    restitution: float
    stepper: str


def draw(seed: int) -> Drawn:
    """The scene of a seed."""
    rng = np.random.default_rng([36, seed])
    layout = rng.choice(["stack", "bricks", "beside", "on an edge"], p=[0.4, 0.25, 0.2, 0.15])
    bodies = {"stack": _stack, "bricks": _bricks, "beside": _beside, "on an edge": _on_an_edge}[str(layout)](rng)
    friction, restitution = float(rng.choice([0.0, 0.3, 0.6])), float(rng.choice([0.0, 0.0, 0.5]))
    stepper = str(rng.choice(["EventDriven", "MoreauJean", "GeneralizedAlpha"]))
    return Drawn(seed, tuple(bodies), friction, restitution, stepper)


def shape_of(put: Put) -> Shape:
    """Its body and corners."""
    makers: dict[str, Any] = {"box": box, "prism": prism, "gem": gem, "drum": drum}
    whole = put.kind in ("prism", "gem")  # whose first number counts
    first = int(put.numbers[0]) if whole else put.numbers[0]
    made: Shape = makers[put.kind](first, *put.numbers[1:])
    return made


def _kind(rng: np.random.Generator) -> tuple[str, tuple[float, ...]]:
    """A body that stands about as wide and high as a brick."""
    kind = str(rng.choice(["box", "prism", "gem", "drum"], p=[0.65, 0.15, 0.1, 0.1]))
    if kind == "box":
        return kind, tuple(
            float(edge) for edge in (BRICK if rng.random() < 0.6 else rng.choice([BRICK, (0.1, 0.1, 0.1)]))
        )
    if kind == "gem":
        return kind, (float(rng.integers(5)),)
    if kind == "drum":
        return kind, (0.06, 0.06)
    return "prism", (float(rng.choice([4, 6, 8])), 0.08, 0.06)


def _yaw(rng: np.random.Generator) -> Rotation:
    angle = rng.choice([*YAWS, rng.uniform(-math.pi, math.pi)])
    return Rotation.from_euler("z", float(angle))


def _put(
    rng: np.random.Generator,
    kind: tuple[str, tuple[float, ...]],
    x: float,
    y: float,
    floor: float,
    turn: Rotation,
    moves: bool,
) -> tuple[Put, float]:
    """A body with its lowest corner at a height, and the height of its highest one."""
    shape = shape_of(Put(*kind, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))
    z = floor + above(shape, turn)
    moved = moves and rng.random() < 0.4
    velocity = (float(rng.uniform(-0.6, 0.6)), float(rng.choice([0.0, rng.uniform(-0.3, 0.3)])), 0.0)
    spin = float(rng.choice([0.0, rng.uniform(-3.0, 3.0)]))
    x, y, z, qx, qy, qz, qw = (float(value) for value in (x, y, z, *turn.as_quat()))
    put = Put(*kind, (x, y, z), (qx, qy, qz, qw), velocity if moved else (0.0, 0.0, 0.0), spin if moved else 0.0)
    return put, z + float(turn.apply(shape.corners)[:, 2].max())


def _stack(rng: np.random.Generator) -> list[Put]:
    """Two or three on each other, often equal."""
    kind, top, found = _kind(rng), 0.0, []
    for k in range(int(rng.choice([2, 3], p=[0.75, 0.25]))):
        kind = kind if rng.random() < 0.6 else _kind(rng)
        x, y = 0.1 * rng.choice(ASIDE, 2) * (k > 0)
        floor = top + (float(rng.choice(GAPS)) if k else 0.0)
        put, top = _put(rng, kind, x, y, floor, _yaw(rng), k > 0)
        found.append(put)
    return found


def _bricks(rng: np.random.Generator) -> list[Put]:
    """Two end to end, or side by side, and one on both."""
    length, width, height = BRICK
    along = rng.random() < 0.7
    aside = 0.1 * float(rng.choice(ASIDE[:-2]))
    step = np.array([length, aside] if along else [aside, width]) + float(rng.choice([0.0, 1e-9, 1e-4])) * np.array(
        [along, not along]
    )
    turn, kind = Rotation.identity(), ("box", BRICK)
    found = [_put(rng, kind, *(k * step), 0.0, turn, False)[0] for k in range(2)]
    upper = turn if along else Rotation.from_euler("z", 0.5 * math.pi)
    x, y = 0.5 * step + 0.1 * rng.choice(ASIDE[:-1], 2)
    yaw = Rotation.from_euler("z", float(rng.choice(YAWS)))
    return [*found, _put(rng, kind, x, y, height + float(rng.choice(GAPS)), yaw * upper, True)[0]]


def _beside(rng: np.random.Generator) -> list[Put]:
    """One slides into a side of an equal one, or along it."""
    length, width, _ = BRICK
    kind = ("box", BRICK)
    first, _ = _put(rng, kind, 0.0, 0.0, 0.0, Rotation.identity(), False)
    if rng.random() < 0.5:
        x, y, velocity = -length - float(rng.choice([1e-9, 0.02])), width * float(rng.choice(ASIDE)), (0.8, 0.0, 0.0)
    else:
        x, y, velocity = -0.05, width + float(rng.choice([0.0, 1e-9, 1e-6])), (0.5, 0.0, 0.0)
    second, _ = _put(rng, kind, x, y, 0.0, Rotation.identity(), False)
    return [first, Put(*kind, second.place, second.quaternion, velocity)]


def _on_an_edge(rng: np.random.Generator) -> list[Put]:
    """A cube falls with an edge on a brick: on its face, along its end, or across that."""
    low, top = _put(rng, ("box", BRICK), 0.0, 0.0, 0.0, Rotation.identity(), False)
    lean = Rotation.from_euler("y", float(rng.choice([45.0, 44.0, 30.0])), degrees=True)
    x = float(rng.choice([0.0, 0.05, 0.1 - 1e-6, 0.1 - 1e-3]))
    up, _ = _put(rng, ("box", (0.1, 0.1, 0.1)), x, 0.0, top + float(rng.choice(GAPS)), _yaw(rng) * lean, False)
    return [low, up]


def build(drawn: Drawn) -> lf.SpatialScene:
    """The scene."""
    scene = level()
    scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    for k, put in enumerate(drawn.bodies):
        scene.add(
            shape_of(put).body,
            f"body {k}",
            put.place,
            Rotation.from_quat(put.quaternion),
            velocity=put.velocity,
            angular_velocity=(0.0, 0.0, put.spin),
        )
    scene.contact_all(friction=drawn.friction, restitution=drawn.restitution)
    return scene


def stepper_of(drawn: Drawn) -> Any:
    """The stepper to be judged."""
    made = {"EventDriven": lf.EventDriven, "MoreauJean": lf.MoreauJean, "GeneralizedAlpha": lf.GeneralizedAlpha}
    return made[drawn.stepper](**({} if drawn.stepper == "EventDriven" else {"step": STEP}))


def references(drawn: Drawn) -> tuple[Any, Any]:
    """Two of other kinds, finer."""
    fine: dict[str, Any] = {
        "EventDriven": lf.EventDriven(rtol=1e-9),
        "MoreauJean": lf.MoreauJean(step=STEP / 10.0),
        "GeneralizedAlpha": lf.GeneralizedAlpha(
            step=STEP / 4.0
        ),  # of the second order, and dear where loads are shared
    }
    first, second = (stepper for name, stepper in fine.items() if name != drawn.stepper)
    return first, second
