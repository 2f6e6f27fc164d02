"""Complementarity problems, what a solution of one is, and the only door through which a solver may claim one.

0 <= z  _|_  w = M z + q >= 0                                                    (Cottle, Pang & Stone)
"""

from __future__ import annotations

import enum
import math
from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.compiled import FloatArray, IntArray, kernel
from lcpflex.errors import ModelError

__all__ = [
    "ContactProblem",
    "Lcp",
    "Solution",
    "Status",
    "accept",
    "assemble_friction_lcp",
    "certifies_infeasibility",
    "natural_residual",
    "split_friction_solution",
]

GUARD = 1e-6  # a residual above this fraction of |q| is judged against |q| itself: see natural_residual
ROUNDING = 2.2e-16  # of one operation, relative
SYMMETRY = 1e-10  # largest |M - M^T| of a symmetric matrix, relative to max|M|


class Status(enum.IntEnum):
    """What is known about the point a solver returns."""

    SOLVED = 0
    """The residual, computed anew from the original M and q, is within the tolerance."""
    RAY = 1
    """Lemke's path ended on a ray. For copositive-plus M (PSD included) no solution exists; else inconclusive."""
    ITERATION_LIMIT = 2
    """The limit of pivots or iterations was reached first."""
    NUMERICAL_FAILURE = 3
    """The algorithm ended, but its point does not pass the residual test."""
    INACCURATE = 4
    """The residual is above the tolerance, by a factor of 1000 at most."""
    INFEASIBLE = 5
    """No z >= 0 with w >= 0 exists: a certificate u >= 0, M^T u <= 0, q.u < 0 was verified and is returned."""


# The same codes as plain integers, for kernels.
SOLVED, RAY, ITERATION_LIMIT, NUMERICAL_FAILURE = 0, 1, 2, 3


@kernel
def residual_parts(M: FloatArray, q: FloatArray, z: FloatArray, n: int) -> tuple[float, float, float]:
    """The absolute natural-map residual, the size of the terms of w, and |q|; all inf if anything is not finite.

    M (cap, cap), q (cap,), z (cap,): the leading n x n block and the first n entries count. Returns
    ``max_i |min(d_i z_i, w_i)|`` with d_i the largest |M_ij| of the row (1 for a zero row),
    ``max_i (|q_i| + sum_j |M_ij z_j|)`` and ``max_i |q_i|``, all in the units of q.
    """
    worst, size, load = 0.0, 0.0, 0.0
    for i in range(n):
        w, terms, row = q[i], abs(q[i]), 0.0
        load = max(load, terms)
        for j in range(n):
            entry = M[i, j]
            term = entry * z[j]
            w += term
            terms += abs(term)
            row = max(row, abs(entry))
        if row == 0.0:
            row = 1.0
        lifted = row * z[i]
        # NaN fails every comparison, and min() may drop it: each number is asked for by itself.
        if not (terms < np.inf and abs(lifted) < np.inf and abs(w) < np.inf):
            return np.inf, np.inf, np.inf
        worst = max(worst, abs(min(lifted, w)))
        size = max(size, terms)
    return worst, size, load


@kernel
def natural_residual(M: FloatArray, q: FloatArray, z: FloatArray, n: int) -> float:
    """How far z is from solving the problem: dimensionless, 0 for a solution, inf for a z that is not finite.

    ``max_i |min(d_i z_i, w_i)| / max_i (|q_i| + sum_j |M_ij z_j|)`` with d_i the largest |M_ij| of row i. A z that
    runs away along a ray makes the denominator, and not the numerator, large; so a residual above
    1e-6 |q| is taken relative to |q| instead, and so is the rounding of w itself when it comes to more than that (w
    would be 0 if z is so large that q is lost in the sum). Arrays as in :func:`residual_parts`.
    """
    worst, size, load = residual_parts(M, q, z, n)
    if size < np.inf and ROUNDING * size > GUARD * load > 0.0:
        return max(worst, ROUNDING * size) / load
    if worst == 0.0:
        return 0.0
    if worst == np.inf:
        return np.inf
    if worst > GUARD * load:
        return worst / load if load > 0.0 else np.inf
    return worst / size


