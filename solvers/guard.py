"""What others raise, as a solution that is none and says why; and the route of a solver that is made of several."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from lcpflex.errors import LcpflexError
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.problem import Problem, Solution, Status

__all__ = ["ENDED", "FAILED", "guarded", "joined", "words_of"]

ENDED = "ended with"  # in the message of a method that raised
FAILED = " (failed)"  # behind each part of a route that did not settle the problem
LONGEST = 200  # characters of a foreign message

P = TypeVar("P", bound=Problem)


def guarded(name: str, problem: P, tolerance: float, solve: Callable[[], Solution]) -> Solution:
    """What ``solve`` returns; NUMERICAL_FAILURE at z = 0, with the name of the exception, where it raises one.

    scipy, numpy and the backends have exceptions of their own, as "Factor is exactly singular" (RuntimeError). Errors
    of this package pass.
    """
    try:
        return solve()
    except (LcpflexError, KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:  # a panic in Rust is no Exception
        return accept(
            problem,
            np.zeros(problem.size),
            tolerance=tolerance,
            status=Status.NUMERICAL_FAILURE,
            route=name,
            message=f"numerical failure: {name} {ENDED} {words_of(error)}",
        )


def words_of(error: BaseException) -> str:
    """Kind and first line of the message of an exception, cut short; the kind alone where str raises, or is empty."""
    try:
        said = " ".join(str(error).strip().partition("\n")[0].split())
    except Exception:
        said = ""
    words = f"{type(error).__name__}: {said}" if said else type(error).__name__
    return words if len(words) <= LONGEST else f"{words[: LONGEST - 3]}..."


def joined(*parts: Solution) -> str:
    """The route over all parts, in order; those that did not settle the problem are marked as failed."""
    return " > ".join(
        part.route if part.settled or part.route.endswith(FAILED) else part.route + FAILED for part in parts
    )
