"""Block Gauss-Seidel for planar friction against Siconos' own, at the residual that Siconos reached."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from lcpflex.solvers import ContactProblem
from lcpflex.solvers.contact.block_gauss_seidel import ByPivots
from lcpflex.solvers.contact.looks import by_looks
from lcpflex.solvers.contact.system import ContactSystem

COUNT = 8


@pytest.mark.parametrize("contacts", [10, 20, 40, 60])
def test_not_slower_than_siconos(
    scattered: Callable[[int, int], ContactProblem],
    per_call: Callable[..., float],
    siconos_solver: Callable[..., list[dict[str, Any]]],
    report: Callable[[str], None],
    contacts: int,
) -> None:
    problems = [scattered(contacts, seed) for seed in range(COUNT)]
    order = np.arange(2 * contacts).reshape(2, contacts).T.ravel()  # normal, tangent of each contact in turn
    arrays: dict[str, Any] = {}
    for i, problem in enumerate(problems):
        arrays |= {f"M_{i}": problem.dense()[np.ix_(order, order)], f"q_{i}": problem.free[order]}
        arrays[f"mu_{i}"] = problem.friction
    theirs = siconos_solver("gauss-seidel", 1e-10, **arrays)
    ratios, reached = [], []
    for peer, problem in zip(theirs, problems, strict=True):
        z = problem.unknowns(*np.split(np.array(peer["point"])[np.argsort(order)], 2))
        reached.append(problem.residual(z))
        ratios.append(peer["seconds"] / per_call(_ours(problem, float(np.clip(reached[-1], 1e-14, 1e-6)))))
    report(
        f"Siconos / block Gauss-Seidel, {contacts:3d} contacts, residual {statistics.median(reached):.0e} "
        f"{statistics.median(ratios):8.2f}"
    )
    assert statistics.median(ratios) >= 1.0


def _ours(problem: ContactProblem, tolerance: float) -> Callable[[], object]:
    """The iteration from zero forces, certificate included."""
    alike = problem.balanced()
    system, finish, none = ContactSystem(alike, alike.dense()), ByPivots(alike, None), np.zeros(len(problem.free))

    def solve() -> float:
        system.take(none)
        return by_looks(system, alike.residual, tolerance, 20_000, finish=finish).residual

    assert solve() <= tolerance
    return solve
