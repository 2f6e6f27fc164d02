"""Lines of structured meshes: how far apart they are, and places that draw them together."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from lcpflex.basics.arguments import array_of, mapping_of, positive, sequence_of
from lcpflex.bodies.fem.grading import ELEMENTS
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.jit.kernel import FloatArray

__all__ = ["Axis", "Pull", "Spot", "lines_between", "refuse_many", "spots_of"]

GROWTH = math.exp(0.25)  # 1.28 from an element to the next, if not given
FASTEST = 3.0  # the same: elements that are three times their neighbour resolve no decay of stresses
WITHIN = 8.0  # finest elements up to which they stay so: a radius of contact of 5 gives pressures to 3 %, and a margin
SAMPLES = 1000  # of the distances from a place, geometric: sizes between them are wrong by 1e-4 at most
ROUNDING = 1e-9  # of a number of elements: so much above a whole number is no reason for one more


class Axis(NamedTuple):
    """One direction of lines."""

    low: float
    high: float
    metric: float  # metres a unit of the coordinate, where they are most
    least: int  # elements


class Spot(NamedTuple):
    """A place of the surface where elements are small."""

    name: str
    place: FloatArray  # (3,) [m]
    finest: float  # edges there [m]
    radius: float  # up to which they are as short [m]
    growth: float  # from an element to the next beyond it


class Pull(NamedTuple):
    """What one place does to the lines of one direction.

    The distance of the line at the coordinate s from the place is about hypot(away, metric (s - at)).
    """

    at: float  # coordinate of the nearest line
    away: float  # its distance [m]; 0: a line is wanted through the place
    metric: float  # metres a unit of the coordinate
    finest: float  # [m]
    within: float  # distance up to which elements are as small as that [m]
    slope: float  # of the size of elements with the distance beyond it: neighbours differ by its exponential

    def steps(self, s: FloatArray) -> FloatArray:
        """(k,) distances of lines that are allowed at coordinates (k,), in units of the coordinate."""
        distance = np.hypot(self.away, self.metric * (s - self.at))
        return np.asarray((self.finest + self.slope * np.maximum(distance - self.within, 0.0)) / self.metric)

    def samples(self, span: float) -> FloatArray:
        """Coordinates between which ``steps`` hardly curves, up to ``span`` from ``at``."""
        flat = self.within / self.metric
        unit = self.finest / self.metric
        beyond = flat + unit * np.expm1(np.linspace(0.0, math.log1p(span / unit), SAMPLES))
        offsets = np.concatenate([np.linspace(0.0, flat, 9), beyond])
        return np.concatenate([self.at - offsets, self.at + offsets])


def refuse_many(count: float, what: str = "size") -> None:
    """Raise ModelError for a mesh of more elements than ELEMENTS, before it is made."""
    if not count <= ELEMENTS:
        raise ModelError(f"{what}: a mesh of {count:.4g} elements would come of it, expected at most {ELEMENTS}")


def lines_between(low: float, high: float, step: float, least: int, pulls: Iterable[Pull]) -> FloatArray:
    """Ascending coordinates from ``low`` to ``high``, closer than ``step`` and than each pull allows.

    With the distance h(s) that is allowed at s, the k-th line is where the integral of ds / h reaches k n / I, of its
    whole I and the next whole number n. Places whose pull has ``away`` 0 get a line, unless another one is within half
    of their finest distance.

    Raises
    ------
    ModelError
        For more lines than a mesh has elements.
    """
    pulls, step = list(pulls), min(step, (high - low) / least)
    if not pulls:
        count = (high - low) / step * (1.0 - ROUNDING)
        refuse_many(count)
        return np.linspace(low, high, math.ceil(count) + 1)
    samples = np.concatenate([np.linspace(low, high, 65), *(pull.samples(high - low) for pull in pulls)])
    s = np.unique(np.clip(samples, low, high))
    density = np.max([1.0 / np.minimum(step, pull.steps(s)) for pull in pulls], axis=0)
    reached = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(s))])
    refuse_many(reached[-1], "near")
    parts = []
    ends = _fixed(low, high, pulls)
    for begin, end in itertools.pairwise(ends):
        first, last = np.interp([begin, end], s, reached)
        count = math.ceil(max(1.0, (last - first) * (1.0 - ROUNDING)))
        inner = np.interp(first + (last - first) * np.arange(1, count) / count, reached, s)
        parts += [np.array([begin]), inner]
    return np.concatenate([*parts, [high]])


def _fixed(low: float, high: float, pulls: list[Pull]) -> list[float]:
    """The ends, and lines through places that are not too close to them or to each other."""
    found = [low, high]
    for pull in pulls:
        if pull.away == 0.0 and low < pull.at < high:
            least = 0.5 * pull.finest / pull.metric
            if min(abs(pull.at - other) for other in found) > least:
                found.append(pull.at)
    return sorted(found)


def spots_of(near: Any, size: float, taken: Iterable[str]) -> list[Spot]:
    """The places of ``near``: name -> (place, finest), (place, finest, radius) or (place, finest, radius, growth).

    Raises
    ------
    ModelError
        For anything else, names in ``taken``, finest > size, radius < finest, or a growth outside (1, 3).
    """
    spots = []
    for name, value in ({} if near is None else mapping_of("near", near)).items():
        label = f"near[{shown(name)}]"
        if name in taken:
            raise ModelError(f"near: the name {shown(name)} was given, expected another one: a face of the mesh has it")
        given = sequence_of(label, value, "a place (3,), its finest size, and a radius and a growth if wanted", 4)
        if len(given) < 2:
            raise ModelError(f"{label}: {shown(value)} was given, expected a place (3,) and its finest size")
        place = array_of(f"{label}: place", given[0], (3,))
        finest = positive(f"{label}: finest", given[1])
        in_range(f"{label}: finest", finest, 0.0, size * (1.0 + ROUNDING))
        radius = WITHIN * finest if len(given) < 3 else positive(f"{label}: radius", given[2])
        if radius < finest:
            raise ModelError(f"{label}: radius: {radius:g} m was given, expected at least the finest size {finest:g} m")
        growth = GROWTH if len(given) < 4 else in_range(f"{label}: growth", given[3], 1.0, FASTEST, open_ends=True)
        spots.append(Spot(name, place, min(finest, size), radius, growth))
    return spots
