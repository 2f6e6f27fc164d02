"""Solvers of the user's own: any function, judged as all solvers are, that cannot spoil what it is given.

A function gets copies that it may write into, its exceptions become a failed solve, and whatever it returns is read as
a point and judged on the original data. With a limit of time it runs in a process of its own.
"""

from __future__ import annotations

import copy
import inspect
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from lcpflex.basics.arguments import one_of
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.answers import Answer, asked
from lcpflex.solvers.arguments import check_guess, posed
from lcpflex.solvers.clock import check_time_limit, limited, remaining
from lcpflex.solvers.limits import check_tolerance
from lcpflex.solvers.near_miss import near_miss
from lcpflex.solvers.problem import Lcp, PosedProblem, Solution, Status
from lcpflex.solvers.refusals import no_cones
from lcpflex.solvers.user_process import Worker

__all__ = ["UserSolver", "as_solver", "is_ours", "name_of", "named_solvers", "own_part"]

TARGET = 1e-10  # residual of a solution where no other is asked for
LONGEST = 300  # characters of what a solver says of its failure
HONEST = (Status.RAY, Status.ITERATION_LIMIT, Status.TIME_LIMIT, Status.INACCURATE)  # a failure that needs no proof
CLAIMED = (Status.SOLVED, Status.NOT_UNIQUE)  # what makes a point that does not solve the problem a wrong one
TAKES = ("arrays", "lcp", "problem")
CONES = (
    'with UserSolver(function, takes="problem") the function gets the SpatialContactProblem p itself (p.delassus or '
    "p.factor, p.free, p.friction) and returns its forces (3 k,), normal and two tangents of each contact in turn"
)
_EXPECTED = (
    "expected a solver such as Auto(), a function of (M, q) or of (problem) that returns z, or an object with "
    "solve(problem)"
)


