"""What is drawn of a spatial scene: surfaces of its bodies, rods and springs, at a configuration."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lcpflex.bodies.spatial.shapes import SurfaceShape
from lcpflex.kinematics.places import material_shapes, modal_sum
from lcpflex.kinematics.spatial.frames import matrices
from lcpflex.model.coordinates import ALONG, COMPONENT, DISTANCE
from lcpflex.model.spatial import N_PLACE
from lcpflex.results.spatial.facets import Facets, ellipsoid, facets_of
from lcpflex.results.spatial.surfaces import Part, parts_of

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.model.spatial import SpatialModel

__all__ = ["BODY_COLOURS", "Drawn", "Scenery", "colour_of", "coil"]

# Okabe and Ito's colours, lightened: facets in the shade stay apart from outlines.
BODY_COLOURS = np.array(
    [[86, 155, 211], [236, 142, 74], [74, 182, 142], [214, 150, 190], [236, 192, 92], [142, 206, 238], [178, 178, 178]],
    dtype=float,
)
MANY = 60  # bodies, from which on circles have half as many sides
FLAT = 0.01  # least semiaxis of an ellipsoid, relative to its largest
TURNS, WIRE, ENDS = 7, 12, 0.12  # of a coil: turns, points of each, straight share at each end
COIL = 0.09  # its radius, relative to its length at the start


class Drawn(NamedTuple):
    """A body."""

    body: int
    facets: Facets | None
    origin: FloatArray  # (3,) where its lines begin, body frame, undeformed: its mass centre
    ends: IntArray  # material points that lines of a body without a shape go to
    dots: SurfaceShape | None  # of which the vertices alone are known
    extent: float  # [m]


class Scenery:
    """Bodies, their surfaces and those of the ground, rods, springs and marks of joints of a compiled spatial scene.

    A body of unknown shape without a surface is drawn as the homogeneous ellipsoid of its mass and inertia. Lines go
    from the mass centre of a body of unknown shape to the points at which joints, springs and forces hold it.
    """

    def __init__(self, compiled: CompiledScene) -> None:
        self.model: SpatialModel = compiled.model
        bodies, many = self.model.bodies, len(compiled.layout.shapes) > MANY
        every = parts_of(self.model, compiled.layout.shapes, many)
        self.parts = [self._part(part) for part in every if part.body >= 0]
        self.solids = [part.facets for part in every if part.body < 0]  # on the ground
        self.drawn = [self._body(b, shape, many) for b, shape in enumerate(compiled.layout.shapes)]
        self.places = bodies.place.tolist()
        kinds = [set(self.model.joints.kind[a:b].tolist()) for a, b in _ranges(self.model.joints.row)]
        pairs = [(int(p), int(q)) for p, q in self.model.joints.point]
        self.rods = [pair for pair, kind in zip(pairs, kinds, strict=True) if DISTANCE in kind]
        sliding = [bool(kind & {ALONG}) for kind in kinds]
        self.joints = [(*pair, slides) for pair, slides in zip(pairs, sliding, strict=True) if pair not in self.rods]
        self.springs = _pairs(self.model, DISTANCE)
        self.bushings = sorted((set(_pairs(self.model, ALONG)) | set(_pairs(self.model, COMPONENT))) - set(pairs))
        self._lengths = {
            pair: float(np.linalg.norm(np.diff(self.at(compiled.q, pair, 1.0), axis=0))) for pair in self.springs
        }

    def _body(self, b: int, shape: object, many: bool) -> Drawn:
        bodies = self.model.bodies
        centre = bodies.moment[b] / bodies.mass[b]
        none = np.zeros(0, np.int64)
        if shape is not None:
            facets = facets_of(shape, many)  # type: ignore[arg-type]
            dots = shape if facets is None and isinstance(shape, SurfaceShape) else None
            vertices = dots.vertices if facets is None else facets.vertices  # type: ignore[union-attr]
            return Drawn(b, facets, centre, none, dots, float(np.ptp(vertices, axis=0).max(initial=0.0)))
        spread = bodies.second[b] / bodies.mass[b] - np.outer(centre, centre)
        squares, axes = np.linalg.eigh(spread)
        semiaxes = np.sqrt(5.0 * np.maximum(squares, 0.0))
        semiaxes = np.maximum(semiaxes, FLAT * semiaxes.max())
        held = np.unique(np.concatenate([self.model.joints.point.ravel(), self.model.loads.spring_point.ravel(),
                                         self.model.loads.force_point]))  # fmt: skip
        own = held[self.model.points.body[held] == b]
        reach = float(np.linalg.norm(self.model.points.place[own] - centre, axis=1).max(initial=0.0))
        parts = [part.extent for part in self.parts if part.body == b]
        if parts:
            return Drawn(b, None, centre, own, None, max(reach, *parts))
        extent = max(2.0 * semiaxes.max(), reach)
        return Drawn(b, ellipsoid(centre, axes, semiaxes, many), centre, own, None, extent)

    def _part(self, part: Part) -> Drawn:
        extent = float(np.ptp(part.facets.vertices, axis=0).max())
        return Drawn(part.body, part.facets, np.zeros(3), np.zeros(0, np.int64), None, extent)

    def frame(self, q: FloatArray, b: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Origin (3,), axes (3, 3) as columns, and modal coordinates (n,) of a body."""
        k = self.places[b]
        return q[k : k + 3], matrices(q[k + 3 : k + N_PLACE]), q[k + N_PLACE : self.places[b + 1]]

    def vertices(self, q: FloatArray, one: Drawn, scale: float) -> FloatArray:
        """(N, 3) world places of the surface of a body, deformed ``scale`` times as much as it is."""
        origin, axes, eta = self.frame(q, one.body)
        source = one.facets or one.dots
        if source is None:
            return np.zeros((0, 3))
        bent = source.vertices + modal_sum(scale * eta[: source.phi.shape[1]], source.phi)
        return np.asarray(origin + bent @ axes.T)

    def at(self, q: FloatArray, points: IntArray | tuple[int, ...], scale: float) -> FloatArray:
        """(k, 3) world places of material points, likewise."""
        found = np.empty((len(points), 3))
        for k, p in enumerate(points):
            body, place = int(self.model.points.body[p]), self.model.points.place[p]
            if body >= 0:
                origin, axes, eta = self.frame(q, body)
                phi = material_shapes(self.model, np.array([p]))[0]  # type: ignore[arg-type]
                place = origin + axes @ (place + modal_sum(scale * eta[: len(phi)], phi))
            found[k] = place
        return found

    def centre(self, q: FloatArray, one: Drawn) -> FloatArray:
        """(3,) where lines of a body begin."""
        origin, axes, _ = self.frame(q, one.body)
        return np.asarray(origin + axes @ one.origin)

    def spring(self, q: FloatArray, pair: tuple[int, int], scale: float) -> FloatArray:
        """(k, 3) line of a coil spring."""
        start, end = self.at(q, pair, scale)
        return coil(start, end, COIL * self._lengths[pair])

    def reach(self, q: FloatArray, scale: float) -> FloatArray:
        """(k, 3) places that the picture has to hold."""
        parts = [self.vertices(q, one, scale) for one in (*self.drawn, *self.parts)]
        parts += [self.at(q, one.ends, scale) for one in self.drawn if len(one.ends)]
        linked = [self.at(q, pair, scale) for pair in (*self.rods, *self.springs, *self.bushings)]
        joints = [self.at(q, (p, q_), scale) for p, q_, _ in self.joints]
        return np.concatenate([*parts, *linked, *joints])


