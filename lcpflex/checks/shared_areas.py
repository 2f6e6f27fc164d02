"""Flat ends of bodies that are small next to the areas of a face they lie on: what both share is not told by samples.

An area counts by its samples over the other body, a node and, over the end of a cylinder, an area whole where its place
is over that. Where the end is as small as an area, that is too much or too little by a factor, and with it pressures
and laws of faces. What both have in common is known of the undeformed shapes: facets of the one cut with those of the
other.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from lcpflex.bodies.spatial.surface import FACE
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.contact.near import near, surfaces_of
from lcpflex.contact.spatial.kinds import CAP, FACET
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.kinematics.spatial.rotations import rotation_matrix
from lcpflex.model.layout import is_spatial
from lcpflex.results.result import Result

__all__ = ["common_part", "wrong_areas"]

APART = 0.2  # of the common area: pressures that are wrong by more are told
SMALL = 25.0  # areas: on more than those, samples tell what is common
FLUSH = 0.02  # [rad] between the normals of what lies flat
HIGH = 0.05  # of the width of an area: as far apart are facets that lie on each other, with what they deform
CIRCLE = 64  # corners of a polygon with the area of the end of a cylinder


class Flat(NamedTuple):
    """A facet, in the world."""

    corners: FloatArray  # (k, 3)
    normal: FloatArray  # (3,)


def wrong_areas(result: Result) -> tuple[str, ...]:
    """A warning for each contact of a face in which the common area is off when its force is the largest."""
    compiled = result.compiled
    if compiled is None or not is_spatial(compiled.model) or not len(result.times):
        return ()
    contacts = compiled.model.contacts
    kinds = np.asarray(contacts.surface_kind)
    found = []
    for s, b, law in zip(contacts.pass_node, contacts.pass_feature, contacts.pass_law, strict=True):
        record = int(result.force[:, law, 0].argmax())
        if kinds[s] != FACE or kinds[b] == FACE or not result.force[record, law, 0] > 0.0:
            continue
        told, true = _areas(compiled, np.array(result.q[record]), int(s), int(b), int(law))
        if abs(told - true) > APART * true:
            found.append(
                f"contact {result.contact_names[law]!r}: at t = {result.times[record]:.6g} s a flat end lies on "
                f"{true:.3g} m^2 of the face, which counts {told:.3g} m^2: it is too small for elements of this size, "
                "and pressures and laws of the whole face are wrong by that; expected a finer mesh there, or the whole "
                "surface of the body, body.surface(), which the corners of the other one touch"
            )
    return tuple(found)


def _areas(compiled: CompiledScene, q: FloatArray, s: int, b: int, law: int) -> tuple[float, float]:
    """[m^2] What the areas of face s count on surface b, and what both have in common; 0 where that is not known."""
    contacts = compiled.model.contacts
    nodes = slice(int(contacts.node_start[s]), int(contacts.node_start[s + 1]))
    area = np.asarray(contacts.node_area)[nodes]
    width, theirs = math.sqrt(float(area.max())), _flat_of(compiled, q, b)
    if not (width and theirs):
        return 0.0, 0.0
    mine = _flat_of(compiled, q, s)
    pairs = _flush_pairs(mine, theirs, HIGH * width)
    if sum(_size(theirs[k].corners) for k in {k for _, k in pairs}) > SMALL * area.max():
        return 0.0, 0.0
    true = sum(common_part(mine[i].corners, theirs[k].corners, mine[i].normal) for i, k in pairs)
    if not true > 0.0:
        return 0.0, 0.0
    model = pack(compiled.model)
    table, count = near(model, q, HIGH * width)
    own = [k for k in range(count) if table.law[k] == law and surfaces_of(contacts, int(table.key[k])) == (s, b)]
    return float(np.asarray(table.area)[own].sum()), true


def _flush_pairs(mine: list[Flat], theirs: list[Flat], high: float) -> list[tuple[int, int]]:
    """Which facets face each other, not farther apart than ``high`` [m], and have places beside each other."""
    a, b = (np.array([flat.normal for flat in flats]) for flats in (mine, theirs))
    one, other = np.nonzero(a @ b.T < -math.cos(FLUSH))
    c, d = (np.array([flat.corners.mean(axis=0) for flat in flats]) for flats in (mine, theirs))
    r, t = (
        np.array([np.linalg.norm(flat.corners - m, axis=1).max() for flat, m in zip(flats, middles, strict=True)])
        for flats, middles in ((mine, c), (theirs, d))
    )
    away = d[other] - c[one]
    near = (np.abs((away * a[one]).sum(axis=1)) < high) & (np.linalg.norm(away, axis=1) < r[one] + t[other] + high)
    return list(zip(one[near].tolist(), other[near].tolist(), strict=True))


def _flat_of(compiled: CompiledScene, q: FloatArray, surface: int) -> list[Flat]:
    """The facets of a surface, and ends of cylinders, where they are in the world."""
    model = compiled.model
    contacts, b = model.contacts, int(model.contacts.surface_body[surface])
    place, A = np.zeros(3), np.eye(3)
    if b >= 0:
        at = int(model.bodies.place[b])
        place, A = q[at : at + 3], np.reshape(rotation_matrix(*q[at + 3 : at + 7].tolist()), (3, 3))
    found = []
    for f in range(int(contacts.feature_start[surface]), int(contacts.feature_start[surface + 1])):
        corners = np.asarray(model.points.place)[np.asarray(contacts.feature_point)[f]]
        if contacts.feature_kind[f] == CAP:
            corners = _circle(corners, float(contacts.feature_radius[f]))
        elif contacts.feature_kind[f] != FACET:
            continue
        corners = place + corners @ A.T
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        found.append(Flat(corners, normal / np.linalg.norm(normal)))
    return found


def _circle(corners: FloatArray, radius: float) -> FloatArray:
    """(CIRCLE, 3) polygon of the area of a circle about the first of three corners, around as these go."""
    first = corners[1] - corners[0]
    first = first / np.linalg.norm(first)
    across = corners[2] - corners[0]
    across = across - (across @ first) * first
    across /= np.linalg.norm(across)
    angle = np.arange(CIRCLE) * 2.0 * math.pi / CIRCLE
    same = radius * math.sqrt(2.0 * math.pi / (CIRCLE * math.sin(2.0 * math.pi / CIRCLE)))
    return np.asarray(corners[0] + same * (np.outer(np.cos(angle), first) + np.outer(np.sin(angle), across)))


def common_part(a: FloatArray, b: FloatArray, normal: FloatArray) -> float:
    """Area [m^2] of what convex polygons (k, 3) have in common, seen along the unit ``normal`` of the first.

    By cutting b along each edge of a. Source: Sutherland & Hodgman 1974.
    """
    left = b
    for start, end in zip(a, np.roll(a, -1, axis=0), strict=True):
        if len(left) < 3:
            return 0.0
        depth = (left - start) @ np.cross(normal, end - start)
        kept: list[Any] = []
        for k in range(len(left)):
            here, there = depth[k - 1], depth[k]
            if (here < 0.0) != (there < 0.0):
                kept.append(left[k - 1] + here / (here - there) * (left[k] - left[k - 1]))
            if there >= 0.0:
                kept.append(left[k])
        left = np.array(kept)
    return _size(left, normal) if len(left) > 2 else 0.0


def _size(corners: FloatArray, normal: FloatArray | None = None) -> float:
    """Area of a plane polygon [m^2], or of what is seen of it along a normal."""
    arms = corners - corners[0]
    vector = 0.5 * np.cross(arms[1:-1], arms[2:]).sum(axis=0)
    return float(np.linalg.norm(vector)) if normal is None else abs(float(vector @ normal))
