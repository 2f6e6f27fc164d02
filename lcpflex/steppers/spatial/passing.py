"""Whether a step of fixed length may have taken a body through another in space: a bound that costs next to nothing."""

from __future__ import annotations

import math
from typing import Any

from lcpflex.contact.rule_pairs import is_barred
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, rotation_matrix, transform
from lcpflex.model.spatial import N_PLACE, N_RIGID, SpatialModel
from lcpflex.steppers.recorder import Recorder

__all__ = ["may_pass"]

A_TURN = math.pi / math.sqrt(2.0)  # a turn by a changes unit quaternions by 2 sin(a / 4), at least a / A_TURN


@kernel
def turned(q: FloatArray, before: FloatArray, i: int) -> float:
    """By how much the body whose quaternion begins at i has turned [rad], at most; by the shorter way."""
    same = 0.0
    other = 0.0
    for k in range(i, i + 4):
        same += (q[k] - before[k]) ** 2
        other += (q[k] + before[k]) ** 2
    return A_TURN * math.sqrt(min(same, other))


@kernel
def travelled(model: SpatialModel, b: int, q: FloatArray, recorder: Recorder) -> float:
    """How far the points of body b have moved against its frame in the step, at most [m]."""
    i = model.bodies.place[b]
    deflection = 0.0
    for m in range(i + N_PLACE, model.bodies.place[b + 1]):
        deflection += abs(q[m] - recorder.before[m])
    return recorder.farthest * turned(q, recorder.before, i + 3) + recorder.deflection[b] * deflection


@kernel
def moved_frame(q: FloatArray, before: FloatArray, i: int) -> float:
    """How far the origin of a frame has moved in the step [m]."""
    x, y, z = q[i] - before[i], q[i + 1] - before[i + 1], q[i + 2] - before[i + 2]
    return math.sqrt(x * x + y * y + z * z)


@kernel
def centre_of(model: SpatialModel, q: FloatArray, s: int) -> tuple[Vector, float]:
    """Centre of the bounding sphere of surface s [m], and its radius, widened by deformation."""
    c = model.contacts
    b = c.surface_body[s]
    x, y, z = c.surface_center[s, 0], c.surface_center[s, 1], c.surface_center[s, 2]
    if b < 0:
        return (x, y, z), c.surface_extent[s]
    i = model.bodies.place[b]
    x, y, z = transform(rotation_matrix(q[i + 3], q[i + 4], q[i + 5], q[i + 6]), x, y, z)
    deflection = 0.0
    for m in range(model.bodies.dof[b + 1] - model.bodies.dof[b] - N_RIGID):
        deflection += abs(q[i + N_PLACE + m]) * c.surface_deflection[s, m]
    return (q[i] + x, q[i + 1] + y, q[i + 2] + z), c.surface_extent[s] + deflection


@kernel
def may_have_met(model: SpatialModel, q: FloatArray, i: int, j: int, thickness: float, recorder: Recorder) -> bool:
    """Whether surfaces i and j, inside each other by ``thickness`` at most [m], have moved by more and are near."""
    if thickness == math.inf:
        return False
    c = model.contacts
    x, y, z, moved, sign = 0.0, 0.0, 0.0, 0.0, 1.0
    for s in (i, j):
        b = c.surface_body[s]
        if b >= 0:
            p = model.bodies.place[b]
            x += sign * (q[p] - recorder.before[p])
            y += sign * (q[p + 1] - recorder.before[p + 1])
            z += sign * (q[p + 2] - recorder.before[p + 2])
            moved += travelled(model, b, q, recorder)
        sign = -1.0
    moved += math.sqrt(x * x + y * y + z * z)
    if moved <= thickness:
        return False
    first, first_radius = centre_of(model, q, i)
    last, last_radius = centre_of(model, q, j)
    x, y, z = first[0] - last[0], first[1] - last[1], first[2] - last[2]
    return math.sqrt(x * x + y * y + z * z) - first_radius - last_radius <= moved


@kernel
def met_by_rule(model: Any, q: FloatArray, recorder: Recorder) -> bool:
    """Whether a pair of the rule of the model may have met. All are looked at: bodies are as fast as that seldom."""
    n = len(model.contacts.rule_rank)
    depth = recorder.thickness
    body = model.contacts.surface_body
    for i in range(n):
        for j in range(i + 1, n):
            if body[i] == body[j] or is_barred(model, i, j):
                continue
            thickness = min(depth[i, 0] + depth[j, 1], depth[j, 0] + depth[i, 1])
            if may_have_met(model, q, i, j, thickness, recorder):
                return True
    return False


@kernel
def passes_near(model: SpatialModel, q: FloatArray, recorder: Recorder) -> bool:
    """``may_pass`` pair by pair, for surfaces that may have met in the step."""
    c = model.contacts
    depth = recorder.thickness
    met = False
    for w in range(len(c.pass_node)):
        i, j = c.pass_node[w], c.pass_feature[w]
        if may_have_met(model, q, i, j, depth[i, 0] + depth[j, 1], recorder):
            met = True
            break
    if not met and len(c.rule_rank) > 0:
        met = met_by_rule(model, q, recorder)
    if met:
        for k in range(len(q)):
            recorder.after[k] = q[k]
    return met


@kernel
def may_pass(model: SpatialModel, q: FloatArray, recorder: Recorder) -> bool:
    """Whether two bodies may have moved, in the step to q, by more than they can be inside each other."""
    least = recorder.thinnest
    if least == math.inf:
        return False
    most = 0.0
    for b in range(len(model.bodies.mass)):
        i = model.bodies.place[b]
        most = max(most, moved_frame(q, recorder.before, i) + travelled(model, b, q, recorder))
    return 2.0 * most > least and passes_near(model, q, recorder)
