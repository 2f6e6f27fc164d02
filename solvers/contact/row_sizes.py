"""The rows of contact problems measured through blocks of rows, where contacts are not known by their coupling."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.contact.matrices import as_dense

if TYPE_CHECKING:
    from lcpflex.solvers.contact.problem import ContactProblem

__all__ = ["row_sizes"]


def row_sizes(problem: ContactProblem, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """max_j |M_ij| and |q_i| + sum_j |M_ij z_j| of every row of :meth:`ContactProblem.lcp`."""
    tangent, normals, m = problem.tangent, len(problem.friction), len(problem.free)
    count = len(tangent)
    edge = libs.sparse.csr_array((problem.friction[tangent], (np.arange(count), tangent)), shape=(count, normals))
    columns = libs.sparse.block_array(
        [[libs.sparse.eye_array(normals), None], [-edge, libs.sparse.eye_array(count)]], format="csr"
    )
    largest, terms = np.zeros(problem.size), np.zeros(problem.size)
    size = np.abs(z)
    for rows, block in problem.row_blocks():
        block = abs(block @ columns)
        largest[rows] = as_dense(block.max(axis=1)).ravel()
        terms[rows] = block @ size[:m]
    terms[:m] += np.abs(problem.free)
    largest[normals:m] = np.maximum(largest[normals:m], 1.0)
    terms[normals:m] += size[m:]
    mu = problem.friction[tangent]
    largest[m:] = np.maximum(2.0 * mu, 1.0)
    terms[m:] = 2.0 * mu * size[tangent] + size[normals:m]
    largest[largest == 0.0] = 1.0
    return largest, terms
