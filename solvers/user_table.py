"""Who is tried when on a problem of a user: one table of attempts, read from the top until the problem is settled.

LCPs, contacts in the plane and contacts in space differ in the rows that are for them. A row is a solver in Python, or
attempts of the compiled table (:mod:`lcpflex.solvers.contact.strategy`), which begin from the best point so far. Each
answer comes through the one door :func:`lcpflex.solvers.accept`, and none can lose the best point; the route has the
names of the rows, those that did not settle the problem marked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from importlib import import_module
from typing import Any

import numpy as np

from lcpflex.solvers.acceptance import accept, confirmed
from lcpflex.solvers.clock import expired, out_of_time
from lcpflex.solvers.guard import ENDED, FAILED, guarded, joined
from lcpflex.solvers.lcp.enumeration import LARGEST, Enumeration
from lcpflex.solvers.lcp.farkas import candidate
from lcpflex.solvers.lcp.lemke import Lemke
from lcpflex.solvers.lcp.newton import MinMapNewton
from lcpflex.solvers.lcp.perturbed import PERTURBED, perturbed_newton
from lcpflex.solvers.lcp.principal_pivoting import PrincipalPivoting
from lcpflex.solvers.lcp.proofs import FULL, NEARLY, exact_solution
from lcpflex.solvers.lcp.repairing import REPAIRED, repaired
from lcpflex.solvers.problem import Lcp, Solution, Status
from lcpflex.solvers.solution import LcpSolver

__all__ = [
    "COPOSITIVE", "LCP", "MANY", "PLANE", "SMALL", "SPACE", "SWEEPS", "TABLE", "Case", "Row", "solve_by_table",
    "with_solver",
]  # fmt: skip

LCP, PLANE, SPACE = "LCP", "contacts in the plane", "contacts in space"
SMALL = 60  # unknowns of planar contacts up to which parts are looked for only where the whole is not solved at once
PIVOTED = 300  # unknowns up to which Lemke's method is cheaper than what else is done for many contacts
MANY = 900  # unknowns up to which it is the last word: ten seconds
TOO_MANY = 3000  # unknowns from which no dense matrix is tried
NEAR = 1e-3  # residual below which many contacts are not suspected of having no solution
SEARCH = 5e5  # entries that a search in whole numbers may compute: a third of a second
KEPT = (Status.INACCURATE, Status.RIGHT_TO_TERMS, Status.TIME_LIMIT)  # what a point is, whoever failed besides


@dataclass(slots=True, eq=False)
class Case:
    """A problem on its way down the table.

    Attributes
    ----------
    kind
        LCP, PLANE or SPACE.
    guess
        The solution of a problem with the same unknowns to begin from, or None.
    factors
        Sparse factors that are left.
    trials
        On perturbed data, at most.
    whole
        Whether contacts may fall into parts; False for a part.
    best
        The best answer so far.
    tried
        All answers in order.
    teller
        Whose status tells why there is no solution, if that is so.
    parted
        Whether the last answer is that of its parts.
    pivoted, system
        What rows leave for others: the best answer of pivoting, and contacts as iterations take them.
    """

    kind: str
    problem: Any
    guess: Solution | None
    tolerance: float
    factors: int
    trials: int
    whole: bool = True
    best: Solution | None = None
    tried: list[Solution] = field(default_factory=list)
    teller: Solution | None = None
    parted: bool = False
    pivoted: Solution | None = None
    system: Any = None

    @property
    def lcp(self) -> Lcp:
        """The problem as an LCP."""
        posed: Lcp = self.problem.lcp()
        return posed

    def offer(self, found: Solution) -> None:
        """Keep an answer if it is the best one so far."""
        if self.best is None or _is_better(found, self.best):
            self.best = found

    def part(self, problem: Any, guess: Solution | None) -> Solution:
        """What the table makes of one of several parts."""
        return solve_by_table(Case(self.kind, problem, guess, self.tolerance, self.factors, self.trials, whole=False))


Run = Callable[[Case], "Solution | None"]


@dataclass(frozen=True, slots=True)
class Row:
    """One attempt.

    Attributes
    ----------
    name
        Its words in a route where it raises something; else the answer has them.
    run
        Its answer, or None where it is not for the problem after all.
    kinds
        Of the problems that it is for.
    over, most
        Their unknowns: more than ``over``, and no more than ``most``.
    when
        What else is needed.
    tells
        Whether its status says best why there is no solution: that of the first row that does.
    last
        Whether its answer is the last one.
    sure
        Whether it raises nothing and overflows quietly.
    """

    name: str
    run: Run
    kinds: tuple[str, ...]
    over: float = -1
    most: float = np.inf
    when: Callable[[Case], bool] | None = None
    tells: bool = False
    last: bool = False
    sure: bool = False


def solve_by_table(case: Case) -> Solution:
    """The certified solution, or the best point of all rows with the reason why it is none."""
    for row in _rows_for(case.kind, case.problem.size):
        if row.when is not None and not row.when(case):
            continue
        if case.tried and not row.last and out_of_time():
            return _said(case, expired(_concluded(case)))
        found = row.run(case) if row.sure else _guarded(row, case)
        if found is None:
            continue
        case.tried.append(found)
        case.offer(found)
        if row.last or (row.tells and case.teller is None):
            case.teller, case.parted = found, row.last
        if found.settled or row.last:
            break
    best = case.best
    if _may_have_digits(case) and best is not None:
        found = _guarded(LAST_DIGITS, case)
        if found is not None and found.solved and found.strict < best.strict:
            case.tried.append(found)
            case.best = found
    return _said(case, _concluded(case))


def _may_have_digits(case: Case) -> bool:
    """Whether contacts are solved, not yet relative to the load alone, and there is time."""
    best = case.best
    if case.kind == LCP or best is None or best.status is not Status.SOLVED:
        return False
    return best.strict > case.tolerance and not out_of_time()


def _guarded(row: Row, case: Case) -> Solution | None:
    """Its answer, whatever it raises; what overflows is not finite, and is not called solved."""
    with np.errstate(all="ignore"):
        return guarded(row.name, case.problem, case.tolerance, partial(row.run, case))  # type: ignore[arg-type]


@lru_cache(256)
def _rows_for(kind: str, size: int) -> tuple[Row, ...]:
    return tuple(row for row in TABLE if kind in row.kinds and row.over < size <= row.most)


def _is_better(found: Solution, best: Solution) -> bool:
    """Whether one settles the problem, or is right to its terms and the other is not, or else has less left."""
    if found.settled or best.settled:
        return not best.settled
    ranks = [one.status is Status.RIGHT_TO_TERMS for one in (found, best)]
    return ranks[0] if ranks[0] != ranks[1] else found.residual < best.residual


def _concluded(case: Case) -> Solution:
    """The best point, the route of all, and, where it is no solution, why."""
    best, tried = case.best, case.tried
    assert best is not None
    if len(tried) == 1 and best.settled:
        return best
    told = replace(best, route=joined(*tried), iterations=sum(found.iterations for found in tried))
    if best.settled:
        return told
    ended = [found.message for found in tried if ENDED in found.message]
    if best.status in KEPT:
        return replace(told, message="; ".join(dict.fromkeys([best.message, *ended])))
    teller = best if case.teller is None else case.teller
    if case.parted:
        return replace(told, status=teller.status, message=teller.message)
    names = " > ".join(name.removesuffix(FAILED) for found in tried for name in found.route.split(" > "))
    reasons = [f"{teller.status.words}: nothing of {names} found a solution or proved that none is", *ended]
    if any(NEARLY in found.message for found in tried):
        reasons.append(NEARLY)
    return replace(told, status=teller.status, message="; ".join(dict.fromkeys(reasons)))


def _said(case: Case, found: Solution) -> Solution:
    """What was found for an LCP, said of the contacts; several solutions of one in space."""
    if case.kind == LCP:
        return found
    if case.kind == SPACE:
        from lcpflex.solvers.contact.cones.alone import told_apart

        return told_apart(case.problem, found, case.tolerance) if case.whole else found
    if case.parted:
        return found
    if found.status is Status.NOT_UNIQUE:
        found = case.problem.told_apart(case.lcp, found, case.tolerance)
    return confirmed(case.problem, found)


_lemke = lru_cache(Lemke)  # its settings checked once
_principal = lru_cache(PrincipalPivoting)


def _pivoted(case: Case) -> Solution:
    """By the basis of the guess, else by principal pivoting where M is symmetric, and by Lemke."""
    lcp, guess = case.problem.lcp(), case.guess if case.kind == LCP or case.problem.size <= SMALL else None
    solver: LcpSolver = _principal(case.tolerance) if lcp.symmetric else _lemke(case.tolerance)
    case.pivoted = found = solver.solve(lcp, guess)
    return found


def _lemke_too(case: Case) -> Solution | None:
    """Where that was principal pivoting."""
    if not case.lcp.symmetric:
        return None
    found = _lemke(case.tolerance).solve(case.lcp)
    if case.pivoted is None or _is_better(found, case.pivoted):
        case.pivoted = found
    return found


def _exchanged(case: Case) -> Solution | None:
    """By exchanges row by row, where pivoting looked at the large rows alone."""
    return None if case.pivoted is None else repaired(case.lcp, case.pivoted, case.tolerance)


def _infeasible(case: Case) -> Solution:
    """The proof that there is no solution, by linear programming."""
    lcp = case.lcp
    u = candidate(*lcp._data)
    return accept(lcp, np.zeros(lcp.size), tolerance=case.tolerance, route=PROGRAM, certificate=u)


def _perturbed(case: Case) -> Solution:
    return perturbed_newton(case.lcp, case.problem.unknown_units.d, case.tolerance, case.trials)


def _exact(case: Case) -> Solution:
    """The search without rounding: a solution that floats can hold, or the proof that there is none."""
    proof, z = exact_solution(case.problem, SEARCH)
    point = np.zeros(case.problem.size) if z is None else z
    failed = Status.NUMERICAL_FAILURE
    return accept(case.problem, point, tolerance=case.tolerance, status=failed, route=EXACT, proof=proof)


def _later(name: str, *settings: Any) -> Run:
    """A row of contacts, whose module the steps of a run do not need."""

    def run(case: Case) -> Solution | None:
        rows = import_module("lcpflex.solvers.contact.user_rows")
        found: Solution | None = getattr(rows, name)(case, *settings)
        return found

    return run


def _by_factor_alone(case: Case) -> bool:
    return case.problem.delassus is None


def _may_part(case: Case) -> bool:
    """Parts of the plane are known with the blocks; in space they are looked for, which is for those in time."""
    return case.whole and (case.kind == PLANE or not out_of_time())


def _rubs(case: Case) -> bool:
    return len(case.problem.tangent) > 0


def _may_be_infeasible(case: Case) -> bool:
    assert case.best is not None
    return case.problem.size <= MANY or not case.best.residual < NEAR


def with_solver(solver: Callable[[float], LcpSolver]) -> Run:
    """A row of any solver made for a tolerance, of this package, of qpsolvers, of a user: if it takes the problem."""

    def run(case: Case) -> Solution | None:
        one, problem = solver(case.tolerance), case.problem if case.kind == SPACE else case.lcp
        return None if one.refuses(problem) else one.solve(problem)

    return run


PROGRAM, EXACT = "linear program of Farkas", "search in whole numbers"
SWEEPS, ACTIVE, NEWTON, COPOSITIVE = "sweeps", "active set", "Newton", "lemke on the copositive form"
_FEW: dict[str, Any] = {"kinds": (PLANE,), "most": SMALL}
_OF_MANY: dict[str, Any] = {"kinds": (PLANE,), "over": SMALL}
_CONTACTS, _ANY = (PLANE, SPACE), (LCP, PLANE)


def _pivoting(kinds: tuple[str, ...], over: float = -1, most: float = np.inf) -> tuple[Row, ...]:
    """Pivoting of LCPs of so many unknowns, in three rows."""
    return (
        Row("pivoting", _pivoted, kinds, over, most, tells=True, sure=True),
        Row("lemke", _lemke_too, kinds, over, most),
        Row(REPAIRED, _exchanged, kinds, over, most),
    )


TABLE = (
    Row("forces of the guess", _later("known"), (SPACE,)),
    Row(SWEEPS, _later("swept_until_solved"), **_FEW, when=_by_factor_alone),
    Row(SWEEPS, _later("swept", "few"), **_OF_MANY),
    Row(SWEEPS, _later("swept_until_solved", 100), (SPACE,)),
    *_pivoting((LCP,)),
    *_pivoting((PLANE,), most=SMALL),
    Row("parts", _later("by_parts"), _CONTACTS, when=_may_part, last=True),
    Row(ACTIVE, _later("on_its_active_set"), **_OF_MANY),
    *_pivoting((PLANE,), over=SMALL, most=PIVOTED),
    Row(SWEEPS, _later("swept", "more"), **_OF_MANY),
    Row(ACTIVE, _later("on_its_active_set"), **_OF_MANY),
    Row(SWEEPS, _later("swept", "many"), **_OF_MANY),
    Row(ACTIVE, _later("on_its_active_set"), **_OF_MANY),
    Row("convex program", _later("relaxed"), **_OF_MANY),
    Row(ACTIVE, _later("on_its_active_set"), **_OF_MANY),
    Row(NEWTON, _later("searched"), **_OF_MANY),
    Row(ACTIVE, _later("on_its_active_set"), **_OF_MANY),
    Row(NEWTON, _later("searched_in_space"), (SPACE,)),
    *_pivoting((PLANE,), over=PIVOTED, most=MANY),
    Row(COPOSITIVE, _later("copositive"), (PLANE,), most=MANY, when=_rubs),
    Row(SWEEPS, _later("swept_until_solved"), **_FEW),
    Row("min-map Newton", with_solver(MinMapNewton), (LCP,)),
    Row("min-map Newton", with_solver(MinMapNewton), (PLANE,), most=MANY),
    Row(PROGRAM, _infeasible, (LCP,)),
    Row(PROGRAM, _infeasible, (PLANE,), most=TOO_MANY, when=_may_be_infeasible),
    Row("enumeration", with_solver(Enumeration), _ANY, most=LARGEST),
    Row(PERTURBED, _perturbed, (PLANE,), most=MANY),
    Row(EXACT, _exact, (LCP,), most=FULL),  # up to LARGEST the enumeration asks it too, where floats find nothing
)
LAST_DIGITS = Row("last digits", _later("to_last_digits"), _CONTACTS)
"""For what is solved, and not yet relative to the load alone."""
