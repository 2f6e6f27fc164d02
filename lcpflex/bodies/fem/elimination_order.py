"""In which order the degrees of freedom of a mesh are eliminated, so that factors stay sparse."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem.sparse_factor import dissection, links
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["rank_of"]


def rank_of(stiffness: csc_matrix[Any], places: FloatArray, node: IntArray, part: IntArray) -> IntArray:
    """(f,) order of elimination of degrees of freedom, each the ``part`` of a ``node`` at its place (N, 2) or (N, 3).

    Raises
    ------
    ModelError
        For a mesh in pieces, naming their number and their sizes.
    """
    graph = links(stiffness, node, len(places))
    pieces, label = libs.csgraph.connected_components(graph, directed=False)
    if pieces > 1:
        sizes = sorted(np.bincount(label).tolist(), reverse=True)
        shown = ", ".join(str(size) for size in sizes[:5]) + (", ..." if pieces > 5 else "")
        raise ModelError(
            f"stiffness: the mesh falls into {pieces} pieces of {shown} nodes, expected one piece without mechanisms "
            "or loose parts (join nodes that lie at one place, drop nodes without elements)"
        )
    rank = dissection(places, graph)
    return np.asarray((part.max(initial=0) + 1) * rank[node] + part)