@dataclass(frozen=True, slots=True)
class Lcp:
    """The problem 0 <= z _|_ M z + q >= 0.

    M (n, n), q (n,): any consistent units; n = 0 is a valid problem, solved by the empty z.
    Both are copied and made read-only. Raises ModelError if M is not square, the sizes differ or a number is not
    finite.
    """

    M: FloatArray
    q: FloatArray

    def __post_init__(self) -> None:
        q = _finite_array("q", self.q, 1)
        M = _finite_array("M", self.M, 2) if np.size(self.M) else np.zeros((0, 0))
        if M.shape != (len(q), len(q)):
            raise ModelError(f"M has shape {M.shape} and q shape {q.shape}: expected (n, n) and (n,)")
        M.setflags(write=False)
        q.setflags(write=False)
        object.__setattr__(self, "M", M)
        object.__setattr__(self, "q", q)

    @property
    def size(self) -> int:
        """Number of unknowns n."""
        return len(self.q)

    def writable(self) -> FloatArray:
        """A copy of M for kernels: they would be compiled a second time for an array that is read-only."""
        return self.M.copy()

    @property
    def symmetric(self) -> bool:
        """Whether M equals its transpose to rounding; looked at when asked."""
        if not self.size:
            return True
        return bool(np.abs(self.M - self.M.T).max() <= SYMMETRY * np.abs(self.M).max())

    def slack(self, z: npt.ArrayLike) -> FloatArray:
        """w = M z + q, shape (n,)."""
        return np.asarray(self.M @ np.asarray(z, dtype=float) + self.q)

    def residual(self, z: npt.ArrayLike, scaled: bool = True) -> float:
        """Natural-map residual of z (n,): dimensionless (:func:`natural_residual`), or in the units of q if not scaled.

        inf for a z that holds NaN or inf. Raises ModelError if z has another shape.
        """
        point = np.array(z, dtype=float, order="C")
        if point.shape != self.q.shape:
            raise ModelError(f"z has shape {point.shape}: expected {self.q.shape}")
        M, q = self.writable(), self.q.copy()
        if scaled:
            return float(natural_residual(M, q, point, self.size))
        return float(residual_parts(M, q, point, self.size)[0])


@dataclass(frozen=True, slots=True)
class Solution:
    """What a solver found: the point, and how far it can be trusted.

    z, w (n,): the point and w = M z + q. residual: :meth:`Lcp.residual`, scaled. iterations: pivots or iterations.
    route: which algorithm gave the point. active (n,): which z are basic (0 or 1), None if the solver has no basis;
    handing the solution back as the guess of a similar problem starts from there (z > 0 would not do:
    a basic variable may be zero). certificate: the vector u that proves INFEASIBLE, else None.
    """

    z: FloatArray
    w: FloatArray
    status: Status
    residual: float
    iterations: int
    route: str
    message: str
    active: IntArray | None = None
    certificate: FloatArray | None = None

    @property
    def solved(self) -> bool:
        """Whether the status is SOLVED."""
        return self.status is Status.SOLVED


def accept(
    problem: Lcp,
    z: npt.ArrayLike,
    *,
    tolerance: float,
    status: Status = Status.SOLVED,
    iterations: int = 0,
    route: str = "",
    message: str = "",
    active: IntArray | None = None,
    certificate: FloatArray | None = None,
) -> Solution:
    """Judge a point on the original data: the one exit of every solver.

    z (n,): the point; status: what the algorithm believes; its word counts only for *why* it failed. SOLVED is granted
    if and only if the residual is within the tolerance; INFEASIBLE only with a verified certificate u (n,).
    """
    point = np.array(z, dtype=float)
    residual = problem.residual(point)
    if residual <= tolerance:
        judged = Status.SOLVED
    elif certificate is not None and certifies_infeasibility(problem, certificate):
        judged = Status.INFEASIBLE
    elif residual <= 1e3 * tolerance:
        judged = Status.INACCURATE
    elif status in (Status.RAY, Status.ITERATION_LIMIT):
        judged = status
    else:
        judged = Status.NUMERICAL_FAILURE
    if judged is not Status.INFEASIBLE:
        certificate = None
    if judged is not Status.SOLVED and not message:
        message = f"{judged.name.lower().replace('_', ' ')}: residual {residual:.1e}, tolerance {tolerance:.1e}"
    with np.errstate(all="ignore"):  # a point that is not finite has been judged already
        w = problem.slack(point)
    return Solution(point, w, judged, residual, iterations, route, message, active, certificate)


