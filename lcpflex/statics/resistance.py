"""What resists a step of a path: alpha M + K, damping and tangent stiffness, as factors F F^T in metres.

K may push away. Where joints and contacts hold those directions it makes no difference, else steps are short enough to
tell; they are left out, V diag(max(s, 0)) V^T of L^-1 K L^-T with M = L L^T, once for all alpha.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray

__all__ = ["Factor", "Resistance"]


@dataclass(frozen=True, slots=True, eq=False)
class Factor:
    """F = L V diag(sizes), L lower triangular; L alone where there is no V."""

    lower: FloatArray
    turned: FloatArray | None = None
    sizes: FloatArray | None = None

    def whitened(self, forces: FloatArray) -> FloatArray:
        """F^-1 of forces (n,) or (n, k)."""
        found = libs.linalg.solve_triangular(self.lower, forces, lower=True, check_finite=False)
        if self.turned is None or self.sizes is None:
            return np.asarray(found)
        return np.asarray(((self.turned.T @ found).T / self.sizes).T)

    def moved(self, white: FloatArray) -> FloatArray:
        """F^-T of ``white`` (n,), a motion in metres."""
        if self.turned is not None and self.sizes is not None:
            white = self.turned @ (white / self.sizes)
        return np.asarray(libs.linalg.solve_triangular(self.lower, white, lower=True, trans=1, check_finite=False))


class Resistance:
    """Of one station, mass matrix M and symmetric K (ndof, ndof); arm (ndof,) metres a unit of each coordinate."""

    def __init__(self, M: FloatArray, K: FloatArray, arm: FloatArray) -> None:
        units = np.outer(arm, arm)
        self._M, self._K = M / units, K / units
        self._known: tuple[FloatArray, FloatArray, FloatArray] | None = None

    def factor(self, alpha: float) -> Factor:
        """Of alpha M + K, without the directions in which K pushes away if it must be."""
        try:
            return Factor(np.asarray(np.linalg.cholesky(alpha * self._M + self._K), dtype=np.float64))
        except np.linalg.LinAlgError:
            L, V, s = self._directions()
            return Factor(L, V, np.sqrt(alpha + np.maximum(s, 0.0)))

    def _directions(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """L, V and s."""
        if self._known is None:
            L = np.asarray(np.linalg.cholesky(self._M), dtype=np.float64)
            half = libs.linalg.solve_triangular(L, self._K, lower=True)
            white = libs.linalg.solve_triangular(L, half.T, lower=True)
            s, V = np.linalg.eigh(0.5 * (white + white.T))
            self._known = L, np.asarray(V), np.asarray(s)
        return self._known
