"""Forces of contacts in space on the material of bodies, from the touching points that were stored.

The force of a touching point on the body of the first surface is N n + F, on the other body -(N n + F). It acts where
the features touch at (t, q), as the equations of motion have it: at the mean r = sum_a w_a r_a of the material points
of a side, with the lever from there to the place of contact (:mod:`lcpflex.contact.spatial.levers`).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.bodies.spatial.surface import CODES, CYLINDER, SpatialKind
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.contact.near import surfaces_of
from lcpflex.contact.rows import contact_rows
from lcpflex.contact.spatial.levers import mean_on_i, mean_on_j
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.spatial import SpatialModel
from lcpflex.results.contact_history import ContactPoints
from lcpflex.results.spatial.point_wrench import PointWrench, Where
from lcpflex.results.touching_pairs import TouchingPair, TouchingPairs

__all__ = ["contact_wrenches"]

# by the material at one place of a body, wherever they touch
CARRIED = (CYLINDER, CODES[SpatialKind.RIM], CODES[SpatialKind.PLANE])

Weights = tuple[tuple[Where, float], ...]


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
                found.append(PointWrench(b, _material(plain, pair, side), own))
    return found


def _along_axes(pair: TouchingPair, force: FloatArray) -> FloatArray:
    """(3,) of a vector along n, t1 and t2 = n x t1."""
    n, t = pair.table.normal[pair.k], pair.table.tangent[pair.k]
    return np.array([n, t, np.cross(n, t)]) @ force


def _material(model: SpatialModel, pair: TouchingPair, side: int) -> Weights:
    """Material points of body i or j that bear a contact, and their weights."""
    contacts: Any = model.contacts
    table, k, _ = pair
    surface = surfaces_of(contacts, int(table.key[k]))[side]
    kind = int(contacts.surface_kind[surface])
    if kind in CARRIED:
        first, second = contacts.feature_point[int(contacts.feature_start[surface]), :2].tolist()
        # a cylinder from end to end, which the material at its middle bears
        return ((first, 0.5), (second, 0.5)) if kind == CYLINDER else ((first, 1.0),)
    mean = mean_on_i(table, k) if side == 0 else mean_on_j(table, k)
    points, weights = (mean.a, mean.b, mean.c)[: mean.number], mean.w[: mean.number]
    if table.averaged[k] == 1:  # of two faces: the table has means of the material, made for the entry
        x, y, z = (np.array(weights) @ np.asarray(table.faces.means.place)[list(points)]).tolist()
        return (((x, y, z), 1.0),)
    return tuple(zip(points, weights, strict=True))
