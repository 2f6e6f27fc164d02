"""A planar mesh of one kind of element: what continuum bodies are assembled from.

Elements turn counter-clockwise: corners first, then the nodes amid the edges 0-1, 1-2, ..., then the middle.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["KINDS", "Kind", "PlanarMesh", "check_nodes"]

FLAT = 1e-9  # of the size of the mesh: distances below it are rounding
EXTENTS = (1e-12, 1e9)  # [m] of meshes: whatever the unit was, beyond it numbers are broken
DEGENERATE = 1e-10  # area of an element relative to the square of its longest edge


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of element.

    Attributes
    ----------
    mesh, element : names of its classes in scikit-fem
    corners, nodes : numbers of them
    turned : the order of its nodes when it is run around the other way
    """

    mesh: str
    element: str
    corners: int
    nodes: int
    turned: tuple[int, ...]

    @property
    def quadratic(self) -> bool:
        """Whether its edges have a node amid."""
        return self.nodes > self.corners

    def edges(self) -> IntArray:
        """(corners, 2 or 3) nodes of each edge as one walks around it: first, last, and the one amid."""
        first = np.arange(self.corners)
        ends = [first, (first + 1) % self.corners]
        return np.column_stack([*ends, first + self.corners] if self.quadratic else ends)


KINDS = {  # by the names of meshio
    "triangle": Kind("MeshTri1", "ElementTriP1", 3, 3, (0, 2, 1)),
    "triangle6": Kind("MeshTri2", "ElementTriP2", 3, 6, (0, 2, 1, 5, 4, 3)),
    "quad": Kind("MeshQuad1", "ElementQuad1", 4, 4, (0, 3, 2, 1)),
    "quad9": Kind("MeshQuad2", "ElementQuad2", 4, 9, (0, 3, 2, 1, 7, 6, 5, 4, 8)),
}


def check_nodes(name: str, mesh: Any) -> None:
    """Raise ModelError for a mesh of scikit-fem that has fewer places than its elements have nodes.

    One of a quadratic class is easily made of corners alone: ``MeshTri2(mesh.p[:, : mesh.nvertices], mesh.t)``.

    name: of the mesh in the message.
    """
    needed, places = int(mesh.dofs.element_dofs.max(initial=-1)) + 1, np.asarray(mesh.doflocs).shape[-1]
    if needed > places:
        kind = type(mesh).__name__
        linear = next((k.mesh for k in KINDS.values() if k.mesh[:-1] == kind[:-1]), kind)
        raise ModelError(
            f"{name}: {kind} with {places} places was given, and its elements have {needed} nodes, amid edges too, "
            f"expected a place for each; on corners alone make skfem.{linear}(p, t), and lf.meshes.quadratic of it"
        )


@dataclass(frozen=True, slots=True, eq=False)
class PlanarMesh:
    """N nodes and m elements of one kind, connected through edges, all of positive area; no node is unused.

    Attributes
    ----------
    kind : what the elements are
    places : (N, 2) [m]
    cells : (m, nodes) nodes of the elements
    groups : named nodes that came with the mesh
    source : what the mesh is called in messages
    """

    kind: Kind
    places: FloatArray
    cells: IntArray
    groups: Mapping[str, IntArray] = field(default_factory=dict)
    source: str = "mesh"

    @property
    def size(self) -> float:
        """Extent of the mesh [m]."""
        return float(np.ptp(self.places, axis=0).max())

    def edge_keys(self) -> IntArray:
        """One number for the pair of ends of each edge of each element, whichever way it is walked."""
        ends = np.sort(self.cells[:, self.kind.edges()[:, :2]].reshape(-1, 2), axis=1)
        return np.asarray(ends[:, 0] * len(self.places) + ends[:, 1])

    def longest_edge(self) -> float:
        """Longest edge of an element, from corner to corner [m]."""
        corners = self.places[self.cells[:, : self.kind.corners]]
        arms = np.roll(corners, -1, axis=1) - corners
        return float(np.hypot(arms[..., 0], arms[..., 1]).max())
