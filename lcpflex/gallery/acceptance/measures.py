"""Numbers taken from results of any stepper: from its events where it locates them, else from stored instants."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.model.arrays import OPEN, SLIP

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result

__all__ = [
    "along_slope",
    "contact_end",
    "contact_start",
    "end_of",
    "energy_kept",
    "first_impact",
    "first_stop",
    "last_speed",
    "mean_force",
    "peak_force",
    "separate_contacts",
    "slips",
    "total_impulse",
]

Measure = Callable[["Result"], float]


def events(result: Result, kind: str) -> list[float]:
    """Times of the events of that kind [s]."""
    return [event.time for event in result.events if event.kind == kind]


def contact_start(result: Result) -> float:
    """First stored instant with a force in the first contact [s]."""
    return float(result.times[np.argmax(result.force[:, 0, 0] > 0.0)])


def contact_end(result: Result) -> float:
    """Last stored instant with a force in the first contact [s]."""
    return float(result.times[result.force[:, 0, 0] > 0.0][-1])


def mean_force(start: float, end: float) -> Measure:
    """Mean normal force of the first contact between two times [N]: impulse over time."""

    def measure(result: Result) -> float:
        impulse = np.interp((start, end), result.times, result.impulse[:, 0, 0])
        return float(impulse[1] - impulse[0]) / (end - start)

    return measure


def peak_force(result: Result) -> float:
    """Largest stored normal force of the first contact [N]."""
    return float(result.force[:, 0, 0].max())


def separate_contacts(result: Result, parted: float) -> list[tuple[float, float]]:
    """Begin and end [s] of each time with a force in the first contact; less than ``parted`` [s] apart: one."""
    closed = np.flatnonzero(result.force[:, 0, 0] > 0.0)
    if not len(closed):
        return []
    breaks = np.flatnonzero(np.diff(result.times[closed]) >= parted)
    begins, ends = np.concatenate([[0], breaks + 1]), np.concatenate([breaks, [len(closed) - 1]])
    found = result.times[closed]
    return [(float(found[a]), float(found[b])) for a, b in zip(begins, ends, strict=True)]


def total_impulse(result: Result) -> float:
    """Normal impulse of all contacts [N s]."""
    return float(result.impulse[-1, :, 0].sum())


def last_speed(coordinate: int) -> Measure:
    """Last rate of a coordinate."""
    return lambda result: float(result.u[-1, coordinate])


def end_of(coordinate: int) -> Measure:
    """Last value of a coordinate."""
    return lambda result: float(result.q[-1, coordinate])


def energy_kept(result: Result) -> float:
    """Last stored energy over the first."""
    return float(result.energies.stored[-1] / result.energies.stored[0])


def first_impact(result: Result) -> float:
    """Time of the first impact [s], or of the start of the step that made it."""
    found = events(result, "impact")
    return (
        found[0] if found else float(result.times[max(np.flatnonzero(result.impulse[:, :, 0].any(axis=1))[0] - 1, 0)])
    )


def along_slope(result: Result) -> tuple[FloatArray, FloatArray]:
    """Distance moved up a slope of 30 degrees [m], and the speed [m/s]."""
    uphill = np.array([math.cos(math.pi / 6), math.sin(math.pi / 6)])
    return (result.q[:, :2] - result.q[0, :2]) @ uphill, result.u[:, :2] @ uphill


def first_stop(times: FloatArray, speed: FloatArray) -> float:
    """Where the speed comes down to zero, along the straight line through its last two values before [s]."""
    k = int(np.flatnonzero(speed <= 0.0)[0])
    return float(times[k - 1] + speed[k - 1] * (times[k - 1] - times[k - 2]) / (speed[k - 2] - speed[k - 1]))


def slips(result: Result) -> tuple[float, float]:
    """When the first contact begins to slip, and when it sticks again for good [s]."""
    slipping = result.times[result.state[:, 0] == SLIP]
    starts = events(result, "slip") or [float(slipping[0])]
    ends = events(result, "stick") or [float(slipping[-1])]
    return starts[0], ends[-1]


def rest(result: Result) -> float:
    """When the first contact closes for good [s]."""
    ends = events(result, "touch-down") or [float(result.times[result.state[:, 0] == OPEN][-1])]
    return ends[-1]


def first_impact_of_rate(result: Result) -> float:
    """Time of the first impact after 0.3 s [s]: of its event, or where the third coordinate's rate jumps most."""
    found = [time for time in events(result, "impact") if time > 0.3]
    if found:
        return found[0]
    late = result.times[1:] > 0.3
    return float(result.times[int(np.argmax(np.abs(np.diff(result.u[:, 2])) * late))])
