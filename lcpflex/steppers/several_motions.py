"""Steps whose contact problem has solutions with different motions: which was taken, and when first."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.lcp.enumeration import Enumeration

__all__ = ["SeveralMotions"]

APART = 1e-6  # relative distance of two motions
STILL = 1e-9  # relative: slower slip is none
LOOKS = 8  # at problems of one kind: contacts that come to rest flicker between two of them for hundreds of steps


class SeveralMotions:
    """What the doubtful contact problems of a run have turned out to be."""

    def __init__(self) -> None:
        self._first = math.nan
        self._taken: list[tuple[int, str]] = []
        self._looks: dict[str, int] = {}  # how often problems of a kind were looked at

    def remarks(self, work: Workspace, name: Callable[[int], str]) -> list[str]:
        """Look at the problems kept since the last call; a warning if one of them so far had several motions."""
        for row in work.impulses.doubtful[: int(work.impulses.n_doubtful)]:
            if math.isnan(self._first):
                self._look(row)
        work.impulses.n_doubtful = 0
        if math.isnan(self._first):
            return []
        taken = ", ".join(f"{name(law)} {fate}" for law, fate in self._taken)
        return [
            f"several motions were admissible (Painleve's paradox), first in the step from t = {self._first:.9g} s: "
            f"taken was the one in which contact {taken}; a step of another length may take another one"
        ]

    def _look(self, row: FloatArray) -> None:
        n, m = int(row[1]), int(row[2])
        laws, friction, free, delassus, forces = np.split(row[3:], np.cumsum([n, n, m, m * m]))
        problem = ContactProblem(delassus.reshape(m, m), free, friction)
        signs = (*(free[:n] < 0.0), *(forces[:n] > 0.0), *_cannot_stay_closed(problem))
        kind = f"{laws.tolist()} {''.join('01'[bool(sign)] for sign in signs)}"
        looks = self._looks[kind] = self._looks.get(kind, 0) + 1
        if looks > LOOKS:
            return
        found = Enumeration().solve(problem)
        motions = [problem.velocity(np.concatenate(problem.forces(point))) for point in found.solutions]
        size = max((float(np.abs(v).max()) for v in [*motions, free]), default=0.0)
        if not any(np.abs(v - motions[0]).max() > APART * size for v in motions[1:]):
            return
        self._first = float(row[0])
        velocity = problem.velocity(forces[:m])
        slip = dict(zip(problem.tangent.tolist(), velocity[n:].tolist(), strict=True))
        self._taken = [
            (
                int(laws[k]),
                "opens" if forces[k] <= 0.0 else "sticks" if abs(slip.get(k, size)) <= STILL * size else "slides",
            )
            for k in range(n)
        ]


def _cannot_stay_closed(problem: ContactProblem) -> list[bool]:
    """Of each tangent, whether its friction presses more than the normal force lifts: mu |G_NT| > G_NN."""
    G, n = problem.delassus, len(problem.friction)
    return [problem.friction[k] * abs(G[k, n + j]) > G[k, k] for j, k in enumerate(problem.tangent)]
