"""Many recorded problems before many solvers: sums, failures, wrong claims, and the performance profile."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.arguments import called, flag
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.arguments import check_options, check_problem
from lcpflex.solvers.benchmark import comparison as one
from lcpflex.solvers.benchmark.attempts import PROOFS, REFUSED, Row, number
from lcpflex.solvers.benchmark.comparison import CrossCheck
from lcpflex.solvers.benchmark.profile import draw_profile
from lcpflex.solvers.benchmark.records import as_csv, csv_of
from lcpflex.solvers.problem import Solution

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Replay", "ReplayRow", "replay"]

SHOWN = 12  # findings that the table tells
_HEAD = (
    "solver", "solved", "proved none", "refused", "failed", "wrong", "other motion", "worst residual", "iterations",
    "time [ms]", "remark",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class ReplayRow:
    """What one solver made of all problems: how many of them it solved, proved to have no solution, refused, failed at,
    claimed wrongly.

    other_motion: solved with another w than the reference of the problem. residual: the worst of those solved.
    iterations, time [s]: sums over all problems tried, each with the median time of its repeats. remark: the reason of
    the first failure or refusal. model: what the solver solves instead, if it does.
    """

    solver: str
    solved: int
    proved: int
    refused: int
    failed: int
    wrong: int
    other_motion: int
    residual: float
    iterations: int
    time: float
    remark: str = ""
    model: str = ""

    def cells(self) -> tuple[str, ...]:
        """The row as text, in the order of the table."""
        counts = (self.solved, self.proved, self.refused, self.failed, self.wrong, self.other_motion)
        tried = self.refused < sum(counts[:5])
        sums = (str(self.iterations), f"{1e3 * self.time:.2f}") if tried else ("-", "-")
        remark = f"another model: {self.model}" if self.model else self.remark
        return (self.solver, *map(str, counts), number(self.residual, ".1e"), *sums, remark)


@dataclass(frozen=True, slots=True, eq=False)
class Replay:
    """The rows of all solvers over many problems.

    names (problems,). times (solvers, problems) [s]: the median time of each solve; inf where the solver refused the
    problem, neither solved it nor proved that nothing does, claimed wrongly, or solves another model. findings: what
    deserves a look, a sentence for each problem on which a claim was wrong or certified solutions differ. checks: the
    comparison on each problem.
    """

    rows: tuple[ReplayRow, ...]
    names: tuple[str, ...]
    times: FloatArray
    findings: tuple[str, ...] = ()
    checks: tuple[CrossCheck, ...] = ()

    @property
    def contradictory(self) -> bool:
        """Whether any claim was wrong: a point that is no solution, or a proof that there is none where one exists."""
        return any(row.wrong for row in self.rows)

    @property
    def verdict(self) -> str:
        """In words: who claimed wrongly, and where certified solutions differ."""
        wrong = [row.solver for row in self.rows if row.wrong]
        words = f"wrong claims by {', '.join(wrong)}" if wrong else "no wrong claim"
        if not self.findings:
            words += ", and all who solved a problem agree"
        count = f"{len(self.names)} problem" + "s" * (len(self.names) != 1)
        left = len(self.findings) - SHOWN
        return "\n".join(
            [f"{count}: {words}", *self.findings[:SHOWN], *([f"... and on {left} more problems"] if left > 0 else [])]
        )

    def table(self) -> str:
        """Aligned text, with the verdict below."""
        return f"{one.aligned([_HEAD, *(row.cells() for row in self.rows)])}\n\n{self.verdict}"

    def __str__(self) -> str:
        return self.table()

    def markdown(self) -> str:
        """The rows as a table of Markdown."""
        return one.as_markdown([_HEAD, *(row.cells() for row in self.rows)])

    def csv(self) -> str:
        """The rows as comma-separated values, numbers in full, time in seconds."""
        return as_csv(ReplayRow, self.rows)

    def problems_csv(self) -> str:
        """A line for each problem and solver, numbers in full, with the machine and all versions."""
        return csv_of(Row, self.checks)

    def plot(self, axes: Axes | None = None) -> Figure:
        """Performance profile: see :mod:`lcpflex.solvers.benchmark.profile`; without solvers of another model.

        axes: of matplotlib, to draw into; a new figure if omitted.
        """
        own = [i for i, row in enumerate(self.rows) if not row.model]
        return draw_profile([self.rows[i].solver for i in own], self.times[own], axes)


def replay(
    problems: Iterable[Any],
    solvers: Any = None,
    repeats: int = 3,
    warm: bool = False,
    progress: Callable[[int, int], object] | None = None,
    *,
    tolerance: float | None = None,
    time_limit: float | None = None,
) -> Replay:
    """Solve all ``problems`` by every solver and add up.

    problems: those :func:`cross_check` takes, or :class:`lcpflex.solvers.benchmark.files.Recorded`. solvers, repeats,
    tolerance, time_limit: as of :func:`cross_check`.
    warm: each solver starts from its own solution of the problem before, as in a simulation; else from nothing.
    progress: called with the numbers of problems done and in all. Raises ModelError if there is no problem or no
    solver, and as :func:`cross_check` does.
    """
    if isinstance(problems, str | bytes | Mapping | np.ma.MaskedArray) or not isinstance(problems, Iterable):
        raise ModelError(f"problems is {shown(problems)}: expected a sequence of problems")
    named = []
    for i, given in enumerate(problems):
        problem = getattr(given, "problem", given)
        check_problem(f"problems[{i}]", problem)
        named.append((str(getattr(given, "name", f"problem {i}")), problem))
    solvers = one.ready_solvers(solvers, time_limit)
    for what, given in (("problems", named), ("solvers", solvers)):
        if not given:
            raise ModelError(f"{what} is empty: expected at least one")
    check_options(repeats, tolerance)
    if progress is not None and (isinstance(progress, type) or not callable(progress)):
        raise ModelError(f"progress is {shown(progress)}: expected a function of two numbers, or None")
    warm = flag("warm", warm)
    guesses: dict[str, Solution | None] = {}
    checks: list[CrossCheck] = []
    for done, (name, problem) in enumerate(named, 1):
        check, found = one.solve_all(problem, solvers, repeats, guesses, tolerance, name)
        checks.append(check)
        if warm:
            guesses |= {name: solution for name, solution in found.items() if solution is not None and solution.solved}
        if progress is not None:
            called("progress", progress, "a function of two numbers", done, len(named))
    columns = list(zip(*(check.rows for check in checks), strict=True))
    findings = (f"{name}: {check.verdict}" for (name, _), check in zip(named, checks, strict=True) if _is_odd(check))
    times = np.array([[_counted(row) for row in rows] for rows in columns])
    rows = tuple(_sum(rows) for rows in columns)
    return Replay(rows, tuple(name for name, _ in named), times, tuple(findings), tuple(checks))


def _is_odd(check: CrossCheck) -> bool:
    return check.contradictory or any(row.same_motion is False for row in check.rows)


def _counted(row: Row) -> float:
    """The time of a solve that counts in the profile, else inf."""
    return row.time if (row.solved or row.status in PROOFS) and not (row.wrong or row.model) else np.inf


def _sum(rows: Sequence[Row]) -> ReplayRow:
    """One solver's rows of many problems in one."""
    solved = [row for row in rows if row.solved and not row.wrong]
    refused = sum(row.status == REFUSED for row in rows)
    proved = sum(row.status in PROOFS and not row.wrong for row in rows)
    wrong = sum(row.wrong for row in rows)
    return ReplayRow(
        rows[0].solver,
        solved=len(solved),
        proved=proved,
        refused=refused,
        failed=len(rows) - len(solved) - proved - refused - wrong,
        wrong=wrong,
        other_motion=sum(row.same_motion is False for row in rows),
        residual=max((row.residual for row in solved), default=float("nan")),
        iterations=sum(row.iterations or 0 for row in rows),
        time=float(np.nansum([row.time for row in rows])),
        remark=next((row.remark for row in rows if row.remark and row.status not in PROOFS), ""),
        model=next((row.model for row in rows if row.model), ""),
    )
