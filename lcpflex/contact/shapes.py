"""Surfaces of bodies and of the ground, and their compilation to flat arrays.

A surface holds *slaves*, material points with a radius that may touch others, and *features*, the segments and arcs
that others may touch. Which side does what follows from the two kinds: discs and single nodes are slaves of everything,
the nodes of a chain are slaves of half-planes, arcs, holes and (in both directions) of the segments of another chain.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
import numpy.typing as npt

from lcpflex.bodies.body import MaterialPoint
from lcpflex.compiled import FloatArray
from lcpflex.errors import ModelError
from lcpflex.model import Contacts, PointTable, frozen

__all__ = ["Kind", "Surface", "arc", "chain", "circle", "compile_contacts", "half_plane", "hole", "node"]

SEGMENT, ARC = 0, 1
STRAIGHT = 1e-12  # a corner whose turn has a smaller sine is straight
SMOOTH = 0.1  # on a flexible body, a hollow corner of smaller turn [rad] may be bent to a bulge and back
HOLE_REACH = 0.5  # of the radius: how far beyond the wall of a hole a slave still belongs to it


class Kind(Enum):
    """What a surface is made of."""

    NODE = "node"
    CIRCLE = "circle"
    CHAIN = "chain"
    ARC = "arc"
    HOLE = "hole"
    HALF_PLANE = "half-plane"


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """One surface of a body, in its frame. Made by the functions of this module.

    points: material points (nodes of a chain; centre of a circle, hole or arc; two points a metre apart of a
    half-plane). radius [m] of circles, holes, arcs and discs. start, extent [rad] of arcs. closed: whether a chain ends
    where it begins. What is below an open chain is solid as far down as the chain is large.
    """

    kind: Kind
    points: tuple[MaterialPoint, ...]
    radius: float = 0.0
    start: float = 0.0
    extent: float = 2.0 * math.pi
    closed: bool = False


def node(point: MaterialPoint, radius: float = 0.0) -> Surface:
    """A single material point, or a disc about it."""
    return Surface(Kind.NODE if radius == 0.0 else Kind.CIRCLE, (point,), radius)


def circle(center: MaterialPoint, radius: float) -> Surface:
    """A disc, solid inside."""
    return Surface(Kind.CIRCLE, (center,), radius)


def hole(center: MaterialPoint, radius: float) -> Surface:
    """A circular hole, solid outside."""
    return Surface(Kind.HOLE, (center,), radius)


def arc(center: MaterialPoint, radius: float, start: float, extent: float, hole: bool = False) -> Surface:
    """Part of a circle from the angle ``start`` over ``extent`` [rad], body frame; solid inside; ``hole``: outside."""
    return Surface(Kind.HOLE if hole else Kind.ARC, (center,), radius, start, extent)


def half_plane(point: MaterialPoint, normal: npt.ArrayLike) -> Surface:
    """Everything behind the line through ``point``; ``normal`` (2,) points out of the solid."""
    direction = np.asarray(normal, dtype=float)
    along = np.array([-direction[1], direction[0]]) / np.hypot(*direction)
    # a second point a metre along the line, carried rigidly by the material at the first
    turned = np.array([-along[1], along[0]])
    second = MaterialPoint(point.place + along, point.phi + point.psi[:, None] * turned, point.psi)
    return Surface(Kind.HALF_PLANE, (point, second))


def chain(points: Sequence[MaterialPoint], closed: bool = False) -> Surface:
    """Straight pieces from node to node, solid on the left.

    Raises
    ------
    ModelError
        If two successive nodes coincide.
    """
    places = np.array([point.place for point in points])
    steps = np.diff(np.vstack([places, places[:1]]) if closed else places, axis=0)
    if len(steps) and np.hypot(*steps.T).min() == 0.0:
        raise ModelError(
            f"chain: nodes {places.tolist()} were given, expected no two successive ones at the same place"
        )
    return Surface(Kind.CHAIN, tuple(points), closed=closed)


@dataclass(slots=True)
class _Feature:
    kind: int
    points: tuple[int, int]
    radius: float = 0.0
    sense: float = 1.0
    reach: float = math.inf
    span: tuple[float, float] = (0.0, 1.0)
    neighbour: tuple[int, int] = (-1, -1)


def compile_contacts(
    surfaces: Sequence[tuple[int, Surface]],
    declared: Sequence[tuple[int, int, float, float, float]],
    points: PointTable,
) -> Contacts:
    """Flat arrays of ``surfaces`` (body index, surface) and ``declared`` contacts (surface a, surface b, mu, e_N, e_T).

    Registers their material points in ``points``.

    Raises
    ------
    ModelError
        For two surfaces that cannot touch each other, or that belong to one body.
    """
    slaves: list[tuple[int, float, FloatArray]] = []
    features: list[_Feature] = []
    slave_start, feature_start = [0], [0]
    for body, surface in surfaces:
        indices = [points.add(body, p.place, p.phi, p.psi) for p in surface.points]
        slaves += _slaves(surface, indices)
        features += _features(surface, indices, len(features))
        slave_start.append(len(slaves))
        feature_start.append(len(features))
    centers = np.array([_bounds(surface) for _, surface in surfaces]).reshape(-1, 3)
    passes = [(*pair, law) for law, (a, b, *_) in enumerate(declared) for pair in _passes(surfaces, a, b)]
    laws = np.array([numbers for _, _, *numbers in declared], dtype=float).reshape(-1, 3)
    ints = np.int64
    return Contacts(
        slave_start=frozen(slave_start, ints),
        slave_point=frozen([point for point, _, _ in slaves], ints),
        slave_radius=frozen([radius for _, radius, _ in slaves]),
        slave_normal=frozen([normal for _, _, normal in slaves], columns=2),
        feature_start=frozen(feature_start, ints),
        feature_kind=frozen([f.kind for f in features], ints),
        feature_point=frozen([f.points for f in features], ints, columns=2),
        feature_radius=frozen([f.radius for f in features]),
        feature_sense=frozen([f.sense for f in features]),
        feature_reach=frozen([f.reach for f in features]),
        feature_span=frozen([f.span for f in features], columns=2),
        feature_neighbour=frozen([f.neighbour for f in features], ints, columns=2),
        surface_body=frozen([body for body, _ in surfaces], ints),
        surface_center=frozen(centers[:, :2], columns=2),
        surface_extent=frozen(centers[:, 2]),
        surface_sway=frozen(_sway([surface for _, surface in surfaces])),
        pass_slave=frozen([a for a, _, _ in passes], ints),
        pass_feature=frozen([b for _, b, _ in passes], ints),
        pass_law=frozen([law for _, _, law in passes], ints),
        friction=frozen(laws[:, 0]),
        restitution=frozen(laws[:, 1]),
        tangential_restitution=frozen(laws[:, 2]),
    )


def _passes(surfaces: Sequence[tuple[int, Surface]], a: int, b: int) -> list[tuple[int, int]]:
    """(slave surface, feature surface) pairs of one declared contact."""
    if surfaces[a][0] == surfaces[b][0]:
        raise ModelError(f"contact: surfaces {a} and {b} belong to the same body, expected two bodies")
    kinds = surfaces[a][1].kind, surfaces[b][1].kind
    if kinds == (Kind.CHAIN, Kind.CHAIN):
        return [(a, b), (b, a)]
    rank = {Kind.NODE: 0, Kind.CIRCLE: 1, Kind.CHAIN: 2}  # the lower is the slave
    if min(rank.get(kind, 3) for kind in kinds) == 3 or kinds == (Kind.NODE, Kind.NODE):
        raise ModelError(
            f"contact: a {kinds[0].value} and a {kinds[1].value} were given, which cannot touch each other"
        )
    return [(a, b) if rank.get(kinds[0], 3) <= rank.get(kinds[1], 3) else (b, a)]


def _segments(surface: Surface) -> tuple[FloatArray, FloatArray]:
    """Start places and directions of the pieces of a chain, (k, 2) each."""
    places = np.array([point.place for point in surface.points])
    ends = np.roll(places, -1, axis=0) if surface.closed else places[1:]
    return places[: len(ends)], ends - places[: len(ends)]


def _slaves(surface: Surface, indices: list[int]) -> list[tuple[int, float, FloatArray]]:
    """(point, radius, mean outward normal) of what may touch other surfaces."""
    if surface.kind in (Kind.NODE, Kind.CIRCLE):
        return [(indices[0], surface.radius, np.zeros(2))]
    if surface.kind is not Kind.CHAIN:
        return []
    _, steps = _segments(surface)
    normals = np.stack([steps[:, 1], -steps[:, 0]], axis=1) / np.hypot(*steps.T)[:, None]
    means = np.zeros((len(indices), 2))
    means[: len(normals)] += normals
    means[(np.arange(len(normals)) + 1) % len(indices)] += normals
    lengths = np.hypot(*means.T)
    means = np.where(lengths[:, None] > STRAIGHT, means / np.maximum(lengths, STRAIGHT)[:, None], 0.0)
    return [(index, 0.0, mean) for index, mean in zip(indices, means, strict=True)]


def _features(surface: Surface, indices: list[int], first: int) -> list[_Feature]:
    """What others may touch; ``first``: index that the first feature gets."""
    if surface.kind is Kind.NODE:
        return []
    if surface.kind is Kind.HALF_PLANE:
        return [_Feature(SEGMENT, (indices[0], indices[1]), span=(-math.inf, math.inf))]
    if surface.kind is Kind.CHAIN:
        return _chain_features(surface, indices, first)
    sense = -1.0 if surface.kind is Kind.HOLE else 1.0
    reach = HOLE_REACH * surface.radius if surface.kind is Kind.HOLE else math.inf
    span = (surface.start, surface.extent)
    return [_Feature(ARC, (indices[0], indices[0]), surface.radius * sense, sense, reach, span)]


def _chain_features(surface: Surface, indices: list[int], first: int) -> list[_Feature]:
    """The segments of a chain, then a vertex (an arc of radius 0) at each convex or smooth corner and open end.

    Neighbours are the segments before and behind.
    """
    starts, steps = _segments(surface)
    n, count = len(indices), len(steps)
    reach = _reach(starts, steps)
    features = [_Feature(SEGMENT, (indices[i], indices[(i + 1) % n]), reach=float(reach[i])) for i in range(count)]
    sharp = SMOOTH if any(point.phi.any() for point in surface.points) else STRAIGHT
    for v in range(n):
        before = v - 1 if v > 0 else (count - 1 if surface.closed else -1)
        after = v if v < count else -1
        if before >= 0 and after >= 0:
            e, f = steps[before], steps[after]
            turn = math.atan2(e[0] * f[1] - e[1] * f[0], e[0] * f[0] + e[1] * f[1])
            features[before].neighbour = (features[before].neighbour[0], first + after)
            features[after].neighbour = (first + before, features[after].neighbour[1])
            if turn < -sharp and turn > STRAIGHT - math.pi:
                continue  # hollow: the two segments hold the slave between them
        meeting = tuple(first + i if i >= 0 else -1 for i in (before, after))
        span = (0.0, 2.0 * math.pi)
        features.append(_Feature(ARC, (indices[v], indices[v]), span=span, neighbour=(meeting[0], meeting[1])))
    return features


def _reach(starts: FloatArray, steps: FloatArray) -> FloatArray:
    """Half the way from the middle of each segment through the solid to the other side of the chain, or inf."""
    middle = starts + 0.5 * steps
    inward = np.stack([-steps[:, 1], steps[:, 0]], axis=1) / np.hypot(*steps.T)[:, None]
    apart = starts[None, :, :] - middle[:, None, :]
    cross = inward[:, None, 0] * steps[None, :, 1] - inward[:, None, 1] * steps[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        way = (apart[..., 0] * steps[None, :, 1] - apart[..., 1] * steps[None, :, 0]) / cross
        place = (apart[..., 0] * inward[:, None, 1] - apart[..., 1] * inward[:, None, 0]) / cross
    hit = (way > 0.0) & (place >= -1e-9) & (place <= 1.0 + 1e-9) & ~np.eye(len(steps), dtype=bool)
    return np.asarray(0.5 * np.where(hit, way, math.inf).min(axis=1))


def _bounds(surface: Surface) -> tuple[float, float, float]:
    """Bounding circle (x, y, radius), undeformed."""
    if surface.kind is Kind.HALF_PLANE:
        return (*surface.points[0].place, math.inf)
    if surface.kind is Kind.HOLE:
        return (*surface.points[0].place, (1.0 + HOLE_REACH) * surface.radius)
    places = np.array([point.place for point in surface.points])
    center = 0.5 * (places.min(axis=0) + places.max(axis=0))
    return float(center[0]), float(center[1]), float(np.hypot(*(places - center).T).max()) + surface.radius


def _sway(surfaces: Sequence[Surface]) -> FloatArray:
    """(surfaces, most modes) greatest displacement that a unit of each mode gives to a point of the surface."""
    modes = max((len(point.psi) for surface in surfaces for point in surface.points), default=0)
    sway = np.zeros((len(surfaces), max(modes, 1)))
    for row, surface in zip(sway, surfaces, strict=True):
        for point in surface.points:
            n = len(point.psi)
            row[:n] = np.maximum(row[:n], np.hypot(*point.phi.T) + (np.abs(point.psi) * surface.radius))
    return sway
