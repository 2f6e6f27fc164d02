"""Two bodies with flat faces on each other: their shapes for the package, and for brute force."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.contact.near import near
from lcpflex.jit.struct import pack
from tests.flush.places import Place
from tests.flush.polytopes import between, polytope, shadows_overlap

__all__ = [
    "BRICK",
    "KINDS",
    "ROUND",
    "Kind",
    "Shape",
    "above",
    "anywhere",
    "box",
    "detections",
    "deviations",
    "drum",
    "gem",
    "on_top",
    "prism",
]

BRICK = (0.2, 0.1, 0.06)  # [m]


EXACT = 1e-8  # of the size: what a gap may be off
SHALLOWER = 2e-4  # of the depth, likewise: a face is preferred to pairs of edges whose axis is within .02 rad of it
SLIVER = 1e-6  # of the size: of narrower overlaps it is rounding, over the sine of the yaw, where along them they end


class Shape(NamedTuple):
    """A body, its corners in its frame, and how high its centre is above the face it stands on [m]."""

    body: lf.SpatialBody
    corners: Any
    height: float


def box(a: float, b: float, c: float, mass: float = 1.0) -> Shape:
    """A cuboid."""
    corners = np.array([(x, y, z) for x in (-a, a) for y in (-b, b) for z in (-c, c)]) / 2.0
    return Shape(lf.Cuboid(a, b, c, mass=mass), corners, 0.5 * c)


def prism(sides: int, radius: float, height: float, mass: float = 1.0) -> Shape:
    """Upright, as a hull, a flat side of it towards +x."""
    angles = (np.arange(sides) + 0.5) * 2.0 * np.pi / sides
    ring = radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    corners = np.array([(*xy, z) for z in (-0.5 * height, 0.5 * height) for xy in ring])
    return Shape(lf.ConvexHull(corners, mass=mass), corners, 0.5 * height)


def gem(seed: int, corners: int = 20, size: float = 0.1) -> Shape:
    """A hull of random points on a ball, cut flat below and above; it stands on many corners."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(corners, 3))
    points *= size / np.linalg.norm(points, axis=1)[:, None]
    points[:, 2] = np.clip(points[:, 2], -0.5 * size, 0.5 * size)
    rings = np.linspace(0.0, 2.0 * np.pi, 6)[:-1]  # both flat ends are wide, whatever was drawn
    wide = 0.7 * size * np.stack([np.cos(rings), np.sin(rings)], axis=-1)
    points = np.concatenate([points, [(*xy, z) for xy in wide for z in (-0.5 * size, 0.5 * size)]])
    body = lf.ConvexHull(points, mass=1.0)
    vertices = np.array(body.shape.vertices)  # type: ignore[union-attr]  # in the frame of the mass centre
    return Shape(body, vertices, -float(vertices[:, 2].min()))


def drum(radius: float, length: float, mass: float = 1.0) -> Shape:
    """A cylinder about z, for brute force a prism inside of it."""
    angles = np.linspace(0.0, 2.0 * np.pi, 25)[:-1]
    corners = np.array([(radius * np.cos(a), radius * np.sin(a), z) for a in angles for z in (-length / 2, length / 2)])
    return Shape(lf.Cylinder(radius, length, mass=mass), corners, 0.5 * length)


def above(shape: Shape, turn: Rotation) -> float:
    """Height of the centre over the lowest corner [m]."""
    return -float(turn.apply(shape.corners)[:, 2].min())


class Kind(NamedTuple):
    """The upper body on the lower one."""

    low: Shape
    up: Shape
    width: float  # [m] what offsets are measured by
    start: float = 0.0  # x of the upper body before it is put aside [m]

    @property
    def size(self) -> float:
        """Diagonal of the smaller body [m]."""
        return min(2.0 * float(np.linalg.norm(shape.corners, axis=1).max()) for shape in (self.low, self.up))


def _bar() -> Shape:
    """Upright: what two of them do end to end."""
    return box(0.02, 0.02, 0.2)


