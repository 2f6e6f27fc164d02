"""Proximal semismooth Newton method for planar Coulomb friction on sparse matrices.

Coulomb's law regularised about a centre c of impulses, which then follows, in units in which the diagonal is 1:

    a = c_N - v_N / eps,  t = c_T - v_T / eps:   open (a <= 0) p = 0;  sticking (|t| <= mu a) p = (a, t);
    sliding p = (a, +-mu a);       v = J u + free, F(u) = u - J^T p = 0:   (I + J^T C J) du = -F,   C = -dp/dv

Where only W = J J^T is known, the same in forces: u = J^T x, F = x - p measured by F.W F, and the equations are those
of the contacts that are pressed, (W + eps) y = -W F. eps is in the way and not in the limit. Sources: Alart & Curnier
1991 (the mapping); Rockafellar 1976 (the proximal point algorithm).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.contact.active_set import free_forces, in_cones
from lcpflex.solvers.contact.laws.states import BACK, FORTH, OPEN, STICKING
from lcpflex.solvers.contact.problem import ContactProblem

__all__ = ["Proximal"]

INNER_LIMIT = 20  # Newton steps for one centre
INNER = 1e-3  # of the residual: what is left of F when the centre moves on
ROUNDING = 4e-16
SHRINK, SHORTEST, DESCENT = 0.4, 1e-3, 1e-4  # of a step that does not make F smaller
LEAST_EPS, LARGEST_EPS = 1e-8, 1e3
FAR = 1e6  # how far impulses may be taken on at once
SLOW = 0.5  # of the residual: what a new centre leaves where impulses have far to go
FOUND, NOT_FOUND, NO_FACTOR = 1, 0, -1

Step = Callable[[FloatArray], FloatArray]


class _Point(NamedTuple):
    """x, the impulses p (m,) that the law gives for it, the states (n,), F and its size."""

    x: FloatArray
    p: FloatArray
    states: IntArray
    F: FloatArray
    size: float


class _Space(Protocol):
    """What the unknowns x are: velocities of bodies, or forces."""

    def of_forces(self, p: FloatArray) -> FloatArray: ...
    def velocity(self, x: FloatArray) -> FloatArray: ...
    def defect(self, x: FloatArray, p: FloatArray) -> tuple[FloatArray, float]: ...
    def rounding(self, x: FloatArray) -> float: ...
    def factor(self, rows: IntArray, spread: Any, eps: float) -> Step: ...


class _InBodies:
    """Velocities u (k,) of the bodies, by the factor J."""

    def __init__(self, problem: ContactProblem) -> None:
        self.J = libs.sparse.csr_array(problem._data[3])
        self.JT = libs.sparse.csr_array(self.J.T)
        self.free = problem._data[1]

    def of_forces(self, p: FloatArray) -> FloatArray:
        return np.asarray(self.JT @ p)

    def velocity(self, x: FloatArray) -> FloatArray:
        return np.asarray(self.J @ x + self.free)

    def defect(self, x: FloatArray, p: FloatArray) -> tuple[FloatArray, float]:
        F = x - self.JT @ p
        return F, float(np.sqrt(F @ F))

    def rounding(self, x: FloatArray) -> float:
        """Size of the terms of v."""
        return float(np.sqrt(x @ x)) + float(np.abs(self.free).max(initial=0.0))

    def factor(self, rows: IntArray, spread: Any, eps: float) -> Step:
        matrix = libs.sparse.eye_array(self.J.shape[1]) + (self.JT @ spread) @ (self.J[rows] / eps)
        solve = _factorised(matrix)
        return lambda F: -solve(F)


class _InForces:
    """Forces x (m,) with u = J^T x, where W alone is known."""

    def __init__(self, problem: ContactProblem) -> None:
        self.W = libs.sparse.csr_array(problem._data[0])
        self.free = problem._data[1]

    def of_forces(self, p: FloatArray) -> FloatArray:
        return p.copy()

    def velocity(self, x: FloatArray) -> FloatArray:
        return np.asarray(self.W @ x + self.free)

    def defect(self, x: FloatArray, p: FloatArray) -> tuple[FloatArray, float]:
        F = x - p
        return F, float(np.sqrt(max(float(F @ (self.W @ F)), 0.0)))

    def rounding(self, x: FloatArray) -> float:
        """Size of the terms of v: forces that cancel count."""
        return 2.0 * float(np.sqrt(x @ x)) + float(np.abs(self.free).max(initial=0.0))

    def factor(self, rows: IntArray, spread: Any, eps: float) -> Step:
        if not len(rows):
            return lambda F: -F
        solve = _factorised(self.W[rows] @ spread + eps * libs.sparse.eye_array(len(rows)))
        return lambda F: -F - spread @ solve(-(self.W @ F)[rows])


def _factorised(matrix: Any) -> Step:
    """Solve with a matrix whose diagonal is large: without exchanges of rows, in the order of least degree."""
    how: dict[str, Any] = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    solve: Step = libs.splu(libs.sparse.csc_array(matrix), **how).solve
    return solve


class Proximal:
    """The method for one problem in units of its contacts; ``keep`` judges impulses (m,) and returns their residual."""

    def __init__(self, problem: ContactProblem, keep: Callable[[FloatArray], float]) -> None:
        self.problem, self.keep = problem, keep
        self.space: _Space = _InForces(problem) if problem.delassus is not None else _InBodies(problem)
        self.n, self.tangent = len(problem.friction), problem.tangent
        self.mu = problem.friction[self.tangent]
        self.factors, self.limit = 0, 0

    def run(self, p: FloatArray, eps: float, limit: int, tolerance: float) -> int:
        """From impulses p (m,) and a first ``eps``, until ``keep`` returns no more than the tolerance.

        limit: factors at most; how many were made is returned. eps goes down where few factors were needed, and up
        where F could not be made zero.
        """
        self.factors, self.limit = 0, limit
        residual, x, failed = self._left(p), self.space.of_forces(p), 0.0
        for _ in range(limit):
            before = self.factors
            ended, point = self._centred(x, p, eps, INNER * residual)
            if ended == NO_FACTOR:
                break
            if ended == NOT_FOUND:
                failed, eps = eps, 10.0 * eps
                if eps > LARGEST_EPS:
                    break
                continue
            good, p, x = p, point.p, point.x
            if self.keep(p) <= tolerance:
                break
            now = self._left(p)
            if now > SLOW * residual:
                further = self._further(p, good)
                if further is not None and self._left(further) <= 2.0 * now:
                    p, x, now = further, self.space.of_forces(further), self._left(further)
                    if self.keep(p) <= tolerance:
                        break
            spent = self.factors - before
            wanted = self._next(eps, spent, failed)
            if spent == 0 and wanted == eps and now > 0.9 * residual:
                break  # nothing moves any more
            residual, eps = now, wanted
        return self.factors

    def _next(self, eps: float, spent: int, failed: float) -> float:
        wanted = 0.2 * eps if spent <= 4 else 0.5 * eps if spent <= 8 else eps
        if failed > 0.0 and wanted < 2.0 * failed:
            wanted = max(wanted, 0.6 * eps)
        return max(wanted, LEAST_EPS)

    def _left(self, p: FloatArray) -> float:
        """Absolute residual of impulses, in units of the contacts."""
        n, v = self.n, self.space.velocity(self.space.of_forces(p))
        normal = np.abs(np.minimum(p[:n], v[:n])).max(initial=0.0)
        edge = self.mu * np.maximum(p[:n][self.tangent], 0.0)
        return float(max(normal, np.abs(p[n:] - np.clip(p[n:] - v[n:], -edge, edge)).max(initial=0.0)))

    def _at(self, x: FloatArray, centre: FloatArray, eps: float) -> _Point:
        """What the regularised law gives."""
        n, tangent = self.n, self.tangent
        wanted = centre - self.space.velocity(x) / eps
        p = wanted.copy()
        p[:n] = np.maximum(wanted[:n], 0.0)
        edge = self.mu * p[:n][tangent]
        p[n:] = np.clip(wanted[n:], -edge, edge)
        states = np.where(p[:n] > 0.0, STICKING, OPEN)
        pressed = edge > 0.0
        states[tangent[pressed & (wanted[n:] > edge)]] = BACK
        states[tangent[pressed & (wanted[n:] < -edge)]] = FORTH
        return _Point(x, p, states, *self.space.defect(x, p))

    def _centred(self, x: FloatArray, centre: FloatArray, eps: float, goal: float) -> tuple[int, _Point]:
        """Newton's method on F for one centre, steps shortened until F falls."""
        point = self._at(x, centre, eps)
        solve, factored = None, b""
        for _ in range(INNER_LIMIT):
            if point.size <= max(goal, ROUNDING * self.space.rounding(point.x) / eps):
                return FOUND, point
            states = point.states.tobytes()
            if solve is None or states != factored:
                if self.factors >= self.limit or out_of_time():
                    return NO_FACTOR, point
                self.factors += 1
                try:
                    solve, factored = self.space.factor(*free_forces(self.problem, point.states), eps), states
                except RuntimeError:  # exactly singular
                    return NOT_FOUND, point
            following = self._along(point, solve(point.F), centre, eps)
            if following is None:
                return NOT_FOUND, point
            point = following
        return NOT_FOUND, point

    def _along(self, point: _Point, step: FloatArray, centre: FloatArray, eps: float) -> _Point | None:
        """The first point along the step at which F is smaller; None if there is none."""
        length = 1.0
        while length >= SHORTEST and np.isfinite(step).all():
            following = self._at(point.x + length * step, centre, eps)
            if following.size <= (1.0 - DESCENT * length) * point.size:
                return following
            length *= SHRINK
        return None

    def _further(self, p: FloatArray, good: FloatArray) -> FloatArray | None:
        """p taken on along its last change until a contact changes its state; None if it has none to change.

        In a soft direction impulses have far to go before a contact opens or slips.
        """
        n, tangent, change = self.n, self.tangent, p - good
        normal, rate = p[:n][tangent], change[:n][tangent]
        rooms, rates = [p[:n]], [-change[:n]]
        for sign in (-1.0, 1.0):
            room = self.mu * normal - sign * p[n:]
            rooms.append(np.where(room > 1e-12 * self.mu * normal, room, 0.0))
            rates.append(sign * change[n:] - self.mu * rate)
        room, speed = np.concatenate(rooms), np.concatenate(rates)
        moving = (room > 0.0) & (speed > 0.0)
        far = float((room[moving] / speed[moving]).min(initial=FAR))
        return in_cones(self.problem, p + far * change) if SHORTEST <= far < FAR else None
