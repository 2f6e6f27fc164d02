"""Step control of time-stepping schemes by doubling: one step of length h against two of h/2.

    |y(2 x h/2) - y(1 x h)| <= atol + rtol |y|   for every coordinate and velocity y,

and no pair has closed unmet (:mod:`lcpflex.steppers.unmet`). Where an impact falls between the ends of the two, their
velocities differ by its jump, so that impacts shorten the step by themselves, down to ``shortest``, where steps are
taken as they come: an error estimate across an impact would mean nothing. One that both pass over is located, a trial
ends there, and a shortest step takes the impact.

Impacts that accumulate end where a pair approaches no faster than a velocity threshold: it is stopped, not reflected.
Source of step doubling: Hairer, Norsett & Wanner 1993, II.4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lcpflex.basics.options import keep_at_least, keep_number, keep_number_or_none
from lcpflex.dynamics.instants import longest_look, time_left
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.configuration import difference, magnitudes
from lcpflex.model.arrays import Model
from lcpflex.steppers.backup import Backup
from lcpflex.steppers.clock import StepClock
from lcpflex.steppers.scales import ABSOLUTE, USUAL, Scales, absolute_tolerance, given_or, scales_of
from lcpflex.steppers.system import System

__all__ = [
    "MOST_STRIKES",
    "SETTLE",
    "AdaptiveStep",
    "Limits",
    "accept",
    "after_impact",
    "after_rejection",
    "doubling_error",
    "end_there",
    "least_interval",
    "next_length",
    "position_tolerance",
    "resume",
    "threshold",
]

PART = 0.01  # of the duration that one step may take, where no limit is given
SETTLE = 4.0  # times what the approach of a pair gains in one shortest step: no faster, it is at rest
MOST_STRIKES = 20  # shortest steps in a row for impacts
ENDED_EARLY = 0.99  # of the length planned: a shorter step was to end at a stop


@dataclass(frozen=True, slots=True)
class AdaptiveStep:
    """Step length by error control: coarse where the motion is smooth, fine across impacts.

    Attributes
    ----------
    rtol, atol
        Error of a step at most atol + rtol |y| in each coordinate and velocity y. atol None: a hundredth of rtol times
        what is usual in the scene, of lengths, angles and velocities each.
    shortest, longest
        Range of the step [s]. Steps at ``shortest`` are not controlled: it bounds the error in the time of an impact.
        The longest is a hundredth of the duration by default, the shortest 1e-9 of it or, where that is less, of the
        time that the speed of the scene takes for its size (:mod:`lcpflex.steppers.scales`).
    velocity_threshold
        Normal velocity [m/s] up to which an approach is stopped instead of reflected (e_N = 0), so that an accumulation
        of impacts ends. None: atol of a speed + rtol times the fastest approach of an impact so far. At least four
        times what a contact gains in a step of length ``shortest`` in any case. A restitution of 0 is not affected.

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    rtol: float = 1e-6
    atol: float | None = None
    shortest: float | None = None
    longest: float | None = None
    velocity_threshold: float | None = None

    def __post_init__(self) -> None:
        keep_number(self, "rtol", 0.0, 1.0)
        keep_number_or_none(self, "atol", 0.0, math.inf, open_ends=True)
        keep_number_or_none(self, "shortest", 0.0, math.inf, open_ends=True)
        keep_number_or_none(self, "velocity_threshold", 0.0, math.inf)
        if self.longest is not None and self.shortest is not None:
            keep_at_least(self, "longest", self.shortest, f"at least shortest = {self.shortest!r} (seconds)")
        elif self.longest is not None:
            keep_at_least(self, "longest", 0.0, "a number > 0 (seconds)", open_end=True)

    def limits(self, system: System, duration: float, interval: float) -> Limits:
        """The numbers for a run over ``duration`` [s] that stores an instant about every ``interval`` [s].

        system: what a scene or a system of the user's own is compiled to.
        """
        # never 0: an instant is stored once, however many steps from it are rejected
        apart = max(interval, least_interval(duration))
        threshold = -1.0 if self.velocity_threshold is None else self.velocity_threshold
        scales = scales_of(system, duration)
        atol = _of_changes(absolute_tolerance(self.atol, self.rtol, system, scales), self.atol, system, scales)
        usual = ABSOLUTE * (self.rtol or USUAL)
        near, slow = given_or(self.atol, usual * scales.length), given_or(self.atol, usual * scales.speed)
        shortest = given_or(self.shortest, min(scales.shortest(duration), self.longest or math.inf))
        longest = given_or(self.longest, max(shortest, PART * duration))
        return Limits(duration, apart, self.rtol, atol, near, slow, shortest, longest, threshold)


def _of_changes(atol: FloatArray, given: float | None, system: System, scales: Scales) -> FloatArray:
    """Tolerances (2 ndof,) of changes of q, in the form of velocities over 1 s, and of u, from those of (q, u)."""
    ndof = len(system.u)
    if len(system.q) == ndof:
        return atol
    of_rates = atol[len(system.q) :]
    return np.concatenate((of_rates if given is not None else of_rates * (scales.length / scales.speed), of_rates))


