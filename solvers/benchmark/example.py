"""What a problem of the gallery is: the problem, how it is built, and what is known of its answer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.problem import Lcp, Status

__all__ = ["Example", "planted"]


@dataclass(frozen=True, slots=True, eq=False)
class Example:
    """A problem whose answer is known, at least in part.

    kind: "symmetric" (M symmetric and positive semidefinite), "semidefinite" (positive semidefinite, not symmetric),
    "friction" (planar Coulomb contact), "cone" (Coulomb contact in space), "P" (all principal minors of M positive) or
    "general".
    outcome: SOLVED and NOT_UNIQUE if a solution exists, INFEASIBLE or NO_SOLUTION if none does; None if unknown.
    z (n,): a solution, of ``problem.lcp()`` for a planar contact problem. unique: what all solutions share with it:
    "z", "motion" (w, or the contact velocities of a contact problem) or "" (nothing that is known).
    certificate (n,): u >= 0 with M^T u <= 0 and q.u < 0 where the outcome is INFEASIBLE.
    """

    name: str
    problem: Lcp | ContactProblem | SpatialContactProblem
    kind: str
    outcome: Status | None
    z: FloatArray | None = None
    unique: str = ""
    certificate: FloatArray | None = None

    @property
    def lcp(self) -> Lcp:
        """The problem as an LCP; in its three-unknown form if it is one of contact."""
        return self.problem if isinstance(self.problem, Lcp) else self.problem.lcp()

    @property
    def solvable(self) -> bool:
        """Whether a solution is known to exist."""
        return self.outcome is Status.SOLVED or self.outcome is Status.NOT_UNIQUE


def planted(
    rng: np.random.Generator, M: FloatArray, active: float = 0.4, degenerate: float = 0.1
) -> tuple[FloatArray, FloatArray]:
    """(q, z), (n,) each, such that z solves the problem: z and w are drawn, and q = w - M z.

    active: expected share of z > 0; degenerate: share of pairs with z = w = 0.
    """
    draw, size = rng.random(len(M)), rng.uniform(0.1, 1.0, len(M))
    z = np.where(draw < active, size, 0.0)
    w = np.where(draw >= active + degenerate, size, 0.0)
    return w - M @ z, z
