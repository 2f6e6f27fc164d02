"""Tolerances of the numbers of a state, where an integrator takes q and u as numbers.

Of quaternions no number is small against itself: a rotation is wrong by twice what they are wrong by, whatever they
are. So their tolerance is half that of an angle of 1 rad.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.model.layout import PLANE, dimension, place_offsets
from lcpflex.steppers.scales import Scales, absolute_tolerance, usual_state
from lcpflex.steppers.system import System

__all__ = ["tolerance_of_numbers", "usual_numbers"]


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


def _share(system: System) -> FloatArray:
    """(nq,) by how much each number changes at most where that velocity moves it: quaternions by half of an angle."""
    share = np.ones(len(system.q))
    if dimension(system.model.bodies) is not PLANE:
        for first in place_offsets(system.model.bodies)[:-1].tolist():
            share[first + 3 : first + 7] = 0.5
    return share
