"""Tangent stiffness at rest: how forces change with the place, constraint forces of fixed size included."""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.model.planar import N_RIGID
from lcpflex.statics.balance import Balance
from lcpflex.statics.scales import Scales

__all__ = ["tangent_stiffness"]

SHARE = 6e-6  # of the extent of the body: displacement of a difference, the cube root of the rounding


def tangent_stiffness(balance: Balance, scales: Scales, q: FloatArray, p: FloatArray) -> FloatArray:
    """K (ndof, ndof) = -d(h + rows^T p)/dq at q, with the contacts found last and their multipliers p constant.

    Central differences: about ten digits of what changes over the extent of a body.
    """
    n = len(q)
    K = np.empty((n, n))
    dof = balance.model.bodies.dof
    body = np.searchsorted(dof, np.arange(n), side="right") - 1
    step = SHARE * scales.extent[body] / scales.arm
    for i in range(n):
        ahead, behind = q.copy(), q.copy()
        ahead[i] += step[i]
        behind[i] -= step[i]
        K[:, i] = (balance.pull(behind, p) - balance.pull(ahead, p)) / (ahead[i] - behind[i])
    for b in range(len(dof) - 1):  # linear springs of modes are known: nothing of theirs is to be lost
        modes = np.arange(dof[b] + N_RIGID, dof[b + 1])
        own = balance.model.bodies.stiffness[modes - N_RIGID * (b + 1)]
        linear = np.abs(K[modes, modes] - own) <= 1e-7 * np.abs(own)
        K[modes[linear], modes[linear]] = own[linear]
    return K
