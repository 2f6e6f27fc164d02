"""A scene as points and cells that move with its bodies: what other programs show of it.

Meshes are their elements, beams and bars four-sided elements over their height, other bodies their outlines, discs and
what touches of them, and the ground its surfaces; of a half-plane a piece as long as what the bodies sweep. Bodies of
space are their surfaces (:mod:`lcpflex.results.spatial.cells`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lcpflex.contact.narrow_phase.feature import SEGMENT
from lcpflex.kinematics.places import material_shapes, turned
from lcpflex.model.layout import is_spatial
from lcpflex.model.planar import N_RIGID
from lcpflex.model.recovery import LineShapes, MeshShapes
from lcpflex.results.drawing import WHOLE, circle_points, features_of, stars, surfaces_of_bodies, view_of

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.model.arrays import Model
    from lcpflex.results.result import Result

__all__ = ["ELEMENTS", "LINE", "POLYGON", "QUAD", "VERTEX", "Motion", "Shape", "motion_of", "shapes_of"]

VERTEX, LINE, POLYGON, QUAD = 1, 4, 7, 9  # types of cells, by the numbers of VTK
ELEMENTS = {"triangle": 5, "quad": QUAD, "triangle6": 22, "quad9": 28}
GROUND = -1
FINENESS = 8.0  # points of arcs a radian: within 0.2 % of the radius, and a thousand discs stay small files


class Shape(NamedTuple):
    """Points of the ground, of rigid bodies, or of one flexible body, and the cells between them."""

    owner: IntArray  # (k,) body of each point, -1: ground
    places: FloatArray  # (k, 2) undeformed, in the frame of its body [m]
    phi: FloatArray  # (k, n, 2) mode shapes, n = 0 but for a flexible body
    cells: tuple[tuple[int, tuple[int, ...]], ...]  # type and points of each
    stress_at: IntArray | None = None  # (k,) place of ``result.stress(body)`` that each point is at


class Motion(NamedTuple):
    """Of k points at m instants, in world axes."""

    place: FloatArray  # (m, k, 2) [m]
    velocity: FloatArray  # (m, k, 2) [m/s]
    deflection: FloatArray  # (m, k, 2) A Phi q [m]


class _Drawn:
    """Points and cells of a shape while it is collected."""

    def __init__(self, modes: int) -> None:
        self._modes = modes
        self._owner: list[int] = []
        self._places: list[FloatArray] = []
        self._phi: list[FloatArray] = []
        self._cells: list[tuple[int, tuple[int, ...]]] = []

    def points(self, body: int, places: FloatArray, phi: FloatArray | None = None) -> list[int]:
        """Add points (k, 2) of a body with mode shapes (k, n, 2), or one (n, 2) for all; none: 0."""
        first = len(self._owner)
        self._owner += [body] * len(places)
        self._places.append(np.reshape(places, (-1, 2)))
        own = np.zeros((self._modes, 2)) if phi is None else phi
        self._phi.append(np.broadcast_to(own, (len(places), self._modes, 2)))
        return list(range(first, len(self._owner)))

    def cell(self, kind: int, ids: list[int]) -> None:
        self._cells.append((kind, tuple(ids)))

    def bodies(self) -> set[int]:
        return set(self._owner)

    def shape(self) -> Shape:
        places = np.concatenate([np.zeros((0, 2)), *self._places])
        phi = np.concatenate([np.zeros((0, self._modes, 2)), *self._phi])
        return Shape(np.array(self._owner, dtype=np.int64), places, phi, tuple(self._cells))


def shapes_of(result: Result, compiled: CompiledScene) -> list[Shape]:
    """Those of a scene: of its rigid bodies, of each flexible one, and of the ground, where there are any."""
    if compiled.spatial:
        from lcpflex.results.spatial.cells import spatial_shapes

        return spatial_shapes(compiled)
    modes = (np.diff(compiled.model.bodies.dof) - N_RIGID).tolist()
    recovery = compiled.recovery or (None,) * len(modes)
    recovered = {b for b, shapes in enumerate(recovery) if shapes is not None and modes[b]}
    rigid = _Drawn(0)
    drawn = {b: _Drawn(modes[b]) if modes[b] else rigid for b in range(len(modes))}
    _add_outlines(compiled, drawn, recovered)
    _add_discs(compiled, drawn, recovered)
    _add_surfaces(compiled, drawn, surfaces_of_bodies(compiled))
    _add_lines(compiled, drawn, recovered)
    for b, one in drawn.items():
        if b not in one.bodies() and b not in recovered:  # nothing but a mass
            one.cell(VERTEX, one.points(b, np.zeros((1, 2))))
    found = [rigid.shape()] if rigid.bodies() else []
    for b in (b for b in drawn if modes[b]):
        own = recovery[b]
        found += [_of_recovery(b, own)] if b in recovered and isinstance(own, LineShapes | MeshShapes) else []
        found += [drawn[b].shape()] if drawn[b].bodies() else []
    ground = _ground(result, compiled)
    return [*found, ground] if len(ground.owner) else found


def motion_of(model: Model, shape: Shape, q: FloatArray, u: FloatArray) -> Motion:
    """r = R + A (x + Phi q) and its rate over configurations q, u (m, ndof)."""
    if is_spatial(model):
        from lcpflex.results.spatial.cells import spatial_motion

        return spatial_motion(model, shape, q, u)
    if not (shape.owner >= 0).any():
        still = np.broadcast_to(shape.places, (len(q), *shape.places.shape))
        return Motion(still, np.zeros_like(still), np.zeros_like(still))
    d = model.bodies.dof[shape.owner]
    n = shape.phi.shape[1]
    bent, rate = np.zeros((2, len(q), *shape.places.shape))
    if n:
        own = slice(int(d[0]) + N_RIGID, int(d[0]) + N_RIGID + n)
        bent, rate = (np.tensordot(part[:, own], shape.phi, (1, 1)) for part in (q, u))
    s, angle, spin = shape.places + bent, q[:, d + 2], u[:, d + 2]
    across = np.stack([-spin * s[..., 1], spin * s[..., 0]], axis=-1)
    frame, moving = (np.stack([part[:, d], part[:, d + 1]], axis=-1) for part in (q, u))
    return Motion(frame + turned(angle, s), moving + turned(angle, across + rate), turned(angle, bent))


def _of_recovery(b: int, shapes: LineShapes | MeshShapes) -> Shape:
    """A mesh as its elements, or a beam or bar as elements over its height, with stresses at their nodes."""
    if isinstance(shapes, MeshShapes):
        kind = ELEMENTS[shapes.kind]
        places, phi = shapes.places, np.moveaxis(shapes.phi, 2, 1)
        cells = tuple((kind, tuple(ids)) for ids in shapes.cells.tolist())
        return Shape(np.full(len(places), b), places, phi, cells, np.arange(len(places)))
    nodes = len(shapes.stretch)
    x, y = np.meshgrid(np.linspace(0.0, shapes.length, nodes), 0.5 * shapes.height * np.arange(-1, 2), indexing="ij")
    along = shapes.stretch[:, None] - y[:, :, None] * shapes.rotation[:, None]
    phi = np.stack([along, np.broadcast_to(shapes.deflection[:, None], along.shape)], axis=-1)
    first = (3 * np.arange(nodes - 1)[:, None] + np.arange(2)).ravel()
    cells = tuple((QUAD, (k, k + 3, k + 4, k + 1)) for k in first.tolist())
    at = np.arange(3 * nodes) if shapes.second_moment else np.repeat(np.arange(nodes), 3)
    places = np.column_stack([x.ravel(), y.ravel()])
    return Shape(np.full(3 * nodes, b), places, phi.reshape(3 * nodes, -1, 2), cells, at)


def _add_outlines(compiled: CompiledScene, drawn: dict[int, _Drawn], recovered: set[int]) -> None:
    """Polygons; a body with holes as lines, for polygons have none."""
    outlines = [one for one in compiled.layout.outlines if one[0] >= 0 and one[0] not in recovered]
    loops = np.bincount([body for body, _, _ in outlines], minlength=len(drawn))
    for body, ids, closed in outlines:
        points = drawn[body].points(body, compiled.model.points.place[ids], material_shapes(compiled.model, ids))
        if closed and loops[body] == 1:
            drawn[body].cell(POLYGON, points)
        else:
            drawn[body].cell(LINE, points + points[:1] * closed)


def _add_discs(compiled: CompiledScene, drawn: dict[int, _Drawn], recovered: set[int]) -> None:
    """Polygons, with a spoke that tells how they are turned."""
    points = compiled.model.points
    for p, radius in compiled.layout.circles:
        body = int(points.body[p])
        if body >= 0 and body not in recovered:
            _add_arc(compiled, drawn[body], body, p, radius, np.array([0.0, 2.0 * np.pi]))
            spoke = points.place[p] + radius * np.array([[0.0, 0.0], [1.0, 0.0]])
            drawn[body].cell(LINE, drawn[body].points(body, spoke, material_shapes(compiled.model, np.array([p]))[0]))


def _add_arc(compiled: CompiledScene, drawn: _Drawn, body: int, p: int, radius: float, span: FloatArray) -> None:
    """A piece of a circle about the material point p, a polygon where it is whole."""
    whole = bool(span[1] >= WHOLE)
    rim = radius * circle_points(span, 0.0, FINENESS)[: -1 if whole else None]
    phi = material_shapes(compiled.model, np.array([p]))[0] if body >= 0 else None
    drawn.cell(POLYGON if whole else LINE, drawn.points(body, compiled.model.points.place[p] + rim, phi))


def _add_surfaces(compiled: CompiledScene, drawn: dict[int, _Drawn], surfaces: dict[int, list[int]]) -> None:
    """Finite surfaces: their sides as lines, their arcs."""
    contacts, model = compiled.model.contacts, compiled.model
    for body, own in surfaces.items():
        for surface in (one for one in own if np.isfinite(contacts.surface_extent[one])):
            first, last = contacts.feature_start[surface], contacts.feature_start[surface + 1]
            for f in range(int(first), int(last)):
                ends = contacts.feature_point[f]
                if contacts.feature_kind[f] == SEGMENT:
                    phi = material_shapes(model, ends) if body >= 0 else None
                    drawn[body].cell(LINE, drawn[body].points(body, model.points.place[ends], phi))
                elif contacts.feature_radius[f]:
                    radius = float(abs(contacts.feature_radius[f]))
                    _add_arc(compiled, drawn[body], body, int(ends[0]), radius, contacts.feature_span[f])


def _add_lines(compiled: CompiledScene, drawn: dict[int, _Drawn], recovered: set[int]) -> None:
    """Bodies without an outline: lines from their frame, or middle, to their points, discs and surfaces."""
    model = compiled.model
    for ends, thin in stars(compiled):
        body = int(model.points.body[ends[0][0]])
        if body in recovered:
            continue
        places = np.array([model.points.place[ids].mean(axis=0) for ids in ends])
        phi = np.array([material_shapes(model, ids).mean(axis=0) for ids in ends])
        middle = (np.zeros(2), np.zeros(phi.shape[1:])) if thin else (places.mean(axis=0), phi.mean(axis=0))
        for place, own in zip(places, phi, strict=True):
            if (place == middle[0]).all():
                continue
            line = drawn[body].points(body, np.stack([middle[0], place]), np.stack([middle[1], own]))
            drawn[body].cell(LINE, line)


def _ground(result: Result, compiled: CompiledScene) -> Shape:
    """Surfaces of the ground; half-planes as far as bodies sweep."""
    contacts, places = compiled.model.contacts, compiled.model.points.place
    own = np.flatnonzero(contacts.surface_body < 0)
    drawn = _Drawn(0)
    _add_surfaces(compiled, {GROUND: drawn}, {GROUND: own.tolist()})
    endless = own[~np.isfinite(contacts.surface_extent[own])]
    if len(endless):
        x0, x1, y0, y1 = view_of(result, compiled, np.arange(len(result.times)))
        middle, half = np.array([x0 + x1, y0 + y1]) / 2.0, np.hypot(x1 - x0, y1 - y0) / 2.0
        for ends in np.concatenate([features_of(compiled, int(surface)) for surface in endless]):
            a, b = places[ends]
            along = (b - a) / np.hypot(*(b - a))
            foot = a + along * ((middle - a) @ along)
            drawn.cell(LINE, drawn.points(GROUND, foot + half * np.stack([-along, along])))
    return drawn.shape()