KINDS = {
    "box on box": Kind(box(*BRICK), box(*BRICK), 0.1),
    "box on a wider box": Kind(box(0.4, 0.3, 0.1), box(*BRICK), 0.1),
    "brick on half a brick": Kind(box(*BRICK), box(*BRICK), 0.1, start=0.1),
    "prism on box": Kind(box(*BRICK), prism(6, 0.06, 0.08), 0.1),
    "box on prism": Kind(prism(8, 0.1, 0.06), box(*BRICK), 0.1),
    "gem on box": Kind(box(*BRICK), gem(3), 0.1),
    "gem on gem": Kind(gem(3), gem(4), 0.1),
    "bar on bar": Kind(_bar(), _bar(), 0.02),
}
# a cylinder, for brute force, is no polytope: its scenes rest and move, but its gaps are not judged here
ROUND = {"drum on box": Kind(box(*BRICK), drum(0.04, 0.06), 0.1)}


class Posed(NamedTuple):
    """Where the upper body is, the lower one at the origin."""

    label: Any
    turn: Rotation
    shift: Any


class Detected(NamedTuple):
    """Least and largest gap of what detection finds (infinite if nothing), and bounds of the least one [m]."""

    gap: float
    largest: float
    least: float
    most: float
    overlap: float  # of the shadows [m]


class _Detector:
    """The package's answer, the lower body at the origin."""

    def __init__(self, kind: Kind) -> None:
        scene = lf.SpatialScene()
        low, up = scene.add(kind.low.body), scene.add(kind.up.body)
        scene.contact(low.surface(), up.surface())
        compiled = scene.compile(indents=lambda name: True)
        self.model, self.q = pack(compiled.model), compiled.q.copy()

    def gaps(self, posed: Posed, margin: float) -> Any:
        self.q[7:10] = posed.shift
        self.q[10:14] = np.roll(posed.turn.as_quat(), 1)
        table, n = near(self.model, self.q, margin)
        return table.gap[:n]


def on_top(kind: Kind, places: Iterable[Place], gap: float) -> Iterator[Posed]:
    """At each place, with the lowest corner of the upper body by ``gap`` above the lower one's upper face."""
    top = float(kind.low.corners[:, 2].max())
    for place in places:
        turn = place.turn()
        yield Posed(place, turn, place.at(kind.width, kind.start, top + above(kind.up, turn) + gap))


def anywhere(kind: Kind, count: int, seed: int) -> Iterator[Posed]:
    """Turned at random, somewhere beside the lower body, a millimetre deep or up to three apart along some axis."""
    rng = np.random.default_rng(seed)
    turns = Rotation.random(count, rng=rng)
    for k, turn in enumerate(turns):
        n = rng.normal(size=3)
        n /= np.linalg.norm(n)
        beside = 0.05 * rng.normal(size=3)
        beside -= (beside @ n) * n
        reach = (kind.low.corners @ n).max() - (turn.apply(kind.up.corners) @ n + beside @ n).min()
        yield Posed(k, turn, beside + (reach + rng.uniform(-1e-3, 3e-3)) * n)


def detections(kind: Kind, poses: Iterable[Posed], margin: float) -> Iterator[tuple[Posed, Detected]]:
    """What is found and what is so."""
    detector, low, up = _Detector(kind), polytope(kind.low.corners), polytope(kind.up.corners)
    for posed in poses:
        moved, gaps = up.moved(posed.turn, posed.shift), detector.gaps(posed, margin)
        least, largest = gaps.min(initial=np.inf), gaps.max(initial=-np.inf)
        bounds = between(low, moved)
        yield posed, Detected(float(least), float(largest), *bounds, shadows_overlap(low, moved))


def deviations(kind: Kind, poses: Iterable[Posed], margin: float) -> dict[str, list[tuple[Any, float]]]:
    """Poses with nothing found of bodies that are near and overlap in shadow, with a wrong gap, or one too large."""
    lost, off, far = [], [], []
    for posed, found in detections(kind, poses, margin):
        if found.largest > margin:
            far.append((posed.label, found.largest))
        if not np.isfinite(found.gap):
            if found.overlap > 1e-9 * kind.size and found.most < margin:
                lost.append((posed.label, found.overlap))
            continue
        if abs(found.overlap) < SLIVER * kind.size:
            continue
        error = max(found.least - found.gap, found.gap - found.most)
        if error > EXACT * kind.size + SHALLOWER * max(0.0, -found.most):
            off.append((posed.label, error / kind.size))
    return {"lost": lost, "off": off, "far": far}
