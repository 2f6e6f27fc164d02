"""Lemke's algorithm on planar friction against quantecon, Drake's Moby and Siconos: kernels and drivers, same matrices.

Ours is the compiled kernel with its perturbation, scaling and the certificate on the original data; a peer's answer
is not checked while the clock runs.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers import ContactProblem, Lcp
from lcpflex.solvers.auto import auto, auto_workspace
from lcpflex.solvers.certificate import natural_residual
from lcpflex.solvers.lcp.lemke import lemke, lemke_workspace

COUNT = 8
FORMS = {"three unknowns": (3, ContactProblem.lcp), "four unknowns": (4, ContactProblem.copositive_lcp)}
Scattered = Callable[[int, int], ContactProblem]
PerCall = Callable[..., float]


def _problems(scattered: Scattered, form: str, contacts: int) -> list[Lcp]:
    """Problems that need pivots."""
    posed = (FORMS[form][1](scattered(contacts, seed)) for seed in range(10 * COUNT))
    return [lcp for lcp in posed if (lcp.q < 0.0).any()][:COUNT]


def _ours(lcp: Lcp) -> Callable[[], object]:
    n, (M, q) = lcp.size, lcp.data
    z, (table, basis) = np.zeros(n), lemke_workspace(n)
    assert lemke(M, q, n, z, table, basis, 1000 + 50 * n)[0] == 0
    assert lcp.residual(z) <= 1e-10
    return lambda: lemke(M, q, n, z, table, basis, 1000 + 50 * n)


def _quantecon(lcp: Lcp) -> Callable[[], object]:
    peer = pytest.importorskip("quantecon.optimize")
    n, (M, q) = lcp.size, lcp.data
    d, tableau, basis, z = np.ones(n), np.empty((n, 2 * n + 2)), np.empty(n, dtype=np.int64), np.empty(n)
    return lambda: peer.lcp_lemke(M, q, d=d, tableau=tableau, basis=basis, z=z)


def _drake(lcp: Lcp) -> Callable[[], object]:
    peer = pytest.importorskip("pydrake.solvers")
    program, solver = peer.MathematicalProgram(), peer.MobyLcpSolver()
    program.AddLinearComplementarityConstraint(lcp.M, lcp.q, program.NewContinuousVariables(lcp.size))
    return lambda: solver.Solve(program, None, None)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("contacts", [1, 2, 5, 13, 25, 50])
@pytest.mark.parametrize("peer", [_quantecon, _drake], ids=["quantecon", "Drake's Moby"])
def test_faster_than_a_peer_in_this_process(
    scattered: Scattered,
    per_call: PerCall,
    report: Callable[[str], None],
    peer: Callable[[Lcp], Callable[[], object]],
    form: str,
    contacts: int,
    request: pytest.FixtureRequest,
) -> None:
    ratios = []
    for lcp in _problems(scattered, form, contacts):
        theirs, ours = peer(lcp), _ours(lcp)
        theirs()
        ratios.append(per_call(theirs) / per_call(ours))
    name = request.node.callspec.id.split("-")[0]
    report(f"{name:16s} / Lemke, {form}, {contacts:3d} contacts {statistics.median(ratios):9.2f}")
    assert statistics.median(ratios) > 1.0


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("contacts", [1, 2, 5, 13, 25, 50])
def test_faster_than_siconos(
    scattered: Scattered,
    per_call: PerCall,
    siconos_solver: Callable[..., list[dict[str, Any]]],
    report: Callable[[str], None],
    form: str,
    contacts: int,
) -> None:
    problems = _problems(scattered, form, contacts)
    arrays = {f"M_{i}": lcp.M for i, lcp in enumerate(problems)} | {f"q_{i}": lcp.q for i, lcp in enumerate(problems)}
    theirs = siconos_solver("lemke", 1e-12, **arrays)
    ratios = [peer["seconds"] / per_call(_ours(lcp)) for peer, lcp in zip(theirs, problems, strict=True)]
    solved = sum(lcp.residual(peer["point"]) <= 1e-10 for peer, lcp in zip(theirs, problems, strict=True))
    report(
        f"{'Siconos':16s} / Lemke, {form}, {contacts:3d} contacts {statistics.median(ratios):9.2f}"
        f"   (it solved {solved} of {len(problems)})"
    )
    assert statistics.median(ratios) > 1.0


@pytest.mark.parametrize("contacts", [13, 25, 50])
def test_last_basis_halves_the_time(
    scattered: Scattered, per_call: PerCall, report: Callable[[str], None], contacts: int
) -> None:
    """A problem that drifts for 60 steps: the compiled default solver of the steppers, cold and from the last basis."""
    rng = np.random.default_rng(contacts)
    first = scattered(contacts, 3)
    drift = rng.standard_normal(len(first.free))
    n = first.lcp().size
    z, (table, basis) = np.zeros(n), auto_workspace(n)
    cold, warm, last, misses = [], [], None, 0
    for step in range(60):
        M, q = replace(first, free=first.free + 1e-3 * step * drift).lcp()._data

        def solve(before: IntArray | None, M: FloatArray = M, q: FloatArray = q) -> tuple[int, int]:
            if before is not None:
                basis[:n] = before
            return auto(M, q, n, z, table, basis, False, before is not None)

        if last is not None:
            cold.append(per_call(lambda solve=solve: solve(None), 1e-3))
            warm.append(per_call(lambda solve=solve, last=last: solve(last), 1e-3))
            misses += solve(last)[1] > 1
        assert solve(None)[0] == 0
        assert natural_residual(M, q, z, n) <= 1e-10
        last = basis[:n].copy()
    report(f"Lemke warm / cold, {contacts:3d} contacts, {misses:2d} of 59 bases changed {sum(warm) / sum(cold):13.2f}")
    assert sum(warm) <= 0.5 * sum(cold)
