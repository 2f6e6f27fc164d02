"""Factors and modes of a solid of 3e4 degrees of freedom: SuperLU, and PARDISO where it is installed."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import cache

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.fem import pardiso, sparse_factor
from lcpflex.bodies.fem.sparse_factor import Factor, positive_factor
from lcpflex.bodies.reduction.eigenmodes import FreeMesh
from lcpflex.bodies.spatial.elastic import ElasticMesh
from tests import solids

CELLS = (30, 18, 16)
MODES = 40


@cache
def mesh() -> ElasticMesh:
    return lf.SpatialMatrices(**solids.block((0.3, 0.18, 0.16), CELLS, "hex1"))._elastic()


def seconds(job: Callable[[], object]) -> float:
    began = time.perf_counter()
    job()
    return time.perf_counter() - began


@cache
def factor(large: float) -> Factor:
    """Of what is held at three nodes."""
    held = mesh()
    free = np.arange(9, len(held.rank))
    sparse_factor.LARGE, before = large, sparse_factor.LARGE
    try:
        return positive_factor(held.stiffness[free][:, free].tocsc(), held.rank[free])
    finally:
        sparse_factor.LARGE = before


@cache
def free(large: float) -> FreeMesh:
    sparse_factor.LARGE, before = large, sparse_factor.LARGE
    try:
        return FreeMesh(mesh().mass, mesh().stiffness, mesh().rigid, mesh().rank)
    finally:
        sparse_factor.LARGE = before


@pytest.mark.skipif(not pardiso.is_there(), reason="pypardiso is not installed: pip install 'lcpflex[large]'")
def test_pardiso_and_superlu(interleave: Callable[..., Mapping[str, float]], report: Callable[[str], None]) -> None:
    right = np.random.default_rng(1).standard_normal((len(mesh().rank) - 9, 32))
    ours, theirs = 0.0, np.inf  # operations from which PARDISO is taken: always, never
    medians = interleave(
        {
            "PARDISO, factor": lambda: seconds(lambda: factor.__wrapped__(ours)),
            "SuperLU, factor": lambda: seconds(lambda: factor.__wrapped__(theirs)),
            "PARDISO, 32 right sides": lambda: seconds(lambda: factor(ours).solve(right)),
            "SuperLU, 32 right sides": lambda: seconds(lambda: factor(theirs).solve(right)),
            "PARDISO, 40 modes by blocks": lambda: seconds(lambda: free(ours).modes(MODES)),
            "SuperLU, 40 modes": lambda: seconds(lambda: free(theirs).modes(MODES)),
        },
        rounds=3,
    )
    times = list(medians.values())
    report(
        "3e4 degrees of freedom in space: SuperLU takes "
        + ", ".join(
            f"{b / a:.1f} times as long ({what})"
            for a, b, what in zip(times[::2], times[1::2], ("factor", "32 right sides", "40 modes"), strict=True)
        )
    )
    assert times[1] > 1.5 * times[0]
    assert times[3] > 1.5 * times[2]
