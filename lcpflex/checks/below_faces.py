"""What is below a face of a solid without being felt there: corners and balls smaller than what the face touches with.

The nodes or areas of a face are what touches. A corner, or a ball, that comes down between them goes in until one of
them feels it, or through. So the nodes and edges of the other surface are looked at over the face, at some stored
instants. An area at a corner or an edge of its own body, which lands on it, is far behind that: so the nodes of the
face are looked at as well.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from lcpflex.bodies.spatial.surface import CODES, FACE, SpatialKind
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.contact.near import near
from lcpflex.contact.spatial.bounds import bound
from lcpflex.contact.spatial.faces.detection import depth_along, depth_below, depth_of
from lcpflex.contact.spatial.kinds import EDGE, SIDE
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import pack
from lcpflex.model.layout import is_spatial
from lcpflex.results.result import Result

__all__ = ["sunk_below_faces"]

INSTANTS = 20  # looked at: that of the largest force, the last one, and some between
DEEP = 0.05  # of the width of an area or of the way between nodes: resolved contacts are a tenth of that deep
MOST_WORK = 20_000  # nodes at instants
PLACES = 8  # of a line, about as many are looked at
LINES = (EDGE, SIDE)
ROUND_KINDS = (CODES[SpatialKind.SPHERE], CODES[SpatialKind.CAPSULE])


def sunk_below_faces(result: Result) -> tuple[str, ...]:
    """A warning for each contact of a face in which one surface is deeper in the other one than its gaps tell."""
    compiled = result.compiled
    if compiled is None or not is_spatial(compiled.model) or len(result.times) < 2:
        return ()
    contacts = compiled.model.contacts
    faces = np.flatnonzero(np.asarray(contacts.surface_kind) == FACE)
    passes = [w for w in range(len(contacts.pass_law)) if contacts.pass_node[w] in faces]
    return tuple(told for w in passes if (told := _told(result, compiled, w)))


def _told(result: Result, compiled: CompiledScene, w: int) -> str:
    """The warning of a pass; empty where there is none to be given."""
    contacts = compiled.model.contacts
    law, s, b = (int(column[w]) for column in (contacts.pass_law, contacts.pass_node, contacts.pass_feature))
    nodes = _nodes(compiled, b)
    share = np.asarray(contacts.area_share)
    first = np.asarray(contacts.area_start)[contacts.node_start[s] : contacts.node_start[s + 1] + 1]
    wide = math.sqrt(max(share[i:j].sum() for i, j in pairwise(first)))
    model = pack(compiled.model)
    lines, normals = _lines(compiled, b)
    table, _ = near(model, np.array(compiled.q), 0.0)
    worst, at = np.zeros(2), np.zeros(2, dtype=np.int64)  # of the nodes of the other surface, of those of the face
    for record in _instants(result, law, len(nodes) + len(first) + PLACES * len(lines)):
        q = np.array(result.q[record])
        if not np.isfinite(q).all():
            continue
        bound(model, q, table)
        theirs = [depth_below(model, q, table, s, int(node), b) for node in nodes]
        theirs += [depth_along(model, q, table, s, f, b, n, 0.5 * wide) for f, n in zip(lines, normals, strict=True)]
        depth = np.array([max(theirs, default=0.0), depth_of(model, q, table, s, b)])
        depth -= 2.0 * max(0.0, -float(np.nan_to_num(result.gap[record, law])))
        at[depth > worst] = record
        worst = np.maximum(worst, depth)
    name = f"contact {result.contact_names[law]!r}"
    if worst[0] > DEEP * wide:
        return (
            f"{name}: at t = {result.times[at[0]]:.6g} s the other surface is {worst[0]:.3g} m below the face, where "
            f"none of its nodes or areas, about {wide:.3g} m wide, feels it: expected a finer mesh there, or the whole "
            "surface of the body, body.surface(), which corners and balls touch anywhere"
        )
    if worst[1] > DEEP * wide:
        return (
            f"{name}: at t = {result.times[at[1]]:.6g} s a node of the face is {worst[1]:.3g} m below the other "
            f"surface, which none of its areas, about {wide:.3g} m wide, feels: expected points='nodes', or the whole "
            "surface of the body, body.surface(), where a body lands on its corners or edges or tips over them (the "
            "last of its areas bears at its middle, a third of an element inside), or a finer mesh there"
        )
    return ""


def _nodes(compiled: CompiledScene, b: int) -> IntArray:
    """Nodes of a surface that tell how deep it is: corners, and centres of balls."""
    contacts = compiled.model.contacts
    own = np.arange(contacts.node_start[b], contacts.node_start[b + 1])
    if contacts.surface_kind[b] in ROUND_KINDS:
        return own
    radius: FloatArray = np.asarray(contacts.node_radius)[own]
    return np.asarray(own[radius == 0.0])


def _lines(compiled: CompiledScene, b: int) -> tuple[list[int], FloatArray]:
    """Edges, capsules and sides of cylinders of a surface, and the mean outward normals of their ends."""
    contacts = compiled.model.contacts
    own = np.arange(contacts.node_start[b], contacts.node_start[b + 1])
    normal = dict(
        zip(np.asarray(contacts.node_point)[own].tolist(), np.asarray(contacts.node_normal)[own], strict=True)
    )
    features = np.arange(contacts.feature_start[b], contacts.feature_start[b + 1])
    lines = features[np.isin(np.asarray(contacts.feature_kind)[features], LINES)].tolist()
    ends = np.asarray(contacts.feature_point)[lines, :2].reshape(-1, 2).tolist()
    none = np.zeros(3)
    return lines, np.array([normal.get(p, none) + normal.get(r, none) for p, r in ends]).reshape(-1, 3)


def _instants(result: Result, law: int, nodes: int) -> list[int]:
    """Stored instants that are looked at."""
    count = max(2, min(INSTANTS, MOST_WORK // nodes))
    even = np.linspace(0, len(result.times) - 1, count).astype(int).tolist()
    return sorted({*even, int(result.force[:, law, 0].argmax())})
