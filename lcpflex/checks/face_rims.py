"""Contacts that reach the rim of a named face though the surface of the body goes on there.

Beyond the rim nothing touches, and what should press there presses on the rim: pressures are up to twice too high. A
rim that is an edge of the body is none of these.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.bodies.spatial.surface import FACE
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.compile.spatial.mesh_features import facet_normals, sides_of
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.kinematics.spatial.rotations import rotation_matrix
from lcpflex.model.layout import is_spatial
from lcpflex.results.result import Result

__all__ = ["cut_vertices", "reached_rims"]

BENT = 0.2  # [rad] facets that meet at a smaller angle are one surface, which a contact may pass over
PRESSED = 0.05  # of the largest force of a touching point: what is less is the edge of a contact that ends there
DIGITS = 9  # of the size of a body, to which places of vertices are told


def reached_rims(result: Result) -> tuple[str, ...]:
    """A warning for each contact of a face that is pressed at such a rim when its force is the largest."""
    compiled = result.compiled
    if compiled is None or not is_spatial(compiled.model) or not compiled.layout.shapes:
        return ()
    contacts = compiled.model.contacts
    kinds = np.asarray(contacts.surface_kind)
    found = []
    for s, law in zip(contacts.pass_node.tolist(), contacts.pass_law.tolist(), strict=True):
        record = int(result.force[:, law, 0].argmax()) if len(result.times) else 0
        if kinds[s] == FACE and result.force[record, law, 0] > 0.0 and _is_pressed(result, compiled, s, law, record):
            found.append(
                f"contact {result.contact_names[law]!r}: at t = {result.times[record]:.6g} s, when its force is the "
                "largest, it reaches the rim of its face, beyond which the surface of the body goes on and touches "
                "nothing: pressures there are too high; expected a larger face"
            )
    return tuple(found)


def _is_pressed(result: Result, compiled: CompiledScene, s: int, law: int, record: int) -> bool:
    """Whether a touching point of contact ``law`` at a stored instant is at such a rim of surface s."""
    model = compiled.model
    b = int(model.contacts.surface_body[s])
    first, last = (int(model.contacts.feature_start[s + k]) for k in range(2))
    corners = np.asarray(model.contacts.feature_point)[first:last]
    vertices = np.unique(corners)
    places = np.asarray(model.points.place)[vertices]
    shape = compiled.layout.shapes[b]
    triangles = getattr(shape, "triangles", np.zeros((0, 3), np.int64))
    if not len(triangles):
        return False
    cut = cut_vertices(places, np.searchsorted(vertices, corners), np.asarray(shape.vertices), triangles)
    points = result.contact_points.at(record)
    own = points.contact == law
    force = points.normal_force[own]
    if not cut.any() or not len(force):
        return False
    at = int(model.bodies.place[b])
    q = result.q[record]
    A = np.reshape(rotation_matrix(*q[at + 3 : at + 7].tolist()), (3, 3))
    local = (points.place[own] - q[at : at + 3]) @ A
    pressed = local[force > PRESSED * force.max()]
    nearest = np.linalg.norm(pressed[:, None] - places[None], axis=2).argmin(axis=1)
    return bool(cut[nearest].any())


def cut_vertices(places: FloatArray, own: IntArray, surface: FloatArray, whole: IntArray) -> Any:
    """(V,) which vertices of a face are on edges of its rim at which the surface of the body goes on smoothly.

    places (V, 3) of the triangles ``own`` (F, 3) of the face, ``surface`` (N, 3) of the triangles ``whole`` (T, 3).
    """
    size = float(np.ptp(surface, axis=0).max())
    keys = {tuple(key): k for k, key in enumerate(np.round(places / size, DIGITS).tolist())}
    number = np.array([keys.get(tuple(key), -1) for key in np.round(surface / size, DIGITS).tolist()])
    known = number[whole]  # corners of the whole surface that are vertices of the face
    sides, mine, theirs = sides_of(own), facet_normals(places, own), facet_normals(surface, whole)
    of_face = {frozenset(corners) for corners in own.tolist()}
    cut = np.zeros(len(places), dtype=bool)
    for facet in np.flatnonzero((known >= 0).sum(axis=1) >= 2).tolist():
        corners = known[facet].tolist()
        if frozenset(corners) in of_face:
            continue
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            beside = sides.get((min(a, b), max(a, b)), [])
            if len(beside) == 1 and mine[beside[0][0]] @ theirs[facet] > np.cos(BENT):
                cut[[a, b]] = True
    return cut