def coil(start: FloatArray, end: FloatArray, radius: float) -> FloatArray:
    """(k, 3) a helix between two places, with straight ends."""
    along = end - start
    length = float(np.linalg.norm(along))
    if length <= 0.0:
        return np.array([start, end])
    ahead = along / length
    side = np.cross(ahead, np.eye(3)[np.argmin(np.abs(ahead))])
    side /= np.linalg.norm(side)
    turn = np.linspace(0.0, 2.0 * np.pi * TURNS, TURNS * WIRE + 1)
    share = np.linspace(ENDS, 1.0 - ENDS, len(turn))
    helix = start + np.outer(share, along)
    helix += radius * (np.outer(np.cos(turn), side) + np.outer(np.sin(turn), np.cross(ahead, side)))
    return np.concatenate([[start, start + ENDS * along], helix, [end - ENDS * along, end]])


def colour_of(body: int) -> FloatArray:
    """(3,) in bytes."""
    return np.asarray(BODY_COLOURS[body % len(BODY_COLOURS)])


def _pairs(model: SpatialModel, kind: int) -> list[tuple[int, int]]:
    """Points of springs along one kind of relative coordinate, each once."""
    chosen = model.loads.spring_point[model.loads.spring_kind == kind]
    return sorted({(int(p), int(q)) for p, q in chosen})


def _ranges(offsets: IntArray) -> list[tuple[int, int]]:
    return list(zip(offsets[:-1].tolist(), offsets[1:].tolist(), strict=True))
