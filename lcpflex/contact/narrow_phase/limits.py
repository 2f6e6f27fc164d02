"""Where features end, and what has no direction."""

from __future__ import annotations

__all__ = ["COINCIDENT", "NOWHERE", "SPAN_TOLERANCE", "WIDEN"]

WIDEN = 1e-9  # relative, at the ends of segments and arcs: no node falls between two
SPAN_TOLERANCE = 2e-9  # how far a foot may leave its feature: more than detection widens features by
COINCIDENT = 1e-12  # [m] two points so close have no direction from one to the other
NOWHERE = (False, 0.0, 0.0, 0.0, 0.0, 0.0)  # a node that is not over a feature
