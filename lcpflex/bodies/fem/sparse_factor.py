"""Factors of sparse positive definite matrices of meshes, in an order that keeps them sparse.

A mesh is cut in two halves of equal numbers of nodes, across its longer side; the nodes at the cut that separate them
come last, and each half is treated likewise (nested dissection, A. George 1973). In a planar mesh of N nodes the factor
has O(N log N) entries, of a spatial one O(N^(4/3)). Large ones are left to PARDISO where it is installed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem import pardiso
from lcpflex.bodies.fem.factor_cost import PARDISO, SUPERLU, check_reach, cost_of
from lcpflex.bodies.fem.factors import AT_ONCE, Factor, NotPositive, SuperLuFactor
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["AT_ONCE", "Factor", "NotPositive", "dissection", "links", "positive_factor"]

LEAF = 24  # nodes that are not cut any more
LEVELS = 38  # 3^38 < 2^63
FEW = 20_000  # rows whose factor is not worth counting: a few seconds at most
PER_ROW = 100  # entries of a row of the matrix, for which that is true: solid elements have less
# Operations from which a factor is left to PARDISO, five seconds of SuperLU: 3e4 degrees of freedom of a block, 7e4 of
# a slender one. Planar meshes have less with up to half a million of them.
LARGE = 2e10


def positive_factor(matrix: csc_matrix[Any], rank: IntArray) -> Factor:
    """Factors of a symmetric matrix whose rows are eliminated by ascending rank (n,), or as PARDISO chooses.

    Raises
    ------
    NotPositive
        If a pivot on the diagonal is not positive.
    ModelError
        If the factor does not fit in the memory of this machine.

    Warns
    -----
    ModelWarning
        If it takes more than 4 GiB or a minute, and if PARDISO is installed and does not work.
    """
    order = np.argsort(rank, kind="stable")
    ordered = matrix[order][:, order].tocsc()
    n = matrix.shape[0]
    cost = cost_of(ordered) if n > FEW or matrix.nnz > PER_ROW * FEW else None
    if cost is not None:
        large = cost.operations > LARGE
        if large and pardiso.is_there():
            check_reach(n, cost, PARDISO)
            found = pardiso.pardiso_factor(matrix)
            if found is not None:
                return found
        check_reach(n, cost, SUPERLU, better=large and not pardiso.is_there())
    return SuperLuFactor(_superlu(ordered), order)


def _superlu(ordered: csc_matrix[Any]) -> Any:
    """Factors of a symmetric matrix, eliminated in its own order."""
    try:
        lu = libs.splu(ordered, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except MemoryError:
        raise ModelError(
            f"stiffness: the memory does not suffice to factorise a mesh of {ordered.shape[0]} degrees of freedom, "
            "expected a smaller one"
        ) from None
    except RuntimeError as error:
        raise NotPositive(str(error)) from None
    if not np.array_equal(lu.perm_r, lu.perm_c) or not lu.U.diagonal().min() > 0.0:
        raise NotPositive("a pivot is not positive")
    return lu


def links(stiffness: csc_matrix[Any], node: IntArray, count: int) -> csc_matrix[Any]:
    """(count, count) pattern of nodes that share an entry; ``node``: that of each row of the stiffness."""
    owner = libs.sparse.csc_matrix((np.ones(len(node)), (np.arange(len(node)), node)), shape=(len(node), count))
    pattern = libs.sparse.csc_matrix(
        (np.ones(stiffness.nnz), stiffness.indices, stiffness.indptr), shape=stiffness.shape
    )
    return (owner.T @ pattern @ owner).tocsc()


def dissection(places: FloatArray, graph: csc_matrix[Any]) -> IntArray:
    """(N,) rank of each node in nested dissection of the graph, halved by the places (N, 2) or (N, 3)."""
    count = len(places)
    pairs = graph.tocoo()
    upper = pairs.row < pairs.col
    edges = np.stack([pairs.row[upper], pairs.col[upper]]).astype(np.int64)
    domain = np.zeros(count, dtype=np.int64)  # number of the part, -1: in a separator
    key = np.zeros(count, dtype=np.int64)
    for level in range(LEVELS):
        right = _halves(places, domain)
        if right is None:
            break
        a, b = edges
        cut = right[a] != right[b]
        left_end = np.where(right[a][cut], b[cut], a[cut])
        digit = right.astype(np.int64)
        digit[left_end] = 2
        digit[domain < 0] = 0
        key += digit * 3 ** (LEVELS - level)
        parted = np.where(domain < 0, -1, np.where(digit == 2, -1, 2 * domain + right))
        numbers, renumbered = np.unique(parted, return_inverse=True)
        domain = renumbered - int(numbers[0] < 0)
        edges = edges[:, (domain[a] == domain[b]) & (domain[a] >= 0)]
    rank = np.empty(count, dtype=np.int64)
    rank[np.argsort(key, kind="stable")] = np.arange(count)
    return rank


def _halves(places: FloatArray, domain: IntArray) -> Any:
    """(N,) whether a node lies in the right or upper half of its domain; None if all domains are small."""
    inside = np.flatnonzero(domain >= 0)
    own = domain[inside]
    sizes = np.bincount(own)
    if not len(sizes) or sizes.max() <= LEAF:
        return None
    low = np.full((len(sizes), places.shape[1]), np.inf)
    high = np.full((len(sizes), places.shape[1]), -np.inf)
    np.minimum.at(low, own, places[inside])
    np.maximum.at(high, own, places[inside])
    axis = np.argmax(high - low, axis=1)
    along = places[inside, axis[own]]
    across = places[inside, (axis[own] + 1) % places.shape[1]]
    sorted_ = np.lexsort((across, along, own))
    position = np.arange(len(inside)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    upper = position >= np.repeat(np.where(sizes > LEAF, sizes // 2, sizes), sizes)
    right = np.zeros(len(places), dtype=bool)
    right[inside[sorted_]] = upper
    return right
