"""The last steps to a place of rest: Newton's method with the contacts as they are on the path.

Where contacts share friction in many ways, as those of a box on a floor, some are at their limit in the forces that a
solver found, against each other: those that could be within it stick.

With C = [J; W_N; W_T] of closed normals and sticking tangents, B the same with W_N + W_T lambda_T / lambda_N where a
contact slips, and K the tangent stiffness,

    K dq - B^T p = h,    C dq = -[phi; g; 0]

in least squares of least norm: dependent rows and directions in which nothing resists are left as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from lcpflex.jit.kernel import FloatArray
from lcpflex.statics.balance import Balance, Configuration
from lcpflex.statics.path import Path
from lcpflex.statics.scales import Scales
from lcpflex.statics.shared_forces import could_stick
from lcpflex.statics.tangent import tangent_stiffness

__all__ = ["Sets", "coordinate_units", "refined", "sets_of"]

BoolArray: TypeAlias = NDArray[np.bool_]

SLIPPED = 1e-9  # of the size: a shorter slip has no direction
PRESSED = 1e-9  # of the largest force: smaller normal forces are none
INSIDE = 1e-7  # of the limit of friction: what is nearer slips
CUT = 1e-9  # of the largest singular value
TURNS = 20
LARGE = 200  # equations from which on a factor is tried before singular values: a tenth of their time
FAST = 0.01  # of the residual before: while it falls so fast, the stiffness is not computed anew
HALVED = 0.5  # of the best residual: what is not better is rounding
EXACT = 1e-11  # residual, relative to the forces that act and to the size, that must be reached
# of the size: gaps up to it are closed. Of surfaces that bend, more may be than there are coordinates to close them
CLOSED = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Sets:
    """Rows that hold, among those of a configuration."""

    hold: FloatArray  # C (k, ndof)
    push: FloatArray  # B (k, ndof)
    spread: FloatArray  # (rows, k): multipliers of all rows from those of B
    offset: FloatArray  # (k,) [phi; g; 0]


def sets_of(at: Configuration, pressed: BoolArray, ratio: FloatArray, sticks: BoolArray) -> Sets:
    """Of a configuration with the n contacts that are ``pressed``, the m tangents that stick, and for others
    the ``ratio`` (m,) of tangential to normal force."""
    r, n = at.n_joint, at.n_contacts
    picks = [np.eye(len(at.rows))[:, :r]]
    normals = np.zeros((len(at.rows), n))
    normals[r + np.arange(n), np.arange(n)] = 1.0
    pushing = normals.copy()
    for j, k in enumerate(at.tangent):
        if not sticks[j]:
            pushing[r + n + j, k] = ratio[j]
    tangents = np.zeros((len(at.rows), len(at.tangent)))
    tangents[r + n + np.arange(len(at.tangent)), np.arange(len(at.tangent))] = 1.0
    hold = np.hstack([*picks, normals[:, pressed], tangents[:, sticks & pressed[at.tangent]]])
    push = np.hstack([*picks, pushing[:, pressed], tangents[:, sticks & pressed[at.tangent]]])
    offset = np.concatenate([at.phi, at.gap, np.zeros(len(at.tangent))])
    return Sets(hold.T @ at.rows, push.T @ at.rows, push, hold.T @ offset)


def coordinate_units(K: FloatArray, scales: Scales, force: float | FloatArray) -> FloatArray:
    """(ndof,) c = 1 / sqrt(k): k the own stiffness of each coordinate, no less than that of the forces that act.

    Forces of ``force`` [N], one for all or (ndof,) each its own, turn with the bodies, which are of the ``size``:
    force / size [N/m]. In these units stiffnesses are numbers up to about 1.
    """
    floor = force / scales.size * scales.arm**2
    return np.asarray(1.0 / np.sqrt(np.maximum(np.abs(np.diag(K)), floor)))


def refined(balance: Balance, scales: Scales, path: Path) -> FloatArray | None:
    """The place of rest (nq,) next to the last station of the path; None where Newton's method finds none."""
    here = path.station
    if here.scale == 0.0:
        return here.at.q
    at, p = here.at, here.p
    r, n = at.n_joint, at.n_contacts
    normal, tangential = p[r : r + n], p[r + n :]
    pressed = normal > PRESSED * here.scale
    limit = (at.friction * normal)[at.tangent]
    size = np.repeat(np.hypot.reduce(tangential.reshape(-1, at.d), axis=1), at.d)
    sticks = size < (1.0 - INSIDE) * limit
    if at.d == 2 and not sticks[pressed[at.tangent]].all():
        sticks |= could_stick(at, scales, pressed, p / here.scale)
    ratio = tangential / np.where(size > 0.0, size, 1.0) * at.friction[at.tangent]
    sliding = Sliding(scales, path, ~sticks)
    best, best_left, before = at.q, np.inf, np.inf
    near, near_left = at.q, np.inf  # balanced, with gaps that are closed as far as they count
    q, K = at.q, None
    for _ in range(TURNS):
        at = balance.again(q)
        ratio, turning = sliding.at(at, p, ratio)
        sets = sets_of(at, pressed, ratio, sticks)
        if balance.crossing().any():
            p = p + _missing(sets, at, scales, p)
        unbalanced = scales.force(at.force + at.rows.T @ p) / here.scale
        drift = scales.off(at)
        apart = float(np.abs(sets.offset[r:]).max(initial=0.0)) / scales.size
        left = max(unbalanced, drift, apart)
        done = best_left <= EXACT and left > HALVED * best_left
        if left < best_left:
            best, best_left = q, left
        if max(unbalanced, drift) <= EXACT and apart <= CLOSED:
            done |= apart > EXACT and apart > HALVED * near_left  # no step closes them any farther
            if apart < near_left:
                near, near_left = q, apart
        if done:
            break
        if K is None or left > FAST * before:
            K = tangent_stiffness(balance, scales, q, p)
        before = left
        dq, p = _newton(K + turning, sets, at, coordinate_units(K, scales, here.scale))
        q = balance.moved(q, dq)
        if not scales.moved(balance.difference(q, here.at.q)) <= path.longest:
            break
    return best if best_left <= EXACT else near if near_left <= CLOSED else None


