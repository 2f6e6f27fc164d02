"""How far two runs of the same bodies with different modes are apart: by material points that both know.

Modal coordinates cannot be compared, and frames tell nothing of a deformation. The frame itself means the same whatever
the number of modes: it moves as the mass does on average, or with the nodes that it is held by.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lcpflex.errors import ModelError
from lcpflex.model.layout import dimension
from lcpflex.results.places import trajectory, velocity
from lcpflex.results.watched_places import gyration, known_places, two_places

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.result import Result

__all__ = ["Apart", "apart"]

SAME = 1e-9  # of the duration: instants nearer than that are one


class Apart(NamedTuple):
    """Differences at k times, of nb bodies.

    place : (k, nb) of the watched point that is worst off [m]
    turn : (k, nb) of the rotation of the frame, times the extent of the body [m]
    speed : (k, nb) of the watched point that is worst off [m/s], impacts included
    """

    times: FloatArray
    bodies: tuple[str, ...]
    place: FloatArray
    turn: FloatArray
    speed: FloatArray


def apart(result: Result, other: Result, at: FloatArray) -> Apart:
    """How far two results of scenes with the same bodies are apart at the times ``at`` (k,) [s], ascending.

    Between two stored instants a place is a cubic by the velocities at both, a velocity linear; of two instants at one
    time the later counts.

    Raises
    ------
    ModelError
        For results of other bodies, and for a flexible body of which no point is known in both.
    """
    one, two = result.compiled, other.compiled
    if one is None or two is None or one.layout.bodies != two.layout.bodies or one.spatial != two.spatial:
        raise ModelError("other: a result of other bodies was given, expected one of the same scene with other modes")
    at = np.asarray(at, dtype=float)
    names = one.layout.bodies
    place, turn, speed = (np.zeros((len(at), len(names))) for _ in range(3))
    for name, x in two_places(one, other=two):
        b = names.index(name)
        ours, theirs = (_sampled(run, run.point(name, x), run.velocity(name, x), at) for run in (result, other))
        place[:, b] = np.maximum(place[:, b], np.linalg.norm(ours[0] - theirs[0], axis=1))
        speed[:, b] = np.maximum(speed[:, b], np.linalg.norm(ours[1] - theirs[1], axis=1))
    for b in range(len(names)):
        arm = _extent(one, b)
        # of two rotations by an angle a apart, |R - R'| = 2 sqrt(2) sin(a / 2), in the plane as in space
        off = np.linalg.norm(_axes(result, b, arm, at) - _axes(other, b, arm, at), axis=(1, 2))
        turn[:, b] = 2.0 * np.arcsin(np.minimum(off / np.sqrt(8.0), 1.0)) * arm
    return Apart(at, names, place, turn, speed)


def _extent(compiled: CompiledScene, b: int) -> float:
    """Largest extent of the material points of a body, at least twice its central radius of gyration [m]."""
    own = known_places(compiled, b)
    bodies = compiled.model.bodies
    off = float(np.linalg.norm(bodies.moment[b]) / bodies.mass[b])
    central = math.sqrt(max(gyration(compiled, b) ** 2 - off**2, 0.0))
    return max(float(np.ptp(own, axis=0).max()) if len(own) else 0.0, 2.0 * central)


def _axes(result: Result, b: int, arm: float, at: FloatArray) -> FloatArray:
    """(k, d, d) unit vectors along the axes of the frame of a body, one a row."""
    model = result.compiled.model  # type: ignore[union-attr]
    count = dimension(model.bodies).components
    rigid = np.zeros((0, count))
    ends = []
    for x in (np.zeros(count), *(arm * np.eye(count))):
        path = trajectory(model, result.q, b, x, rigid)
        ends.append(_sampled(result, path, velocity(model, result.q, result.u, b, x, rigid), at)[0])
    axes = np.stack([end - ends[0] for end in ends[1:]], axis=1)
    return np.asarray(axes / np.linalg.norm(axes, axis=2, keepdims=True))


def _sampled(result: Result, places: FloatArray, rates: FloatArray, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Places and velocities (k, d) of a point at some times, from those at the stored instants (m, d)."""
    row, behind, s, h = _between(result.times, at)
    r, v, r2, v2 = places[row], rates[row], places[behind], rates[behind]
    cubic = (1.0 + 2.0 * s) * (1.0 - s) ** 2 * r + s**2 * (3.0 - 2.0 * s) * r2
    cubic += h * s * (1.0 - s) * ((1.0 - s) * v - s * v2)
    return np.asarray(cubic), np.asarray((1.0 - s) * v + s * v2)


def _between(times: FloatArray, at: FloatArray) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """The stored instants before and behind some times, how far between them, and their distance [s]."""
    slack = SAME * float(times[-1] - times[0])
    row = np.clip(np.searchsorted(times, at + slack, side="right") - 1, 0, len(times) - 1)
    behind = np.minimum(row + 1, len(times) - 1)
    h = (times[behind] - times[row])[:, None]
    s = np.clip((at - times[row])[:, None], 0.0, h)
    s = np.where(s > slack, s / np.where(h > 0.0, h, 1.0), 0.0)
    return row, behind, s, h