class Limits(NamedTuple):
    """Numbers of the step control, as a compiled loop takes them."""

    duration: float
    interval: float
    rtol: float
    atol: FloatArray  # (2 ndof,) of changes of q, as velocities over 1 s, and of u
    near: float  # the same, of a length [m]
    slow: float  # and of a speed [m/s]
    shortest: float
    longest: float
    velocity_threshold: float  # negative: from the tolerances


def least_interval(duration: float) -> float:
    """Time between stored instants, at least [s]."""
    return 4.0 * math.ulp(duration)


@kernel
def doubling_error(model: Model, limits: Limits, q: FloatArray, u: FloatArray, kept: Backup) -> float:
    """Largest difference of the two results over its tolerance; infinite where one is not finite."""
    worst = 0.0
    n = len(u)
    difference(model, kept.long_q, q, kept.change)
    magnitudes(model, q, kept.size)
    magnitudes(model, kept.q, kept.size_before)
    for i in range(n):
        largest = max(kept.size[i], kept.size_before[i])
        ratio = abs(kept.change[i]) / (limits.atol[i] + limits.rtol * largest)
        rate = abs(u[i] - kept.long_u[i]) / (limits.atol[n + i] + limits.rtol * max(abs(u[i]), abs(kept.u[i])))
        if not ratio + rate < math.inf:
            return math.inf
        worst = max(worst, max(ratio, rate))
    return worst


@kernel
def position_tolerance(limits: Limits, q: FloatArray) -> float:
    """The tolerance of the largest coordinate."""
    largest = 0.0
    for i in range(len(q)):
        largest = max(largest, abs(q[i]))
    return limits.near + limits.rtol * largest


@kernel
def after_rejection(limits: Limits, clock: StepClock, h: float, error: float) -> None:
    """A shorter step to try; the next one that is accepted will not be lengthened."""
    factor = 0.1 if not error < math.inf else max(0.1, 0.8 / math.sqrt(error))
    clock.step = max(limits.shortest, min(0.5, factor) * h)
    clock.rejected = 1


@kernel
def end_there(limits: Limits, clock: StepClock, h: float, share: float) -> None:
    """After a trial of length h in which a pair closed unmet: have the next one end where it does."""
    clock.cruise = max(clock.cruise, h)
    clock.step = max(limits.shortest, share * h)
    clock.rejected = 1


@kernel
def threshold(limits: Limits, clock: StepClock) -> float:
    """Normal velocity up to which an approach is stopped [m/s]."""
    least = limits.velocity_threshold
    if least < 0.0:
        least = limits.slow + limits.rtol * clock.fastest
    return max(least, SETTLE * clock.pull)


@kernel
def resume(limits: Limits, clock: StepClock) -> None:
    """Go on with the step that was tried before one that had to end at an impact."""
    clock.step = min(limits.longest, max(clock.step, clock.cruise))
    clock.cruise = 0.0


@kernel
def after_impact(limits: Limits, clock: StepClock, approach: float, pull: float, alone: bool) -> None:
    """Have a shortest step take an impact that is due, and go on as before once it has.

    approach: fastest one of closed pairs that no problem has held yet [m/s]; pull: what a shortest step adds to it.
    """
    if not alone:
        clock.pull = pull
    if approach > threshold(limits, clock) and clock.strikes < MOST_STRIKES:
        clock.fastest = max(clock.fastest, approach)
        clock.step = limits.shortest
        clock.strikes += 1
        return
    if clock.strikes > 0:
        resume(limits, clock)
    clock.strikes = 0


@kernel
def next_length(model: Model, limits: Limits, clock: StepClock) -> float:
    """Length of the step to try [s]: to the very end, or stop of a load, where little would be left."""
    rest = time_left(model.signals, clock.time, limits.duration)
    h = min(clock.step, rest, longest_look(model.signals))
    return rest if rest - h < 0.01 * h else h


@kernel
def accept(limits: Limits, clock: StepClock, h: float, error: float, alone: bool, sunk: float) -> None:
    """Go on to the end of a step and choose the length of the next one: local errors grow at least as h^2.

    alone: whether it was a single step, not controlled; sunk: deepest penetration at its end [m].
    """
    factor = min(2.0, 0.8 / math.sqrt(max(error, 1e-4)))
    if clock.rejected == 1:
        factor = min(factor, 1.0)
    planned = clock.step if h < ENDED_EARLY * clock.step else 0.0  # a stop says nothing of the step behind it
    clock.step = min(limits.longest, max(limits.shortest, factor * h, planned))
    clock.rejected = 0
    clock.deepest = sunk
    clock.time = limits.duration if clock.time + h >= limits.duration else clock.time + h
    clock.steps += 1 if alone else 2
    clock.n_shortest += 1 if alone else 0
