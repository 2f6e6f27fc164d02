"""What is known about the point that a solver returns."""

from __future__ import annotations

import enum

__all__ = ["ITERATION_LIMIT", "NUMERICAL_FAILURE", "RAY", "SOLVED", "Status"]

SOLVED, RAY, ITERATION_LIMIT, NUMERICAL_FAILURE = 0, 1, 2, 3  # as plain integers, for kernels


class Status(enum.IntEnum):
    """What is known about the point a solver returns."""

    @property
    def words(self) -> str:
        """The same in lower case, for messages."""
        return self.name.lower().replace("_", " ")

    SOLVED = 0
    """The residual, computed anew from the original M and q, is within the tolerance."""
    RAY = 1
    """Lemke's path ended on a ray. Without rounding, and for copositive-plus M (PSD included), that would mean that no
    solution exists; it is not proved."""
    ITERATION_LIMIT = 2
    """The limit of pivots or iterations was reached first."""
    NUMERICAL_FAILURE = 3
    """The algorithm ended, but its point does not pass the residual test."""
    INACCURATE = 4
    """The residual is above the tolerance, by a factor of 1000 at most."""
    INFEASIBLE = 5
    """No z >= 0 with w >= 0 exists: a certificate u >= 0, M^T u <= 0, q.u < 0 was verified in exact arithmetic."""
    NOT_UNIQUE = 6
    """Solved, and another solution is known: ``Solution.solutions`` holds them."""
    NO_SOLUTION = 7
    """Every active set was refuted in exact arithmetic (exhaustive search)."""
    TIME_LIMIT = 8
    """The time allowed for one solve was up first (:class:`lcpflex.solvers.TimeLimit`)."""
    WRONG = 9
    """A function of the user's own returned a point as a solution, and its residual is above 1000 tolerances."""
    RIGHT_TO_TERMS = 10
    """Right to its terms only: what is left of each contact (or row of an LCP) is within the tolerance of the terms
    that cancel in it, but in at least one more than SOLVED allows of its own load, the velocity that it would have
    without forces. The message names the one that is worst. Numbers too far apart, as masses of 1e12 to 1 that press on
    each other, leave no more digits; a run goes on with such an answer, and says so."""