@dataclass(frozen=True, slots=True)
class UserSolver:
    """A solver of 0 <= z _|_ M z + q >= 0 that is a function of the user's own, or an object with ``solve``.

    Every stepper, ``cross_check`` and ``replay`` make one of any callable that they are given as a solver. A problem
    without unknowns is answered without a call.

    Attributes
    ----------
    function
        Called with what ``takes`` says; returns z (n,): an array or list of any numbers, also (n, 1) or (1, n); a tuple
        whose first item is z; a dictionary with the key "z" or "x"; an object with the attribute ``z`` or ``x``; a
        :class:`Solution`. None, NaN, other shapes, complex, masked and missing numbers are failures, and so is any
        exception. A count under ``iterations``, ``num_iter`` or ``nit`` is kept.
    tolerance
        Largest residual that counts as solved [-].
    takes
        "arrays": function(M, q), two arrays (n, n) and (n,). "lcp": function(problem), an :class:`Lcp`. "problem":
        the same with the problem as it was posed, such as a :class:`ContactProblem`, whose unknowns z are those of its
        ``lcp()``. "" (default): "lcp" for a function that needs one argument, "arrays" for one that needs two; of an
        object with ``solve`` "problem" if it has ``refuses`` too, else "lcp". All are copies, which may be written to.
    time_limit
        Seconds for each solve; the function then runs in a process of its own, made by fork (where there is none, a new
        one that must be able to import the function), and is killed when the time is up: status TIME_LIMIT. None: no
        limit, and no process.
    name, version
        For tables; those of the function and of its package if left out.

    Raises
    ------
    ModelError
        For something that cannot be called so, and numbers out of their range.
    """

    function: Any
    tolerance: float = TARGET
    takes: str = ""
    time_limit: float | None = None
    name: str = ""
    version: str = ""
    _workers: list[Worker] = field(default_factory=list, init=False, repr=False, compare=False)
    _answers: list[Answer] = field(default_factory=list, init=False, repr=False, compare=False)  # the last one

    def __post_init__(self) -> None:
        check_tolerance(self.tolerance)
        check_time_limit("time_limit", self.time_limit)
        one_of("takes", self.takes, ("", *TAKES))
        for name in ("name", "version"):
            if not isinstance(getattr(self, name), str):
                raise ModelError(f"{name} is {shown(getattr(self, name))}: expected a text")
        takes = _taken(self.function, self.takes)
        object.__setattr__(self, "takes", takes)
        if not self.name:
            object.__setattr__(self, "name", name_of(self.function))

    def __reduce__(self) -> tuple[Any, ...]:
        given = (self.function, self.tolerance, self.takes, self.time_limit, self.name, self.version)
        return UserSolver, given  # without its processes

    @property
    def model(self) -> str:
        """What an object says that it solves instead of the problem."""
        return str(getattr(self.function, "model", "")) if hasattr(self.function, "solve") else ""

    @property
    def last(self) -> Answer | None:
        """What the function answered to its last call, with the time it took."""
        return self._answers[-1] if self._answers else None

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """What the object says that ``function`` is; a function takes every problem that comes as it asks for it."""
        if self.takes != "problem" and (reason := no_cones(self, problem)):
            return f'{reason}. takes is "{self.takes}"; {CONES}'
        asked_for = getattr(self.function, "refuses", None)
        if not callable(asked_for):
            return ""
        try:
            return str(asked_for(copy.deepcopy(problem)) or "")
        except Exception as error:
            return f"refuses() raised {type(error).__name__}: {error}"

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """The point that the function returns, judged; the origin with the reason where it returns none.

        problem: an :class:`Lcp`, a :class:`ContactProblem` or another problem that is posed as one. guess: the
        solution of a similar problem to start from, or None.
        """
        check_guess(guess)
        if not isinstance(problem, Lcp):
            problem = posed(problem)
            if self.takes != "problem":
                return problem.solve_by(self, guess)
        answer = self.ask(problem, guess)
        if answer.z is None:
            return _failed(problem, self.name, answer)
        claim, status, message = answer.claim, Status.WRONG, ""
        certificate = active = None
        if claim is not None:
            certificate, active = _like(answer.z, claim.certificate), _like(answer.z, claim.active)
            if claim.status in HONEST:
                status, message = claim.status, str(claim.message)[:LONGEST]
            elif claim.status not in CLAIMED:
                status = Status.NUMERICAL_FAILURE
        judged = accept(
            problem,
            answer.z,
            tolerance=self.tolerance,
            status=status,
            iterations=answer.iterations,
            route=self.name,
            message=message,
            certificate=certificate,
        )
        judged = self._told_wrong(problem, judged)
        return judged if active is None else replace(judged, active=(active == 1).astype(np.int64))

    def _told_wrong(self, problem: Lcp | PosedProblem, judged: Solution) -> Solution:
        """The verdict with what the user may have meant, where the point is called wrong."""
        if judged.status is not Status.WRONG:
            return judged
        hint = near_miss(problem, judged.z, self.tolerance)
        error = f"returned a z of residual {judged.residual:.1e}, tolerance {self.tolerance:.1e}"
        error = f"{error}; {hint}" if hint else error
        self._answers[:] = [replace(answer, error=error) for answer in self._answers]  # for who asks what went wrong
        return replace(judged, message=f"wrong: {self.name} {error}")

    def ask(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Answer:
        """What the function answers, not yet judged.

        problem: an :class:`Lcp`, a :class:`ContactProblem` or another problem that is posed as one. guess: the
        solution of a similar problem to start from, or None.
        """
        answer = self._asked(problem, guess)
        self._answers[:] = [answer]
        return answer

    def _asked(self, problem: Lcp | PosedProblem, guess: Solution | None) -> Answer:
        if problem.size == 0:  # steppers pose such problems too; few functions bear them
            return Answer(np.zeros(0), seconds=0.0)
        lent = _lent(problem, guess, self.takes, self.function)
        seconds = self.time_limit
        if limited():
            seconds = min(remaining(), seconds or float("inf"))
        if seconds is None:
            return asked(self.function, lent, problem.size)
        if seconds <= 0.0:
            return Answer(None, "the time was up before it began", expired=True)
        try:
            worker = self._workers.pop() if self._workers else Worker(self.function)
        except Exception as error:  # no fork, and a function that cannot be imported by name
            return Answer(None, f"cannot run in a process of its own: {type(error).__name__}: {error}")
        answer = worker.ask(lent, problem.size, seconds)
        if worker.alive:
            self._workers.append(worker)
        return answer


def _lent(problem: Any, guess: Solution | None, takes: str, function: Any) -> tuple[Any, ...]:
    """The arguments of a call: copies, that may be written to."""
    if takes == "arrays":
        return problem.M.copy(), problem.q.copy()
    lent = copy.deepcopy(problem)
    return (lent, copy.deepcopy(guess)) if hasattr(function, "refuses") else (lent,)


def _like(z: FloatArray, part: Any) -> Any:
    """A part of a Solution that belongs to each unknown, if it does."""
    return part if part is not None and np.shape(part) == z.shape else None


def _failed(problem: Any, name: str, answer: Answer) -> Solution:
    """The origin, as the failure that it is even where z = 0 happens to be the solution."""
    z = np.zeros(problem.size)
    status = Status.TIME_LIMIT if answer.expired else Status.NUMERICAL_FAILURE
    words = "time limit" if answer.expired else "numerical failure"
    return Solution(z, problem.slack(z), status, problem.residual(z), 0, name, f"{words}: {name} {answer.error}")


def is_ours(solver: object) -> bool:
    """Whether it is a solver of this package, by its class: not one derived from it."""
    return type(solver).__module__.startswith("lcpflex.solvers.") and hasattr(solver, "refuses")


def as_solver(solver: Any, tolerance: float = TARGET, name: str = "") -> Any:
    """The solver itself if it is one of this package, else an :class:`UserSolver` with it.

    tolerance: of one that does not tell its own. Raises ModelError for what is no solver.
    """
    if is_ours(solver):
        return solver
    if isinstance(solver, type):
        raise ModelError(
            f"solver is the class {solver.__name__}: expected an object of it, such as {solver.__name__}()"
        )
    return UserSolver(solver, own_tolerance(solver, tolerance), name=name)


def own_tolerance(solver: Any, otherwise: float) -> float:
    """The tolerance that a solver states, if it is one that can be."""
    stated = getattr(solver, "tolerance", None)
    try:
        check_tolerance(stated)  # type: ignore[arg-type]
    except ModelError:
        return otherwise
    return float(stated)  # type: ignore[arg-type]


def own_part(solver: Any) -> UserSolver | None:
    """The solver of the user's that a solver, with or without a limit of time, is made of."""
    inner = getattr(solver, "solver", solver) if is_ours(solver) else solver
    return inner if isinstance(inner, UserSolver) else None


def named_solvers(given: Any) -> dict[str, Any]:
    """Solvers by name: of a mapping, of one solver or callable, or of a sequence of them."""
    if isinstance(given, Mapping) and given:
        return {str(name): as_solver(solver, name=str(name)) for name, solver in given.items()}
    listed = list(given) if isinstance(given, (list, tuple, Mapping)) else [given]
    if not listed:
        raise ModelError("what was given is empty, expected at least one")
    named: dict[str, Any] = {}
    for solver in listed:
        ready = as_solver(solver)
        name = first = name_of(solver)
        count = 1
        while name in named:
            count += 1
            name = f"{first} {count}"
        named[name] = ready
    return named


def name_of(solver: Any) -> str:
    """What a solver is called in tables."""
    known = getattr(solver, "name", None) if is_ours(solver) else getattr(solver, "__name__", None)
    if known == "<lambda>":
        known = "own solver"
    return known if isinstance(known, str) and known else type(solver).__name__


def _taken(function: Any, takes: str) -> str:
    """Which arguments the function is to be given; refuses what cannot be called with any."""
    if callable(getattr(function, "solve", None)):
        return takes or ("problem" if hasattr(function, "refuses") else "lcp")
    if not callable(function):
        text = type(function).__name__
        raise ModelError(f"solver: an object of type {text} was given, {_EXPECTED}")
    if takes:
        return takes
    try:
        parameters = list(inspect.signature(function).parameters.values())
    except (TypeError, ValueError):  # compiled functions of other languages do not tell
        return "arrays"
    places = [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    needed = [p for p in places if p.default is p.empty]
    more = any(p.kind is p.VAR_POSITIONAL for p in parameters)
    bound = [p for p in parameters if p.kind is p.KEYWORD_ONLY and p.default is p.empty]
    if len(needed) > 2 or bound or (not places and not more):
        raise ModelError(f"solver: {name_of(function)[:60]} needs {len(needed) + len(bound)} arguments, {_EXPECTED}")
    if len(needed) == 2 or (more and len(places) < 2 and not needed) or (len(places) > 1 and places[1].name == "q"):
        return "arrays"
    return "lcp"
