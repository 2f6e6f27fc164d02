"""Creep: what friction by a law without states does where Coulomb's law would stick.

The slip is read off the law: at rest it rises steadily with the slip, up to the slip speed at least.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.force_laws import compiled
from lcpflex.force_laws.layout import FRICTION, FRICTION_KIND, LawRow
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import STICK

__all__ = ["CREEP", "creeping", "crept"]

CREEP = 3  # state of a contact in results, beside OPEN, STICK and SLIP
HALVINGS = 40


def creeping(rows: Sequence[LawRow | None], contact: npt.NDArray[Any], state: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """``state`` with CREEP for STICK where the law ``rows[contact]`` is a friction law without states."""
    creeps = np.array([row is not None and not row.bristles for row in rows] or [False])
    found = np.where(creeps[contact] & (state == STICK), CREEP, state)
    return np.asarray(found)


def crept(
    rows: Sequence[LawRow | None], mus: FloatArray, times: FloatArray, state: npt.NDArray[Any], force: FloatArray
) -> tuple[float, ...]:
    """Path [m] that each contact has crept; empty if none has a law. ``state`` (m, nc), ``force`` (m, nc, 2 or 4) [N].

    From instant to instant by the trapezoidal rule, as far as both are creeping.
    """
    if not any(rows):
        return ()
    return tuple(
        _path(row, float(mu), times, state[:, k], force[:, k]) if row else 0.0
        for k, (row, mu) in enumerate(zip(rows, mus, strict=True))
    )


def _path(row: LawRow, mu: float, times: FloatArray, state: npt.NDArray[Any], force: FloatArray) -> float:
    still = state == CREEP
    between = still[1:] & still[:-1]
    if not between.any():
        return 0.0
    speed = np.zeros(len(times))
    speed[still] = _slip(row, mu, force[still])
    return float(np.sum(between * np.diff(times) * 0.5 * (speed[1:] + speed[:-1])))


def _slip(row: LawRow, mu: float, force: FloatArray) -> FloatArray:
    """Slip speeds [m/s] up to the slip speed of the law, by bisection."""
    kinds, p = np.array(row.kinds), np.array(row.parameters)
    normal = np.ascontiguousarray(force[:, 0])
    wanted = np.abs(force[:, 1]) if force.shape[1] == 2 else np.linalg.norm(force[:, 1:], axis=1)
    free = compiled.FRICTION_KINDS[row.kinds[FRICTION_KIND]] == "ambrosio"
    start = row.parameters[FRICTION] if free else 0.0
    low, high = np.full(len(force), start), np.full(len(force), row.slip_speed)
    found, mus = np.empty(len(force)), np.full(len(force), mu)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        compiled.friction_forces(kinds, p, middle, normal, mus, found)
        less = np.abs(found) < wanted
        low, high = np.where(less, middle, low), np.where(less, high, middle)
    return np.asarray(np.where(wanted > 0.0, 0.5 * (low + high), 0.0))
