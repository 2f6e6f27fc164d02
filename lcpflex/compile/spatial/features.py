"""A feature of a surface in space, as it is collected for the arrays of a model."""

from __future__ import annotations

import math
from typing import NamedTuple

__all__ = ["Feature"]


class Feature(NamedTuple):
    """What others may touch: material points by their indices, radius and depth [m], and neighbours."""

    kind: int
    points: tuple[int, int, int]
    radius: float = 0.0
    depth: float = math.inf
    neighbour: tuple[int, int, int] = (-1, -1, -1)  # of facets across their hollow sides; of edges both facets, sharp?
    fan: tuple[int, ...] = ()  # of vertices: the points at the other ends of their edges
    cell: int = -1  # of facets: which face of an element of an open face they are a part of; -1: themselves
