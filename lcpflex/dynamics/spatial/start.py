"""The projection of a start onto the joints of a spatial scene. See :mod:`lcpflex.dynamics.start`."""

from __future__ import annotations

import numpy as np

from lcpflex.dynamics.spatial.redundancy import DEPENDENT
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.spatial import N_RIGID, SpatialModel

__all__ = ["locking_error", "nearest"]

NEARLY = 1e-5  # as ``DEPENDENT``: errors of assembly up to 1e-3


def nearest(model: SpatialModel, M: FloatArray, J: FloatArray, residual: FloatArray) -> FloatArray:
    """The shortest d, in the metric of M, with J d = residual; redundant rows allowed, and assembled with errors.

    What is independent is decided without masses, as in :mod:`lcpflex.dynamics.spatial.redundancy`: of the rows in
    units of their own size, J D J^T = U diag(s) U^T, the combinations U_1 with s > ``DEPENDENT`` of the largest are
    fulfilled, U_1^T J d = U_1^T residual. What contradictory rows leave is the least in these units.
    """
    if not len(J):
        return np.zeros(len(M))
    scaled, unit = _alike(model, M, J)
    U, s, _ = np.linalg.svd(scaled, full_matrices=False)
    independent = U[:, s * s > DEPENDENT * s.max(initial=0.0) ** 2].T * unit
    rows = independent @ J
    spread = np.linalg.solve(M, rows.T)
    return np.asarray(spread @ np.linalg.solve(rows @ spread, independent @ residual))


def locking_error(model: SpatialModel, M: FloatArray, J: FloatArray) -> float:
    """About the error of assembly that leaves no motion at all where some would be without it; 0.0: there is none."""
    if not len(J):
        return 0.0
    s = np.linalg.svd(_alike(model, M, J)[0], compute_uv=False)
    s = np.sort(s * s / s.max(initial=0.0) ** 2)[::-1]
    kept = int((s > DEPENDENT).sum())
    locked = kept == len(M) and s[kept - 1] < NEARLY
    return float(np.sqrt(s[kept - 1])) if locked else 0.0


def _alike(model: SpatialModel, M: FloatArray, J: FloatArray) -> tuple[FloatArray, FloatArray]:
    """J sqrt(D), each row divided by its size, and 1 / these (r,)."""
    scaled = J * _sizes(model, M, J)
    size = np.sqrt((scaled * scaled).sum(axis=1))
    unit = 1.0 / np.where(size > 0.0, size, 1.0)
    return unit[:, None] * scaled, unit


def _sizes(model: SpatialModel, M: FloatArray, J: FloatArray) -> FloatArray:
    """sqrt(D) (ndof,): 1 of translations, 1/L of rotations, sqrt(m) of modes; L^2: arms of the joints and J/m."""
    dof = model.bodies.dof
    found = np.ones(len(M))
    inertia = np.diag(M)
    for b in range(len(dof) - 1):
        d = int(dof[b])
        moves, turns = J[:, d : d + 3], J[:, d + 3 : d + N_RIGID]
        place = (moves != 0.0).any(axis=1)
        arm = (turns[place] ** 2).sum() / max((moves**2).sum(), np.finfo(float).tiny)
        mass = inertia[d : d + 3].mean()
        found[d + 3 : d + N_RIGID] = 1.0 / np.sqrt(arm + inertia[d + 3 : d + N_RIGID].mean() / mass)
        found[d + N_RIGID : dof[b + 1]] = np.sqrt(mass)
    return found
