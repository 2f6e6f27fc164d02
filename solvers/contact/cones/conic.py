"""Convex programs over the friction cones of contacts in space, by Clarabel, their last digits by Newton steps.

    min 1/2 r.G r + (free + e).r  subject to r in K    <=>    K ∋ r  _|_  G r + free + e ∈ K*

With e = 0 it is the convex relaxation of Coulomb's law (Anitescu 2006), another model, which lifts contacts that slide.
With e = mu s n and s = |u_T| of its own solution it is Coulomb's law: s <- |u_T|, from s = 0, is mostly a contraction,
without a guarantee. Source: Acary, Cadoux, Lemarechal & Malick 2011 (a formulation of the linear discrete Coulomb
friction problem via convex optimization).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.basics.blas import one_thread
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.acceptance import accept, restored
from lcpflex.solvers.arguments import check_guess
from lcpflex.solvers.clock import limited, out_of_time, remaining
from lcpflex.solvers.contact.cones.certificate import nearest_in_cone
from lcpflex.solvers.contact.matrices import is_sparse
from lcpflex.solvers.contact.spatial import OtherLaw, SpatialContactProblem
from lcpflex.solvers.contact.starts import started
from lcpflex.solvers.guard import guarded, words_of
from lcpflex.solvers.limits import keep_settings
from lcpflex.solvers.problem import Lcp, PosedProblem, Solution, Status
from lcpflex.solvers.refusals import only_cones

__all__ = [
    "SHORT_STEP", "STEP", "SUCCESS", "ConicFixedPoint", "ConicProgram", "RelaxedSpatialProblem", "conic_program",
    "relaxed_miss", "relaxed_solution",
]  # fmt: skip

SUCCESS = ("Solved", "AlmostSolved")
ACCURACY = 1e-12  # asked of Clarabel: near what it can reach in double precision
STEP, SHORT_STEP = 0.99, 0.9  # of the way to the edge of a cone; shorter ones seldom get stuck in rounding
LARGEST = 1200  # force components up to which Newton steps with a dense matrix take out what Clarabel leaves
STEPS = 12  # of Newton
REGULARISED = 1e-10  # of the diagonal: what the Jacobian alone is given, as G is singular where supports are redundant
PRESSED = 1e-8  # r_N, relative to the largest, beyond which a contact counts as pressed
ROUTE = "conic fixed point"
NEAR = 1e-2  # residual from which a program is near enough to the last one for Newton steps alone
ROUNDED = 1e-13  # what they may leave of the natural map, relative to the load
STALLED = 10  # passes without a better point that end the iteration
BETTER = 0.9  # of the least residual


def conic_program(
    P: Any, B: Any, c: FloatArray, smooth: int, rows: int, step: float = STEP
) -> tuple[FloatArray, int, str]:
    """x (m,), the iterations and what Clarabel says of it.

    P (m, m) symmetric; or None and B (m, k) with P = B B^T: then min 1/2 |y|^2 with B y + c in the dual cones is
    solved, which never forms P, and x is its multiplier. The first ``smooth`` unknowns are >= 0, the others in cones
    of so many ``rows`` each. step: how far an iteration may go, of the way to the edge of a cone.
    """
    m = len(c)
    cones = [libs.clarabel.NonnegativeConeT(smooth)] if smooth else []
    cones += [libs.clarabel.SecondOrderConeT(rows)] * ((m - smooth) // rows)
    settings = libs.clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_step_fraction = step
    settings.tol_feas = settings.tol_gap_abs = settings.tol_gap_rel = ACCURACY
    if limited():
        settings.time_limit = max(remaining(), 1e-6)
    if B is None:
        squares = libs.sparse.triu(libs.sparse.csc_matrix(P), format="csc")
        A = -libs.sparse.identity(m, format="csc")
        objective, bound = c, np.zeros(m)
    else:
        squares, A = libs.sparse.identity(B.shape[1], format="csc"), -libs.sparse.csc_matrix(B)
        objective, bound = np.zeros(B.shape[1]), c
    try:
        found = libs.clarabel.DefaultSolver(squares, objective, A, bound, cones, settings).solve()
    except (KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:  # a panic in Rust is no Exception; what it says is passed on
        return np.full(m, np.nan), 0, words_of(error)
    said = str(found.status)
    if B is not None and said == "PrimalInfeasible":  # the dual program is named from its own side
        said = "DualInfeasible"
    return np.array(found.x if B is None else found.z), int(found.iterations), said


@kernel
def relaxed_miss(
    forces: FloatArray, velocity: FloatArray, friction: FloatArray, n: int, miss: FloatArray, slope: FloatArray
) -> float:
    """r - P_K(r - u) of n contacts, and the derivative of P_K there; the largest component of the former.

    forces, velocity (3 n,): in units in which the contacts are alike. Out: miss (3 n,), slope (3 n, 3).
    """
    worst = 0.0
    for k in range(n):
        i, mu = 3 * k, friction[k]
        x_n, x_1, x_2 = forces[i] - velocity[i], forces[i + 1] - velocity[i + 1], forces[i + 2] - velocity[i + 2]
        p_n, p_1, p_2 = nearest_in_cone(x_n, x_1, x_2, mu)
        miss[i], miss[i + 1], miss[i + 2] = forces[i] - p_n, forces[i + 1] - p_1, forces[i + 2] - p_2
        inside = p_n == x_n and p_1 == x_1 and p_2 == x_2
        if inside:
            miss[i], miss[i + 1], miss[i + 2] = velocity[i], velocity[i + 1], velocity[i + 2]
        for a in range(3):
            worst = max(worst, abs(miss[i + a]))
            for b in range(3):
                slope[i + a, b] = 1.0 if inside and a == b else 0.0
        if not inside and p_n > 0.0:
            _edge_slope(x_1, x_2, mu, p_1 * p_1 + p_2 * p_2, i, slope)
    return worst


@kernel
def _edge_slope(x_1: float, x_2: float, mu: float, square: float, i: int, slope: FloatArray) -> None:
    """The derivative of P_K where it is on the edge of the cone, |P_T|^2 = square."""
    slip = np.hypot(x_1, x_2)
    share = 1.0 / (1.0 + mu * mu)
    t_1, t_2 = (x_1 / slip, x_2 / slip) if slip > 0.0 else (0.0, 0.0)
    turned = np.sqrt(square) / slip if slip > 0.0 else 0.0
    along = mu * mu * share
    slope[i, 0] = share
    slope[i, 1] = slope[i + 1, 0] = mu * share * t_1
    slope[i, 2] = slope[i + 2, 0] = mu * share * t_2
    slope[i + 1, 1] = along * t_1 * t_1 + turned * t_2 * t_2
    slope[i + 2, 2] = along * t_2 * t_2 + turned * t_1 * t_1
    slope[i + 1, 2] = slope[i + 2, 1] = (along - turned) * t_1 * t_2


@dataclass(frozen=True, slots=True, eq=False)
class ConicProgram:
    """The convex program of a problem in balanced units, prepared for several loads.

    rows (m,): of the problem that are unknowns, those of contacts without friction, which have one, first. unit (m,):
    r = unit x, in which every cone is |x_T| <= x_N. P (m, m) or B (m, j) with P = B B^T. lagged: half of G - G^T, which
    is no part of a program; None where G is symmetric.
    """

    problem: SpatialContactProblem
    rows: IntArray
    unit: FloatArray
    smooth: int
    P: Any
    B: Any
    lagged: Any

    @classmethod
    def of(cls, problem: SpatialContactProblem) -> ConicProgram:
        """problem: balanced."""
        friction = problem.friction
        smooth, rough = 3 * np.flatnonzero(friction == 0.0), 3 * np.flatnonzero(friction)
        rows = np.concatenate([smooth, (rough[:, None] + np.arange(3)).ravel()]).astype(np.int64)
        aspect = np.repeat(friction, 3)
        aspect[::3] = 1.0
        unit = aspect[rows]
        P = B = lagged = None
        delassus, _, _, factor = problem._data
        if factor is not None and problem.symmetric:
            B = libs.sparse.diags_array(unit) @ libs.sparse.csr_array(factor)[rows]
        else:
            G = 0.5 * (delassus + delassus.T)
            lagged = None if problem.symmetric else delassus - G
            chosen = G[rows][:, rows] if is_sparse(G) else G[np.ix_(rows, rows)]
            scale = libs.sparse.diags_array(unit)
            P = scale @ chosen @ scale if is_sparse(chosen) else chosen * np.outer(unit, unit)
        return cls(problem, rows, unit, len(smooth), P, B, lagged)

    def load(self, slip: FloatArray, forces: FloatArray) -> FloatArray:
        """free + mu s n (3 k,), with what the unsymmetric part of G makes of the forces. slip (k,)."""
        load = np.array(self.problem.free)
        load[::3] += self.problem.friction * slip
        return load if self.lagged is None else load + self.lagged @ forces

    def solve(self, load: FloatArray) -> tuple[FloatArray, int, str]:
        """Forces (3 k,) in the cones, the iterations and what Clarabel says."""
        c = self.unit * load[self.rows]
        largest = float(np.abs(c).max(initial=0.0))
        forces = np.zeros(self.problem.size)
        if largest == 0.0:
            return forces, 0, "Solved"
        x, iterations, said = conic_program(self.P, self.B, c / largest, self.smooth, 3)
        forces[self.rows] = largest * (self.unit * x)
        return forces, iterations, said

    def polished(self, load: FloatArray, forces: FloatArray) -> tuple[FloatArray, float]:
        """The same forces with more digits, and the largest component of r - P_K(r - (G r + load)) that is left.

        By semismooth Newton steps, while they help; inf for what is left where the problem is too large for them.
        """
        problem, m = self.problem, self.problem.size
        if m > LARGEST or not np.isfinite(forces).all():
            return forces, np.inf
        G = problem.dense() if self.lagged is None else 0.5 * (problem.dense() + problem.dense().T)
        with one_thread(m):
            return _newton(problem._data[2], G, load, forces)


def _newton(friction: FloatArray, G: FloatArray, load: FloatArray, forces: FloatArray) -> tuple[FloatArray, float]:
    """The point of :meth:`ConicProgram.polished`."""
    n, m = len(friction), len(forces)
    miss, slope = np.empty(m), np.empty((m, 3))
    best, least = forces, np.inf
    r = forces.copy()
    for _ in range(STEPS):
        worst = relaxed_miss(r, G @ r + load, friction, n, miss, slope)
        if not worst < least:
            break
        best, least = r.copy(), worst
        if worst == 0.0 or out_of_time():
            break
        r = r - _step(G, miss, slope, n)
        if not np.isfinite(r).all():
            break
    return best, least


def _step(G: FloatArray, miss: FloatArray, slope: FloatArray, n: int) -> FloatArray:
    """(I - S (I - G'))^-1 miss, with S the slopes of the contacts and G' = G and a little more."""
    softened = np.eye(3 * n) - G
    softened[np.diag_indices(3 * n)] -= REGULARISED
    product = np.matmul(slope.reshape(n, 3, 3), softened.reshape(n, 3, 3 * n)).reshape(3 * n, 3 * n)
    try:
        step = np.linalg.solve(np.eye(3 * n) - product, miss)
    except np.linalg.LinAlgError:
        return np.full(3 * n, np.nan)
    return np.asarray(step)


class RelaxedSpatialProblem(OtherLaw):
    """The relaxed law K ∋ r _|_ G r + free ∈ K* for the contacts of a :class:`SpatialContactProblem`.

    Its residual is the largest component of r' - P_K(r' - u') in units of each contact.
    """

    __slots__ = ()

    def lift(self, z: npt.ArrayLike) -> float:
        """Largest u_N of the contacts that forces z (3 k,) press: 0 if Coulomb's law holds too; in units of free."""
        pressed = self.contact.forces(z)[:, 0]
        chosen = pressed > PRESSED * np.abs(pressed).max(initial=0.0)
        return float(self.slack(z)[::3][chosen].max(initial=0.0))

    def _miss(self, r: FloatArray, u: FloatArray) -> float:
        contact, miss, slope = self.contact, np.empty(self.size), np.empty((self.size, 3))
        return float(relaxed_miss(r, u, contact._data[2], len(contact.friction), miss, slope))


def relaxed_solution(contact: SpatialContactProblem) -> tuple[FloatArray, int, str]:
    """Forces (3 k,) of the relaxed law as Clarabel and Newton steps find them, the iterations, and what it says."""
    units = contact.unknown_units
    program = ConicProgram.of(contact.balanced())
    load = np.array(program.problem.free)
    forces, iterations, said = program.solve(load)
    if np.isfinite(forces).all():
        forces, _ = program.polished(load, forces)
    return units.outward(forces), iterations, said


@dataclass(frozen=True, slots=True)
class ConicFixedPoint:
    """Contact in space by a sequence of convex programs (Clarabel): slow, and independent of all other solvers.

    tolerance: largest accepted residual [-]; pass_limit: largest number of programs. Takes a
    :class:`SpatialContactProblem`, with the Delassus matrix or only its factor. Converges in practice, without a
    guarantee; where the slip of many contacts depends on that of others, or friction is large, it may not. Beyond 400
    contacts the last digits of its programs are Clarabel's, and it ends at 1e-8 to 1e-9. Raises ModelError for numbers
    out of their range and for other problems.
    """

    tolerance: float = 1e-10
    pass_limit: int = 300
    only_cones: ClassVar[bool] = True

    def __post_init__(self) -> None:
        keep_settings(self, "pass_limit", needed=True)

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Why the solver cannot take the problem; empty if it can."""
        return only_cones(self, problem)

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """Iterate, from the slips of the guess if there is one (matched by contact).

        problem: a :class:`SpatialContactProblem`. guess: the solution of a similar problem to start from, or None.
        """
        check_guess(guess)
        if not isinstance(problem, SpatialContactProblem):
            raise ModelError(self.refuses(problem))
        units, alike = problem.unknown_units, problem.balanced()
        start = started(guess, problem.unknown_keys)
        start = None if start is None else units.inward(start)
        with np.errstate(all="ignore"):  # what overflows is not finite, and is not called solved
            found = guarded(ROUTE, alike, self.tolerance, lambda: self._iterate(alike, start))
        return replace(restored(problem, found, units, self.tolerance), keys=problem.unknown_keys)

    def _iterate(self, problem: SpatialContactProblem, start: FloatArray | None) -> Solution:
        """Programs, each with the slips of the last one. problem: balanced; start (3 k,): forces, or None."""
        best = np.zeros(problem.size)
        least = problem.residual(best)
        if least <= self.tolerance:
            return accept(problem, best, tolerance=self.tolerance, route="free velocities")
        program = ConicProgram.of(problem)
        forces = best if start is None else start
        slip = np.zeros(len(problem.friction)) if start is None else _slip(problem, start)
        said, status, done, stalled = "", Status.ITERATION_LIMIT, 0, 0
        while done < self.pass_limit and least > self.tolerance:
            forces, said = _pass(program, program.load(slip, forces), forces, warm=least < NEAR)
            done += 1
            if not np.isfinite(forces).all():
                status = Status.NUMERICAL_FAILURE
                break
            residual = problem.residual(forces)
            stalled = 0 if residual < BETTER * least else stalled + 1
            if residual < least:
                best, least = forces, residual
            if stalled > STALLED or out_of_time():
                status = Status.TIME_LIMIT if out_of_time() else Status.NUMERICAL_FAILURE
                break
            slip = _slip(problem, forces)
        message = "" if least <= self.tolerance or said in SUCCESS else f"numerical failure: Clarabel: {said}"
        return accept(
            problem,
            best,
            tolerance=self.tolerance,
            status=status,
            iterations=done,
            route=ROUTE,
            message=message,
        )


def _pass(program: ConicProgram, load: FloatArray, forces: FloatArray, warm: bool) -> tuple[FloatArray, str]:
    """The solution of one program, and what Clarabel says.

    warm: whether forces are near enough for Newton steps alone to find it.
    """
    if warm:
        near, left = program.polished(load, forces)
        if left <= ROUNDED * float(np.abs(load).max(initial=0.0)):
            return near, SUCCESS[0]
    forces, _, said = program.solve(load)
    return program.polished(load, forces)[0], said


def _slip(problem: SpatialContactProblem, forces: FloatArray) -> FloatArray:
    """|u_T| (k,) of each contact."""
    u = problem.velocity(forces)
    return np.hypot(u[1::3], u[2::3])
