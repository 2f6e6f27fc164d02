"""One problem before many solvers: who solves it, how well and how fast, and whether they agree.

Of symmetric semidefinite problems all solutions share w = M z, though z may differ (redundant contacts): agreement is
therefore sought in w, of contact problems in the contact velocities.
"""

from __future__ import annotations

import csv
import dataclasses
import io
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

import lcpflex.solvers
from lcpflex.compiled import FloatArray
from lcpflex.errors import ModelError
from lcpflex.solvers.problem import Solution, check_limit

__all__ = ["CrossCheck", "Row", "all_solvers", "cross_check"]

ALIKE = 1e-6  # relative difference up to which two certified answers count as one
LOOSEST = 1e-2  # residual above which nothing is a solution, for solvers that do not tell their tolerance
LONGEST = 110  # characters of a remark
PROOFS = ("INFEASIBLE", "NO_SOLUTION")
REFUSED, FAILED = "refused", "failed"  # in place of a status
_HEAD = ("solver", "status", "residual", "|z - z_ref|", "same motion", "iterations", "time [us]", "remark")


def all_solvers(problem: Any = None) -> dict[str, Any]:
    """Every solver ``lcpflex.solvers`` exports, by name, QuadraticProgram once for each backend installed.

    problem: leave out those that refuse it.
    """
    found: dict[str, Any] = {}
    for name in lcpflex.solvers.__all__:
        kind: Any = getattr(lcpflex.solvers, name)
        if not _is_solver(kind):
            continue
        if name == "QuadraticProgram":
            import qpsolvers

            found |= {f"{name}({b})": kind(backend=b) for b in sorted(qpsolvers.available_solvers)}
        else:
            found[name] = kind()
    if problem is None:
        return found
    return {name: solver for name, solver in found.items() if not solver.refuses(problem)}


def _is_solver(kind: object) -> bool:
    promises = all(callable(getattr(kind, name, None)) for name in ("solve", "refuses"))
    return isinstance(kind, type) and dataclasses.is_dataclass(kind) and promises


@dataclass(frozen=True, slots=True)
class Row:
    """What one solver made of the problem.

    status: name of its Status, or "refused" or "failed" (it raised). difference: max |z - z_ref|; same_motion: whether
    w is that of the reference; both None if not solved or the model is another one. time [s]: median of the repeats.
    remark: the reason, if it was not solved. model: what the solver solves instead of the problem, if it does.
    solved, wrong: what it claims, and whether the claim was refuted here.
    """

    solver: str
    status: str
    residual: float = float("nan")
    difference: float | None = None
    same_motion: bool | None = None
    iterations: int | None = None
    time: float = float("nan")
    remark: str = ""
    model: str = ""
    solved: bool = False
    wrong: bool = False

    def cells(self) -> tuple[str, ...]:
        """The row as text, in the order of the table."""
        motion = {None: "-", True: "yes", False: "no"}[self.same_motion]
        return (
            self.solver,
            "-" if self.status == REFUSED else self.status,
            number(self.residual, ".1e"),
            "-" if self.difference is None else f"{self.difference:.1e}",
            motion,
            "-" if self.iterations is None else str(self.iterations),
            number(1e6 * self.time, ".1f"),
            f"another model: {self.model}" if self.model else self.remark,
        )


@dataclass(frozen=True, slots=True)
class CrossCheck:
    """The rows of all solvers; ``reference`` names the solved one of least residual, "" if none solved it."""

    rows: tuple[Row, ...]
    reference: str
    verdict: str

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
        """The rows as comma-separated values, numbers in full, time in seconds."""
        return as_csv(Row, self.rows)


def cross_check(problem: Any, solvers: Mapping[str, Any] | None = None, repeats: int = 5) -> CrossCheck:
    """Solve ``problem`` (Lcp, ContactProblem or another posed one) by every solver and compare.

    solvers: by name, all of :func:`all_solvers` if left out. repeats: solves of which the median time counts, after one
    that may compile. Raises ModelError for repeats < 1 and problems no solver takes; what a solver raises is shown in
    its row.
    """
    check_request(problem, repeats)
    return solve_all(problem, all_solvers() if solvers is None else solvers, repeats, {})[0]


def solve_all(
    problem: Any, solvers: Mapping[str, Any], repeats: int, guesses: Mapping[str, Solution | None]
) -> tuple[CrossCheck, dict[str, Solution | None]]:
    """The comparison, and what each solver found, started from its guess if there is one."""
    tried = {name: _attempt(problem, name, s, repeats, guesses.get(name)) for name, s in solvers.items()}
    rivals = {n: s for n, (row, s) in tried.items() if s is not None and s.solved and not (row.model or row.wrong)}
    reference = min(rivals, key=lambda n: rivals[n].residual, default="")
    rows = tuple(_compared(problem, row, s, rivals.get(reference)) for row, s in tried.values())
    return CrossCheck(rows, reference, _verdict(problem, rows, reference)), {n: s for n, (_, s) in tried.items()}


