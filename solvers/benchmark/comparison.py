"""One problem before many solvers: who solves it, how well and how fast, and whether they agree.

Of symmetric semidefinite problems all solutions share w = M z, though z may differ (redundant contacts): agreement is
therefore sought in w, of contact problems in the contact velocities.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import lcpflex.solvers
from lcpflex.basics import libs
from lcpflex.basics.arguments import text
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.arguments import check_options, check_problem, posed
from lcpflex.solvers.benchmark.attempts import PROOFS, Row, attempt
from lcpflex.solvers.benchmark.records import csv_of
from lcpflex.solvers.certificate import is_symmetric
from lcpflex.solvers.clock import check_time_limit
from lcpflex.solvers.limits import check_tolerance
from lcpflex.solvers.mixed.problems import BoxedLcp, MixedLcp
from lcpflex.solvers.problem import Lcp, Solution
from lcpflex.solvers.refusals import has_cones
from lcpflex.solvers.time_limit import TimeLimit
from lcpflex.solvers.user_solver import named_solvers

__all__ = ["CrossCheck", "Row", "all_solvers", "cross_check"]

ALIKE = 1e-6  # relative difference up to which two certified answers count as one
_HEAD = ("solver", "status", "residual", "|z - z_ref|", "same motion", "iterations", "time [us]", "remark")


def all_solvers(problem: Any = None) -> dict[str, Any]:
    """Every solver ``lcpflex.solvers`` exports, by name, QuadraticProgram once for each backend installed.

    problem: leave out those that refuse it.
    """
    if problem is not None and not isinstance(problem, Lcp):
        posed(problem)
    found: dict[str, Any] = {}
    for name in lcpflex.solvers.__all__:
        kind: Any = getattr(lcpflex.solvers, name)
        if not _is_solver(kind):
            continue
        if name == "QuadraticProgram":
            found |= {f"{name}({b})": kind(backend=b) for b in sorted(libs.qpsolvers.available_solvers)}
        else:
            found[name] = kind()
    if problem is None:
        return found
    return {name: solver for name, solver in found.items() if not solver.refuses(problem)}


def _is_solver(kind: object) -> bool:
    promises = all(callable(getattr(kind, name, None)) for name in ("solve", "refuses"))
    if not (promises and isinstance(kind, type) and dataclasses.is_dataclass(kind)):
        return False
    missing = dataclasses.MISSING
    return all(f.default is not missing or f.default_factory is not missing for f in dataclasses.fields(kind) if f.init)


@dataclass(frozen=True, slots=True)
class CrossCheck:
    """The rows of all solvers; ``reference`` names the solved one of least residual, "" if none solved it.

    name, kind, size: of the problem, as it was named, by its class, and how many unknowns it has.

    verdict: what the solvers say together, in words.
    """

    rows: tuple[Row, ...]
    reference: str
    verdict: str
    name: str = ""
    kind: str = ""
    size: int = 0

    @property
    def contradictory(self) -> bool:
        """Whether a claim was wrong: a point that is no solution, or a proof that there is none where one exists."""
        return any(row.wrong for row in self.rows)

    def table(self) -> str:
        """Aligned text, with the verdict below."""
        return f"{aligned([_HEAD, *(row.cells() for row in self.rows)])}\n\n{self.verdict}"

    def __str__(self) -> str:
        return self.table()

    def markdown(self) -> str:
        """The rows as a table of Markdown."""
        return as_markdown([_HEAD, *(row.cells() for row in self.rows)])

    def csv(self) -> str:
        """A line for each solver, numbers in full, time in seconds: with the problem, the machine, and all versions."""
        return csv_of(Row, [self])


def cross_check(
    problem: Any,
    solvers: Any = None,
    repeats: int = 5,
    *,
    tolerance: float | None = None,
    time_limit: float | None = None,
    name: str = "",
) -> CrossCheck:
    """Solve ``problem`` (Lcp, ContactProblem or another posed one) by every solver and compare.

    Parameters
    ----------
    solvers
        By name, or one, or a sequence of them; all of :func:`all_solvers` if left out. Callables become
        :class:`UserSolver`: a function of (M, q) or of (problem) that returns z.
    repeats
        Solves of which the median time counts, after one that may compile. All are judged, and the worst counts.
    tolerance
        Largest residual that counts as solved [-], for all solvers. By default the one that each solver states, for
        those that state none that of the problem, if it has one, else 1e-10.
    time_limit
        Seconds for each solve: see :class:`TimeLimit`. Callables then run in a process of their own.
    name
        Of the problem, for tables.

    Raises
    ------
    ModelError
        For repeats < 1, problems no solver takes, and what is no solver. What a solver raises is shown in its row.
    """
    check_options(repeats, tolerance)
    check_problem("problem", problem)
    if not (isinstance(name, str) and name == ""):
        text("name", name)
    ready = ready_solvers(solvers, time_limit)
    return solve_all(problem, ready, repeats, {}, tolerance, name)[0]


def ready_solvers(solvers: Any, time_limit: float | None) -> dict[str, Any]:
    """The solvers by name, each with its limit of time."""
    try:
        named = all_solvers() if solvers is None else named_solvers(solvers)
    except ModelError as error:
        raise ModelError(f"solvers: {error}") from None
    if check_time_limit("time_limit", time_limit) is None:
        return named
    return {name: TimeLimit(solver, time_limit) for name, solver in named.items()}  # type: ignore[arg-type]


def solve_all(
    problem: Any,
    solvers: Mapping[str, Any],
    repeats: int,
    guesses: Mapping[str, Solution | None],
    tolerance: float | None = None,
    name: str = "",
) -> tuple[CrossCheck, dict[str, Solution | None]]:
    """The comparison, and what each solver found, started from its guess if there is one."""
    if tolerance is not None:
        check_tolerance(tolerance)
    tried = {n: attempt(problem, n, s, repeats, guesses.get(n), tolerance) for n, s in solvers.items()}
    rivals = {n: (row, s) for n, (row, s) in tried.items() if s is not None and row.solved and not row.model}
    reference = min(rivals, key=lambda n: rivals[n][0].residual, default="")
    best = rivals[reference][1] if reference else None
    rows = tuple(_compared(problem, row, s, best) for row, s in tried.values())
    verdict = _verdict(problem, rows, reference)
    check = CrossCheck(rows, reference, verdict, name, type(problem).__name__, int(problem.size))
    return check, {n: s for n, (_, s) in tried.items()}


def _compared(problem: Any, row: Row, found: Solution | None, best: Solution | None) -> Row:
    if found is None or best is None or row.model or row.wrong:
        return row
    if not row.solved:
        return dataclasses.replace(row, wrong=row.status in PROOFS or row.claim in PROOFS)
    difference = float(np.abs(found.z - best.z).max(initial=0.0))
    return dataclasses.replace(
        row, difference=difference, same_motion=_same(problem, _motion(problem, found), _motion(problem, best))
    )


def _motion(problem: Any, found: Solution) -> FloatArray:
    """w, or the contact velocities of a contact problem."""
    if hasattr(problem, "velocity") and hasattr(problem, "unknowns"):
        return np.asarray(problem.velocity(np.concatenate(problem.forces(found.z))))
    return found.w


def _same(problem: Any, a: FloatArray, b: FloatArray) -> bool:
    """Whether two motions differ by less than ALIKE of the largest velocity there is, that without forces included."""
    free = problem.free if hasattr(problem, "velocity") else problem.slack(np.zeros(problem.size))
    size = max(float(np.abs(x).max(initial=0.0)) for x in (a, b, np.asarray(free)))
    return bool(np.abs(a - b).max(initial=0.0) <= ALIKE * size)


def _is_unique(problem: Any) -> bool:
    """Whether all solutions share w: M is symmetric positive semidefinite, that of the problem or that of its LCP."""
    if has_cones(problem):
        return False
    if isinstance(problem, MixedLcp | BoxedLcp) and is_symmetric(np.array(problem.M), problem.size):
        return _semidefinite(problem.M)
    lcp = problem.lcp() if hasattr(problem, "lcp") else problem
    return bool(lcp.symmetric) and _semidefinite(lcp.M)


def _semidefinite(M: FloatArray) -> bool:
    values = np.linalg.eigvalsh(M) if len(M) else np.zeros(1)
    return bool(values[0] >= -1e-12 * values[-1])


def _verdict(problem: Any, rows: Sequence[Row], reference: str) -> str:
    wrong = [row.solver for row in rows if row.wrong]
    if wrong:
        return f"wrong claim by {', '.join(wrong)}"
    proofs = [row.solver for row in rows if row.status in PROOFS]
    if not reference:
        return f"no solution exists, says {', '.join(proofs)}" if proofs else "no solver solved it"
    solved = [row for row in rows if row.same_motion is not None]
    others = [row.solver for row in solved if not row.same_motion]
    kind = "the contact velocities" if hasattr(problem, "velocity") else "w"
    if others and _is_unique(problem):
        return f"{', '.join(others)}: differs from {reference} in {kind}, though unique: less accurate"
    if others:
        return f"{', '.join(others)}: another solution than {reference}, both certified; {kind} may differ"
    if len(solved) == 1:
        return f"only {reference} solved it"
    return f"all {len(solved)} solvers that solved it agree in {kind}"


def aligned(lines: Sequence[Sequence[str]]) -> str:
    """Columns of text, two blanks apart."""
    widths = [max(len(line[k]) for line in lines) for k in range(len(lines[0]))]
    return "\n".join("  ".join(c.ljust(w) for c, w in zip(line, widths, strict=True)).rstrip() for line in lines)


def as_markdown(lines: Sequence[Sequence[str]]) -> str:
    """A table of Markdown; the first line is its head."""
    ruled = [lines[0], ("---",) * len(lines[0]), *lines[1:]]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in ruled)
