"""Principal pivoting against the floor of the trade: one Cholesky factorisation of the whole matrix and one solve.

Both are called from Python; run with OPENBLAS_NUM_THREADS=1 (set here before numpy is loaded where that is possible).
"""

from __future__ import annotations

import statistics
from collections.abc import Callable

import numpy as np
import pytest
from scipy.linalg.lapack import dpotrf, dpotrs

from lcpflex.solvers import ContactProblem
from lcpflex.solvers.lcp.principal_pivoting import principal_pivoting, principal_pivoting_workspace

COUNT = 8


@pytest.mark.parametrize("n", [5, 10, 20, 50, 100, 200])
def test_one_cholesky_of_the_whole_matrix(
    scattered: Callable[[int, int], ContactProblem],
    per_call: Callable[..., float],
    report: Callable[[str], None],
    n: int,
) -> None:
    cold, warm = [], []
    for seed in range(COUNT):
        contacts = scattered(n, seed)
        M, q = np.ascontiguousarray(contacts.dense()[:n, :n]), contacts.free[:n].copy()
        z, (factor, basis) = np.zeros(n), principal_pivoting_workspace(n)
        floor = per_call(lambda M=M, q=q: dpotrs(dpotrf(M)[0], q))
        limit = 100 + 20 * n

        def ours(start: bool, M=M, q=q, z=z, factor=factor, basis=basis, limit=limit) -> tuple[int, int]:  # type: ignore[no-untyped-def]
            return principal_pivoting(M, q, n, z, factor, basis, start, 1e-10, limit)

        assert ours(False)[0] == 0
        cold.append(per_call(lambda ours=ours: ours(False)) / floor)
        nearby = q * (1.0 + 1e-6 * np.cos(np.arange(n)))  # the basis of a problem that has changed a little
        assert ours(False, q=nearby)[0] == 0
        assert ours(True)[0] == 0
        warm.append(per_call(lambda ours=ours: ours(True)) / floor)
    report(
        f"principal pivoting / Cholesky, n = {n:3d}: cold {statistics.median(cold):5.2f}, "
        f"warm {statistics.median(warm):5.2f}"
    )
    if n >= 50:
        assert statistics.median(cold) <= 1.2
        assert statistics.median(warm) <= 0.6
