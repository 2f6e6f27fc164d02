"""Where surfaces are: circles about them, undeformed, and how far deformation may carry their points."""

from __future__ import annotations

import math

from lcpflex.contact.table import ContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID

__all__ = ["above_half_plane", "bound", "near_surfaces"]


@kernel
def bound(model: Model, q: FloatArray, table: ContactTable) -> None:
    """Where every surface is as a rigid one, and how far deformation may carry its points."""
    c = model.contacts
    dof = model.bodies.dof
    out = table.bound
    deflection_of = c.surface_deflection
    last = -1
    cos = 1.0
    sin = 0.0
    for s in range(len(c.surface_body)):
        b = c.surface_body[s]
        x = c.surface_center[s, 0]
        y = c.surface_center[s, 1]
        deflection = 0.0
        if b < 0:
            out[s, 3] = 1.0
            out[s, 4] = 0.0
        else:
            d = dof[b]
            if b != last:
                cos = math.cos(q[d + 2])
                sin = math.sin(q[d + 2])
                last = b
            x, y = q[d] + cos * x - sin * y, q[d + 1] + sin * x + cos * y
            for m in range(dof[b + 1] - d - N_RIGID):
                deflection += abs(q[d + N_RIGID + m]) * deflection_of[s, m]
            out[s, 3] = cos
            out[s, 4] = sin
        out[s, 0] = x
        out[s, 1] = y
        out[s, 2] = deflection


@kernel
def above_half_plane(model: Model, table: ContactTable, a: int, b: int) -> float:
    """How far the centre of surface a is above the half-plane b [m], which stands on the ground or a rigid body."""
    f = model.contacts.feature_start[b]
    place = model.points.place
    o = model.contacts.feature_point[f, 0]
    p = model.contacts.feature_point[f, 1]
    nx = place[p, 1] - place[o, 1]  # the two are a metre apart
    ny = place[o, 0] - place[p, 0]
    cos = table.bound[b, 3]
    sin = table.bound[b, 4]
    dx = table.bound[a, 0] - table.bound[b, 0]
    dy = table.bound[a, 1] - table.bound[b, 1]
    return (cos * nx - sin * ny) * dx + (sin * nx + cos * ny) * dy


@kernel
def near_surfaces(model: Model, table: ContactTable, a: int, b: int, margin: float) -> bool:
    """Whether nodes of surface a may be within ``margin`` [m] of surface b, or below it, as far as circles tell."""
    extent = model.contacts.surface_extent
    at = table.bound
    reach = extent[a] + at[a, 2] + at[b, 2] + margin
    if extent[b] < math.inf:
        reach += extent[b]
        dx = at[a, 0] - at[b, 0]
        dy = at[a, 1] - at[b, 1]
        return not dx * dx + dy * dy > reach * reach
    return at[b, 2] != 0.0 or not above_half_plane(model, table, a, b) > reach
