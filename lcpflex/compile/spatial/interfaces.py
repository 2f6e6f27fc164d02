"""What a spatial scene asks of one of its bodies: the interfaces at which joints, loads and contacts act on it.

They are at the points of the mesh that the parts of the scene are made on: single nodes, means of sets, places between
nodes. Of a surface of triangles some nodes are taken, evenly spread: with all of them a body would have as many
coordinates as its mesh has on its boundary. A named face is where contact is expected: all its nodes are taken where
these are few. A larger one is divided into patches, each with one force that its nodes share by area: together these
make a uniform pressure, and the face leans on no few of its nodes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from numbers import Real
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem.faces import areas_of, even_parts
from lcpflex.bodies.reduction.interface import Interface, NodeMean
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
# Of a named face: at how many nodes it gives way along its normals at most, and at how many patches along itself, which
# moves little. A contact of radius a on elements of a/4, within a face of 121 nodes, has 3.4 % more force with 60
# patches than with all nodes, 6.5 % with 30; the face that ``near`` makes has some 220 nodes.
FACE_NODES, FACE_PATCHES = 250, 30
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
    of_face: int | None = None,
) -> list[Acting]:
    """What acts on a body; of a surface of triangles, at ``count`` of its nodes, or where None looks at it.

    source: the body as it is now, which tells how its mesh is numbered. of_face: at how many nodes or patches of a
    named face at most; None: all that a contact needs.
    """
    found = [*_of_joints(body, joints, turned), *_of_loads(body, loads)]
    for name, contact in contacts.items():
        for surface in contact.pair:
            if surface.body == body:
                shape, rubs, label = surface.shape, contact.friction > 0.0, surface.label
                face = shape.kind is SpatialKind.FACE
                if face:
                    own = _of_face(shape, rubs, of_face)
                elif shape.kind is SpatialKind.MESH:
                    own = _of_mesh(source, shape, rubs, count)
                else:
                    own, label = _of_points(shape, rubs), ""
                found += [Acting(one, f"contact {name!r}", arm, label, at, face) for one, arm, at in own]
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


def _of_face(
    surface: SpatialSurface, rubs: bool, count: int | None
) -> Iterator[tuple[Interface, float, tuple[float, ...]]]:
    """Of a named face: at ``count`` of its nodes or patches at most; None: FACE_NODES, along itself FACE_PATCHES."""
    many = FACE_NODES if count is None else count
    few = FACE_PATCHES if count is None else count
    apart = rubs and min(many, len(surface.points)) > few
    for patch in _patches(surface, many):
        yield from _at_patch(patch, [None] if patch.normal is None or (rubs and not apart) else [patch.normal])
    for patch in _patches(surface, few) if apart else ():
        yield from _at_patch(patch, [None] if patch.normal is None else [*_across(patch.normal)])


class _Patch(NamedTuple):
    """Nodes of a face that share a force by area."""

    place: int | NodeMean
    at: tuple[float, ...]  # (3,) their mean [m]
    normal: FloatArray | None  # (3,) of all of it; None where it bends


def _patches(surface: SpatialSurface, count: int) -> Iterator[_Patch]:
    """The nodes of a face where they are no more than ``count``, else so many patches: what is nearest to each seed."""
    places = np.array([point.place for point in surface.points])
    parts = even_parts(np.array(surface.cells))
    share = np.repeat(areas_of(places, parts), parts.shape[1])
    area = np.bincount(parts.ravel(), share, len(places))
    seeds = spread_nodes(places, np.arange(len(places)), count)
    _, nearest = libs.cKDTree(places[seeds]).query(places) if seeds else (None, np.full(len(places), -1))
    normals = facet_normals(places, surface.triangles)
    nodal = area[:, None] * node_normals(surface)
    for k in range(len(seeds)):
        own = np.flatnonzero(nearest == k)
        mean = nodal[own].sum(axis=0)
        size = float(np.linalg.norm(mean))
        touched = normals[np.isin(surface.triangles, own).any(axis=1)]
        smooth = size > 0.0 and bool((touched @ mean > CORNER * size).all())
        weights = area[own] / area[own].sum()
        numbers = [surface.points[node].made_at for node in own]
        place = numbers[0] if len(own) == 1 else NodeMean(tuple(numbers), tuple(weights.tolist()))
        yield _Patch(place, tuple((weights @ places[own]).tolist()), mean / size if smooth else None)


def _at_patch(patch: _Patch, ways: Sequence[FloatArray | None]) -> Iterator[tuple[Interface, float, tuple[float, ...]]]:
    for way in ways:
        along = None if way is None else tuple(way.tolist())
        yield Interface(patch.place, along, moment=False), math.inf, patch.at


def _across(normal: FloatArray) -> FloatArray:
    """(2, 3) directions across one, and each other."""
    first = np.cross(normal, np.eye(3)[int(np.abs(normal).argmin())])
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first)])


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
