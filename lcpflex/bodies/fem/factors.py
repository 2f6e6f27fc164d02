"""Factors of a positive definite matrix, whatever has made them."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from lcpflex.bodies.fem.factor_cost import SUPERLU
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["AT_ONCE", "Factor", "NotPositive", "SuperLuFactor"]

AT_ONCE = 32  # columns treated together: more cost memory and save no time


class NotPositive(ArithmeticError):
    """The matrix has no factors with positive pivots."""


class Factor(Protocol):
    """Solves A x = b."""

    @property
    def in_blocks(self) -> bool:
        """Whether many columns together take much less time than one by one."""
        ...

    @property
    def memory(self) -> float:
        """Bytes that it takes, about."""
        ...

    def solve(self, right: FloatArray) -> FloatArray:
        """x of b (n,) or (n, k)."""
        ...


class SuperLuFactor:
    """That of SuperLU, of a matrix whose rows were put in an order (n,)."""

    __slots__ = ("_lu", "_order")

    def __init__(self, lu: Any, order: IntArray) -> None:
        self._lu = lu
        self._order = order

    @property
    def in_blocks(self) -> bool:
        """It takes four fifths of the time, which Lanczos iterations with blocks lose by more columns."""
        return False

    @property
    def memory(self) -> float:
        """Bytes that it takes, about."""
        return 0.5 * SUPERLU.memory * float(self._lu.nnz)  # entries of both triangles

    def solve(self, right: FloatArray) -> FloatArray:
        """x of b (n,) or (n, k)."""
        out = np.empty(right.shape)
        if right.ndim == 1:
            out[self._order] = self._lu.solve(right[self._order])
            return out
        for first in range(0, right.shape[1], AT_ONCE):
            part = slice(first, first + AT_ONCE)
            out[self._order, part] = self._lu.solve(np.asfortranarray(right[self._order, part]))
        return out
