"""Forces of contacts in space on the material of bodies, from the touching points that were stored.

The force of a touching point on the body of the first surface is N n + F, on the other body -(N n + F). It acts where
the features touch at (t, q), as the equations of motion have it: at the mean r = sum_a w_a r_a of the material points
of a side, with the lever from there to the place of contact (:mod:`lcpflex.contact.spatial.levers`). What touches on an
area is a mean of nodes, and its force is shared out over these: a uniform pressure is that of its elements, on the mesh
as well.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.bodies.spatial.surface import CODES, CYLINDER, FACE, SpatialKind
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.contact.near import surfaces_of
from lcpflex.contact.rows import contact_rows
from lcpflex.contact.spatial.faces.detection import weigh_entry
from lcpflex.contact.spatial.faces.memory import EACH, MEANS
from lcpflex.contact.spatial.levers import mean_on_i, mean_on_j
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.spatial import SpatialModel
from lcpflex.results.contact_history import ContactPoints
from lcpflex.results.spatial.point_wrench import PointWrench
from lcpflex.results.touching_pairs import TouchingPair, TouchingPairs

__all__ = ["contact_wrenches"]

# by the material at one place of a body, wherever they touch
CARRIED = (CYLINDER, CODES[SpatialKind.RIM], CODES[SpatialKind.PLANE])

Weights = tuple[tuple[int, float], ...]


def contact_wrenches(
    compiled: CompiledScene, model: Any, touching: ContactPoints, t: float, q: FloatArray
) -> list[PointWrench]:
    """On the bodies of a packed model, of the contacts ``touching`` at a stored instant.

    Raises
    ------
    ModelError
        Where a contact force cannot be told the points it acts on.
    """
    plain = compiled.model
    assert isinstance(plain, SpatialModel)
    dof = plain.bodies.dof
    pairs = TouchingPairs(compiled, model, t, q)
    rows = np.zeros((3, 2, int(np.diff(dof).max())))
    found: list[PointWrench] = []
    for c in np.flatnonzero(touching.force.any(axis=1)).tolist():
        pair = pairs.of(touching, c)
        contact_rows(model, q, pair.table, pair.k, rows[0], rows[1:])
        blocks = np.einsum("d,dsw->sw", pair.side * _along_axes(pair, touching.vector[c]), rows)
        for side, b in enumerate(pair.table.body[pair.k].tolist()):
            if b >= 0:
                own = blocks[side, : int(dof[b + 1] - dof[b])].copy()
                found.append(PointWrench(b, _material(plain, model, q, pair, side), own))
    return found


def _along_axes(pair: TouchingPair, force: FloatArray) -> FloatArray:
    """(3,) of a vector along n, t1 and t2 = n x t1."""
    n, t = pair.table.normal[pair.k], pair.table.tangent[pair.k]
    return np.array([n, t, np.cross(n, t)]) @ force


def _material(model: SpatialModel, packed: Any, q: FloatArray, pair: TouchingPair, side: int) -> Weights:
    """Material points of body i or j that bear a contact, and their weights."""
    contacts: Any = model.contacts
    table, k = pair.table, pair.k
    surfaces = surfaces_of(contacts, int(table.key[k]))
    surface = surfaces[side]
    kind = int(contacts.surface_kind[surface])
    if kind in CARRIED:
        first, second = contacts.feature_point[int(contacts.feature_start[surface]), :2].tolist()
        # a cylinder from end to end, which the material at its middle bears
        return ((first, 0.5), (second, 0.5)) if kind == CYLINDER else ((first, 1.0),)
    mean = mean_on_i(table, k) if side == 0 else mean_on_j(table, k)
    points, weights = (mean.a, mean.b, mean.c)[: mean.number], mean.w[: mean.number]
    if table.averaged[k] == 1:  # of two faces: the table has means of the material, made for the entry
        return _of_means(
            packed, q, pair, surfaces, [(p // EACH % MEANS, w) for p, w in zip(points, weights, strict=True)]
        )
    if side == 0 and kind == FACE:
        return _of_samples(contacts, int(table.key[k]) // len(contacts.feature_kind))
    return tuple(zip(points, weights, strict=True))


def _of_samples(contacts: Any, node: int) -> Weights:
    """Material points whose mean a node of a face is, by all of its samples."""
    weight: dict[int, float] = {}
    own = slice(int(contacts.area_start[node]), int(contacts.area_start[node + 1]))
    shares = contacts.area_share[own] / contacts.area_share[own].sum()
    for s, share in zip(contacts.area_sample[own].tolist(), shares.tolist(), strict=True):
        for at in range(int(contacts.sample_start[s]), int(contacts.sample_start[s + 1])):
            p = int(contacts.sample_point[at])
            weight[p] = weight.get(p, 0.0) + share * float(contacts.sample_weight[at])
    return tuple(weight.items())


def _of_means(
    packed: Any, q: FloatArray, pair: TouchingPair, surfaces: tuple[int, int], parts: list[tuple[int, float]]
) -> Weights:
    """Material points of which a side of an entry of two faces is made: parts of its means (number, weight)."""
    memory = pair.table.faces
    weights = np.zeros((len(memory.listed), MEANS))
    count = weigh_entry(packed, q, pair.margin, pair.table, pair.k, *surfaces, weights)
    total = sum((w * weights[:count, which] for which, w in parts), np.zeros(count))
    used = np.flatnonzero(total)
    listed = np.asarray(memory.listed)
    return tuple((int(listed[at]), float(total[at])) for at in used)
