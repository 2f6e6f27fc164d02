"""Tolerances of the numbers of a state, where an integrator takes q and u as numbers.

Of quaternions no number is small against itself: a rotation is wrong by twice what they are wrong by, whatever they
are. So their tolerance is half that of an angle of 1 rad.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.steppers.scales import Scales, absolute_tolerance, usual_state
from lcpflex.steppers.system import System

__all__ = ["as_velocities", "tolerance_of_numbers", "usual_numbers"]


def usual_numbers(system: System, scales: Scales) -> FloatArray:
    """What is usual of the nq numbers of a configuration and of each velocity: see ``usual_state``."""
    usual = usual_state(system, scales)
    usual[: len(system.q)] *= _share(system)
    return usual


def tolerance_of_numbers(
    given: float | None, rtol: float, system: System, scales: Scales, laws: int = -1
) -> FloatArray:
    """Absolute tolerance of nq numbers, of velocities and of what follows them: see ``absolute_tolerance``.

    Of a quaternion's numbers half of ``rtol`` is added, for the size that a rotation counts as: 1 rad.
    """
    tolerance = absolute_tolerance(given, rtol, system, scales, laws)
    share = _share(system)
    tolerance[: len(system.q)] *= share
    tolerance[: len(system.q)][share < 1.0] += 0.5 * rtol
    return tolerance


def as_velocities(system: System, numbers: FloatArray) -> FloatArray:
    """(2, nu) magnitudes of errors of q, as velocities move it in 1 s, and of u, from those of all their numbers."""
    nq, nu = len(system.q), len(system.u)
    moved = np.zeros(nu)
    np.maximum.at(moved, _source(system), numbers[:nq] / _share(system))
    return np.array([moved, numbers[nq : nq + nu]])


def _source(system: System) -> IntArray:
    """(nq,) the velocity that each number of q goes with."""
    if len(system.q) == len(system.u):
        return np.arange(len(system.q))
    frame = np.array([0, 1, 2, 3, 3, 4, 5])
    dof = system.model.bodies.dof
    return np.concatenate(
        [
            np.concatenate((d + frame, np.arange(d + 6, end)))
            for d, end in zip(dof[:-1].tolist(), dof[1:].tolist(), strict=True)
        ]
    )


def _share(system: System) -> FloatArray:
    """(nq,) by how much each number changes at most where that velocity moves it: quaternions by half of an angle."""
    share = np.ones(len(system.q))
    if len(system.q) != len(system.u):
        bodies: Any = system.model.bodies
        for first in bodies.place[:-1].tolist():
            share[first + 3 : first + 7] = 0.5
    return share
