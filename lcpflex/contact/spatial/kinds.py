"""Kinds of features of surfaces in space, as compiled arrays hold them."""

from __future__ import annotations

__all__ = ["CAP", "EDGE", "FACET", "PLANE", "POINT", "RIM", "SIDE"]

# POINT: a vertex, or a sphere (radius < 0: a hole). SIDE, CAP: of a cylinder, behind its two rims
FACET, EDGE, POINT, PLANE, RIM, SIDE, CAP = range(7)
