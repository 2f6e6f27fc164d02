"""How far two runs of the same bodies with different modes are apart: by material points that both know.

Modal coordinates cannot be compared, and frames tell nothing of a deformation. The frame itself means the same whatever
the number of modes: it moves as the mass does on average, or with the nodes that it is held by.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lcpflex.accuracy.comparison import Around, around, places_between, rates_between
from lcpflex.basics.lengths import lengths
from lcpflex.errors import ModelError
from lcpflex.kinematics.places import trajectory, velocity
from lcpflex.model.layout import dimension
from lcpflex.results.watched_places import gyration, known_places, two_places

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result

__all__ = ["Apart", "apart"]


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

    What is between stored instants is told as by :func:`lcpflex.accuracy.comparison.values_at`.

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
    held = [(run, around(run.times, at)) for run in (result, other)]
    for name, x in two_places(one, other=two):
        b = names.index(name)
        paths = [(run.point(name, x), run.velocity(name, x), when) for run, when in held]
        r, r_other = (places_between(path, rate, when) for path, rate, when in paths)
        v, v_other = (rates_between(rate, when) for _, rate, when in paths)
        place[:, b] = np.maximum(place[:, b], lengths(r - r_other))
        speed[:, b] = np.maximum(speed[:, b], lengths(v - v_other))
    for b in range(len(names)):
        arm = _extent(one, b)
        # of two rotations by an angle a apart, |R - R'| = 2 sqrt(2) sin(a / 2), in the plane as in space
        axes, axes_other = (_axes(run, when, b, arm) for run, when in held)
        off = np.linalg.norm(axes - axes_other, axis=(1, 2))
        turn[:, b] = 2.0 * np.arcsin(np.minimum(off / np.sqrt(8.0), 1.0)) * arm
    return Apart(at, names, place, turn, speed)


def _extent(compiled: CompiledScene, b: int) -> float:
    """Largest extent of the material points of a body, at least twice its central radius of gyration [m]."""
    own = known_places(compiled, b)
    bodies = compiled.model.bodies
    off = float(np.linalg.norm(bodies.moment[b]) / bodies.mass[b])
    central = math.sqrt(max(gyration(compiled, b) ** 2 - off**2, 0.0))
    return max(float(np.ptp(own, axis=0).max()) if len(own) else 0.0, 2.0 * central)


def _axes(result: Result, held: Around, b: int, arm: float) -> FloatArray:
    """(k, d, d) unit vectors along the axes of the frame of a body, one a row."""
    model = result.compiled.model  # type: ignore[union-attr]
    count = dimension(model.bodies).components
    rigid = np.zeros((0, count))
    ends = []
    for x in (np.zeros(count), *(arm * np.eye(count))):
        path = trajectory(model, result.q, b, x, rigid)
        ends.append(places_between(path, velocity(model, result.q, result.u, b, x, rigid), held))
    axes = np.stack([end - ends[0] for end in ends[1:]], axis=1)
    return np.asarray(axes / np.linalg.norm(axes, axis=2, keepdims=True))
