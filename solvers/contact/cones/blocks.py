"""The Delassus operator of contacts in space by its blocks of two contacts, and Newton's method on sparse matrices."""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray, IntArray, interpreted, kernel
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.contact.algebra import Vector, add_block
from lcpflex.solvers.contact.cones import newton as method
from lcpflex.solvers.contact.cones.alart_curnier import lengths, mixed_rows
from lcpflex.solvers.contact.cones.newton import ConeWork, misses

__all__ = ["ConeBlocks", "newton_on_blocks"]


class ConeBlocks:
    """Blocks of contact k: first[k] to first[k + 1], with contact other[e], entries block[e] (9,) by rows.

    own (n, 9): the block of each contact with itself, which is kept even if it is zero, as entry diagonal[k].
    """

    def __init__(self, matrix: Any) -> None:
        n = matrix.shape[0] // 3
        coupled = libs.sparse.bsr_array(libs.sparse.csr_array(matrix), blocksize=(3, 3))
        present = libs.sparse.csr_array(
            (np.ones(len(coupled.indices)), coupled.indices, coupled.indptr), shape=(n, n)
        )  # fmt: skip
        if not present.diagonal().all():  # a contact between two bodies that are held
            coupled = _with_diagonal(coupled, n)
        coupled.sort_indices()
        self.first, self.other = coupled.indptr.astype(np.int64), coupled.indices.astype(np.int64)
        self.block = np.ascontiguousarray(coupled.data.reshape(-1, 9))
        self.diagonal = np.flatnonzero(self.other == np.repeat(np.arange(n), np.diff(self.first)))
        self.own = np.ascontiguousarray(self.block[self.diagonal])
        self._shape = (3 * n, 3 * n)
        self._pattern: tuple[IntArray, Any, Any] | None = None
        self._jacobian = np.empty_like(self.block)

    def by_columns(self, block: FloatArray) -> Any:
        """A matrix of other blocks at the same places, by compressed columns."""
        if self._pattern is None:
            count = np.arange(1.0, block.size + 1.0).reshape(-1, 3, 3)
            places = libs.sparse.bsr_array((count, self.other, self.first), shape=self._shape).tocsc()
            self._pattern = (places.data.astype(np.int64) - 1, places.indices, places.indptr)
        place, rows, starts = self._pattern
        return libs.sparse.csc_array((block.ravel()[place], rows, starts), shape=self._shape)

    def step(self, friction: FloatArray, shift: float, forces: FloatArray, work: ConeWork) -> float:
        """As :func:`.newton.direction`, by a sparse factor."""
        fill_jacobian(
            self.first, self.other, self.block, friction, shift, forces, work.velocity, work.rho, work.small,
            self._jacobian,
        )  # fmt: skip
        try:
            found = libs.splu(self.by_columns(self._jacobian)).solve(-work.miss)
        except RuntimeError:  # "Factor is exactly singular"
            return np.inf
        if not np.isfinite(found).all():
            return np.inf
        work.step[:] = found
        return float(np.abs(found).max(initial=0.0))


def _with_diagonal(coupled: Any, n: int) -> Any:
    """The same blocks and those of each contact with itself, zero or not: a sum would leave zeros out."""
    rows = np.repeat(np.arange(n), np.diff(coupled.indptr))
    missing = np.setdiff1d(np.arange(n), rows[coupled.indices == rows])
    rows, others = np.concatenate([rows, missing]), np.concatenate([coupled.indices, missing])
    block = np.concatenate([coupled.data, np.zeros((len(missing), 3, 3))])
    order = np.lexsort([others, rows])
    first = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=n))])
    return libs.sparse.bsr_array((block[order], others[order], first), shape=(3 * n, 3 * n))


@kernel
def fill_jacobian(
    first: IntArray,
    other: IntArray,
    block: FloatArray,
    friction: FloatArray,
    shift: float,
    forces: FloatArray,
    u: FloatArray,
    rho: FloatArray,
    small: FloatArray,
    out: FloatArray,
) -> None:
    """Out: the blocks (e, 9) of I - P (I - rho (W + shift I)), arrays as of :class:`ConeBlocks` and ConeWork."""
    keep, take = small[:9], small[9:18]
    for k in range(len(friction)):
        i = 3 * k
        mixed_rows(
            forces[i], forces[i + 1], forces[i + 2], u[i], u[i + 1], u[i + 2],
            friction[k], rho[k, 0], rho[k, 1], keep, take,
        )  # fmt: skip
        for e in range(first[k], first[k + 1]):
            for a in range(3):
                t_n, t_1, t_2 = take[3 * a], take[3 * a + 1], take[3 * a + 2]
                for b in range(3):
                    out[e, 3 * a + b] = t_n * block[e, b] + t_1 * block[e, 3 + b] + t_2 * block[e, 6 + b]
            if other[e] == k:
                for j in range(9):
                    out[e, j] += keep[j] + shift * take[j]


@kernel
def fill_velocity(
    first: IntArray,
    other: IntArray,
    block: FloatArray,
    free: FloatArray,
    alpha: float,
    centre: FloatArray,
    forces: FloatArray,
    u: FloatArray,
) -> None:
    """Out: u = W r + q + alpha (r - centre) (3 n,)."""
    for k in range(len(first) - 1):
        i = 3 * k
        v: Vector = (free[i], free[i + 1], free[i + 2])
        for e in range(first[k], first[k + 1]):
            j = 3 * other[e]
            v = add_block(block, e, (forces[j], forces[j + 1], forces[j + 2]), v)
        for a in range(3):
            u[i + a] = v[a] + alpha * (forces[i + a] - centre[i + a])


@kernel
def fill_lengths(own: FloatArray, alpha: float, rho: FloatArray) -> None:
    """Out: rho (n, 2) of the blocks own (n, 9) + alpha I."""
    for k in range(len(own)):
        rho[k, 0], rho[k, 1] = lengths(
            own[k, 0] + alpha, own[k, 4] + alpha, own[k, 5], own[k, 7], own[k, 8] + alpha
        )  # fmt: skip


def _look(
    W: ConeBlocks, free: FloatArray, friction: FloatArray, n: int, alpha: float, forces: FloatArray, work: ConeWork
) -> float:
    fill_velocity(W.first, W.other, W.block, free, alpha, work.centre, forces, work.velocity)
    return misses(friction, n, forces, work)


def _direction(
    W: ConeBlocks, friction: FloatArray, n: int, shift: float, forces: FloatArray, work: ConeWork
) -> float:  # fmt: skip
    return W.step(friction, shift, forces, work)


def _measure(W: ConeBlocks, n: int, alpha: float, work: ConeWork) -> None:
    fill_lengths(W.own, alpha, work.rho)


newton_on_blocks: Any = interpreted(
    method.newton, look=_look, direction=_direction, measure=_measure, expired=out_of_time
)  # fmt: skip
"""As :func:`.newton.newton`, with :class:`ConeBlocks` for W."""
