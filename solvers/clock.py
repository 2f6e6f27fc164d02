"""The time a solve may take: set around it, looked at by the solvers between their iterations.

Kernels cannot look at a clock. Where there is a limit they are called with limits of iterations that grow fourfold,
each time from the beginning: what ends in time is to the bit what it is without a limit, at a third more of time.
Without a limit nothing of this happens.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace
from time import perf_counter
from typing import TypeVar

from lcpflex.errors import ModelError, in_range
from lcpflex.solvers.attention import Ear
from lcpflex.solvers.problem import Solution, Status

__all__ = ["check_time_limit", "expired", "grown", "limited", "out_of_time", "remaining", "within"]

FIRST = 1e-3  # seconds for which the first, small limit of iterations should last, at FLOPS operations a second
FLOPS = 1e9
GROWTH = 4  # of the limit of iterations from one call to the next
LEAST = 1.5  # growth below which another call is not worth its while
LONGEST = 1e6  # seconds

Found = TypeVar("Found")

_end: ContextVar[float] = ContextVar("end of the solve", default=float("inf"))


def remaining() -> float:
    """Seconds left to the solve that is under way; inf without a limit, negative after it."""
    end = _end.get()
    return end if end == float("inf") else end - perf_counter()


def limited() -> bool:
    """Whether the solve that is under way has a limit."""
    return _end.get() != float("inf")


def out_of_time() -> bool:
    """Whether the time is up."""
    return limited() and remaining() <= 0.0


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """A solve that may take so long; an earlier end around it stays."""
    token = _end.set(min(_end.get(), perf_counter() + seconds))
    try:
        yield
    finally:
        _end.reset(token)


def check_time_limit(name: str, seconds: float | None) -> float | None:
    """A limit of time [s], or None for none. Raises ModelError for what is no positive number."""
    if isinstance(seconds, bool):
        raise ModelError(f"{name} is {seconds}: expected a number of seconds > 0, or None")
    return None if seconds is None else in_range(name, seconds, 0.0, LONGEST, open_ends=True)


def grown(
    solve: Callable[[int], Found], limit: int, size: int, cut: Callable[[Found], bool], ear: Ear | None = None
) -> tuple[Found, bool]:
    """``solve(limit)``, or what it came to when the time was up; and whether that ended it.

    solve(k): from the beginning, with k iterations at most, each of about size^2 operations. cut: whether the limit of
    iterations ended a solve. ear: what its kernels listen with, if they do.
    """
    if not limited():
        return (solve(limit) if ear is None else ear(lambda: solve(limit))), False
    allowed = min(limit, max(10, int(FIRST * FLOPS / max(size, 1) ** 2)))
    while True:
        began = perf_counter()
        most = allowed
        found = solve(most) if ear is None else ear(lambda most=most: solve(most))  # type: ignore[misc]
        if allowed >= limit or not cut(found):
            return found, False
        left, spent = remaining(), perf_counter() - began
        more = min(limit, GROWTH * allowed, int(allowed * max(left, 0.0) / spent))
        if more < min(limit, LEAST * allowed):
            return found, True
        allowed = more


def expired(solution: Solution) -> Solution:
    """The same point, with the status TIME_LIMIT, of a solve whose time is up; a solved one as it is."""
    if solution.solved:
        return solution
    if solution.status is Status.TIME_LIMIT:
        return solution
    words = f"time limit: {solution.message}" if solution.message else "time limit"
    return replace(solution, status=Status.TIME_LIMIT, message=words)
