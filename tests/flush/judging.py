"""What runs of flush bodies must show: balance at rest; in motion what the aligned show, or event-driven finely."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.flush.places import Place
from tests.flush.polytopes import polytope, separation
from tests.flush.scenes import GRAVITY, STEP, Motion

__all__ = [
    "Bound",
    "broken",
    "corner_tracks",
    "deepest_overlap",
    "moves_as_it_must",
    "names_of",
    "off_rest",
    "poses",
    "rests",
    "turned",
    "unbalanced",
]

Array = Any
SMALL = 1e-4  # amount up to which a place is judged by the aligned one
WIDTH = 0.1  # [m] of bodies that are tilted: what turns in a step in which one side does not touch yet
STEP_SEES = 1e-10  # tilt above which time stepping takes a side for open, which it is for a step
MERGED = (
    5e-7  # of corners that leave within 1e-8 of the size of each other and count as one: it tips fifty times as far
)
LATE = 5.0  # steps by which time stepping may miss an impact, and what follows from it


class Bound(NamedTuple):
    """How far a run is off, and by how much it may be."""

    off: float
    most: float

    @property
    def kept(self) -> bool:
        return self.off <= self.most  # not of a NaN


def names_of(result: lf.Result) -> tuple[str, ...]:
    """Of the bodies, in the order of their coordinates."""
    assert result.compiled is not None
    return tuple(result.compiled.layout.bodies)


def poses(result: lf.Result) -> Array:
    """(m, bodies, 7) of rigid bodies: places and quaternions."""
    return result.q.reshape(len(result.q), -1, 7)


def unbalanced(result: lf.Result, record: int = -1) -> tuple[float, float]:
    """Force and moment about its centre that a body at rest has too much of, over g and g x size, of 1 kg.

    Contacts must be named by their bodies, and nothing else may hold these.
    """
    compiled = result.compiled
    assert compiled is not None
    record %= len(result.times)
    names, centres = names_of(result), poses(result)[record, :, :3]
    points = result.contact_points.at(record)
    wrench = np.zeros((len(names), 2, 3))
    wrench[:, 0, 2] = -GRAVITY * np.asarray(compiled.model.bodies.mass)
    for c, place, force in zip(points.contact, points.place, points.vector, strict=True):
        for end, sign in zip(result.contact_names[c].split("/"), (1.0, -1.0), strict=True):
            name = end.split(".")[0]
            if name in names:
                body = names.index(name)
                wrench[body, 0] += sign * force
                wrench[body, 1] += sign * np.cross(place - centres[body], force)
    force, moment = np.linalg.norm(wrench, axis=2).max(axis=0) / GRAVITY
    return float(force), float(moment)


def turned(result: lf.Result, body: int, first: int = 0, last: int = -1) -> Rotation:
    """Of a body between two instants, in world axes."""
    quaternions = np.roll(poses(result)[[first, last], body, 3:], -1, axis=-1)
    start, end = Rotation.from_quat(quaternions)
    return end * start.inv()


def off_rest(result: lf.Result) -> float:
    """The largest move [m] or turn [rad] of what should rest."""
    at = poses(result)
    moved = float(np.abs(at[-1, :, :3] - at[0, :, :3]).max())
    return max(moved, *(float(turned(result, b).magnitude()) for b in range(at.shape[1])))


def off_aligned(result: lf.Result, aligned: lf.Result, size: float) -> float:
    """The largest difference of the places, over the size, and of the turns [rad] of bodies at the end."""
    one, two = (poses(r)[-1, :, :3] for r in (result, aligned))
    off = float(np.linalg.norm(one - two, axis=1).max()) / size
    turns = [turned(result, b) * turned(aligned, b).inv() for b in range(len(one))]
    return max(off, *(float(turn.magnitude()) for turn in turns))


def corner_tracks(result: lf.Result, corners: Array, body: int) -> Array:
    """(m, n, 3) where material points of a body go."""
    at = poses(result)[:, body]
    turns = Rotation.from_quat(np.roll(at[:, 3:], -1, axis=-1))
    return np.stack([turns.apply(corner) for corner in corners], axis=1) + at[:, None, :3]


def off_truth(result: lf.Result, truth: lf.Result, corners: Array, body: int) -> tuple[float, float]:
    """The largest difference of where its corners are at the end, and the largest way that one has gone [m]."""
    mine, right = (corner_tracks(r, corners, body)[[0, -1]] for r in (result, truth))
    travel = float(np.linalg.norm(right[1] - right[0], axis=-1).max())
    return float(np.linalg.norm(mine[1] - right[1], axis=-1).max()), travel


def rests(result: lf.Result, size: float) -> Bound:
    """Whether nothing has moved, and the forces are those of statics: to 1e-6 of size, weight and weight x size."""
    force, moment = unbalanced(result)
    return Bound(max(off_rest(result), force, moment / size), 1e-6)


def moves_as_it_must(motion: Motion, place: Place, stepper: Any, aligned: lf.Result) -> Bound:
    """Up to amounts of SMALL against the aligned run; beyond against event-driven at a tenth of the tolerance."""
    result = lf.simulate(motion.build(place), motion.duration, stepper, progress=False)
    size = 2.0 * float(np.linalg.norm(motion.moved.corners, axis=1).max())
    event_driven = isinstance(stepper, lf.EventDriven)
    if place.amount <= SMALL:
        seen = motion.leaves + (place.tilt > STEP_SEES)  # events that time stepping sees at the end of a step
        stepped = 0.0 if event_driven else seen * GRAVITY * STEP**2 / WIDTH
        merged = MERGED if motion.leaves else 0.0
        return Bound(off_aligned(result, aligned, size), 10.0 * place.amount + 1e-8 + merged + 1.5 * stepped)
    fine = lf.EventDriven(rtol=0.1 * lf.EventDriven().rtol)
    truth = lf.simulate(motion.build(place), motion.duration, fine, progress=False)
    off, travel = off_truth(result, truth, motion.moved.corners, -1)
    late = 0.0 if event_driven else LATE * STEP
    passing = travel / motion.duration if motion.leaves else 0.0  # speed at which it leaves, seen at the end of a step
    landing = motion.speed + math.sqrt(2.0 * GRAVITY * place.tilt * size)  # a tilted body lands on its other corners
    return Bound(off, 1e-3 * travel + late * (landing + passing))


def deepest_overlap(result: lf.Result, corners: Array) -> float:
    """Of equal convex bodies at the end [m], by brute force; what lies on the ground may be as deep in it."""
    solid = polytope(corners)
    at = poses(result)[-1]
    turns = Rotation.from_quat(np.roll(at[:, 3:], -1, axis=-1))
    placed = [solid.moved(turn, place[:3]) for turn, place in zip(turns, at, strict=True)]
    far = 2.0 * float(np.linalg.norm(corners, axis=1).max())
    near = [(a, b) for a, b in combinations(range(len(at)), 2) if np.linalg.norm(at[a, :3] - at[b, :3]) < far]
    return max((-separation(placed[a], placed[b]) for a, b in near), default=0.0)


def broken(places: Iterable[Place], judge: Callable[[Place], Bound]) -> list[str]:
    """A line for each place where a bound is not kept, or the run ends with an error."""
    found = []
    for place in places:
        try:
            bound = judge(place)
            said = "" if bound.kept else f"{bound.off:.1e} for {bound.most:.1e}"
        except lf.LcpflexError as error:
            said = f"{type(error).__name__}: {str(error)[:120]}"
        if said:
            found.append(f"{place}: {said}")
    return found
