"""Kinds of features of surfaces in space, as compiled arrays hold them."""

from __future__ import annotations

__all__ = ["AROUND", "CAP", "EDGE", "FACET", "PLANE", "POINT", "POLYGON", "RIM", "SIDE"]

# POINT: a vertex, or a sphere (radius < 0: a hole). SIDE, CAP: of a cylinder, behind its two rims. POLYGON: a face of a
# convex polyhedron, whose triangles are FACETs, too; convex bodies touch the former, all others the latter
FACET, EDGE, POINT, PLANE, RIM, SIDE, CAP, POLYGON = range(8)

AROUND = 16  # material points of each rim of a cylinder, the corners of the polygon that others meet
