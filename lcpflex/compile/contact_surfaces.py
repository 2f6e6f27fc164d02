"""Compilation of surfaces and declared contacts to flat arrays: nodes, features, and the passes between them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from lcpflex.bodies.body import MaterialPoint
from lcpflex.bodies.surface import BOTH, NO_NODE, Kind, Surface, can_touch
from lcpflex.contact.depth_bounds import below_chain, below_hole, is_solid
from lcpflex.contact.feature_blocks import Feature, blocks_of
from lcpflex.contact.narrow_phase.feature import ARC, SEGMENT, VERTEX
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import Contacts, PointTable, frozen

__all__ = ["compile_surfaces"]

STRAIGHT = 1e-12  # [rad] a corner of smaller turn is straight
SMOOTH = 0.2  # [rad] on a flexible body, a hollow corner of smaller turn may be bent to a bulge
HOLLOW = 0.01  # [rad] a foot does not leave a segment over a hollow corner of larger turn: the next one is in the way


def compile_surfaces(
    surfaces: Sequence[tuple[int, Surface]],
    declared: Sequence[tuple[int, int, float, float, float]],
    points: PointTable,
    node_side_of: Mapping[int, int] = MappingProxyType({}),
) -> Contacts:
    """Flat arrays of ``surfaces`` (body index, surface) and ``declared`` contacts (surface a, surface b, mu, e_N, e_T).

    Registers their material points in ``points``. ``node_side_of``: by number of contact, the one that was chosen.

    Raises
    ------
    ModelError
        For two surfaces that cannot touch each other, or that belong to one body.
    """
    nodes: list[tuple[int, float, FloatArray]] = []
    features: list[Feature] = []
    node_start, feature_start = [0], [0]
    for body, surface in surfaces:
        indices = [points.add(body, p.place, p.phi, p.psi) for p in (*surface.points, *surface.ends())]
        nodes += _nodes(surface, indices)
        features += _features(surface, indices, len(features))
        node_start.append(len(nodes))
        feature_start.append(len(features))
    centers = np.array([_bounds(surface) for _, surface in surfaces]).reshape(-1, 3)
    spans = [(s.start, s.extent) for (_, s), n in zip(surfaces, np.diff(node_start), strict=True) for _ in range(n)]
    surface_block, block_start, circles, heights = blocks_of(features, feature_start)
    passes = [(*w, law) for law, d in enumerate(declared) for w in _passes(surfaces, d[0], d[1], node_side_of.get(law))]
    laws = np.array([numbers for _, _, *numbers in declared], dtype=float).reshape(-1, 3)
    ints = np.int64
    return Contacts(
        node_start=frozen(node_start, ints),
        node_point=frozen([point for point, _, _ in nodes], ints),
        node_radius=frozen([radius for _, radius, _ in nodes]),
        node_normal=frozen([normal for _, _, normal in nodes], columns=2),
        node_span=frozen(spans, columns=2),
        feature_start=frozen(feature_start, ints),
        feature_kind=frozen([f.kind for f in features], ints),
        feature_point=frozen([f.points for f in features], ints, columns=2),
        feature_radius=frozen([f.radius for f in features]),
        feature_sense=frozen([f.sense for f in features]),
        feature_depth=frozen([f.reach for f in features], columns=3),
        feature_span=frozen([f.span for f in features], columns=2),
        feature_neighbour=frozen([f.neighbour for f in features], ints, columns=2),
        surface_block=surface_block,
        block_start=block_start,
        block_circle=circles,
        block_height=heights,
        surface_body=frozen([body for body, _ in surfaces], ints),
        surface_center=frozen(centers[:, :2], columns=2),
        surface_extent=frozen(centers[:, 2]),
        surface_deflection=frozen(_deflection([surface for _, surface in surfaces])),
        pass_node=frozen([a for a, _, _ in passes], ints),
        pass_feature=frozen([b for _, b, _ in passes], ints),
        pass_law=frozen([law for _, _, law in passes], ints),
        friction=frozen(laws[:, 0]),
        restitution=frozen(laws[:, 1]),
        tangential_restitution=frozen(laws[:, 2]),
    )


def _passes(surfaces: Sequence[tuple[int, Surface]], a: int, b: int, node_side: int | None) -> list[tuple[int, int]]:
    """(node surface, feature surface) pairs of one declared contact; one only where a ``node_side`` is chosen."""
    if surfaces[a][0] == surfaces[b][0]:
        raise ModelError(f"contact: surfaces {a} and {b} belong to the same body, expected two bodies")
    first, second = surfaces[a][1], surfaces[b][1]
    if not can_touch(first, second):
        raise ModelError(
            f"contact: a {first.kind.value} and a {second.kind.value} were given, which cannot touch each other"
        )
    if node_side is not None:
        return [(node_side, a + b - node_side)]
    if BOTH <= first.rank < NO_NODE and BOTH <= second.rank < NO_NODE:
        return [(a, b), (b, a)]
    return [(a, b) if first.rank <= second.rank else (b, a)]


def _segments(surface: Surface) -> tuple[FloatArray, FloatArray]:
    """Start places and directions of the pieces of a chain, (k, 2) each."""
    places = np.array([point.place for point in surface.points])
    ends = np.roll(places, -1, axis=0) if surface.closed else places[1:]
    return places[: len(ends)], ends - places[: len(ends)]


def _nodes(surface: Surface, indices: list[int]) -> list[tuple[int, float, FloatArray]]:
    """(point, radius, mean outward normal) of what may touch other surfaces.

    The end of an open chain is a right-angled corner of the solid. That of an arc touches whatever the arc itself does
    not, on the side that it ends at: the outward direction along the arc stands for its normal.
    """
    if surface.kind in (Kind.NODE, Kind.CIRCLE, Kind.ARC, Kind.HOLE):
        own = [] if surface.kind is Kind.HOLE else [(indices[0], surface.radius, np.zeros(2))]
        return own + [(index, 0.0, _end_direction(surface, at)) for at, index in enumerate(indices[1:])]
    if surface.kind is not Kind.CHAIN:
        return []
    _, steps = _segments(surface)
    along = steps / np.hypot(*steps.T)[:, None]
    normals = np.stack([along[:, 1], -along[:, 0]], axis=1)
    means = np.zeros((len(indices), 2))
    means[: len(normals)] += normals
    means[(np.arange(len(normals)) + 1) % len(indices)] += normals
    if not surface.closed:
        begins, ends = surface.goes_on()
        means[0] -= 0.0 if begins else along[0]
        means[-1] += 0.0 if ends else along[-1]
    lengths = np.hypot(*means.T)
    means = np.where(lengths[:, None] > STRAIGHT, means / np.maximum(lengths, STRAIGHT)[:, None], 0.0)
    return [(index, 0.0, mean) for index, mean in zip(indices, means, strict=True)]


def _end_direction(surface: Surface, at: int) -> FloatArray:
    """The direction in which an arc would go on beyond its beginning (0) or its end (1)."""
    angle = surface.start + at * surface.extent
    along = np.array([-math.sin(angle), math.cos(angle)])
    return along if at == 1 else -along


def _features(surface: Surface, indices: list[int], first: int) -> list[Feature]:
    """What others may touch; ``first``: index that the first feature gets."""
    if surface.kind is Kind.NODE:
        return []
    if surface.kind is Kind.CHAIN:
        return _chain_features(surface, indices, first)
    circle = _bounds(surface)
    if surface.kind is Kind.HALF_PLANE:
        return [Feature(SEGMENT, (indices[0], indices[1]), circle, span=(-math.inf, math.inf))]
    sense = -1.0 if surface.kind is Kind.HOLE else 1.0
    reach = _hole_depth(surface) if surface.kind is Kind.HOLE else math.inf
    span = (surface.start, surface.extent)
    pair = (indices[0], indices[0])
    own = Feature(ARC, pair, circle, (0.0, 0.0), surface.radius * sense, sense, (reach, reach, reach), span)
    ends = zip(surface.ends(), indices[1:], ((-1, first), (first, -1)), strict=False)
    return [own, *(_corner(point, index, meeting) for point, index, meeting in ends)]


def _corner(point: MaterialPoint, index: int, meeting: tuple[int, int]) -> Feature:
    """A vertex; ``meeting``: the features that end and begin there, -1 for none."""
    circle = (float(point.place[0]), float(point.place[1]), 0.0)
    return Feature(VERTEX, (index, index), circle, span=(0.0, 2.0 * math.pi), neighbour=meeting)


def _chain_features(surface: Surface, indices: list[int], first: int) -> list[Feature]:
    """The segments of a chain, then a vertex at each corner that may bulge, and each open end.

    Neighbours of a segment are the segments before and after it; those of a vertex the segments that meet in it.
    """
    starts, steps = _segments(surface)
    n, count = len(indices), len(steps)
    reach = _chain_depth(surface)
    lengths = np.hypot(*steps.T)
    features = []
    for i in range(count):
        middle = starts[i] + 0.5 * steps[i]
        circle = (float(middle[0]), float(middle[1]), 0.5 * float(lengths[i]))
        depths = (float(reach[i, 0]), float(reach[i, 1]), float(reach[i, 2]))
        normal = (float(steps[i, 1] / lengths[i]), float(-steps[i, 0] / lengths[i]))
        features.append(Feature(SEGMENT, (indices[i], indices[(i + 1) % n]), circle, normal, reach=depths))
    begins, ends = surface.goes_on()
    if begins and not surface.closed:
        features[0].span = (-math.inf, features[0].span[1])
    if ends and not surface.closed:
        features[-1].span = (features[-1].span[0], math.inf)
    sharp = SMOOTH if any(point.phi.any() for point in surface.points) else STRAIGHT
    for v in range(n):
        before = v - 1 if v > 0 else (count - 1 if surface.closed else -1)
        after = v if v < count else -1
        if before >= 0 and after >= 0:
            e, f = steps[before], steps[after]
            features[before].neighbour = (features[before].neighbour[0], first + after)
            features[after].neighbour = (first + before, features[after].neighbour[1])
            turn = math.atan2(e[0] * f[1] - e[1] * f[0], e[0] * f[0] + e[1] * f[1])
            if STRAIGHT - math.pi < turn < -max(sharp, HOLLOW):
                features[before].span = (features[before].span[0], math.inf)
                features[after].span = (-math.inf, features[after].span[1])
            if STRAIGHT - math.pi < turn < -sharp:
                continue  # hollow: the two segments hold the node between them
        elif surface.goes_over:
            continue
        meeting = (first + before if before >= 0 else -1, first + after if after >= 0 else -1)
        features.append(_corner(surface.points[v], indices[v], meeting))
    return features


def _chain_depth(surface: Surface) -> FloatArray:
    places = np.array([point.place for point in surface.points])
    return below_chain(places, surface.closed, surface.outline)


def _hole_depth(surface: Surface) -> float:
    return min(below_hole(surface.points[0].place, surface.radius, surface.outline), 0.5 * surface.wall)


def _bounds(surface: Surface) -> tuple[float, float, float]:
    """Circle (x, y, radius), undeformed, that holds the surface and all nodes that belong to it."""
    if surface.kind is Kind.HALF_PLANE:
        return (*surface.points[0].place, math.inf)
    if surface.kind is Kind.HOLE:
        return (*surface.points[0].place, surface.radius + _hole_depth(surface))
    places = np.array([point.place for point in surface.points])
    center = 0.5 * (places.min(axis=0) + places.max(axis=0))
    extent = float(np.hypot(*(places - center).T).max()) + surface.radius
    if surface.kind is Kind.CHAIN and not is_solid(places, surface.closed):
        extent += float(_chain_depth(surface).max())
    return float(center[0]), float(center[1]), extent


def _deflection(surfaces: Sequence[Surface]) -> FloatArray:
    """(surfaces, most modes) greatest displacement that a unit of each mode gives to a point of the surface."""
    modes = max((len(point.psi) for surface in surfaces for point in surface.points), default=0)
    deflection = np.zeros((len(surfaces), max(modes, 1)))
    for row, surface in zip(deflection, surfaces, strict=True):
        for point in surface.points:
            n = len(point.psi)
            row[:n] = np.maximum(row[:n], np.hypot(*point.phi.T) + (np.abs(point.psi) * surface.radius))
    return deflection
