"""Named open parts of the surface of a solid: facets on the nodes of its mesh, which touch other surfaces."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from lcpflex.jit.kernel import IntArray

if TYPE_CHECKING:
    from lcpflex.bodies.spatial.body import SpatialPoint

__all__ = ["FaceNodes"]


@dataclass(frozen=True, slots=True, eq=False)
class FaceNodes:
    """A face of a body in space, made by reductions of a mesh.

    Attributes
    ----------
    points : the material of each node; its displacements alone are known
    cells : of which points each facet is made, (k,), k = 3, 4, 6, 8 or 9: its corners, counter-clockwise seen from
        outside, then those amid its edges (the first between the first two corners), then the middle
    triangles : (T, 3) plane ones that the facets are split into
    """

    points: tuple[SpatialPoint, ...] = field(repr=False)
    cells: tuple[IntArray, ...] = field(repr=False)
    triangles: IntArray = field(repr=False)
