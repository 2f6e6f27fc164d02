"""Friction in space with a faceted cone, an LCP for Lemke's method. It is another model (Stewart & Trinkle 1996).

The disc |r_T| <= mu r_N becomes the polygon of m corners mu r_N d_j, d_j = (cos 2 pi j / m, sin 2 pi j / m), within it:

    0 <= r_N _|_ u_N >= 0,   0 <= beta _|_ s e + D^T u_T >= 0,   0 <= s _|_ mu r_N - e.beta >= 0,   r_T = D beta

(2 + m unknowns a contact, copositive). Friction still dissipates the most of all forces in the polygon; but its
direction is off that of the slip by up to pi / m, and where slip points to the middle of an edge it dissipates
cos(pi / m) of what Coulomb's law does.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lcpflex.basics.arguments import whole_number
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.acceptance import brought_back, restored
from lcpflex.solvers.arguments import check_guess
from lcpflex.solvers.contact.matrices import check_dense
from lcpflex.solvers.contact.spatial import OtherLaw, SpatialContactProblem
from lcpflex.solvers.guard import guarded
from lcpflex.solvers.lcp.lemke import Lemke
from lcpflex.solvers.limits import keep_settings
from lcpflex.solvers.problem import Lcp, PosedProblem, Solution
from lcpflex.solvers.refusals import only_cones

__all__ = ["FacetedCone", "FacetedContactProblem"]

MOST = 1000  # directions


@dataclass(frozen=True, slots=True)
class FacetedContactProblem(OtherLaw):
    """The contacts of a :class:`SpatialContactProblem` with a faceted friction cone.

    Unknowns are the forces (3 k,). directions: m, an even number from 4 on. Raises ModelError for anything else. Its
    residual is the largest of |min(r'_N, u'_N)| and |r'_T - P(r'_T - u'_T)|, P the projection on the polygon of
    mu r'_N, in units of each contact.
    """

    directions: int = 8

    def __post_init__(self) -> None:
        OtherLaw.__post_init__(self)
        object.__setattr__(self, "directions", _checked(self.directions))

    @property
    def corners(self) -> FloatArray:
        """D (2, m): the directions of the corners."""
        angle = 2.0 * np.pi * np.arange(self.directions) / self.directions
        return np.array([np.cos(angle), np.sin(angle)])

    def lcp(self) -> Lcp:
        """Unknowns [r_N (k), beta (m for each contact with friction), s (one each)].

        Raises ModelError beyond 4000 unknowns.
        """
        contact, D, m = self.contact, self.corners, self.directions
        mu = contact.friction
        rough = np.flatnonzero(mu)
        k, f = len(mu), len(rough)
        n = k + f * (m + 1)
        check_dense("the LCP of faceted cones", n)
        spread = np.zeros((contact.size, k + f * m))  # forces of [r_N, beta]
        spread[3 * np.arange(k), np.arange(k)] = 1.0
        for j, i in enumerate(rough):
            spread[3 * i + 1 : 3 * i + 3, k + j * m : k + (j + 1) * m] = D
        M, q = np.zeros((n, n)), np.zeros(n)
        M[: k + f * m, : k + f * m] = spread.T @ contact.dense() @ spread
        q[: k + f * m] = spread.T @ contact.free
        for j, i in enumerate(rough):
            edge, own = slice(k + j * m, k + (j + 1) * m), k + f * m + j
            M[edge, own], M[own, edge], M[own, i] = 1.0, -1.0, mu[i]
        return Lcp(M, q).measured_alike()

    def forces(self, z: FloatArray) -> FloatArray:
        """Forces (3 k,) of a point of :meth:`lcp`."""
        k, m = len(self.contact.friction), self.directions
        rough = np.flatnonzero(self.contact.friction)
        out = np.zeros((k, 3))
        out[:, 0] = z[:k]
        out[rough, 1:] = z[k : k + len(rough) * m].reshape(-1, m) @ self.corners.T
        return out.ravel()

    def _miss(self, r: FloatArray, u: FloatArray) -> float:
        r, u = r.reshape(-1, 3), u.reshape(-1, 3)
        pressed = np.abs(np.minimum(r[:, 0], u[:, 0])).max(initial=0.0)
        radius = self.contact.friction * np.maximum(r[:, 0], 0.0)
        rubbed = r[:, 1:] - nearest_in_polygon(r[:, 1:] - u[:, 1:], radius, self.directions)
        return max(float(pressed), float(np.abs(rubbed).max(initial=0.0)))


@dataclass(frozen=True, slots=True)
class FacetedCone:
    """Contact in space with a faceted friction cone, by Lemke's method: another model, as a cross-check.

    Its friction is off the direction of slip by up to pi / m, and dissipates as little as cos(pi / m) of what Coulomb's
    law does: 22.5 degrees and 7.6 % with the 8 directions of the default. SOLVED means solved in that model, as route
    and message say.

    directions: m, even, from 4 on; the first along the first tangent of each contact. tolerance: largest accepted
    residual of that model [-]. Raises ModelError for numbers out of their range and for problems of another kind.
    """

    directions: int = 8
    tolerance: float = 1e-10

    def __post_init__(self) -> None:
        keep_settings(self)
        object.__setattr__(self, "directions", _checked(self.directions))

    @property
    def model(self) -> str:
        """What it solves instead of the problem."""
        return f"friction cone of {self.directions} facets"

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Why the solver cannot take the problem; empty if it can."""
        return only_cones(self, problem)

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """The forces of the faceted model. A guess is ignored: Lemke's path has its own beginning.

        problem: a :class:`SpatialContactProblem`. guess: the solution of a similar problem, or None. Raises ModelError
        beyond 4000 unknowns of the LCP.
        """
        check_guess(guess)
        if not isinstance(problem, SpatialContactProblem):
            raise ModelError(self.refuses(problem))
        faceted = FacetedContactProblem(problem, self.directions)
        alike = FacetedContactProblem(problem.balanced(), self.directions)
        lcp = alike.lcp()
        with np.errstate(all="ignore"):
            found = guarded("lemke", lcp, self.tolerance, lambda: Lemke(self.tolerance).solve(lcp))
            route = f"{found.route} on {self.model} (not Coulomb's law)"
            words = "" if found.solved else found.message
            told = brought_back(alike, found, alike.forces, self.tolerance, route=route, message=words, active=None)
            told = restored(faceted, told, problem.unknown_units, self.tolerance)
        message = told.message
        if told.solved:
            angle, short = 180.0 / self.directions, 100.0 * (1.0 - np.cos(np.pi / self.directions))
            message = (
                f"solves friction with a cone of {self.directions} facets, whose direction is off by up to {angle:.3g} "
                f"degrees and whose dissipation is short by up to {short:.2g} %"
            )
        return replace(told, message=message, keys=problem.unknown_keys)


def nearest_in_polygon(points: FloatArray, radius: FloatArray, m: int) -> FloatArray:
    """The nearest points (k, 2) of regular polygons of m corners, the first on the first axis, radius (k,) >= 0."""
    sector = 2.0 * np.pi / m
    middle = (np.floor(np.arctan2(points[:, 1], points[:, 0]) / sector) + 0.5) * sector
    along, across = np.cos(middle), np.sin(middle)
    out = points[:, 0] * along + points[:, 1] * across
    side = points[:, 1] * along - points[:, 0] * across
    edge, half = radius * np.cos(0.5 * sector), radius * np.sin(0.5 * sector)
    outside = out > edge
    out, side = np.where(outside, edge, out), np.where(outside, np.clip(side, -half, half), side)
    nearest = np.column_stack([out * along - side * across, out * across + side * along])
    return np.where(outside[:, None], nearest, points)


def _checked(directions: int) -> int:
    """Number of directions. Raises ModelError for what is odd or too few."""
    m = whole_number("directions", directions, 4, MOST)
    if m % 2:
        raise ModelError(f"directions is {m}: expected an even number, as friction acts both ways")
    return m
