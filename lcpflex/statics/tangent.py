"""Tangent stiffness at rest: how forces change with the place, constraint forces of fixed size included.

Corners of the patch between two faces are where edges cross. Where these are nearly parallel, as of equal boxes on each
other, a corner runs along them by their length while the bodies turn by next to nothing: its derivative is that of no
motion that is longer. The force of such a corner stays where it is, and the others of the patch hold the bodies.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.model.layout import dimension
from lcpflex.statics.balance import Balance
from lcpflex.statics.scales import Scales

__all__ = ["tangent_stiffness"]

FAR = 100.0  # extents a radian: a contact that moves along its bodies by more stays where it is
SHARE = 6e-6  # of the extent of the body: displacement of a difference, the cube root of the rounding


def tangent_stiffness(balance: Balance, scales: Scales, q: FloatArray, p: FloatArray) -> FloatArray:
    """K (ndof, ndof) = -d(h + rows^T p)/dq at q, with the contacts found last and their multipliers p constant.

    Central differences: about ten digits of what changes over the extent of a body.
    """
    n, rigid = len(scales.arm), dimension(balance.model.bodies).rigid
    dof = balance.model.bodies.dof
    body = np.searchsorted(dof, np.arange(n), side="right") - 1
    step = SHARE * scales.extent[body] / scales.arm
    K = balance.stiffness(q, _staying(balance, scales, q, p, step), step)
    for b in range(len(dof) - 1):  # linear springs of modes are known: nothing of theirs is to be lost
        modes = np.arange(dof[b] + rigid, dof[b + 1])
        own = balance.model.bodies.stiffness[modes - rigid * (b + 1)]
        linear = np.abs(K[modes, modes] - own) <= 1e-7 * np.abs(own)
        K[modes[linear], modes[linear]] = own[linear]
    return K


def _staying(balance: Balance, scales: Scales, q: FloatArray, p: FloatArray, step: FloatArray) -> FloatArray:
    """The multipliers p, without those of crossing edges that move by more than FAR when a body turns."""
    crossing = balance.crossing()
    if not crossing.any():
        return p
    at, dof = balance.again(q), balance.model.bodies.dof
    normals = slice(at.n_joint, at.n_joint + at.n_contacts)
    loose = np.zeros(at.n_contacts, bool)
    for i in (dof[:-1, None] + np.arange(3, 6)).ravel():
        way = np.zeros(len(scales.arm))
        way[i] = step[i]
        ahead, behind = (balance.again(balance.moved(q, sign * way)).rows[normals] for sign in (1.0, -1.0))
        loose |= np.abs((ahead - behind) / scales.arm).max(axis=1) > 2.0 * FAR * step[i]
    loose &= crossing
    return np.where(np.concatenate([np.zeros(at.n_joint, bool), loose, loose[at.tangent]]), 0.0, p)
