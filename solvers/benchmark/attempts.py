"""One problem before one solver: every solve is judged on the data of the problem, and the worst counts."""

from __future__ import annotations

import dataclasses
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from lcpflex.errors import LONGEST
from lcpflex.solvers.answers import Answer
from lcpflex.solvers.benchmark.records import version_of
from lcpflex.solvers.near_miss import near_miss
from lcpflex.solvers.problem import Solution, Status
from lcpflex.solvers.refusals import check_answer
from lcpflex.solvers.user_solver import TARGET, own_part, own_tolerance

__all__ = ["FAILED", "PROOFS", "REFUSED", "Row", "attempt", "number"]

ROUNDING = 1.01  # by which a residual that is computed once more may exceed the tolerance
PROOFS = ("INFEASIBLE", "NO_SOLUTION")
REFUSED, FAILED = "refused", "failed"  # in place of a status


@dataclass(frozen=True, slots=True)
class Row:
    """What one solver made of the problem: the worst of its solves, of which each is judged.

    status: name of the Status that its point deserves, or "refused" or "failed" (it raised, or returned no point).
    residual: of its point, computed here on the data of the problem, whatever the solver states; of another model's
    forces too; strict: the same relative to the load alone, where the problem tells it. difference: max |z - z_ref|;
    same_motion: whether w is that of the reference; both None if not solved or the model is another one. time [s]:
    median of the repeats. remark: the reason, if it was not solved. model: what the solver solves instead of the
    problem, if it does. solved: whether the residual is within the tolerance. wrong: whether the solver's claim,
    ``claim``, was refuted here. route: which algorithms it says that it tried. version: of the solver, as far as it is
    known.
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
    claim: str = ""
    tolerance: float = float("nan")
    strict: float = float("nan")
    route: str = ""
    version: str = ""

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


def attempt(
    problem: Any, name: str, solver: Any, repeats: int, guess: Solution | None, tolerance: float | None
) -> tuple[Row, Solution | None]:
    """The row of one solver, not yet compared, and its solution if it returned one.

    The solver solves ``problem`` once, and then ``repeats`` times, each time from ``guess``; ``tolerance`` is that of
    all solvers, or None for the one that this solver states. ``name`` is what the row is called.
    """
    version = version_of(solver)
    try:
        reason = solver.refuses(problem)
        if reason:
            return Row(name, REFUSED, remark=_one_line(reason), version=version), None
        tries = _solved(problem, solver, repeats, guess)
    except Exception as error:  # a solver that breaks its promise is a finding, not the end of the comparison
        return Row(name, FAILED, remark=_first_line(f"{type(error).__name__}: {error}"), version=version), None
    judged: dict[Any, Row] = {}
    rows = []
    for found, answer, _ in tries:
        claim = found.status.name if answer is None or answer.claim is None else _status_name(answer.claim)
        if answer is not None and answer.z is None and answer.claim is None and not answer.expired:
            remark = _first_line(answer.error.removeprefix("raised "))
            rows.append(Row(name, FAILED, remark=remark, version=version))
            continue
        seen = (np.asarray(found.z).tobytes(), found.status, claim, found.message)
        if seen not in judged:
            judged[seen] = _judged(problem, name, solver, found, claim, tolerance)
        rows.append(judged[seen])
    worst = max(range(len(rows)), key=lambda i: _badness(rows[i]))  # of equals the first: the row is of one solve
    row = dataclasses.replace(rows[worst], time=statistics.median([time for *_, time in tries[1:]] or [np.nan]))
    if row.status == FAILED:
        row = dataclasses.replace(row, time=np.nan)
    return _of_all(row, rows), None if row.status == FAILED else tries[worst][0]


def _solved(
    problem: Any, solver: Any, repeats: int, guess: Solution | None
) -> list[tuple[Solution, Answer | None, float]]:
    """What each solve found, what a function of the user's answered, and the time [s]; the first may compile."""
    own, tries = own_part(solver), []
    for _ in range(repeats + 1):
        start = perf_counter()
        found = solver.solve(problem, guess)
        time = perf_counter() - start
        answer = None if own is None else own.last
        if own is not None and own.time_limit is not None and answer is not None:
            time = answer.seconds  # without what it takes to hand it to another process
        tries.append((check_answer(found), answer, time))
        if answer is not None and answer.z is None and not answer.expired:
            break  # it raised, and may do so after a while: once is enough
    return tries


