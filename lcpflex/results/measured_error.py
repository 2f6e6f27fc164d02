"""The error of a run, measured by reruns: see :func:`lcpflex.accuracy.verify.verify`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from lcpflex.jit.kernel import FloatArray

__all__ = ["PARTED", "MeasuredError", "Reach", "Rerun"]

PARTED = 0.05  # of the extent: a run that may be off by more has parted from the motion of the scene


@dataclass(frozen=True, slots=True)
class Rerun:
    """One more run of the same scene.

    Attributes
    ----------
    what
        In which way it differs: "a quarter of the step", "another method", "twice as many modes".
    stepper
        Its ``repr``.
    steps, seconds
        Made in all, and the time of computing [s].
    until
        Time that it came to [s].
    factor
        The difference to it counts so many times.
    ended
        Why it stopped before the end of the run that it checks; empty where it did not.
    """

    what: str
    stepper: str
    steps: int
    seconds: float
    until: float
    factor: float
    ended: str = ""


class Reach(NamedTuple):
    """The largest errors up to some time: of the body that is worst off."""

    place: float  # [m]
    turn: float  # rotation times the extent of the body [m]
    speed: float  # off impacts [m/s]
    place_share: float  # of the extent
    turn_share: float
    speed_share: float  # of the fastest point


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredError:
    """By how much a run may be off, E(t): some times the largest difference to its reruns, at nt equal times.

    Of nb bodies; of a user's own system, of its coordinates, each over its range, and of its velocities, each over the
    largest of it: lengths are shares then, and ``extent`` and ``fastest`` are 1.

    Attributes
    ----------
    times
        (nt,) [s], at which the runs were compared.
    place_curve
        (nt, nb) of the point of each body that is worst off, rotation of the body apart: the largest so far [m].
    turn_curve
        (nt, nb) of the rotation of each body, times its extent: the largest so far [m].
    speed_curve
        (nt, nb) of the velocity of the point of each body that is worst off, near no impact of either run on the body
        or on what joints hold it by: the largest so far [m/s].
    speed_rms
        Root mean square of that over time, impacts included, of the body that is worst off [m/s].
    extent, fastest
        Largest extent of a body or way of its origin [m], and largest speed of a point [m/s]: what shares are of.
    horizon
        Time up to which the run holds at least [s]: to the first at which place and turn of a body pass ``PARTED`` of
        the extent, or to the end of the shortest rerun.
    whole
        Whether that is all of the run.
    parted
        Where the runs part, in words; empty where they do not.
    gap_curve
        By contact: error of its gap, the largest so far (nt,) [m].
    force, impulse
        By contact: largest error of the force where no impact is near [N], and of the impulse since the start [N s].
    touches
        Of the contacts with most impulse: their names, and how often they touched in this run and in each rerun.
    reruns
        What was run.
    modes
        By how much twice as many modes move a body, twice [m], which is no part of the curves: those are of the steps.
        None where no body has modes, or this is not known.
    modes_horizon
        Time up to which that is below ``PARTED`` of the extent [s]; infinite where it is to the end, or not known.
    modes_note
        Why that was not run, or what came of it; empty where no body has modes.
    """

    times: FloatArray
    place_curve: FloatArray
    turn_curve: FloatArray
    speed_curve: FloatArray
    speed_rms: float
    extent: float
    fastest: float
    horizon: float
    whole: bool
    parted: str
    bodies: tuple[str, ...]
    gap_curve: Mapping[str, FloatArray]
    force: Mapping[str, float]
    impulse: Mapping[str, float]
    touches: tuple[tuple[str, tuple[int, ...]], ...]
    reruns: tuple[Rerun, ...]
    modes: float | None = None
    modes_horizon: float = np.inf
    modes_note: str = ""
    notes: tuple[str, ...] = field(default=())

    def up_to(self, t: float) -> Reach:
        """The largest errors up to the time ``t`` [s]."""
        row = int(np.searchsorted(self.times, t, side="right")) - 1
        if row < 0 or not self.place_curve.shape[1]:
            return Reach(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        found = [float(curve[row].max()) for curve in (self.place_curve, self.turn_curve, self.speed_curve)]
        sizes = self.extent, self.extent, self.fastest
        return Reach(*found, *(value / size for value, size in zip(found, sizes, strict=True)))

    @property
    def place(self) -> float:
        """Largest error of a place, rotations apart [m]."""
        return self.up_to(np.inf).place

    @property
    def turn(self) -> float:
        """Largest error of a rotation, times the extent of the body [m]."""
        return self.up_to(np.inf).turn

    @property
    def speed(self) -> float:
        """Largest error of a velocity near no impact [m/s]."""
        return self.up_to(np.inf).speed

    @property
    def place_share(self) -> float:
        """``place`` over ``extent``."""
        return self.up_to(np.inf).place_share

    @property
    def turn_share(self) -> float:
        """``turn`` over ``extent``."""
        return self.up_to(np.inf).turn_share

    @property
    def speed_share(self) -> float:
        """``speed`` over ``fastest``."""
        return self.up_to(np.inf).speed_share

    @property
    def speed_rms_share(self) -> float:
        """``speed_rms`` over ``fastest``."""
        return self.speed_rms / self.fastest
