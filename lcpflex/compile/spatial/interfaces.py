"""What a spatial scene asks of one of its bodies: the interfaces at which joints, loads and contacts act on it.

They are at the points of the mesh that the parts of the scene are made on: single nodes, means of sets, places between
nodes. Of a surface of triangles some nodes are taken, evenly spread: with all of them a body would have as many
coordinates as its mesh has on its boundary.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.bodies.reduction.interface import Interface
from lcpflex.bodies.spatial.surface import SpatialKind, SpatialSurface
from lcpflex.compile.spatial.mesh_features import facet_normals, node_normals
from lcpflex.compile.surface_interfaces import CORNER, Acting
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.coordinates import is_angular
from lcpflex.scene.loads.effort import Effort
from lcpflex.scene.spatial.relative import SpatialRelative

if TYPE_CHECKING:
    from lcpflex.bodies.placed_point import PlacedPoint
    from lcpflex.bodies.spatial.body import SpatialBody, SpatialPoint
    from lcpflex.scene.declared import DeclaredContact
    from lcpflex.scene.spatial.relative import SpatialJoint, SpatialLoad

__all__ = ["spatial_acting_on", "spread_nodes"]

LOOKED_AT = 16  # nodes of a surface, the ones that are taken for 3, 5 or 9 among them
AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
ROUND = (SpatialKind.SPHERE, SpatialKind.HOLE, SpatialKind.CAPSULE)  # their nodes are touched at a distance

Turned = Callable[[int], FloatArray]  # rotation matrix (3, 3) of each body at the start


def spatial_acting_on(
    body: int,
    source: SpatialBody,
    joints: Mapping[str, SpatialJoint],
    loads: Sequence[SpatialLoad],
    contacts: Mapping[str, DeclaredContact],
    count: int | None,
    turned: Turned,
) -> list[Acting]:
    """What acts on a body; of a surface of triangles, at ``count`` of its nodes, or where None looks at it.

    source: the body as it is now, which tells how its mesh is numbered.
    """
    found = [*_of_joints(body, joints, turned), *_of_loads(body, loads)]
    for name, contact in contacts.items():
        for surface in contact.pair:
            if surface.body == body:
                mesh = surface.shape.kind is SpatialKind.MESH
                rubs = contact.friction > 0.0
                own = _of_mesh(source, surface.shape, rubs, count) if mesh else _of_points(surface.shape, rubs)
                label = surface.label if mesh else ""
                found += [Acting(one, f"contact {name!r}", arm, label, at) for one, arm, at in own]
    return found


def _of_joints(body: int, joints: Mapping[str, SpatialJoint], turned: Turned) -> Iterator[Acting]:
    for name, joint in joints.items():
        rows = joint.spatial_rows()
        for point in (joint.P, joint.Q):
            if point.body == body:
                guides = point is joint.Q
                turn = np.eye(3) if guides else turned(body).T @ turned(joint.Q.body)
                yield from _of_rows(f"joint {name!r}", point, rows, turn, guides)


def _of_rows(
    name: str, point: PlacedPoint, rows: Sequence[SpatialRelative], turn: FloatArray, guides: bool
) -> Iterator[Acting]:
    """At a point whose relative coordinates are held or resisted.

    Forces along axes of Q are along these in the body of Q (``guides``), which they push with a lever; in that of P
    they are along the axes as they are at the start, ``turn`` times those of Q, if it cannot turn against Q.
    """
    forces = [row for row in rows if not is_angular(row.kind)]
    slides = any(row.kind == "along" for row in forces)
    held = sum(row.kind == "perpendicular" for row in rows) == 3
    moment = len(forces) < len(rows) or (slides and guides)
    ways: list[tuple[float, ...] | None] = [None]
    if slides and len(forces) < 3 and all(row.kind == "along" for row in forces) and (guides or held):
        ways = [tuple((turn @ np.array(row.axis)).tolist()) for row in forces]
    for k, along in enumerate(ways):
        if forces or moment:
            yield from _at(name, point.material, bool(forces), moment and k == 0, along)


def _of_loads(body: int, loads: Sequence[SpatialLoad]) -> Iterator[Acting]:
    for load in loads:
        forms = load.spatial_forms()
        rows = tuple(form.coordinate for form in forms if not isinstance(form, Effort))
        for point in (load.P, getattr(load, "Q", None)):
            if point is None or point.body != body:
                continue
            name = f"{type(load).__name__.lower()} at {point.label}"
            if rows:
                yield from _of_rows(name, point, rows, np.eye(3), point is getattr(load, "Q", None))
            for form in forms:
                if isinstance(form, Effort):
                    turns = form.kind.startswith("torque")
                    yield from _at(name, point.material, not turns, turns, _direction(form))


def _direction(form: Effort) -> tuple[float, ...] | None:
    """Of a force that always has the same one in the body."""
    if form.kind != "follower" or callable(form.value):
        return None
    fixed = [isinstance(part, Real) for part in form.value]
    if all(fixed) and any(form.value):
        return tuple(float(part) for part in form.value)  # type: ignore[arg-type]  # numbers
    moving = [k for k, part in enumerate(form.value) if not (fixed[k] and part == 0.0)]
    return AXES[moving[0]] if len(moving) == 1 else None


def _at(
    name: str, point: SpatialPoint, forces: bool, moment: bool, along: tuple[float, ...] | None
) -> Iterator[Acting]:
    """At a point of a mesh; nothing at one that none tells."""
    if point.made_at is not None:
        interface = Interface(point.made_at, along, moment, contact=False, forces=forces)
        yield Acting(interface, name, at=tuple(point.place.tolist()))


def _of_points(surface: SpatialSurface, rubs: bool) -> Iterator[tuple[Interface, float, tuple[float, ...]]]:
    """Of a surface that was made at one point or two: interface, lever of its forces there, place.

    Cylinders, rims and planes ride on the material at their first point, and push it with a lever; so does friction on
    a ball.
    """
    own = surface.points[: 2 if surface.kind is SpatialKind.CAPSULE else 1]
    lever = (surface.kind in ROUND and rubs) or surface.kind not in (*ROUND, SpatialKind.NODE)
    arm = surface.radius if surface.kind in ROUND else math.inf
    for point in own:
        if point.made_at is not None:
            yield Interface(point.made_at, None, moment=lever), arm, tuple(point.place.tolist())


def _of_mesh(
    body: SpatialBody, surface: SpatialSurface, rubs: bool, count: int | None
) -> Iterator[tuple[Interface, float, tuple[float, ...]]]:
    """Of nodes of a surface: forces along the normal where nothing rubs, and in any direction else and at edges."""
    places = np.array([point.place for point in surface.points])
    outside = np.unique(surface.triangles) if len(surface.triangles) else np.arange(len(places))
    nodes = spread_nodes(places, outside, LOOKED_AT if count is None else count)
    normals = node_normals(surface)
    facing = _least_facing(places, surface.triangles, normals)
    for node in nodes:
        smooth = not rubs and facing[node] > CORNER
        along = tuple(normals[node].tolist()) if smooth else None
        at: Any = node if body.nodes is not None else tuple((places[node] + body.origin).tolist())
        yield Interface(at, along, moment=False), math.inf, tuple(places[node].tolist())


def spread_nodes(places: FloatArray, nodes: IntArray, count: int) -> list[int]:
    """``count`` of some nodes at most, each farthest from those before it; the first one from their mean.

    The first of more are those of fewer.
    """
    own = places[nodes]
    apart = np.linalg.norm(own - own.mean(axis=0), axis=1)
    chosen: list[int] = []
    for k in range(min(count, len(nodes))):
        rounded = np.round(apart / apart.max(initial=math.ulp(0.0)), 9)  # equally far ones by their numbers
        best = int(rounded.argmax())
        chosen.append(int(nodes[best]))
        away = np.linalg.norm(own - own[best], axis=1)
        apart = away if k == 0 else np.minimum(apart, away)
    return chosen


def _least_facing(places: FloatArray, triangles: IntArray, means: FloatArray) -> FloatArray:
    """(N,) least cosine between the mean normal of a node and those of the triangles about it; 0 without."""
    units = means / np.maximum(np.linalg.norm(means, axis=1), 1e-12)[:, None]
    normals = facet_normals(places, triangles)
    least = np.where(means.any(axis=1), 1.0, 0.0)
    for k in range(3):
        vertex = triangles[:, k]
        np.minimum.at(least, vertex, np.einsum("ij,ij->i", units[vertex], normals))
    return least
