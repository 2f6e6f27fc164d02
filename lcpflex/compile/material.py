"""Material points that a scene or its result is asked about: by their names, or by their places."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.arguments import absent, numbers
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.kinematics.places import material_shapes
from lcpflex.model.layout import dimension
from lcpflex.model.recovery import LineShapes, MeshShapes, SpatialLineShapes

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene

__all__ = ["body_index", "material_of", "material_points"]

WIDE = 0.5  # of the extent of a body: the mean of nodes that are farther apart moves otherwise than their middle


def material_of(
    compiled: CompiledScene | None, body: str, point: str | tuple[float, ...]
) -> tuple[Any, int, FloatArray, FloatArray]:
    """The model, body index, undeformed place (2,) and shapes (n, 2) of a named or placed point; in space 3 for 2."""
    if compiled is None:
        raise ModelError("point: a system of the user's own has no material points; expected the result of a Scene")
    layout, model = compiled.layout, compiled.model
    b = body_index(compiled, body)
    if isinstance(point, str):
        if (body, point) not in layout.points:
            known = tuple(name for owner, name in layout.points if owner == body)
            raise ModelError(f"point: {shown(body)} has no point {absent(point, known)}")
        p = layout.points[body, point]
        return model, b, model.points.place[p], material_shapes(model, np.array([p]))[0]
    place = numbers(point)
    axes = ("x", "y", "z")[: dimension(model.bodies).components]
    words = "two" if len(axes) == 2 else "three"
    if place is None or place.shape != (len(axes),) or not np.isfinite(place).all():
        raise ModelError(
            f"point: {shown(point)} was given, expected the name of a point or {words} finite numbers "
            f"({', '.join(axes)})"
        )
    phi = _shapes_at(compiled, b, place)
    if phi is None:
        handle = "body.node(x, y)" if len(axes) == 2 else "a joint, load or sensor at body.at(x, y, z)"
        raise ModelError(
            f"point: {shown(point)} is neither a named point nor on the outline of the flexible body "
            f"{shown(body)}, nor within a beam; expected one of these ({handle} before the simulation makes a place "
            f"known){_named_mean(compiled, b, place)}"
        )
    return model, b, place, phi


def body_index(compiled: CompiledScene, body: object) -> int:
    """Index of the body of that name; raises ModelError where there is none."""
    bodies = compiled.layout.bodies
    if not isinstance(body, str) or body not in bodies:
        raise ModelError(f"body: no body {absent(body, bodies)}")
    return bodies.index(body)


def _shapes_at(compiled: CompiledScene, b: int, place: FloatArray) -> FloatArray | None:
    """Mode shapes (n, 2) at an undeformed place: of a point that is there, between two on an outline, or of a beam."""
    model = compiled.model
    size = dimension(model.bodies)
    if model.bodies.dof[b + 1] - model.bodies.dof[b] == size.rigid:
        return np.zeros((0, size.components))
    own = material_points(compiled, b)
    found = _of_points(compiled, b, own, place) if own.size else None
    line = compiled.recovery[b] if found is None and compiled.recovery else None
    return _of_line(line, place) if isinstance(line, LineShapes | SpatialLineShapes) else found


def _named_mean(compiled: CompiledScene, b: int, place: FloatArray) -> str:
    """What to add where the middle of a set of nodes is asked for by its place."""
    points, body = compiled.model.points, compiled.layout.bodies[b]
    size = float(np.ptp(points.place[points.body == b], axis=0).max()) if (points.body == b).any() else 0.0
    for (owner, name), p in compiled.layout.points.items():
        if owner == body and float(np.linalg.norm(points.place[p] - place)) <= 1e-9 * size:
            return f"; the mean of the nodes of {name!r}, whose middle is there, is asked for by that name"
    return ""


def material_points(compiled: CompiledScene, b: int) -> IntArray:
    """Points of body b that move as the material at their place.

    Left out are means of nodes all over a mesh, such as its surface. Those of an end or a patch, by less than WIDE of
    its extent, stand for the material at their middle.
    """
    own = compiled.model.points.body == b
    shapes = compiled.recovery[b] if compiled.recovery else None
    if isinstance(shapes, MeshShapes):
        extent = WIDE * np.ptp(shapes.places, axis=0).max()
        for p in filter(own.item, compiled.spread):
            nodes, _ = compiled.spread[p]
            own[p] = np.ptp(shapes.places[nodes], axis=0).max() <= extent
    return np.flatnonzero(own)


def _of_points(compiled: CompiledScene, b: int, own: IntArray, place: FloatArray) -> FloatArray | None:
    """Of one of the points ``own`` of body b, or between two on its outline."""
    layout, model = compiled.layout, compiled.model
    near = 1e-9 * float(np.ptp(model.points.place[own], axis=0).max())
    distance = np.linalg.norm(model.points.place[own] - place, axis=1)
    if distance.min() <= near:
        shapes: FloatArray = material_shapes(model, own[[distance.argmin()]])[0]
        return shapes
    for owner, ids, closed in layout.outlines:
        if owner == b:
            ends = np.column_stack([ids, np.roll(ids, -1)])[: len(ids) if closed else len(ids) - 1]
            start = model.points.place[ends[:, 0]]
            edge = model.points.place[ends[:, 1]] - start
            length = np.maximum(np.einsum("ki,ki->k", edge, edge), np.finfo(float).tiny)
            s = np.clip(np.einsum("ki,ki->k", place - start, edge) / length, 0.0, 1.0)
            off = np.linalg.norm(start + s[:, None] * edge - place, axis=1)
            k = int(off.argmin())
            if off[k] <= near:
                phi = material_shapes(model, ends[k])
                return np.asarray((1.0 - s[k]) * phi[0] + s[k] * phi[1])
    return None


def _of_line(line: LineShapes | SpatialLineShapes, place: FloatArray) -> FloatArray | None:
    """(n, 2), in space (n, 3), of what a section of a beam or bar carries rigidly; None beyond its ends."""
    first = 0.0 if isinstance(line, LineShapes) else -0.5 * line.length
    slack = 1e-9 * line.length
    if not first - slack <= place[0] <= first + line.length + slack:
        return None
    x = np.clip(place[:1], first, first + line.length)
    if isinstance(line, SpatialLineShapes):
        from lcpflex.bodies.spatial.beam_elements import shapes_on_axis

        move, turn = shapes_on_axis(line.shapes, line.length, line.shear, x)
        return np.asarray(move[0].T + np.cross(turn[0].T, [0.0, place[1], place[2]]))
    if abs(place[1]) > 0.5 * line.height + slack:
        return None
    from lcpflex.bodies.fem.line_elements import LineModes, interpolate

    modes = LineModes(np.zeros(0), line.stretch, line.deflection, line.rotation)
    stretch, deflection, slope = interpolate(modes, line.length / (len(line.stretch) - 1), x)
    return np.column_stack([stretch[0] - place[1] * slope[0], deflection[0]])