class Sliding:
    """Friction in space of contacts that slide from a place of rest: against their whole way from there, which turns.

    -mu lambda_N s / |s| of a slip s, and its tangent mu lambda_N (I - s s^T / s^2) / |s| for moves across the way. In
    the plane, and where no slip is counted, friction stays along where it is.
    """

    def __init__(self, scales: Scales, path: Path, slides: BoolArray) -> None:
        self._path, self._least = path, SLIPPED * scales.size
        self._slides = slides if path.station.at.d == 2 and path.slip(path.station.at).any() else np.zeros(0, bool)

    def at(self, at: Configuration, p: FloatArray, ratio: FloatArray) -> tuple[FloatArray, FloatArray | float]:
        """The ratios (m,) of tangential to normal force, and what is added to the stiffness (ndof, ndof)."""
        if not self._slides.any():
            return ratio, 0.0
        tangents = at.rows[at.n_joint + at.n_contacts :]
        whole = self._path.slip(at).reshape(-1, 2)
        size = np.hypot(whole[:, 0], whole[:, 1])
        turned, added = ratio.reshape(-1, 2).copy(), np.zeros((tangents.shape[1],) * 2)
        for e in np.flatnonzero(self._slides[::2] & (size > self._least)):
            k, way, rows = at.tangent[2 * e], whole[e] / size[e], tangents[2 * e : 2 * e + 2]
            turned[e] = -at.friction[k] * way
            limit = at.friction[k] * max(float(p[at.n_joint + k]), 0.0)
            added += limit / size[e] * rows.T @ (np.eye(2) - np.outer(way, way)) @ rows
        return turned.ravel(), added


def _missing(sets: Sets, at: Configuration, scales: Scales, p: FloatArray) -> FloatArray:
    """What the multipliers p of all rows lack of a balance.

    Where edges that are nearly parallel cross, rounding of the place moves the corner, and with it its force, by much
    more than itself.
    """
    left = (at.force + at.rows.T @ p) / scales.arm
    return np.asarray(sets.spread @ np.linalg.lstsq((sets.push / scales.arm).T, -left, rcond=CUT)[0])


def _newton(K: FloatArray, sets: Sets, at: Configuration, c: FloatArray) -> tuple[FloatArray, FloatArray]:
    """dq and the multipliers of all rows."""
    count = len(sets.hold)
    unit = np.linalg.norm(sets.hold * c, axis=1)
    d = 1.0 / np.where(unit > 0.0, unit, 1.0)
    A = np.block(
        [
            [K * np.outer(c, c), -(sets.push * np.outer(d, c)).T],
            [sets.hold * np.outer(d, c), np.zeros((count, count))],
        ]
    )
    right = np.concatenate([at.force * c, -sets.offset * d])
    x = _solved(A, right)
    return x[: len(c)] * c, sets.spread @ (x[len(c) :] * d)


def _solved(A: FloatArray, right: FloatArray) -> FloatArray:
    """The x of least norm that leaves least of A x = right.

    Singular values are dear of large matrices, and not needed where none is small: in the norm of columns the inverse
    condition is at most n times the ratio of the smallest to the largest one.
    """
    if len(A) > LARGE:
        lu, exchanges, _ = lapack.dgetrf(A)
        condition, _ = lapack.dgecon(lu, float(np.abs(A).sum(axis=0).max()))
        if condition > len(A) * CUT:
            x = lapack.dgetrs(lu, exchanges, right)[0]
            return np.asarray(x + lapack.dgetrs(lu, exchanges, right - A @ x)[0])
    return np.asarray(np.linalg.lstsq(A, right, rcond=CUT)[0])
