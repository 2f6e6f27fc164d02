"""Lowest modes of large meshes, many columns at a time.

Block Lanczos iterations (Golub and Underwood 1977) with G M, G a flexibility, in the inner product of the mass matrix,

    G M V = V H + Q B e^T,   V^T M V = I,   V^T M Q = 0

where each step appends the block Q to V and makes the next one. H s = theta s gives the modes V s with omega^2 =
1 / theta, each with the error |B s| of its last rows. The basis is kept orthogonal in full, and restarted with its best
modes when it is long (Stathopoulos, Saad and Wu 1998). A block finds as many modes of one frequency as it has columns;
whether more were missed, a few steps from another start tell.

A factor is read once for all columns of a block: of large ones reading it is most of the time of a solution.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.blas import one_thread
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

Flexibility: TypeAlias = Callable[[FloatArray], FloatArray]

__all__ = ["block_lanczos", "check_modes", "columns_of"]

BLOCK = 12  # columns: with more a solution takes hardly less time a column, and more columns are needed
WIDEST = 48  # block of the last try
SPARE = 10  # blocks in the basis beyond twice the modes that are wanted, where it is restarted
RESTARTS = 50  # of them; a few suffice
ERROR = 1e-9  # of a mode, relative to its theta: its omega^2 is then exact to rounding
NOISE = 1e-14  # part of the highest theta that is rounding
CHECKED = 3  # steps from another start
LEFT = 1e-5  # of the equations of a mode, of which rounding and ERROR leave 1e-7
TINY = 1e-290  # square of a length below which there is none
MISSED = 1e-6  # part by which a theta of that start is above the last one found, and so was missed


def columns_of(count: int) -> int:
    """Full columns in memory while ``count`` modes are sought."""
    return 2 * columns_in_basis(count, BLOCK) + count + 6 * BLOCK


def columns_in_basis(count: int, block: int) -> int:
    """How long it grows."""
    return 2 * count + SPARE * block


def block_lanczos(mass: csc_matrix[Any], flexibility: Flexibility, count: int) -> tuple[FloatArray, FloatArray]:
    """(omega2, shapes) of the ``count`` lowest modes, M-orthonormal; a fixed start gives the same bits.

    Raises
    ------
    ModelError
        If they are not found, or more modes of one frequency than the widest block has columns.
    """
    block = BLOCK
    while block <= WIDEST:
        theta, shapes = _Krylov(mass, flexibility, block, count).run()
        again = _Krylov(mass, flexibility, BLOCK // 2, count, locked=shapes)
        if again.top() <= (1.0 + MISSED) * theta[-1]:
            return 1.0 / theta, shapes
        block *= 2
    raise ModelError(
        f"stiffness, mass: their {count} lowest modes were not found, more than {WIDEST} of them have one frequency"
    )


def check_modes(stiffness: csc_matrix[Any], mass: csc_matrix[Any], omega2: FloatArray, shapes: FloatArray) -> None:
    """Refuse what is left of K v - omega^2 M v, in the norm of the diagonal of K."""
    for first in range(0, len(omega2), BLOCK):
        part = slice(first, first + BLOCK)
        left = stiffness @ shapes[:, part] - omega2[part] * (mass @ shapes[:, part])
        size = float(np.sqrt((left**2 / stiffness.diagonal()[:, None]).sum(axis=0) / omega2[part]).max())
        if not size <= LEFT:
            raise ModelError(f"stiffness, mass: their lowest modes are left with errors of {size:.3g}, expected {LEFT}")


class _Krylov:
    """The basis, and the projection of G M on it. M times the basis is kept: to make it again costs more time."""

    def __init__(
        self,
        mass: csc_matrix[Any],
        flexibility: Flexibility,
        block: int,
        count: int,
        locked: FloatArray | None = None,
    ) -> None:
        n = mass.shape[0]
        self._mass, self._flexibility, self._count = mass, flexibility, count
        self._locked = np.zeros((n, 0)) if locked is None else locked
        self._heavy_locked = mass @ self._locked
        self._most = columns_in_basis(count, block) if locked is None else CHECKED * block
        self._basis, self._heavy = (np.empty((n, self._most), order="F") for _ in range(2))
        self._projection = np.zeros((self._most, self._most))
        self._used = 0
        start = np.random.default_rng(block).standard_normal((n, block))
        self._next, self._heavy_next, _ = self._orthonormal(self._apply(mass @ start), 0.0)

    def run(self) -> tuple[FloatArray, FloatArray]:
        """The highest theta, descending, and their modes."""
        for _ in range(RESTARTS):
            while self._used + self._next.shape[1] <= self._most:
                coupling = self._step()
                theta, turn = self._ritz()
                last = turn[self._used - coupling.shape[1] :, : self._count]
                error = np.linalg.norm(coupling @ last, axis=0)
                settled = error <= np.maximum(ERROR * theta[: self._count], NOISE * theta[0])
                if (len(theta) >= self._count and settled.all()) or not self._next.shape[1]:
                    return theta[: self._count], self._basis[:, : self._used] @ turn[:, : self._count]
            self._restart(theta, turn)
        raise ModelError(f"stiffness, mass: their {self._count} lowest modes were not found in {RESTARTS} restarts")

    def top(self) -> float:
        """The highest theta after some steps."""
        for _ in range(CHECKED):
            if self._next.shape[1]:
                self._step()
        return float(self._ritz()[0][0]) if self._used else 0.0

    def _step(self) -> FloatArray:
        """Append the next block and make another; returns what couples it to that of before, B."""
        first, last = self._used, self._used + self._next.shape[1]
        self._basis[:, first:last], self._heavy[:, first:last] = self._next, self._heavy_next
        self._used = last
        found = self._apply(self._heavy_next)
        along = self._heavy[:, :last].T @ found
        found -= self._basis[:, :last] @ along
        self._projection[:last, first:last] = along
        self._projection[first:last, :last] = along.T
        size = float(np.abs(self._projection[:last, :last]).max())
        self._next, self._heavy_next, coupling = self._orthonormal(found, size)
        return coupling

    def _apply(self, heavy: FloatArray) -> FloatArray:
        """G of M times columns, without what is locked."""
        found = self._flexibility(heavy)
        found -= self._locked @ (self._heavy_locked.T @ found)
        return found

    def _orthonormal(self, columns: FloatArray, size: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """(Q, M Q, B) with Q B = columns, Q^T M Q = I; directions that are rounding of a ``size`` are left out."""
        heavy = self._mass @ columns
        gram = columns.T @ heavy
        with one_thread(len(gram)):
            squares, turn = libs.linalg.eigh(gram)
        kept = squares > max((NOISE * size) ** 2, TINY)
        length = np.sqrt(squares[kept])
        turned = turn[:, kept] / length
        columns, heavy = self._cleaned(columns @ turned, heavy @ turned)
        return columns, heavy, length[:, None] * turn[:, kept].T

    def _cleaned(self, columns: FloatArray, heavy: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Orthonormal to rounding: short columns have kept some of the basis, or were nothing else."""
        if not columns.shape[1]:
            return columns, heavy
        pairs = [(self._basis[:, : self._used], self._heavy[:, : self._used]), (self._locked, self._heavy_locked)]
        for basis, weighed in pairs:
            along = weighed.T @ columns
            columns -= basis @ along
            heavy -= weighed @ along
        with one_thread(columns.shape[1]):
            squares, turn = libs.linalg.eigh(columns.T @ heavy)
        kept = squares > 0.5  # of 1
        turn = turn[:, kept] / np.sqrt(squares[kept])
        return columns @ turn, heavy @ turn

    def _ritz(self) -> tuple[FloatArray, FloatArray]:
        """All theta, descending, and their coordinates in the basis."""
        part = self._projection[: self._used, : self._used]
        with one_thread(len(part)):
            theta, turn = libs.linalg.eigh(part)
        return theta[::-1], turn[:, ::-1]

    def _restart(self, theta: FloatArray, turn: FloatArray) -> None:
        """Keep the best modes and the next block."""
        kept = min(self._count + BLOCK, self._used)
        for basis in (self._basis, self._heavy):
            basis[:, :kept] = basis[:, : self._used] @ turn[:, :kept]
        self._projection[:] = 0.0
        self._projection[np.arange(kept), np.arange(kept)] = theta[:kept]
        self._used = kept
