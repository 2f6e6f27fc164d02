"""What is large and small in a scene: tolerances that nobody has set follow it.

    length L    extent of the largest body [m]
    speed  V    the larger of sqrt(g L) / pi and the fastest initial speed of a body [m/s]; with neither gravity nor
                initial motion L in the duration of the run
    mass   M    of all bodies [kg]
    reach  R    largest coordinate of a body, and radius of a circle with the distance of its centre, at the start [m]

A pendulum of 1 m swings once in a second, there and back in two: sqrt(g L) / pi is .997 m/s for L = 1 m, so that
numbers in metres and seconds keep their meaning in scenes of that size. In other units, and in a scene of another size
whose motion is similar, L, V and M change as lengths, speeds and masses do, and every tolerance with them.
Rounding alone does not follow the bodies: a gap is a difference of places, which are known to 2.2e-16 R. So no gap
tolerance is finer than a multiple of that.
Of a user's own system, of which only numbers are known, L, V and M are 1: tolerances are in its own units.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.model.layout import PLANE, dimension, place_offsets, sums_of_contacts
from lcpflex.steppers.system import System

__all__ = ["SUNK", "Scales", "absolute_tolerance", "given_or", "scales_of", "usual_state"]

EPS = 2.0**-52
GAP = 1e-9  # of the length: gaps up to that are closed
ROUNDED = 10.0 * EPS  # of the reach: no gap tolerance is finer
LOCATED = 3e4 * EPS  # of the reach, where the instants of impacts are sought: gaps to a thousandth of the tolerance
EVENTS = 1e5  # in the time V / L: no more can be located one by one
FEW_EVENTS = 1e-2  # of the duration takes the place of that time where V has come from it
INSTANT = 1e-9  # of the time in which the length is passed, at most of the duration: the shortest step
RESOLVED = 1e-13  # of the duration: no step is shorter, times would not tell it from none
ABSOLUTE = 1e-2  # of the relative tolerance, times what is usual: the absolute one
SUNK = 1e-3  # of the length: penetration and drift of joints that a result calls large
USUAL = 1e-6  # relative tolerance that counts for it where it is 0


class Scales(NamedTuple):
    """Length [m], speed [m/s] and mass [kg] that are usual in a scene; reach [m] and pace [1/s]."""

    length: float
    speed: float
    mass: float
    reach: float = 0.0
    pace: float = 1.0

    def gap(self, given: float | None, located: bool = False) -> float:
        """Gaps up to this count as closed [m]; ``located``: of a run that seeks the instants at which they close."""
        if given is not None:
            return given
        return max(GAP * self.length, (LOCATED if located else ROUNDED) * self.reach)

    def most_events(self, given: float | None) -> float:
        """Events a second that are followed one by one."""
        return EVENTS * self.pace if given is None else given

    def shortest(self, duration: float) -> float:
        """The shortest step [s] of a run over ``duration`` [s]: at this speed a body moves by a closed gap."""
        return max(INSTANT * min(self.length / self.speed, duration), RESOLVED * duration)


def scales_of(system: System, duration: float) -> Scales:
    """The scales of a scene that is simulated over ``duration`` [s]."""
    if not system.size > 0.0:
        return Scales(1.0, 1.0, 1.0)
    bodies, u = system.model.bodies, system.u
    length = system.size
    size = dimension(bodies)
    speed = math.sqrt(float(np.linalg.norm(system.model.loads.gravity)) * length) / math.pi
    for first, last, mass in zip(bodies.dof[:-1], bodies.dof[1:], bodies.mass, strict=True):
        turns = first + size.components
        modal = float(np.linalg.norm(u[first + size.rigid : last])) / math.sqrt(mass)
        spin = float(np.linalg.norm(u[turns : first + size.rigid]))
        speed = max(speed, float(np.linalg.norm(u[first:turns])) + length * spin + modal)
    pace = speed / length or 1.0 / (FEW_EVENTS * duration)
    return Scales(length, speed or length / duration, float(bodies.mass.sum()), _reach(system), pace)


def _reach(system: System) -> float:
    """The largest coordinate of which gaps are made, at the start [m]."""
    points, contacts, bodies = system.model.points, system.model.contacts, system.model.bodies
    size = dimension(bodies)
    frames = np.abs(system.q[place_offsets(bodies)[:-1, None] + np.arange(size.components)])
    center = contacts.feature_point[:, 0]
    lengths = np.hypot(*points.place[center].T) if size is PLANE else np.linalg.norm(points.place[center], axis=1)
    away = np.where(points.body[center] < 0, lengths, 0.0)
    radius = np.abs(contacts.feature_radius)
    circles = (away + radius)[radius > 0.0]
    return system.size + max(float(frames.max()), float(circles.max(initial=0.0)))


def usual_state(system: System, scales: Scales) -> FloatArray:
    """What is usual of each coordinate and each velocity.

    L and V of places, 1 and V / L of angles, L sqrt(m) and V sqrt(m) of modal coordinates of a body of mass m.
    """
    places, speeds = np.ones(len(system.q)), np.ones(len(system.u))
    if system.size > 0.0:
        bodies = system.model.bodies
        size = dimension(bodies)
        for usual, offsets, rigid in ((places, place_offsets(bodies), size.places), (speeds, bodies.dof, size.rigid)):
            for first, last, mass in zip(offsets[:-1], offsets[1:], bodies.mass, strict=True):
                usual[first : first + size.components] = scales.length
                usual[first + rigid : last] = scales.length * math.sqrt(mass)
    return np.concatenate((places, speeds * (scales.speed / scales.length)))


def absolute_tolerance(given: float | None, rtol: float, system: System, scales: Scales, laws: int = -1) -> FloatArray:
    """Absolute tolerance of the state and, with ``laws`` >= 0, of three works and of the impulses of each law.

    Given, it is the same for all. Else ``ABSOLUTE rtol`` times what is usual: see ``usual_state``, M V^2 and M V.
    """
    speed, mass = scales.speed, scales.mass
    usual = usual_state(system, scales)
    if laws >= 0:
        usual = np.concatenate(
            (usual, np.full(3, mass * speed**2), np.full(sums_of_contacts(system.model) * laws, mass * speed))
        )
    return np.full(len(usual), given) if given is not None else ABSOLUTE * (rtol or USUAL) * usual


def given_or(given: float | None, usual: float) -> float:
    """What the user has set, or ``usual``."""
    return usual if given is None else given
