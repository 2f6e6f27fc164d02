"""A mesh of one kind of element, in the plane or in space: what continuum bodies are assembled from.

Elements have their corners first, then the nodes amid their edges, then those amid their faces, then the middle, in the
order of VTK. In the plane they turn counter-clockwise; in space their volume is positive.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["KINDS", "Kind", "Mesh", "check_nodes", "told_place"]

FLAT = 1e-9  # of the size of the mesh: distances below it are rounding
EXTENTS = (1e-12, 1e9)  # [m] of meshes: whatever the unit was, beyond it numbers are broken
DEGENERATE = 1e-10  # area or volume of an element relative to the square or cube of its longest edge


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of element.

    Attributes
    ----------
    name : that of meshio
    mesh, element : names of its classes in scikit-fem
    dimension : 2 or 3
    corners, nodes : numbers of them
    turned : the order of its nodes in which it is its mirror image
    pairs : the two corners of each edge; the node amid edge e of a quadratic element is ``corners + e``
    facets : nodes of each facet: its corners, counter-clockwise seen from outside (in the plane: first and last), then
        those amid its edges, then the one amid it
    """

    name: str
    mesh: str
    element: str
    dimension: int
    corners: int
    nodes: int
    turned: tuple[int, ...]
    pairs: tuple[tuple[int, int], ...]
    facets: tuple[tuple[int, ...], ...]

    @property
    def quadratic(self) -> bool:
        """Whether its edges have a node amid."""
        return self.nodes > self.corners

    @property
    def simplex(self) -> bool:
        """Whether it is a triangle or tetrahedron."""
        return self.corners == self.dimension + 1

    @property
    def linear(self) -> Kind:
        """The kind of its corners alone."""
        names = ("triangle", "quad") if self.dimension == 2 else ("tetra", "hexahedron")
        return KINDS[names[0] if self.simplex else names[1]]

    @property
    def facet_corners(self) -> int:
        """How many corners a facet has."""
        return 2 if self.dimension == 2 else 3 if self.corners == 4 else 4

    @property
    def middles(self) -> tuple[tuple[int, ...], ...]:
        """The corners amid which each node lies; those of a corner are itself."""
        own = [(k,) for k in range(self.corners)]
        amid = list(self.pairs) if self.quadratic else []
        inside = [tuple(range(self.corners))]
        if self.name == "hexahedron27":
            inside = [*sorted((f[:4] for f in self.facets), key=lambda f: _VTK_FACES.index(frozenset(f))), *inside]
        return tuple([*own, *amid, *inside][: self.nodes])

    def edges(self) -> IntArray:
        """(edges, 2 or 3) nodes of each edge, in the plane as one walks around it: first, last, and the one amid."""
        ends = np.array(self.pairs)
        return np.column_stack([ends, self.corners + np.arange(len(ends))]) if self.quadratic else ends


