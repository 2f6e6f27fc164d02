"""Mixed and boxed complementarity problems, brought to the form of an LCP and back.

Boxed: lower <= z <= upper with w = M z + q and, for each i,

    w_i >= 0 where z_i = lower_i,    w_i <= 0 where z_i = upper_i,    w_i = 0 between.

Mixed: some z_i are free and their w_i = 0 (bilateral constraints), the others as in an LCP. Both become an LCP: bounds
are shifted to zero, unknowns bounded above only are mirrored, those bounded on both sides get the multiplier y of their
upper bound, and free ones are eliminated by the Schur complement, which is symmetric and semidefinite if M is.
Sources: Cottle, Pang & Stone 1992, sections 1.4 and 2.3; Dirkse & Ferris 1995 (the normal form of boxes).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import flag, numbers, point_of
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.acceptance import accept, brought_back, confirmed, retold
from lcpflex.solvers.arguments import check_guess, check_solver
from lcpflex.solvers.arrays import as_array, check_finite
from lcpflex.solvers.bilateral import OUTSIDE, eliminated, sum_of
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.guard import joined
from lcpflex.solvers.lcp.exact_systems import ExactSystem, boxed_rows
from lcpflex.solvers.mixed.box_measure import BoxMeasure
from lcpflex.solvers.mixed.boxes import (
    DOUBLE,
    FREE,
    box_parts,
    box_sizes,
    on_bounds,
    recover_box,
    reduce_box,
    sound_box,
)
from lcpflex.solvers.problem import PROVED, Lcp, LcpSolver, Solution

__all__ = ["BoxedLcp", "MixedLcp"]

RELAXED = 4  # times that bounds which were left out as far and then broken are put back


class _Reduction(NamedTuple):
    """How a boxed problem became an LCP in [x; y] (or [x; y; plus; minus] where free unknowns had to be split).

    z = base + sign * x for bounded unknowns, frame (2, n) = [base, sign]; z_F = gain @ [x; 1] for eliminated ones.
    """

    lcp: Lcp
    frame: FloatArray
    kind: IntArray
    gain: FloatArray | None
    contradiction: float = 0.0

    def recover(self, x: FloatArray) -> FloatArray:
        """z (n,) from the unknowns of the LCP."""
        z = np.empty(len(self.kind))
        if self.gain is not None:
            recover_box(x, self.frame, self.kind, self.gain, z)
            return z
        bounded, (base, sign) = self.kind != FREE, self.frame
        count = int(bounded.sum())
        z[bounded] = base[bounded] + sign[bounded] * x[:count]
        plus, minus = np.split(x[count + int((self.kind == DOUBLE).sum()) :], 2)
        z[~bounded] = plus - minus
        return z

    def point(self, z: FloatArray, w: FloatArray) -> FloatArray:
        """The unknowns of the LCP for a guess z, w (n,)."""
        bounded, (base, sign) = self.kind != FREE, self.frame
        parts = [np.maximum(sign * (z - base), 0.0)[bounded], np.maximum(-w, 0.0)[self.kind == DOUBLE]]
        if self.gain is None:
            parts += [np.maximum(z[~bounded], 0.0), np.maximum(-z[~bounded], 0.0)]
        return np.concatenate(parts)


@dataclass(frozen=True, slots=True, eq=False)
class BoxedLcp:
    """The problem lower <= z <= upper with w = M z + q complementary to the bounds.

    M (n, n), q (n,): finite. lower, upper (n,), or numbers: lower <= upper, -inf and inf where there is no bound.
    Raises ModelError for sizes that differ, numbers that are not finite, bounds that are NaN or crossed.
    """

    M: FloatArray
    q: FloatArray
    lower: FloatArray
    upper: FloatArray
    # What the four show read-only: kernels would be compiled a second time for read-only arrays.
    _data: tuple[FloatArray, FloatArray, FloatArray, FloatArray] = field(init=False, repr=False, compare=False)
    # How many unknowns have a bound, and two; whether all are alike as they are.
    _bounds: tuple[int, int, int] = field(init=False, repr=False, compare=False)
    _reduction: list[_Reduction] = field(default_factory=list, init=False, repr=False, compare=False)  # once made
    _measure: list[BoxMeasure] = field(default_factory=list, init=False, repr=False, compare=False)  # once made

    def __post_init__(self) -> None:
        q = as_array("q", self.q, 1)
        M = as_array("M", self.M, 2) if len(q) else np.zeros((0, 0))
        if M.shape != (len(q), len(q)):
            raise ModelError(f"M has shape {M.shape} and q shape {q.shape}: expected (n, n) and (n,)")
        data = M, q, _bound("lower", self.lower, len(q)), _bound("upper", self.upper, len(q))
        bounds = sound_box(*data)
        if bounds[0] < 0:
            _refuse(*data)
        object.__setattr__(self, "_bounds", bounds)
        object.__setattr__(self, "_data", data)
        for name, value in zip(("M", "q", "lower", "upper"), data, strict=True):
            view = value.view()
            view.flags.writeable = False
            object.__setattr__(self, name, view)

    @property
    def data(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """M, q, lower and upper, read-only."""
        return self.M, self.q, self.lower, self.upper

    @property
    def size(self) -> int:
        """Number of unknowns n."""
        return len(self.q)

    def slack(self, z: npt.ArrayLike) -> FloatArray:
        """w = M z + q, shape (n,): positive at lower bounds, negative at upper ones, else zero."""
        return np.asarray(self.M @ point_of("z", z, self.size) + self.q)

    def residual(self, z: npt.ArrayLike, scaled: bool = True) -> float:
        """Natural-map residual of z (n,), ``max_i d_i |z_i - mid(lower_i, z_i - w_i / d_i, upper_i)|``.

        d_i is the largest |M_ij| of row i. Scaled and guarded as that of an :class:`Lcp`, with which it agrees where
        the bounds are 0 and inf: the load is the largest |q_i| and d_i |mid(lower_i, 0, upper_i)|, so that bounds which
        are far away hide no error. Where it is 0, z = 0 is a solution, and so are points with a w of nothing but
        rounding. inf for a z that holds NaN or inf. Raises ModelError if z has another shape.

        scaled: relative to the terms that cancel, and not in the units of the problem.
        """
        point = point_of("z", z, self.size)
        if flag("scaled", scaled):
            return float(self.judged(point)[1])
        return float(box_parts(*self._data, point, np.empty(self.size))[0])

    def judged(self, point: FloatArray) -> tuple[FloatArray, float, float]:
        """w of a point (n,), and its residual in the two sizes of a :class:`Solution`."""
        w = np.empty(len(point))
        if w.shape != self.q.shape:
            raise ModelError(f"z has shape {point.shape}: expected {self.q.shape}")
        sizes = box_sizes(*self._data, point, w)
        return w, *(sizes if self._bounds[2] else self._measured().residuals(point))

    def lcp(self) -> Lcp:
        """The LCP that :meth:`recover` leads back from."""
        return self._reduced().lcp

    def recover(self, x: npt.ArrayLike) -> FloatArray:
        """z (n,) from a solution x of :meth:`lcp`."""
        reduction = self._reduced()
        return reduction.recover(point_of("x", x, reduction.lcp.size))

    def solve_by(self, solver: LcpSolver, guess: Solution | None = None) -> Solution:
        """The solution by way of :meth:`lcp`; ``active``, ``certificate`` are of it, ``proof`` of :meth:`exact_system`.

        solver: of LCPs. guess: the solution of a similar problem to start from, or None.
        """
        check_solver(solver)
        check_guess(guess)
        return _solve_reduced(self, self._reduced(), solver, guess)

    def _reduced(self) -> _Reduction:
        if not self._reduction:
            self._reduction.append(_reduce(self))
        return self._reduction[0]

    def _measured(self) -> BoxMeasure:
        if not self._measure:
            self._measure.append(BoxMeasure.of(self._data, bool(self._bounds[2])))
        return self._measure[0]

    def exact_system(self) -> ExactSystem:
        """The conditions without rounding, unknowns [bounded ones, multipliers of second bounds, free ones]."""
        return boxed_rows(self.M, self.q, self.lower, self.upper)


@dataclass(frozen=True, slots=True, eq=False)
class MixedLcp:
    """The problem w = M z + q with w_i = 0 for free unknowns and 0 <= z_i _|_ w_i >= 0 for the others.

    M (n, n), q (n,): finite. free: boolean mask (n,) or the numbers of the free unknowns. Redundant bilateral rows are
    allowed: their multipliers are the shortest ones. Raises ModelError for sizes and numbers that do not fit.
    """

    M: FloatArray
    q: FloatArray
    free: npt.NDArray[np.bool_]
    boxed: BoxedLcp = field(init=False, repr=False, compare=False)
    """The same problem by its bounds."""

    def __post_init__(self) -> None:
        q = as_array("q", self.q, 1)
        free = _mask(self.free, len(q))
        lower = np.zeros(len(q))
        lower[free] = -np.inf
        boxed = BoxedLcp(self.M, q, lower, np.inf)  # type: ignore[arg-type]  # a number is all right
        free.flags.writeable = False
        for name, value in (("M", boxed.M), ("q", boxed.q), ("free", free), ("boxed", boxed)):
            object.__setattr__(self, name, value)

    @property
    def size(self) -> int:
        """Number of unknowns n."""
        return len(self.q)

    def slack(self, z: npt.ArrayLike) -> FloatArray:
        """w = M z + q, shape (n,)."""
        return self.boxed.slack(z)

    def residual(self, z: npt.ArrayLike, scaled: bool = True) -> float:
        """Natural-map residual of z (n,), ``scaled`` or not: |w_i| of bilateral rows, else as for an :class:`Lcp`."""
        return self.boxed.residual(z, scaled)

    def lcp(self) -> Lcp:
        """The LCP of the bounded unknowns, free ones eliminated."""
        return self.boxed.lcp()

    def recover(self, x: npt.ArrayLike) -> FloatArray:
        """z (n,) from a solution x of :meth:`lcp`."""
        return self.boxed.recover(x)

    def solve_by(self, solver: LcpSolver, guess: Solution | None = None) -> Solution:
        """The solution by way of :meth:`lcp`; ``active`` and ``certificate`` then are those of the LCP.

        solver: of LCPs. guess: the solution of a similar problem to start from, or None.
        """
        return self.boxed.solve_by(solver, guess)

    def exact_system(self) -> ExactSystem:
        """That of :attr:`boxed`."""
        return self.boxed.exact_system()


def _bound(name: str, value: Any, n: int) -> FloatArray:
    if type(value) is float:
        return np.full(n, value)
    given = numbers(value)
    if given is None:
        raise ModelError(f"{name} is {shown(value)}: expected ({n},) numbers, or one number")
    if given.shape not in ((), (n,)):
        raise ModelError(f"{name} has shape {given.shape}: expected ({n},) or one number")
    bound = np.empty(n)
    bound[:] = given
    return bound


def _refuse(M: FloatArray, q: FloatArray, lower: FloatArray, upper: FloatArray) -> None:
    """Say what is wrong with the numbers of a box."""
    check_finite("q", q)
    check_finite("M", M)
    for name, bound in (("lower", lower), ("upper", upper)):
        if np.isnan(bound).any():
            raise ModelError(f"{name} is {shown(bound)}: expected numbers, -inf or inf")
    crossed = np.flatnonzero((lower > upper) | (lower == np.inf) | (upper == -np.inf))
    i = crossed[0]
    raise ModelError(f"lower[{i}] is {lower[i]}, upper[{i}] is {upper[i]}: expected lower <= upper")


def _mask(value: Any, n: int) -> npt.NDArray[np.bool_]:
    if type(value) is list and all(type(k) is int and 0 <= k < n for k in value):  # by far the quickest
        mask = np.zeros(n, dtype=bool)
        for k in value:
            mask[k] = True
        return mask
    try:
        given = np.asarray(value)
    except Exception:  # ragged, endless, or an object of the user
        given = np.zeros((), dtype=object)
    if isinstance(value, np.ma.MaskedArray) or given.dtype.kind not in "biuf" or given.ndim != 1:
        raise ModelError(f"free is {shown(value)}: expected a mask ({n},) or numbers from 0 to {n - 1}")
    if given.dtype == bool:
        if given.shape != (n,):
            raise ModelError(f"free has shape {given.shape}: expected a mask ({n},) or the numbers of unknowns")
        return given.copy()
    rows = np.clip(given, -1.0, n).astype(np.int64) if np.isfinite(given).all() else np.full(given.shape, -1)
    if (given != rows).any() or ((rows < 0) | (rows >= n)).any():
        raise ModelError(f"free is {shown(value)}: expected a mask ({n},) or numbers from 0 to {n - 1}")
    mask = np.zeros(n, dtype=bool)
    mask[rows] = True
    return mask


def _reduce(problem: BoxedLcp) -> _Reduction:
    """Shift, mirror, add multipliers of upper bounds, eliminate free unknowns."""
    n, (b, extra, _) = problem.size, problem._bounds
    f, k = n - b, b + extra
    frame, (kind, order) = np.empty((2, n)), np.empty((2, n), dtype=np.int64)
    gain, M, q, work = np.empty((f, b + 1)), np.empty((k, k)), np.empty(k), np.empty((n + 2 * f + 2, n + 1))
    made = reduce_box(*problem._data, frame, kind, order, gain, M, q, work)
    if made:
        lcp = Lcp(M, q)
        return _Reduction(lcp.measured_alike() if made == 2 else lcp, frame, kind, gain)
    with np.errstate(all="ignore"):  # what overflows is refused, or judged and found wrong
        return _reduced(problem)


def _reduced(problem: BoxedLcp) -> _Reduction:
    """The same where bilateral rows are many, redundant, or cannot be eliminated."""
    below, above = np.isfinite(problem.lower), np.isfinite(problem.upper)
    bounded, two_sided = below | above, below & above
    sign = np.where(bounded & ~below, -1.0, 1.0)
    base = np.where(below, problem.lower, np.where(above, problem.upper, 0.0))
    M = sign[:, None] * problem.M * sign
    q = sign * (problem.M @ base + problem.q)
    B, F = bounded, ~bounded
    A, b = M[np.ix_(B, B)], q[B]
    gain, offset, contradiction = eliminated(M[np.ix_(F, F)], M[np.ix_(F, B)], q[F])
    if gain is not None:
        A, b = sum_of(A, M[np.ix_(B, F)], gain), sum_of(b, M[np.ix_(B, F)], offset)
        if np.allclose(problem.M, problem.M.T, rtol=1e-12, atol=0.0):
            A = 0.5 * (A + A.T)
    upper = np.flatnonzero(two_sided[B])
    m, extra = len(b), len(upper)
    count = m + extra + (0 if gain is not None else 2 * int(F.sum()))
    full, load = np.zeros((count, count)), np.zeros(count)
    full[:m, :m], load[:m] = A, b
    full[upper, m + np.arange(extra)] = 1.0
    full[m + np.arange(extra), upper] = -1.0
    load[m : m + extra] = (problem.upper - problem.lower)[two_sided]
    if gain is None:
        plus, minus = np.split(np.arange(m + extra, count), 2)
        for rows, side in ((plus, 1.0), (minus, -1.0)):
            full[np.ix_(rows, np.arange(m))] = side * M[np.ix_(F, B)]
            full[np.ix_(np.arange(m), rows)] = side * M[np.ix_(B, F)]
            load[rows] = side * q[F]
            full[np.ix_(rows, plus)] = side * M[np.ix_(F, F)]
            full[np.ix_(rows, minus)] = -side * M[np.ix_(F, F)]
    gain = None if gain is None else np.column_stack([gain, offset])
    kind = bounded.astype(np.int64) + two_sided
    return _Reduction(Lcp(full, load), np.stack([base, sign]), kind, gain, contradiction)


def _solve_reduced(problem: BoxedLcp, reduction: _Reduction, solver: LcpSolver, guess: Solution | None) -> Solution:
    """Solve the LCP, bring the point back, and judge it on the problem itself."""
    if guess is not None and guess.z.shape == problem.q.shape:
        guess = replace(guess, z=reduction.point(guess.z, guess.w))
    tolerance = getattr(solver, "tolerance", 1e-10)
    found = solver.solve(reduction.lcp, guess)
    message = "" if found.solved else found.message
    if reduction.contradiction > OUTSIDE:
        message = f"bilateral rows contradict each other: {reduction.contradiction:.1e} of q is outside their range"
    judged = brought_back(problem, found, reduction.recover, tolerance, message=message)
    if not judged.solved and found.status in PROVED:
        judged = confirmed(problem, replace(judged, status=found.status, certificate=found.certificate))
    good = judged.strict <= tolerance and on_bounds(*problem._data[1:], judged.z, judged.w)
    if good or judged.status in PROVED or reduction.contradiction > OUTSIDE:
        return judged
    judged = _polished(problem, judged, tolerance)
    return judged if judged.solved else _without_far_bounds(problem, judged, solver, tolerance)


def _polished(problem: BoxedLcp, found: Solution, tolerance: float) -> Solution:
    """The better of the point and the one on its active set, which no shift to the bounds has rounded."""
    if not (np.isfinite(problem.lower) & (problem.lower != 0.0) | np.isfinite(problem.upper)).any():
        return found
    measure = problem._measured()
    others = () if found.solved else (*found.solutions, measure.rest)
    for z in (*others, measure.polished(found.z)):
        trial = retold(problem, z, found, tolerance, message="")
        if trial.solved and not (found.solved and found.strict <= trial.strict):
            found = trial
    return found


def _without_far_bounds(problem: BoxedLcp, found: Solution, solver: LcpSolver, tolerance: float) -> Solution:
    """The solution of the problem without its far bounds, if it is one of the problem; else what was found."""
    lower, upper = problem._measured().within_near_bounds()
    for _ in range(RELAXED):
        if out_of_time() or (np.array_equal(lower, problem.lower) and np.array_equal(upper, problem.upper)):
            break
        relaxed = BoxedLcp(problem.M, problem.q, lower, upper).solve_by(solver)
        if not relaxed.solved:
            break
        told = accept(
            problem,
            np.clip(relaxed.z, problem.lower, problem.upper),
            tolerance=tolerance,
            iterations=found.iterations + relaxed.iterations,
            route=f"{joined(found)} > {relaxed.route}, far bounds left out",
        )
        if told.solved:
            return told
        below, above = relaxed.z < problem.lower, relaxed.z > problem.upper
        if not (below | above).any():
            break
        lower, upper = np.where(below, problem.lower, lower), np.where(above, problem.upper, upper)
    return found
