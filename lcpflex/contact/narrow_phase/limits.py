"""Where features end, and what has no direction."""

from __future__ import annotations

__all__ = ["COINCIDENT", "NOWHERE", "WIDEN"]

WIDEN = 1e-9  # relative, at the ends of segments and arcs: no slave falls between two
COINCIDENT = 1e-12  # [m] two points so close have no direction from one to the other
NOWHERE = (False, 0.0, 0.0, 0.0, 0.0, 0.0)  # a slave that is not over a feature