_TRIANGLE = ((0, 1), (1, 2), (2, 0))
_QUAD = ((0, 1), (1, 2), (2, 3), (3, 0))
_TETRA = (*_TRIANGLE, (0, 3), (1, 3), (2, 3))
_HEXAHEDRON = (*_QUAD, (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
_TETRA_FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
_HEXAHEDRON_FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
_VTK_FACES = [
    frozenset(f) for f in ((0, 3, 4, 7), (1, 2, 5, 6), (0, 1, 4, 5), (2, 3, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7))
]
_MIRRORED = {3: (0, 2, 1), 4: (0, 3, 2, 1)}  # corners of triangles and quadrilaterals


def _kind(
    name: str, element: str, nodes: int, corners: int, pairs: tuple[tuple[int, int], ...],
    faces: tuple[tuple[int, ...], ...] = (),
) -> Kind:  # fmt: skip
    """With the facets and the mirror image of its nodes, which follow from those of its corners."""
    dimension = 3 if faces else 2
    quadratic = nodes > corners
    amid = {frozenset(pair): corners + e for e, pair in enumerate(pairs)}
    middle = {f: corners + len(pairs) + k for k, f in enumerate(_VTK_FACES)} if nodes == 27 else {}

    def facet(f: tuple[int, ...]) -> tuple[int, ...]:
        around = [frozenset(pair) for pair in zip(f, (*f[1:], *f[:1]), strict=True)]
        on_edges = [amid[edge] for edge in (around if faces else around[:1])] if quadratic else []
        return (*f, *on_edges, *([middle[frozenset(f)]] if middle else []))

    mirror = _MIRRORED[corners] if dimension == 2 else (0, 2, 1, 3) if corners == 4 else (0, 3, 2, 1, 4, 7, 6, 5)
    turned = list(mirror)
    if quadratic:
        turned += [amid[frozenset(mirror[k] for k in pair)] for pair in pairs]
        turned += [middle[frozenset(mirror[k] for k in f)] for f in middle]
        turned += range(len(turned), nodes)
    whole = element.replace("Element", "Mesh").replace("P", "").replace("S2", "2")
    facets = tuple(facet(f) for f in (faces or pairs))
    return Kind(name, whole, element, dimension, corners, nodes, tuple(turned), pairs, facets)


KINDS = {  # by the names of meshio, whose order of nodes is that of VTK
    kind.name: kind
    for kind in (
        _kind("triangle", "ElementTriP1", 3, 3, _TRIANGLE),
        _kind("triangle6", "ElementTriP2", 6, 3, _TRIANGLE),
        _kind("quad", "ElementQuad1", 4, 4, _QUAD),
        _kind("quad9", "ElementQuad2", 9, 4, _QUAD),
        _kind("tetra", "ElementTetP1", 4, 4, _TETRA, _TETRA_FACES),
        _kind("tetra10", "ElementTetP2", 10, 4, _TETRA, _TETRA_FACES),
        _kind("hexahedron", "ElementHex1", 8, 8, _HEXAHEDRON, _HEXAHEDRON_FACES),
        _kind("hexahedron20", "ElementHexS2", 20, 8, _HEXAHEDRON, _HEXAHEDRON_FACES),
        _kind("hexahedron27", "ElementHex2", 27, 8, _HEXAHEDRON, _HEXAHEDRON_FACES),
    )
}


def told_place(place: FloatArray) -> str:
    """A place in texts: (1.5, 0, 2)."""
    return f"({', '.join(f'{value:.6g}' for value in place)})"


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
class Mesh:
    """N nodes and m elements of one kind, connected through facets, all of positive measure; no node is unused.

    Attributes
    ----------
    kind : what the elements are
    places : (N, d) [m]
    cells : (m, nodes) nodes of the elements
    groups : named nodes that came with the mesh
    faces : named parts of the surface that came with a mesh in space, (k, 3 or 4) corners of facets
    source : what the mesh is called in messages
    """

    kind: Kind
    places: FloatArray
    cells: IntArray
    groups: Mapping[str, IntArray] = field(default_factory=dict)
    source: str = "mesh"
    faces: Mapping[str, IntArray] = field(default_factory=dict)

    def __repr__(self) -> str:
        """How large it is, and not the arrays."""
        return f"<{self.source}: {len(self.places)} nodes, {len(self.cells)} elements of kind {self.kind.name!r}>"

    @property
    def size(self) -> float:
        """Extent of the mesh [m]."""
        return float(np.ptp(self.places, axis=0).max())

    def edge_keys(self) -> IntArray:
        """One number for the pair of ends of each edge of each element, whichever way it is walked."""
        ends = np.sort(self.cells[:, self.kind.edges()[:, :2]].reshape(-1, 2), axis=1)
        return np.asarray(ends[:, 0] * len(self.places) + ends[:, 1])

    def facet_keys(self) -> IntArray:
        """One number for the corners of each facet of each element, whichever way they are walked."""
        if self.kind.dimension == 2:
            return self.edge_keys()
        facets = np.array([facet[: self.kind.facet_corners] for facet in self.kind.facets])
        corners = np.sort(self.cells[:, facets].reshape(-1, facets.shape[1]), axis=1)
        key = corners[:, 0]
        for column in corners.T[1:]:  # numbered anew each time: products of numbers of nodes would overflow
            key = np.unique(key * len(self.places) + column, return_inverse=True)[1].ravel()
        return np.asarray(key)

    def longest_edges(self) -> FloatArray:
        """(m,) the longest edge of each element, from corner to corner [m]."""
        longest = np.zeros(len(self.cells))
        for a, b in self.kind.pairs:  # one after the other: all at once would take many times the memory
            arms = self.places[self.cells[:, b]] - self.places[self.cells[:, a]]
            np.maximum(longest, np.hypot.reduce(arms, axis=-1), out=longest)
        return longest

    def longest_edge(self) -> float:
        """Longest edge of an element [m]."""
        return float(self.longest_edges().max())