def certifies_infeasibility(problem: Lcp, u: npt.ArrayLike) -> bool:
    """Whether u (n,) proves that no z >= 0 has w >= 0: u >= 0, M^T u <= 0 and q.u < 0 (Farkas).

    With w >= 0 one would have 0 <= u.w = z.(M^T u) + q.u < 0. Where rounding leaves M^T u slightly positive, the
    statement is checked for every z with z_i <= 1e6 max|q| / max_j |M_ji|.
    """
    ray = np.array(u, dtype=float)
    if ray.shape != problem.q.shape or not np.isfinite(ray).all() or not ray.size or ray.max() <= 0.0:
        return False
    ray = np.maximum(ray, 0.0) / ray.max()
    gain = float(problem.q @ ray)
    excess = np.maximum(problem.M.T @ ray, 0.0)
    column = np.abs(problem.M).max(axis=0)
    size = np.divide(np.abs(problem.q).max(), column, out=np.zeros_like(column), where=column > 0.0)
    return gain + 1e6 * float(excess @ size) < -1e-8 * float(np.abs(problem.q) @ ray)


@kernel
def assemble_friction_lcp(
    G: FloatArray,
    free: FloatArray,
    mu: FloatArray,
    tangent: IntArray,
    n_normal: int,
    n_tangent: int,
    M: FloatArray,
    q: FloatArray,
) -> int:
    """The LCP of planar Coulomb contact with three unknowns a frictional contact and one a frictionless contact.

    G (cap, cap): Delassus matrix, the leading block of order n_normal + n_tangent, normals first; free (cap,):
    velocity or acceleration of the contacts without contact forces; mu (>= n_normal,): friction coefficients [-];
    tangent (>= n_tangent,): row j of the tangents belongs to normal contact tangent[j]. Out: M (cap', cap') and
    q (cap',), of which the leading n = n_normal + 2 n_tangent are written; n is returned. Unknowns
    [lambda_N, lambda_R, xi_L] with lambda_R = lambda_T + mu lambda_N and the tangential velocity xi_R - xi_L
    (Glocker & Studer 2005).
    """
    n = n_normal + 2 * n_tangent
    m = n_normal + n_tangent
    for i in range(m):
        for j in range(m):
            M[i, j] = G[i, j]
        for k in range(n_tangent):
            j = tangent[k]
            M[i, j] -= G[i, n_normal + k] * mu[j]
            M[i, m + k] = 0.0
        q[i] = free[i]
    for k in range(n_tangent):
        for j in range(n):
            M[m + k, j] = 0.0
        M[n_normal + k, m + k] = 1.0
        M[m + k, n_normal + k] = -1.0
        M[m + k, tangent[k]] = 2.0 * mu[tangent[k]]
        q[m + k] = 0.0
    return n


@kernel
def split_friction_solution(
    z: FloatArray,
    mu: FloatArray,
    tangent: IntArray,
    n_normal: int,
    n_tangent: int,
    lambda_normal: FloatArray,
    lambda_tangent: FloatArray,
) -> None:
    """Contact forces (or impulses) from the unknowns of :func:`assemble_friction_lcp`.

    Out: lambda_normal (>= n_normal,) and lambda_tangent (>= n_tangent,) = lambda_R - mu lambda_N, kept inside
    the cone |lambda_T| <= mu lambda_N, which rounding may leave.
    """
    for i in range(n_normal):
        lambda_normal[i] = z[i]
    for k in range(n_tangent):
        bound = mu[tangent[k]] * z[tangent[k]]
        lambda_tangent[k] = min(max(z[n_normal + k] - bound, -bound), bound)


