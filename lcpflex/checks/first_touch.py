"""How contacts of bodies with modes will close first, told from the start of a scene: flat, or point by point.

Each near point with the gap g, the rate s at which the gap shrinks and what gravity adds to it, a, closes at the time t
of s t + a t^2 / 2 = g, as if nothing held it back. A contact is *flat* where most of the points that close in the first
half of the slowest period close at once, and these points span a face, in the plane a line: an edge or a corner is as
little flat as a ball. Most are half of the area, for a ball takes hold of an area in proportion to its approach: half
of the points, in the plane the root of it. At once is within a part of the period of the highest mode that is kept:
modes answer no faster, and what closes meanwhile meets them as one impact. No time step is asked for: a long one closes
all.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from lcpflex.contact.near import near, normal_row
from lcpflex.contact.rows import contact_point
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.kinematics.configuration import advance
from lcpflex.model.layout import dimension

__all__ = ["AT_ONCE", "Touch", "answer_times", "first_touches", "half_period", "is_flat"]

# A bar with 15 or 40 modes whose end closes from one edge to the other in .3, .5, .8, 1.6, 3.2 of half a period of the
# highest one: over a massless boundary its force rings by .46, .38, .32, .11, .06 of its mean (rms), at once by .48
AT_ONCE = 1.0 / 3.0  # of half a period of the highest mode: what closes in it is flat
DOUBTFUL = 2.0 * AT_ONCE  # what closes in this may be flat, and counts so before a run
LONGER = 4.0  # such halves that a touch lasts at least: of one mode the highest is the slowest, too
AREA = 0.5  # of a touch, which closes at once where it is flat
LINE = 1e-3  # width of points over their length, below which they are on one line
CLOSED = 1e-9  # of the size of a scene: gaps that count as closed at the start


class Touch(NamedTuple):
    """A contact that is to close, of which bodies (-1: the ground), and how.

    ``at_once``, ``points``: how many of its near points close at once, and in the whole touch.
    """

    law: int
    bodies: tuple[int, int]
    at_once: int
    points: int
    flat: bool


def answer_times(model: Any, residual: tuple[tuple[int, int], ...]) -> tuple[FloatArray, FloatArray]:
    """(nb,) half of the highest and of the lowest period of the free modes of each body [s]; 0 of rigid ones.

    ``residual``: of each body, how many of its last modes are residual ones.
    """
    bodies, rigid = model.bodies, dimension(model.bodies).rigid
    fast, slow = np.zeros((2, len(bodies.mass)))
    for b in range(len(fast)):
        own = bodies.stiffness[bodies.dof[b] - rigid * b : bodies.dof[b + 1] - rigid * (b + 1)]
        free = own[: len(own) - (residual[b][0] if residual else 0)]
        fast[b], slow[b] = half_period(free, np.max), half_period(free, np.min)
    return fast, slow


def half_period(squares: FloatArray, of: Any) -> float:
    """Half a period [s] of the highest or lowest (``np.max``, ``np.min``) of modes by omega^2; 0 if there is none."""
    squares = squares[squares > 0.0]
    return math.pi / math.sqrt(float(of(squares))) if len(squares) else 0.0


def is_flat(places: FloatArray, points: int, size: float) -> bool:
    """Whether most of the ``points`` of a touch are at ``places`` (k, 2) or (k, 3), and these span a face.

    They do if they are not all one, in space not all on one line, in a scene of that size [m].
    """
    needed = places.shape[1] - 1
    if len(places) <= needed or not len(places) > AREA ** (0.5 * needed) * points:
        return False
    width = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    return bool(width[0] > CLOSED * size and width[needed - 1] > LINE * width[0])


def first_touches(compiled: Any) -> list[Touch]:
    """Those of the contacts that close first in a scene, of the bodies that have modes.

    Looked at is what is nearer than the size of the largest body, in free flight up to the first touch. Where joints,
    springs or forces act it must come in the first half period of the slowest mode: nothing else is known of it.
    """
    model, residual = pack(compiled.model), compiled.layout.residual
    q, u = np.array(compiled.q), np.array(compiled.u)
    loads, flies = model.loads, not len(model.joints.point)
    flies = flies and not len(loads.spring_kind) and not len(loads.force_point)
    fall = _fall(model) if flies else np.zeros_like(u)
    fast, slow = answer_times(model, residual)
    entries = _entries(model, q, u, fall, compiled.size)
    first = min((entry.time for entry in entries), default=math.inf)
    if not math.isfinite(first):
        return []
    if flies and first > 0.0:
        moved = q.copy()
        advance(model, q, u + 0.5 * first * fall, first, moved)
        q, u = moved, u + first * fall
        entries = _entries(model, q, u, fall, compiled.size)
        first = min((entry.time for entry in entries), default=math.inf)
    found: dict[tuple[int, tuple[int, int]], list[_Entry]] = {}
    for entry in entries:
        found.setdefault((entry.law, entry.bodies), []).append(entry)
    touches = []
    for (law, bodies), own in found.items():
        soft = [b for b in bodies if b >= 0 and fast[b] > 0.0]
        if soft:
            quick, lasts = float(fast[soft].max()), float(slow[soft].max())
            begun = min(entry.time for entry in own)
            if begun <= first + lasts and (flies or begun <= lasts):
                touches.append(_touch(law, bodies, own, quick, max(lasts, LONGER * quick), compiled.size))
    return touches


class _Entry(NamedTuple):
    law: int
    bodies: tuple[int, int]
    time: float  # at which it closes [s]; infinite: it does not
    place: FloatArray  # of the point that touches, world axes [m]


def _touch(law: int, bodies: tuple[int, int], own: list[_Entry], quick: float, lasts: float, size: float) -> Touch:
    times = np.array([entry.time for entry in own])
    first = times.min()
    at_once, points = times <= first + DOUBTFUL * quick, int((times <= first + lasts).sum())
    places = np.array([entry.place for entry in own])[at_once]
    return Touch(law, bodies, len(places), points, is_flat(places, points, size))


def _fall(model: Any) -> FloatArray:
    """(ndof,) acceleration of bodies that nothing but gravity acts on."""
    fall = np.zeros(int(model.bodies.dof[-1]))
    for d in model.bodies.dof[:-1].tolist():
        fall[d : d + len(model.loads.gravity)] = model.loads.gravity
    return fall


def _entries(model: Any, q: FloatArray, u: FloatArray, fall: FloatArray, size: float) -> list[_Entry]:
    """What is near, with the times at which it closes."""
    table, count = near(model, q, size)
    found = []
    for k in range(count):
        row = normal_row(model, q, table, k)
        bodies = int(table.body[k, 0]), int(table.body[k, 1])
        time = _closing(max(float(table.gap[k]) - CLOSED * size, 0.0), -float(row @ u), -float(row @ fall))
        place = np.array(contact_point(model, q, table, k))
        found.append(_Entry(int(table.law[k]), (min(bodies), max(bodies)), time, place))
    return found


def _closing(gap: float, rate: float, growth: float) -> float:
    """The first time t >= 0 at which rate t + growth t^2 / 2 = gap."""
    if gap <= 0.0:
        return 0.0
    root = rate**2 + 2.0 * growth * gap
    if root < 0.0:
        return math.inf
    speed = rate + math.sqrt(root)
    return 2.0 * gap / speed if speed > 0.0 else math.inf
