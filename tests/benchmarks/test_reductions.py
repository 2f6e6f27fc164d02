"""Reducing a mesh: our order of elimination and one factor, against eigsh of scipy as it comes."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import cache

import numpy as np
from scipy.sparse.linalg import eigsh

from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.fem import meshes
from lcpflex.bodies.reduction.component_modes import craig_bampton, free_interface, residual_compliance

MODES = 20
SHIFT = -1e6  # [rad^2/s^2] below zero, without which the factor of a free body is singular


@cache
def plate(nx: int = 200, ny: int = 100) -> Continuum:
    """2e4 nodes."""
    return Continuum(meshes.rectangle(2.0, 1.0, nx, ny, order=1), 7800.0, 2e11, 0.3)


def seconds(job: Callable[[], object]) -> float:
    began = time.perf_counter()
    job()
    return time.perf_counter() - began


def test_reductions_of_2e4_nodes(interleave: Callable[..., Mapping[str, float]], report: Callable[[str], None]) -> None:
    model = plate()
    mesh = model.finite_elements()
    contact = mesh.sets["left"][:100]
    medians = interleave(
        {
            "free interface, 20 modes": lambda: seconds(lambda: free_interface(model, MODES)),
            "scipy eigsh, default factor": lambda: seconds(
                lambda: eigsh(mesh.stiffness, k=MODES + 3, M=mesh.mass, sigma=SHIFT, v0=np.ones(len(mesh.dofs)))
            ),
            "Craig-Bampton, 100 nodes, 20 modes": lambda: seconds(lambda: craig_bampton(model, contact, MODES)),
            "residual compliance, the same": lambda: seconds(lambda: residual_compliance(model, contact, MODES)),
        },
        rounds=3,
    )
    free, peer, *_ = medians.values()
    report(f"2e4 nodes: eigsh takes {peer / free:.1f} times as long as free_interface")
    assert peer > 1.2 * free
