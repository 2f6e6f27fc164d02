"""Tangent stiffness at rest: how forces change with the place, constraint forces of fixed size included."""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.model.layout import dimension
from lcpflex.statics.balance import Balance
from lcpflex.statics.scales import Scales

__all__ = ["tangent_stiffness"]

SHARE = 6e-6  # of the extent of the body: displacement of a difference, the cube root of the rounding


def tangent_stiffness(balance: Balance, scales: Scales, q: FloatArray, p: FloatArray) -> FloatArray:
    """K (ndof, ndof) = -d(h + rows^T p)/dq at q, with the contacts found last and their multipliers p constant.

    Central differences: about ten digits of what changes over the extent of a body.
    """
    n, rigid = len(scales.arm), dimension(balance.model.bodies).rigid
    dof = balance.model.bodies.dof
    body = np.searchsorted(dof, np.arange(n), side="right") - 1
    K = balance.stiffness(q, p, SHARE * scales.extent[body] / scales.arm)
    for b in range(len(dof) - 1):  # linear springs of modes are known: nothing of theirs is to be lost
        modes = np.arange(dof[b] + rigid, dof[b + 1])
        own = balance.model.bodies.stiffness[modes - rigid * (b + 1)]
        linear = np.abs(K[modes, modes] - own) <= 1e-7 * np.abs(own)
        K[modes[linear], modes[linear]] = own[linear]
    return K
