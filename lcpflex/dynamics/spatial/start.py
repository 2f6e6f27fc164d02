"""The projection of a start onto the joints of a spatial scene. See :mod:`lcpflex.dynamics.start`."""

from __future__ import annotations

import numpy as np

from lcpflex.dynamics.spatial.redundancy import DEPENDENT
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.spatial import N_RIGID, SpatialModel

__all__ = ["nearest"]


def nearest(model: SpatialModel, M: FloatArray, J: FloatArray, residual: FloatArray) -> FloatArray:
    """The shortest d, in the metric of M, with J d = residual; redundant rows allowed, and assembled with errors.

    What is independent is decided without masses, as in :mod:`lcpflex.dynamics.spatial.redundancy`: of the rows in
    units of their own size, J D J^T = U diag(s) U^T, the combinations U_1 with s > ``DEPENDENT`` of the largest are
    fulfilled, U_1^T J d = U_1^T residual. What contradictory rows leave is the least in these units.
    """
    if not len(J):
        return np.zeros(len(M))
    scaled = J * _sizes(model, M, J)
    size = np.sqrt((scaled * scaled).sum(axis=1))
    unit = 1.0 / np.where(size > 0.0, size, 1.0)
    U, s, _ = np.linalg.svd(unit[:, None] * scaled, full_matrices=False)
    independent = U[:, s * s > DEPENDENT * s.max(initial=0.0) ** 2].T * unit
    rows = independent @ J
    spread = np.linalg.solve(M, rows.T)
    return np.asarray(spread @ np.linalg.solve(rows @ spread, independent @ residual))


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
