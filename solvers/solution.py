"""What a solver answers, and what it is asked: the types that problems and solvers have in common."""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy.typing as npt

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.status import Status

if TYPE_CHECKING:
    from lcpflex.solvers.problem import Lcp

__all__ = ["PROVED", "LcpSolver", "PosedProblem", "Problem", "Solution"]

PROVED = (Status.INFEASIBLE, Status.NO_SOLUTION)


class Problem(Protocol):
    """What :func:`accept` asks of a problem: its size, and how wrong a point is."""

    @property
    def size(self) -> int: ...
    def slack(self, z: npt.ArrayLike) -> FloatArray: ...
    def residual(self, z: npt.ArrayLike, scaled: bool = True) -> float: ...


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """What a solver found: the point, and how far it can be trusted.

    z, w (n,): the point and w = M z + q. residual: that of the problem, scaled, relative to the terms that cancel in w
    (what rounding allows); strict: the same relative to the load alone, which for contacts is the velocity that they
    would have without their forces (what a user cares about): larger, by far where contacts are wedged. iterations:
    pivots or iterations. route: the algorithms tried, in order, failed ones marked. active (n,): which z are basic (0
    or 1), None if the solver has no basis; handing the solution back as the guess of a similar problem starts from
    there (z > 0 would not do: a basic variable may be zero). certificate: the vector u that proves INFEASIBLE, else
    None; proof: the same in integers of these proportions, with which M^T u <= 0 and q.u < 0 hold exactly. keys: name
    of each unknown, for guesses between problems with different contacts. solutions: all that are known, if several.

    status: solved, or why not. message: the same in words, where there is more to say. ended: why the algorithm ended,
    where the status tells how near its point is instead (INACCURATE, RIGHT_TO_TERMS), else None.
    """

    z: FloatArray
    w: FloatArray
    status: Status
    residual: float
    iterations: int
    route: str
    message: str = ""
    active: IntArray | None = None
    certificate: FloatArray | None = None
    keys: tuple[Hashable, ...] | None = None
    solutions: tuple[FloatArray, ...] = ()
    proof: tuple[int, ...] = ()
    strict: float = math.nan
    ended: Status | None = None

    @property
    def solved(self) -> bool:
        """Whether the status is SOLVED or NOT_UNIQUE."""
        return self.status is Status.SOLVED or self.status is Status.NOT_UNIQUE

    @property
    def settled(self) -> bool:
        """Whether nothing more is to be found out: solved, or proved to have no solution."""
        return self.solved or self.status in PROVED


class LcpSolver(Protocol):
    """What all solvers have in common."""

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Why the solver cannot take the problem, as a sentence for its user; empty if it can."""

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """The certified solution of ``problem``, or the best point found with its status.

        guess: the solution of a similar problem. Raises ModelError, with the reason, for a problem it refuses.
        """


class PosedProblem(Problem, Protocol):
    """A problem that an LCP solver takes by way of an :class:`Lcp`: contact with friction, mixed and boxed problems."""

    def lcp(self) -> Lcp:
        """The LCP whose solutions are, or lead to, those of the problem."""

    def solve_by(self, solver: LcpSolver, guess: Solution | None = None) -> Solution:
        """What ``solver`` makes of :meth:`lcp`, as a certified solution of this problem."""
