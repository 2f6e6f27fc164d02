"""Solvers of contact problems on random ones of rigid bodies, through every way in which a problem is handed to them.

    python -m tests.property.solver_campaign                    # 500 of the plane and 500 of space
    python -m tests.property.solver_campaign --seeds 0:100 --dimension 3 --ways sparse bodies
    python -m tests.property.solver_campaign --one 17 --dimension 2

The judge is that of :mod:`tests.property.random_contacts`, which knows nothing of the solvers.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from lcpflex.jit.struct import allocate
from lcpflex.solvers import Auto, ContactProblem, SpatialContactProblem
from lcpflex.solvers.contact.algebra import IN_SPACE, PLANAR
from lcpflex.solvers.contact.large.memory import BodyContacts, large_memory
from lcpflex.solvers.contact.large.solving import ROOM, solve_large
from lcpflex.solvers.contact.operators.sparse_factor import widen
from lcpflex.solvers.contact.strategy import route_names
from lcpflex.solvers.status import SOLVED
from tests.property.random_contacts import Drawn, FloatArray, draw, miss

__all__ = ["WAYS", "WHOLE", "Answer", "answered", "campaign", "count"]

TOLERANCE = 1e-10  # of what is within
WHOLE = range(500)


@dataclass(frozen=True)
class Answer:
    """What came of one problem: whether it was called solved, and what the judge says."""

    drawn: Drawn
    way: str
    solved: bool
    miss: float
    seconds: float
    route: str

    @property
    def within(self) -> bool:
        """Whether it is right to 1e-10 of the load."""
        return self.miss <= TOLERANCE


def by_delassus(drawn: Drawn) -> tuple[FloatArray, bool, str]:
    """Forces (S n,) by Auto, from the Delassus matrix."""
    return _by_auto(drawn, _matrix(drawn), None)


def by_sparse_delassus(drawn: Drawn) -> tuple[FloatArray, bool, str]:
    """The same where it is sparse."""
    return _by_auto(drawn, sparse.csr_array(_matrix(drawn)), None)


def by_factor(drawn: Drawn) -> tuple[FloatArray, bool, str]:
    """The same from its sparse factor alone."""
    return _by_auto(drawn, None, sparse.csr_array(drawn.condensed[0]))


def _matrix(drawn: Drawn) -> FloatArray:
    J, _ = drawn.condensed
    return J @ J.T


def _by_auto(drawn: Drawn, W: Any, J: Any) -> tuple[FloatArray, bool, str]:
    """In the plane rows are ordered by normals and tangents, and contacts without friction have no tangent."""
    mu, (_, free) = drawn.friction, drawn.condensed
    if drawn.dimension == 3:
        found = Auto().solve(SpatialContactProblem(W, free, mu, factor=J))
        return found.z, found.solved, found.route
    rows = np.concatenate([2 * np.arange(len(mu)), 2 * np.flatnonzero(mu) + 1])
    G = None if W is None else W[rows][:, rows]
    problem = ContactProblem(G, free[rows], mu, factor=None if J is None else J[rows])
    found = Auto().solve(problem)
    forces = np.zeros(drawn.of_contacts)
    forces[rows] = np.concatenate(problem.forces(found.z))
    return forces, found.solved, found.route


def by_bodies(drawn: Drawn) -> tuple[FloatArray, bool, str]:
    """Forces of all rows, those of pins included, by the compiled solver of steppers for many contacts."""
    n, S, rows, mu = len(drawn.friction), drawn.dimension, len(drawn.free), drawn.friction
    first, pins, width = S * np.arange(n), rows - drawn.of_contacts, drawn.white.shape[2]
    problem: Any = allocate(
        BodyContacts, {}, n_contacts=n, n_joints=pins, n_bodies=drawn.bodies, first_contact=0,
        white=drawn.white, row_body=drawn.body, dof=width * np.arange(drawn.bodies + 1), free=drawn.free.copy(),
        terms=drawn.terms, p=np.zeros(rows), normal_row=first, tangent_row=np.where(mu > 0.0, first + 1, -1),
        friction=mu, joint_row=np.arange(S * n, rows), bodies=np.arange(drawn.bodies), slip=np.zeros(n),
    )  # fmt: skip
    memory: Any = large_memory(drawn.bodies, n + pins, drawn.bodies, width, S)
    memory.judged.tolerance = 0.1 * TOLERANCE
    while (status := solve_large(problem, memory, PLANAR if S == 2 else IN_SPACE)) == ROOM:
        widen(memory.op.factor)
    return problem.p, status == SOLVED, route_names(memory.search, memory.attempts)


WAYS: dict[str, Callable[[Drawn], tuple[FloatArray, bool, str]]] = {
    "delassus": by_delassus,
    "sparse": by_sparse_delassus,
    "factor": by_factor,
    "bodies": by_bodies,
}


def answered(drawn: Drawn, way: str) -> Answer:
    """The answer of one way, judged by the numbers that were handed over."""
    began = time.perf_counter()
    forces, solved, route = WAYS[way](drawn)
    seconds = time.perf_counter() - began
    W = _matrix(drawn) if way in ("delassus", "sparse") else None
    return Answer(drawn, way, solved, miss(drawn, forces, W), seconds, route)


def count(answers: Sequence[Answer]) -> dict[str, float]:
    """Problems; of them within 1e-10 and 1e-8, called solved, and called solved though off by more than 1e-6."""
    misses = np.array([one.miss for one in answers])
    solved = np.array([one.solved for one in answers], dtype=bool)
    return {
        "problems": len(answers),
        "within 1e-10": int((misses <= TOLERANCE).sum()),
        "within 1e-8": int((misses <= 1e-8).sum()),
        "solved": int(solved.sum()),
        "wrong": int((solved & (misses > 1e-6)).sum()),
        "median ms": 1e3 * float(np.median([one.seconds for one in answers])),
        "seconds": sum(one.seconds for one in answers),
    }


def campaign(dimension: int, way: str, seeds: Iterable[int]) -> dict[str, float]:
    """The counts of one way; what is not within 1e-10 is printed as it is found."""
    answers = []
    for seed in seeds:
        answers.append(answered(draw(dimension, seed), way))
        if not answers[-1].within:
            print(line(answers[-1]), flush=True)
    counts = count(answers)
    print(f"{dimension}D {way}: " + ", ".join(f"{name} {value:.4g}" for name, value in counts.items()), flush=True)
    return counts


def line(one: Answer) -> str:
    """One answer, in words."""
    drawn = one.drawn
    said = "solved" if one.solved else "not solved"
    return (
        f"  {drawn.dimension}D {one.way} {drawn.seed} ({len(drawn.friction)} contacts, {drawn.bodies} bodies, "
        f"{drawn.kind}): {said}, {one.miss:.1e} in {1e3 * one.seconds:.1f} ms by {one.route}"
    )


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--dimension", type=int, choices=[2, 3])
    parser.add_argument("--seeds", default=f"{WHOLE.start}:{WHOLE.stop}", help="first:last, the last one left out")
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=list(WAYS))
    parser.add_argument("--one", type=int, help="one seed, by all ways")
    options = parser.parse_args()
    first, last = map(int, options.seeds.split(":"))
    for dimension in [options.dimension] if options.dimension else [2, 3]:
        for way in options.ways:
            if options.one is None:
                campaign(dimension, way, range(first, last))
            else:
                print(line(answered(draw(dimension, options.one), way)))


if __name__ == "__main__":
    main()
