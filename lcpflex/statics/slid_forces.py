"""Forces at a place of rest where contacts have slid on the way from the rest before.

Balance may leave friction open, as below a block that a drive holds. The law does not where a contact has slid by s:

    lambda_T = -mu lambda_N s / |s|

Such a contact has its normal force as the only unknown, along W_N - mu W_T s / |s|; the others are shared as before.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lcpflex.jit.kernel import FloatArray
from lcpflex.statics.balance import Configuration
from lcpflex.statics.scales import Scales
from lcpflex.statics.shared_forces import SharedForces, shared_forces

__all__ = ["forces_after_slip"]

SLID = 1e-9  # of the size: less is no slip


def forces_after_slip(
    at: Configuration,
    slip: FloatArray,
    scales: Scales,
    closed: NDArray[np.bool_],
    unit: FloatArray,
    scale: float,
    acting: Callable[[FloatArray], FloatArray],
) -> SharedForces | None:
    """As :func:`lcpflex.statics.shared_forces.shared_forces`, with the ``slip`` (m,) [m] of each tangential row.

    Where no forces of that kind balance the loads, as after a contact slid one way and back, those of balance alone.
    """
    ratio = _ratios(at, slip, SLID * scales.size)
    bound = (ratio != 0.0).reshape(-1, at.d).any(axis=1).repeat(at.d)
    if not bound.any():
        return shared_forces(at, scales, closed, unit, scale, acting)
    first = at.n_joint + at.n_contacts
    keep = np.concatenate([np.ones(first, bool), ~bound])
    rows = at.rows.copy()
    np.add.at(rows, at.n_joint + at.tangent, ratio[:, None] * at.rows[first:])

    def every(p: FloatArray) -> FloatArray:
        """Multipliers of all rows from those of the rows that are kept."""
        whole = np.zeros(len(at.rows))
        whole[keep] = p
        whole[first:][bound] = (ratio * whole[at.n_joint + at.tangent])[bound]
        return whole

    bare = replace(at, rows=rows[keep], tangent=at.tangent[~bound])
    found = shared_forces(bare, scales, closed, unit[keep], scale, lambda p: acting(every(p)))
    if found is None:
        return shared_forces(at, scales, closed, unit, scale, acting)
    unique, sticks = np.ones(len(at.rows), bool), np.zeros(len(at.tangent), bool)
    unique[keep], sticks[~bound] = found.unique, found.sticks
    unique[first:][bound] = unique[at.n_joint + at.tangent][bound]
    return SharedForces(every(found.p), unique, found.pressed, sticks)


def _ratios(at: Configuration, slip: FloatArray, least: float) -> FloatArray:
    """(m,) of friction to normal force of what slid by more than ``least`` [m]; 0 of all others."""
    each = slip.reshape(-1, at.d)
    size = np.linalg.norm(each, axis=1, keepdims=True)
    way = np.where(size > least, each / np.where(size > 0.0, size, 1.0), 0.0)
    return np.asarray(-at.friction[at.tangent] * way.ravel())
