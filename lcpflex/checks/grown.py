"""Motions that cannot be: grown out of all bounds, of which checks beside that of energy have nothing to tell, or gone
farther than their velocities lead."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.basics.lengths import lengths
from lcpflex.model.arrays import OPEN
from lcpflex.model.layout import dimension, place_offsets
from lcpflex.results.motion_units import Units

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.model.arrays import Model
    from lcpflex.results.result import Result

__all__ = ["BOUND", "gone_too_far", "has_grown", "largest_gap"]

BOUND = np.finfo(float).max ** 0.25  # stiffnesses, products of forces and places, have no squares beyond

NOISE = 1e-6  # of the size of the scene, or of the largest gap of a user's own system
FASTER = 2.0  # times its velocities at both ends of an interval: faster, a body was put where it is
LOOKED_AT = 20  # intervals, with all that bodies do but go with their frames
MOST = 3  # of them, that are told


def has_grown(result: Result) -> bool:
    """Whether a place or a velocity at the end is no number, or so large that what is computed of it is none."""
    return not (np.abs(result.q[-1:]).max(initial=0.0) < BOUND and np.abs(result.u[-1:]).max(initial=0.0) < BOUND)


def largest_gap(result: Result) -> float:
    """Of those stored [m]; 0 without any."""
    return float(np.abs(result.gap[np.isfinite(result.gap)]).max(initial=0.0))


def gone_too_far(result: Result, model: Model) -> list[tuple[int, bool]]:
    """Instants before which bodies have gone, or sunk into each other, farther than their velocities take them.

    And those from which on a contact goes on to be closed while its gap is open: for them True. Of a run in doubt also
    the one before which most energy came or went.
    """
    span = np.diff(result.times)
    if not len(span) or not max(np.abs(result.q).max(initial=0.0), np.abs(result.u).max(initial=0.0)) < BOUND:
        return []
    noise = NOISE * (result.compiled.size if result.compiled is not None else largest_gap(result))
    opened = _opened(result)
    sunk = np.maximum(np.diff(result.penetration), opened)
    gone, speed = _gone(result, model)
    way = span[:, None] * np.maximum(speed[:-1], speed[1:])
    put = (gone - FASTER * way).max(axis=1, initial=0.0)
    bodies = len(model.bodies.mass)
    off = np.maximum(sunk - (_of_two(way) if bodies else 0.0), put)
    rows = np.flatnonzero(off > noise)
    rows = rows[np.argsort(-off[rows], kind="stable")][:LOOKED_AT]
    if len(rows) and bodies:  # what turns or bends goes farther than its frame
        units = Units(model, result.u.shape[1])
        speed = np.maximum(units.of(result.u[rows]), units.of(result.u[rows + 1]))
        rows = rows[np.maximum(sunk[rows] - _of_two(span[rows, None] * speed), put[rows]) > noise]
    found = rows[:MOST].tolist()
    if result.found_wrong:
        found.append(int(np.abs(np.diff(result.energies.remainder)).argmax()))
    return [(k + 1, bool(opened[k] > noise)) for k in found]


def _opened(result: Result) -> FloatArray:
    """(m - 1,) by how much a gap has opened whose contact is closed then, and at the next instant, too [m]."""
    closed, gap = result.state != OPEN, result.gap
    opened = np.zeros(len(gap) - 1)
    both = np.where(closed[1:-1] & closed[2:], np.minimum(gap[1:-1], gap[2:]) - gap[:-2], 0.0)
    opened[:-1] = np.nan_to_num(both).max(axis=1, initial=0.0)
    return opened


def _of_two(way: FloatArray) -> FloatArray:
    """What the two bodies that go farthest do together."""
    return np.asarray(np.sort(way, axis=1)[:, -2:].sum(axis=1))


def _gone(result: Result, model: Model) -> tuple[FloatArray, FloatArray]:
    """How far the frame of each body has gone (m - 1, nb), and how fast it was (m, nb).

    Of a user's own system: each coordinate, where they are as many as velocities.
    """
    apart, u, components = np.diff(result.q, axis=0), result.u, dimension(model.bodies).components
    if not len(model.bodies.mass):
        of_coordinates = np.abs(apart) if apart.shape[1] == u.shape[1] else np.zeros((len(apart), u.shape[1]))
        return of_coordinates, np.abs(u)
    places, rates = place_offsets(model.bodies)[:-1], model.bodies.dof[:-1]
    return (
        np.stack([lengths(apart[:, at : at + components]) for at in places], axis=1),
        np.stack([lengths(u[:, at : at + components]) for at in rates], axis=1),
    )
