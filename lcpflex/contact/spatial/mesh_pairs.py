"""What is told of two surfaces of triangles that touch, of which one at least deforms or need not be convex.

No face of such a surface is known as one, so faces that lie on each other touch with whatever may be a corner of the
patch: nodes of both over facets of the other, and the crossings of their edges. Where outlines are equal, rounding
decides whether a node is over a face or beside it. So facets have nodes up to a band beside them, too, and what comes
twice within that is one contact. Rows that are too many do not hurt: they hold what the others hold.
"""

from __future__ import annotations

import math

from lcpflex.bodies.spatial.surface import MESH, POLYHEDRON
from lcpflex.contact.spatial.narrow_phase.edges import TILT
from lcpflex.jit.kernel import kernel
from lcpflex.model.spatial import SpatialModel

__all__ = ["BAND", "BENT", "BLUNT", "DEEP", "TURNED", "are_meshes", "band_between", "deforms"]

BAND = 1e-4  # of the size of the smaller surface, measured: 1e-6 loses corners of uneven faces, 1e-3 was never too wide
DEEP = 200.0  # bands: a node beside a facet, or a crossing of outlines, that is deeper is no corner of two faces' patch
BENT = 0.2  # [rad] on a flexible body, a hollow edge of smaller turn may be bent to a bulge: sharp ones turn by more
BLUNT = math.cos(0.5 * BENT + TILT)  # facing of nodes at no sharp edge is greater
TURNED = 0.5  # [rad] by which deformation may turn the facets about a node; its normal is that of the undeformed ones


@kernel
def deforms(model: SpatialModel, s: int) -> bool:
    """Whether modes move points of surface s."""
    deflection = model.contacts.surface_deflection
    greatest = 0.0
    for m in range(deflection.shape[1]):
        greatest = max(greatest, deflection[s, m])
    return greatest > 0.0


@kernel
def are_meshes(model: SpatialModel, a: int, b: int) -> bool:
    """Whether both are surfaces of triangles, and not both convex and rigid."""
    kind = model.contacts.surface_kind
    return (kind[a] == MESH or kind[b] == MESH) and kind[a] in (MESH, POLYHEDRON) and kind[b] in (MESH, POLYHEDRON)


@kernel
def band_between(model: SpatialModel, a: int, b: int) -> float:
    """How far beside a facet of one surface a node of the other may be to touch it [m]; 0 but of meshes."""
    extent = model.contacts.surface_extent
    return 2.0 * BAND * min(extent[a], extent[b]) if are_meshes(model, a, b) else 0.0