def _badness(row: Row) -> tuple[bool, bool, bool, float]:
    """What makes one solve worse than another: it failed, it claimed wrongly, it is no solution, its residual."""
    return row.status == FAILED, row.wrong, not row.solved, np.nan_to_num(row.residual, nan=np.inf)


def _of_all(row: Row, rows: Sequence[Row]) -> Row:
    """The row of the worst solve, with how many were as bad where the others were better."""
    alike = sum(_badness(other)[:3] == _badness(row)[:3] for other in rows)
    if alike == len(rows):
        return row
    return dataclasses.replace(row, remark=_cut(f"{alike} of {len(rows)} solves: {row.remark}"))


def _status_name(claim: Solution) -> str:
    return claim.status.name if isinstance(claim.status, Status) else str(claim.status)[:20]


def _judged(problem: Any, name: str, solver: Any, found: Solution, claim: str, tolerance: float | None) -> Row:
    """The row of a point, by its residual on the data of the problem."""
    model = str(getattr(solver, "model", ""))
    stated = own_tolerance(solver, getattr(problem, "tolerance", TARGET))
    allowed = stated if tolerance is None else tolerance
    residual, strict = _residuals(problem, found, bool(model))
    claims = claim in (Status.SOLVED.name, Status.NOT_UNIQUE.name)
    wrong = claims and not model and not residual <= ROUNDING * stated
    solved = bool(found.solved if model else residual <= ROUNDING * allowed and _has_point(solver, found))
    status, remark = found.status, "" if solved else _first_line(found.message)
    if solved and not found.solved:
        status = Status.SOLVED
    elif found.solved and not solved:
        status = Status.INACCURATE if residual <= 1e3 * allowed else Status.WRONG
        remark = f"residual {residual:.1e}, tolerance {allowed:.1e}"
    if wrong:
        remark = f"claimed {claim}, but its residual is {residual:.1e}{_hint(problem, found, allowed)}"
    elif claim in PROOFS and claim != status.name:
        remark = f"claimed {claim} without a proof that holds"
    return Row(
        name,
        status.name,
        residual,
        iterations=found.iterations,
        remark=remark,
        model=model,
        solved=solved,
        wrong=wrong,
        claim=claim,
        tolerance=allowed,
        strict=strict,
        route=found.route,
        version=version_of(solver),
    )


def _hint(problem: Any, found: Solution, tolerance: float) -> str:
    """What a wrong claim may have meant, behind a semicolon; empty where nothing is known."""
    z = np.array(found.z, dtype=float)
    hint = near_miss(problem, z, tolerance) if z.shape == (problem.size,) else ""
    return f"; {hint}" if hint else ""


def _has_point(solver: Any, found: Solution) -> bool:
    """Whether the point is what the solver found, though it may not have reached its own tolerance."""
    own = own_part(solver)
    return found.status.name not in PROOFS and (own is None or own.last is None or own.last.z is not None)


def _residuals(problem: Any, found: Solution, other_model: bool) -> tuple[float, float]:
    """Both sizes of the residual in the problem as it was posed; forces of another model are read as its forces."""
    z = np.array(found.z, dtype=float)
    if other_model and hasattr(problem, "unknowns") and z.shape == problem.free.shape:
        z = problem.unknowns(*np.split(z, [len(problem.friction)]))
    if z.shape != (problem.size,):
        return float("nan"), float("nan")
    if hasattr(problem, "residuals"):
        residual, strict = problem.residuals(z)
        return float(residual), float(strict)
    return float(problem.residual(z)), float("nan")


def _first_line(text: str) -> str:
    """The first line of a message, of which some run over pages."""
    return _cut(text.strip().partition("\n")[0])


def _one_line(text: str) -> str:
    """A sentence whole, on one line: the cure stands at its end."""
    return _cut(" ".join(text.split()))


def _cut(line: str) -> str:
    return line if len(line) <= LONGEST else line[: LONGEST - 3] + "..."


def number(value: float, form: str) -> str:
    """The number, or a dash if there is none."""
    return format(value, form) if np.isfinite(value) else "-"
