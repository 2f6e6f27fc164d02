"""Block Gauss-Seidel for planar friction against Siconos' own, at the residual that Siconos reached."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from lcpflex.solvers import ContactProblem
from lcpflex.solvers.contact.sweeps import block_gauss_seidel
from lcpflex.solvers.lcp.lemke import lemke_workspace

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
    """The compiled iteration from zero forces, certificate included."""
    lcp, contacts = problem.lcp(), len(problem.friction)
    n, tangent_of = lcp.size, contacts + np.arange(contacts)
    forces, states = np.zeros(2 * contacts), np.zeros(contacts, dtype=np.int64)
    z, point, (table, basis) = np.zeros(n), np.zeros(n), lemke_workspace(n)
    data = (*problem._data[:3], tangent_of, *lcp._data)

    def solve() -> int:
        forces[:] = 0.0
        return block_gauss_seidel(*data, forces, states, z, point, table, basis, tolerance, 20_000)[0]

    assert solve() == 0
    assert lcp.residual(z) <= tolerance
    return solve
