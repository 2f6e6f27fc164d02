"""What Coulomb's law admits at an instant in space: every motion, where one contact at most may stick.

Sliding contacts have the direction of their slip, so that their friction is in the columns of their normals, and all of
them pose a linear problem, of which every active set is tried. A contact k that may stick is tried

* open: lambda_k = 0;
* sticking: its three accelerations vanish, its forces are eliminated;
* beginning to slip along d = (c, s) = (cos t, sin t), where the direction is an unknown: with a set of other contacts
  that carry forces, lambda_k = -b / D and a_T = F / D with D and F linear in c and s, so that F x d = 0 is a
  trigonometric polynomial of second degree, a quartic in exp(i t). Its roots are all the directions there are.

Of two contacts that may stick, directions would be unknown together: cones have no active sets, and what is not found
could exist. That is refused.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, combinations
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lcpflex.errors import ModelError, SolverError
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.lcp.enumeration import LARGEST, Enumeration
from lcpflex.solvers.problem import Lcp, Status
from lcpflex.studies.stability_maps.admissible_accelerations import (
    STILL,
    AdmissibleMotion,
    AdmissibleMotions,
    ContactFate,
    told,
)

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.compile.state_mechanics import StateMechanics

__all__ = ["spatial_motions"]

MOST = 10  # contacts beside one that may stick: each of their sets has its own polynomial
CLOSE = 1e-9  # of the largest force or acceleration: less is none
ON_CIRCLE = (
    1e-3  # how far a root of the quartic may be from the unit circle before it is refined: double roots are inexact
)
REFINED = 20  # Newton steps of a direction
SINGULAR = 1e-12  # of the largest: a force that accelerates nothing


def spatial_motions(
    compiled: CompiledScene,
    q: FloatArray,
    u: FloatArray,
    time: float,
    gap_tolerance: float,
    threshold: float,
) -> AdmissibleMotions:
    """See :func:`lcpflex.studies.stability_maps.admissible_accelerations.admissible_accelerations`."""
    state = compiled.at(q, u, time, gap_tolerance=gap_tolerance, velocity_threshold=threshold)
    for k in state.C:
        if state.gap_rates[k] < -threshold:
            raise ModelError(
                f"u: contact {state.contacts[k]!r} approaches at {-state.gap_rates[k]:.6g} m/s: an impact comes first"
            )
    names = tuple(state.contacts[k] for k in state.N)
    _check_size(len(names), len(state.H))
    instant = _Instant(state)
    found = list(instant.every())
    return told(names, found, instant.rest, tangents=state.tangents[state.N])


def _check_size(n: int, rough: int) -> None:
    if rough > 1:
        raise ModelError(
            f"scene: {rough} contacts touch that may stick, expected at most one in space: the directions in which "
            "several of them begin to slip are unknown together, and what is not found could exist"
        )
    most = MOST + 1 if rough else LARGEST
    if n > most:
        raise ModelError(
            f"scene: {n} contacts touch, expected at most {most}, for every set of contact states is tried"
        )


class _Instant:
    """The contact problem of one state: accelerations G lambda + free of n contacts, rows n, t1, t2 of each in turn."""

    def __init__(self, state: StateMechanics) -> None:
        N = state.N
        self._n = len(N)
        self._mu = state.friction[N]
        rows = np.stack([state.W_N[:, N], state.W_T[:, N, 0], state.W_T[:, N, 1]], axis=2)
        rows = rows.reshape(len(state.h), 3 * self._n)
        known = np.column_stack([state.w_N[N], state.w_T[N]]).ravel()
        held, kept = state.condensed(np.column_stack([rows, state.h]), state.gamma)
        self._moved, self.rest = held[:, :-1], held[:, -1] + kept
        self._G, self._free = rows.T @ self._moved, rows.T @ self.rest + known
        self._scale = float(np.abs(self._free).max(initial=0.0))
        speed = np.linalg.norm(state.slip_speeds[N], axis=1)
        self._way = np.zeros((self._n, 2))
        sliding = ~np.isin(N, state.H) & (self._mu > 0.0) & (speed > 0.0)
        self._way[sliding] = state.slip_speeds[N][sliding] / speed[sliding, None]
        self._sliding = sliding
        rough = np.flatnonzero(np.isin(N, state.H))
        self._rough = int(rough[0]) if len(rough) else -1
        self._others = [k for k in range(self._n) if k != self._rough]

    def every(self) -> Iterator[AdmissibleMotion]:
        """All motions, some of them several times."""
        yield from self._without(np.zeros((3 * self._n, 0)), np.zeros((0, 3 * self._n)))
        if self._rough < 0:
            return
        k = slice(3 * self._rough, 3 * self._rough + 3)
        yield from self._sticking(k)
        for chosen in chain.from_iterable(combinations(self._others, m) for m in range(len(self._others) + 1)):
            yield from self._slipping(list(chosen), k)

    def _column(self, i: int) -> FloatArray:
        """(3 n,) lambda for one newton along the normal of contact i, which slides, or has no friction."""
        one = np.zeros(3 * self._n)
        one[3 * i] = 1.0
        one[3 * i + 1 : 3 * i + 3] = -self._mu[i] * self._way[i]
        return one

    def _without(self, more: FloatArray, gain: FloatArray) -> Iterator[AdmissibleMotion]:
        """With the contacts but the one that may stick as a linear problem, and forces ``more @ gain @ a``.

        more (3 n, j): lambda by j forces, which answer the accelerations a (3 n,) of contacts without them.
        """
        others = self._others
        columns = np.stack([self._column(i) for i in others], axis=1) if others else np.zeros((3 * self._n, 0))
        answer = np.eye(3 * self._n) + self._G @ more @ gain  # accelerations with these forces, of those without
        normal = [3 * i for i in others]
        M = (answer @ self._G @ columns)[normal]
        free = (answer @ self._free)[normal]
        for z in self._solved(M, free):
            push = columns @ z
            yield from self._checked(push + more @ (gain @ (self._G @ push + self._free)))

    def _solved(self, M: FloatArray, q: FloatArray) -> list[FloatArray]:
        """All solutions of a linear problem."""
        if not len(q):
            return [np.zeros(0)]
        solution = Enumeration().solve(Lcp(M, q))
        if solution.solved:
            return list(solution.solutions or (solution.z,))
        if solution.status in (Status.NO_SOLUTION, Status.INFEASIBLE):
            return []
        raise SolverError(f"the contact problem was left undecided: {solution.message}", solution)

    def _sticking(self, k: slice) -> Iterator[AdmissibleMotion]:
        """Without acceleration of the contact k: of forces that accelerate nothing there, none."""
        own = self._G[k, k]
        inverse = np.linalg.pinv(own, rcond=SINGULAR, hermitian=True)
        more = np.zeros((3 * self._n, 3))
        more[k] = np.eye(3)
        gain = np.zeros((3, 3 * self._n))
        gain[:, k] = -inverse
        yield from self._without(more, gain)

    def _slipping(self, A: list[int], k: slice) -> Iterator[AdmissibleMotion]:
        """Contact k begins to slip, and the contacts A carry forces."""
        columns = np.stack([self._column(i) for i in A], axis=1) if A else np.zeros((3 * self._n, 0))
        rows = [3 * i for i in A]
        block = (self._G @ columns)[rows]
        if A and np.linalg.cond(block) > 1.0 / SINGULAR:
            raise SolverError("contacts that carry the same load slide beside one that may stick: left undecided")
        mu = self._mu[self._rough]
        own = self._G[:, k] * np.array([1.0, -mu, -mu])  # by the parts 1, c, s of the force of contact k
        lam = -np.linalg.solve(block, np.column_stack([own[rows], self._free[rows]])) if A else np.zeros((0, 4))
        whole = np.column_stack([own, self._free]) + self._G @ columns @ lam  # accelerations, by lambda_k (1, c, s), 1
        D, b = whole[k.start, :3], whole[k.start, 3]
        if abs(b) <= CLOSE * self._scale:
            return  # without force: as if it were open
        F = whole[k.start + 1 : k.start + 3, 3:] * D - b * whole[k.start + 1 : k.start + 3, :3]
        for angle in _directions(F):
            way = np.array([np.cos(angle), np.sin(angle)])
            parts = np.array([1.0, *way])
            if not abs(D @ parts) > SINGULAR * np.abs(D).max():
                continue
            normal = -b / float(D @ parts)
            push = columns @ (lam @ np.array([*(normal * parts), 1.0]))
            push[k] += normal * np.array([1.0, *(-mu * way)])
            yield from self._checked(push, way)

    def _checked(self, force: FloatArray, way: FloatArray | None = None) -> Iterator[AdmissibleMotion]:
        """The motion of the contact forces (3 n,), where all laws hold. way: (2,) along which contact k must slip."""
        push, gained = force.reshape(-1, 3), (self._G @ force + self._free).reshape(-1, 3)
        least = CLOSE * float(np.abs(push).max(initial=0.0))
        still = CLOSE * (self._scale + float((np.abs(self._G) @ np.abs(force)).max(initial=0.0)))
        if (push[:, 0] < -least).any() or (gained[:, 0] < -still).any():
            return
        if (np.minimum(np.abs(push[:, 0]) - least, np.abs(gained[:, 0]) - still) > 0.0).any():
            return
        k = self._rough
        if k >= 0 and push[k, 0] > least:
            across, slip = float(np.linalg.norm(push[k, 1:])), float(np.linalg.norm(gained[k, 1:]))
            if across > self._mu[k] * push[k, 0] + CLOSE * across:
                return
            if slip > still and (way is None or not float(gained[k, 1:] @ way) >= (1.0 - CLOSE) * slip):
                return
        fate = tuple(self._fate(i, push[i], gained[i], least, still) for i in range(self._n))
        told_as = np.where((self._mu > 0.0)[:, None] | (np.arange(3) == 0), gained, np.nan)
        yield AdmissibleMotion(push.copy(), told_as, self.rest + self._moved @ force, fate)

    def _fate(self, i: int, push: FloatArray, gained: FloatArray, least: float, still: float) -> ContactFate:
        if push[0] <= least and gained[0] > max(still, STILL * self._scale):
            return ContactFate.SEPARATES
        if not self._mu[i] > 0.0:
            return ContactFate.TOUCHES
        return ContactFate.SLIDES if self._sliding[i] or np.linalg.norm(gained[1:]) > still else ContactFate.STICKS


def _directions(F: FloatArray) -> Iterator[float]:
    """Angles t [rad] of all d = (cos t, sin t) with F (1, c, s) parallel to d, F (2, 3).

    F x d = 0 is a quartic in z = exp(i t). Where it vanishes for all t, the bounds of the arcs with F.d >= 0 and their
    middles stand for the continuum.
    """
    (x0, xc, xs), (y0, yc, ys) = F
    across = _Trigonometric(-y0, x0, 0.5 * (xs - yc), -0.5 * (xs + yc), 0.5 * (xc - ys))
    if across.size > CLOSE * float(np.abs(F).max(initial=0.0)):
        yield from across.roots()
        return
    along = _Trigonometric(x0, y0, 0.5 * (xc + ys), 0.5 * (xc - ys), 0.5 * (xs + yc))
    bounds = sorted(along.roots()) or [0.0]
    yield from bounds
    yield from (0.5 * (a + b) for a, b in zip(bounds, [*bounds[1:], bounds[0] + 2.0 * np.pi], strict=True))


class _Trigonometric:
    """f(t) = a cos t + b sin t + k + m cos 2t + n sin 2t."""

    def __init__(self, a: float, b: float, k: float, m: float, n: float) -> None:
        self._parts = (a, b, k, m, n)
        self.size = float(np.abs(self._parts).max())

    def roots(self) -> list[float]:
        """All t with f(t) = 0, of 0 to 2 pi."""
        a, b, k, m, n = self._parts
        quartic: npt.NDArray[Any] = np.array([m - 1j * n, a - 1j * b, 2.0 * k, a + 1j * b, m + 1j * n])
        if not self.size > 0.0:
            return []
        found = [z for z in np.roots(quartic) if abs(abs(z) - 1.0) <= ON_CIRCLE]
        refined = [self._refined(float(np.angle(z))) for z in found]
        return [t % (2.0 * np.pi) for t in refined if abs(self._at(t)[0]) <= CLOSE * self.size]

    def _at(self, t: float) -> tuple[float, float]:
        a, b, k, m, n = self._parts
        c, s, cc, ss = np.cos(t), np.sin(t), np.cos(2.0 * t), np.sin(2.0 * t)
        return float(a * c + b * s + k + m * cc + n * ss), float(-a * s + b * c - 2.0 * m * ss + 2.0 * n * cc)

    def _refined(self, t: float) -> float:
        for _ in range(REFINED):
            value, slope = self._at(t)
            if abs(value) <= 1e-16 * self.size or abs(slope) <= 1e-12 * self.size:
                break
            t -= value / slope
        return t
