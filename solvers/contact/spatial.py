"""Spatial Coulomb contact, read and judged here; no solver of this package takes it.

With u = G r + free, contact k is solved when K_mu ∋ r_k  _|_  u_k + mu_k |u_Tk| n ∈ K_mu* (de Saxce & Feng 1998),
K_mu the cone |r_T| <= mu r_N and K_mu* its dual.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import point_of
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.arrays import finite_array
from lcpflex.solvers.contact.matrices import coefficients, keys_of

__all__ = ["SpatialContactProblem"]


@dataclass(frozen=True, slots=True)
class SpatialContactProblem:
    """Contact velocities ``delassus @ forces + free`` of contacts in space.

    delassus (3 k, 3 k) [1/kg], free (3 k,) [m/s], rows (n, t1, t2) of each contact in turn; friction (k,) [-]; keys
    (k,) names of the contacts, their numbers if left out. Raises ModelError for sizes that do not fit, numbers that
    are not finite, negative coefficients and keys that repeat.
    """

    delassus: FloatArray
    free: FloatArray
    friction: FloatArray
    keys: tuple[Hashable, ...] = ()

    def __post_init__(self) -> None:
        friction = coefficients(self.friction)
        free = finite_array("free", self.free, 1)
        n = 3 * len(friction)
        delassus = finite_array("delassus", self.delassus, 2) if n else np.zeros((0, 0))
        if delassus.shape != (n, n) or free.shape != (n,):
            raise ModelError(f"delassus has shape {delassus.shape}, free {free.shape}: expected ({n}, {n}) and ({n},)")
        keys = keys_of(self.keys, len(friction))
        for name, value in {"delassus": delassus, "free": free, "friction": friction, "keys": keys}.items():
            object.__setattr__(self, name, value)

    @property
    def size(self) -> int:
        """Number 3 k of force components."""
        return len(self.free)

    def residual(self, forces: npt.ArrayLike) -> float:
        """max |r - P_K(r - rho (u + mu |u_T| n))| / rho over max(|free|, |G r|), with rho = 1 / G_nn per contact.

        forces (3 k,) [N s]; the result is dimensionless, inf for NaN or inf. Raises ModelError for another shape.
        """
        r = point_of("forces", forces, self.size)
        if not np.isfinite(r).all():
            return float("inf")
        with np.errstate(all="ignore"):
            caused = self.delassus @ r
            u = (caused + self.free).reshape(-1, 3)
            scale = np.diag(self.delassus)[::3]
            scale = np.where(scale > 0.0, scale, 1.0)[:, None]
            shifted = u.copy()
            shifted[:, 0] += self.friction * np.hypot(u[:, 1], u[:, 2])
            points = r.reshape(-1, 3)
            miss = scale * (points - _project(points - shifted / scale, self.friction))
            worst = float(np.abs(miss).max(initial=0.0))
            size = max(float(np.abs(self.free).max(initial=0.0)), float(np.abs(caused).max(initial=0.0)))
        if not np.isfinite([worst, size]).all():
            return float("inf")
        return worst / size if size > 0.0 else worst


def _project(x: FloatArray, mu: FloatArray) -> FloatArray:
    """The nearest points (k, 3) of the cones |x_T| <= mu x_N."""
    slip = np.hypot(x[:, 1], x[:, 2])
    inside = slip <= mu * x[:, 0]
    polar = mu * slip <= -x[:, 0]
    normal = np.where(polar, 0.0, (x[:, 0] + mu * slip) / (1.0 + mu * mu))
    shrink = mu * normal / np.where(slip > 0.0, slip, 1.0)
    edge = np.column_stack([normal, x[:, 1] * shrink, x[:, 2] * shrink])
    return np.where(inside[:, None], x, edge)