def check_request(problem: Any, repeats: int) -> None:
    """Raise ModelError for repeats < 1 and problems that no solver takes."""
    if repeats is None:
        raise ModelError("repeats is None: expected a positive integer")
    check_limit("repeats", repeats)
    if not all(hasattr(problem, name) for name in ("size", "slack", "residual")):
        kind = type(problem).__name__
        raise ModelError(f"problem is a {kind}, which no solver takes: expected Lcp, ContactProblem, or a posed one")


def _attempt(problem: Any, name: str, solver: Any, repeats: int, guess: Solution | None) -> tuple[Row, Solution | None]:
    """The row of one solver, not yet compared, and its solution if it returned one."""
    try:
        reason = solver.refuses(problem)
        if reason:
            return Row(name, REFUSED, remark=reason), None
        found = solver.solve(problem, guess)
        times = []
        for _ in range(repeats):
            start = perf_counter()
            solver.solve(problem, guess)
            times.append(perf_counter() - start)
    except Exception as error:  # a solver that breaks its promise is a finding, not the end of the comparison
        return Row(name, FAILED, remark=_first_line(f"{type(error).__name__}: {error}")), None
    model = str(getattr(solver, "model", ""))
    row = Row(
        name,
        found.status.name,
        found.residual,
        iterations=found.iterations,
        time=statistics.median(times),
        remark="" if found.solved else _first_line(found.message),
        model=model,
        solved=found.solved,
        wrong=found.solved and not model and not _is_solution(problem, solver, found),
    )
    return row, found


def _is_solution(problem: Any, solver: Any, found: Solution) -> bool:
    """Whether the residual, computed here once more, is within what the solver promises."""
    tolerance = getattr(solver, "tolerance", LOOSEST)
    return bool(problem.residual(found.z) <= 1.01 * tolerance)


def _compared(problem: Any, row: Row, found: Solution | None, best: Solution | None) -> Row:
    if found is None or best is None or row.model or row.wrong:
        return row
    if not found.solved:
        return dataclasses.replace(row, wrong=row.status in PROOFS)
    difference = float(np.abs(found.z - best.z).max(initial=0.0))
    return dataclasses.replace(
        row, difference=difference, same_motion=_same(problem, _motion(problem, found), _motion(problem, best))
    )


def _motion(problem: Any, found: Solution) -> FloatArray:
    """w, or the contact velocities of a contact problem."""
    if hasattr(problem, "velocity"):
        return np.asarray(problem.velocity(np.concatenate(problem.forces(found.z))))
    return found.w


def _same(problem: Any, a: FloatArray, b: FloatArray) -> bool:
    """Whether two motions differ by less than ALIKE of the largest velocity there is, that without forces included."""
    free = problem.free if hasattr(problem, "velocity") else problem.slack(np.zeros(problem.size))
    size = max(float(np.abs(x).max(initial=0.0)) for x in (a, b, np.asarray(free)))
    return bool(np.abs(a - b).max(initial=0.0) <= ALIKE * size)


def _is_unique(problem: Any) -> bool:
    """Whether all solutions share w: M is symmetric positive semidefinite."""
    lcp = problem.lcp() if hasattr(problem, "lcp") else problem
    if not lcp.symmetric:
        return False
    values = np.linalg.eigvalsh(lcp.M) if lcp.size else np.zeros(1)
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


def _first_line(text: str) -> str:
    """What fits into a table of a message, of which some run over pages."""
    line = text.strip().partition("\n")[0]
    return line if len(line) <= LONGEST else line[: LONGEST - 3] + "..."


def number(value: float, form: str) -> str:
    """The number, or a dash if there is none."""
    return format(value, form) if np.isfinite(value) else "-"


def aligned(lines: Sequence[Sequence[str]]) -> str:
    """Columns of text, two blanks apart."""
    widths = [max(len(line[k]) for line in lines) for k in range(len(lines[0]))]
    return "\n".join("  ".join(c.ljust(w) for c, w in zip(line, widths, strict=True)).rstrip() for line in lines)


def as_markdown(lines: Sequence[Sequence[str]]) -> str:
    """A table of Markdown; the first line is its head."""
    ruled = [lines[0], ("---",) * len(lines[0]), *lines[1:]]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in ruled)


def as_csv(kind: Any, rows: Sequence[object]) -> str:
    """The fields of the rows, all of the dataclass ``kind``, as comma-separated values below their names."""
    names = [f.name for f in dataclasses.fields(kind)]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([[getattr(row, name) for name in names] for row in rows])
    return text.getvalue()
