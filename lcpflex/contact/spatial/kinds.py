"""Kinds of features of surfaces in space, as compiled arrays hold them."""

from __future__ import annotations

__all__ = ["EDGE", "FACET", "PLANE", "POINT", "RIM"]

FACET, EDGE, POINT, PLANE, RIM = range(5)  # POINT: a vertex, or a sphere (radius < 0: a hole)