@dataclass(frozen=True, slots=True)
class ContactProblem:
    """Planar Coulomb contact: contact velocities (or accelerations) are ``delassus @ forces + free``.

    delassus (m, m) [1/kg] and free (m,): rows ordered [normals of all contacts; tangents of the frictional ones],
    m = n_N + n_H. friction (n_N,) [-]: a contact has a tangent row if and only if its coefficient is positive.
    keys (n_N,): names of the contacts, for messages; their numbers if left out. Raises ModelError for sizes that
    do not fit, a number that is not finite or a negative coefficient.
    """

    delassus: FloatArray
    free: FloatArray
    friction: FloatArray
    keys: tuple[Hashable, ...] = ()

    def __post_init__(self) -> None:
        friction = _finite_array("friction", self.friction, 1)
        if (friction < 0.0).any():
            raise ModelError(f"friction is {friction}: expected coefficients >= 0")
        free = _finite_array("free", self.free, 1)
        delassus = _finite_array("delassus", self.delassus, 2) if np.size(self.delassus) else np.zeros((0, 0))
        m = len(friction) + int(np.count_nonzero(friction))
        if free.shape != (m,) or delassus.shape != (m, m):
            raise ModelError(
                f"delassus has shape {delassus.shape} and free {free.shape}: expected ({m}, {m}) and ({m},) for "
                f"{len(friction)} contacts, {m - len(friction)} of them with friction"
            )
        keys = tuple(self.keys) or tuple(range(len(friction)))
        if len(keys) != len(friction):
            raise ModelError(f"keys has {len(keys)} entries: expected {len(friction)}, one a contact")
        for name, value in (("delassus", delassus), ("free", free), ("friction", friction), ("keys", keys)):
            object.__setattr__(self, name, value)

    @property
    def tangent(self) -> IntArray:
        """(n_H,) the contact to which each tangential row belongs."""
        return np.flatnonzero(self.friction).astype(np.int64)

    def lcp(self) -> Lcp:
        """Unknowns [lambda_N (n_N), lambda_R (n_H), xi_L (n_H)]: see :func:`assemble_friction_lcp`."""
        tangent, normals = self.tangent, len(self.friction)
        n = normals + 2 * len(tangent)
        M, q = np.zeros((n, n)), np.zeros(n)
        assemble_friction_lcp(self.delassus, self.free, self.friction, tangent, normals, len(tangent), M, q)
        return Lcp(M, q)

    def forces(self, z: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """(lambda_N (n_N,), lambda_T (n_H,)) of a solution z (n,) of :meth:`lcp`."""
        tangent, normals = self.tangent, len(self.friction)
        point = np.array(z, dtype=float, order="C")
        if point.shape != (normals + 2 * len(tangent),):
            raise ModelError(f"z has shape {point.shape}: expected ({normals + 2 * len(tangent)},)")
        out = np.zeros(normals), np.zeros(len(tangent))
        split_friction_solution(point, self.friction, tangent, normals, len(tangent), *out)
        return out


def _finite_array(name: str, value: Any, dimensions: int) -> FloatArray:
    """A contiguous copy of an argument; refuses other dimensions and NaN or inf."""
    try:
        array = np.array(value, dtype=float, order="C")
    except (TypeError, ValueError) as error:
        raise ModelError(f"{name} is {value!r}: expected numbers") from error
    if array.ndim != dimensions:
        raise ModelError(f"{name} has shape {array.shape}: expected {dimensions} dimension(s)")
    if not np.isfinite(array).all():
        place = tuple(int(k) for k in np.argwhere(~np.isfinite(array))[0])
        raise ModelError(f"{name}[{', '.join(map(str, place))}] is {array[place]}: expected a finite number")
    return array


def check_tolerance(tolerance: float) -> None:
    """A tolerance of the natural-map residual: refuses what no residual could mean."""
    if not (isinstance(tolerance, (int, float)) and math.isfinite(tolerance) and 0.0 < tolerance < 1e-2):
        raise ModelError(f"tolerance is {tolerance!r}: expected a number between 0 and 0.01 (relative residual)")
