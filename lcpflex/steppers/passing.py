"""Whether a step of fixed length may have taken a body through another: a bound that costs next to nothing.

What it cannot exclude is examined outside of the loop (:mod:`lcpflex.steppers.passages`).
"""

from __future__ import annotations

import math

from lcpflex.contact.bounds import bound
from lcpflex.contact.broad_phase import near_pairs
from lcpflex.contact.rule_pairs import is_barred, is_node_side
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.configuration import advance
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID
from lcpflex.steppers.recorder import Recorder

__all__ = ["may_pass", "set_out", "set_out_freely"]


@kernel
def set_out(q: FloatArray, recorder: Recorder) -> None:
    """Keep the configuration at the start of a step."""
    for i in range(len(q)):
        recorder.before[i] = q[i]


@kernel
def set_out_freely(model: Model, q: FloatArray, u: FloatArray, step: float, recorder: Recorder) -> None:
    """``set_out``, and keep where the bodies would be without contact: what is moved out again was met by luck."""
    set_out(q, recorder)
    advance(model, q, u, step, recorder.free)


@kernel
def travelled(model: Model, b: int, q: FloatArray, recorder: Recorder) -> float:
    """How far the points of body b have moved against its frame in the step, at most [m]."""
    d = model.bodies.dof[b]
    deflection = 0.0
    for m in range(d + N_RIGID, model.bodies.dof[b + 1]):
        deflection += abs(q[m] - recorder.before[m])
    return recorder.farthest * abs(q[d + 2] - recorder.before[d + 2]) + recorder.deflection[b] * deflection


@in_space("lcpflex.steppers.spatial.passing")
@kernel
def may_pass(model: Model, q: FloatArray, recorder: Recorder) -> bool:
    """Whether two bodies may have moved, in the step to q, by more than they can be inside each other."""
    least = recorder.thinnest
    if least == math.inf:
        return False
    most = 0.0
    for b in range(len(model.bodies.mass)):
        d = model.bodies.dof[b]
        moved = abs(q[d] - recorder.before[d]) + abs(q[d + 1] - recorder.before[d + 1])
        most = max(most, moved + travelled(model, b, q, recorder))
    return 2.0 * most > least and passes_near(model, q, most, recorder)


@kernel
def may_have_met(model: Model, q: FloatArray, i: int, j: int, recorder: Recorder) -> bool:
    """Whether nodes of surface i and surface j have moved by more than they can be inside each other, and are near."""
    thickness = recorder.thickness[i, 0] + recorder.thickness[j, 1]
    if thickness == math.inf:
        return False
    c = model.contacts
    at = recorder.table.bound
    moved = 0.0
    x = 0.0
    y = 0.0
    sign = 1.0
    for s in (i, j):
        b = c.surface_body[s]
        if b >= 0:
            d = model.bodies.dof[b]
            x += sign * (q[d] - recorder.before[d])
            y += sign * (q[d + 1] - recorder.before[d + 1])
            moved += travelled(model, b, q, recorder)
        sign = -1.0
    moved += math.hypot(x, y)
    if moved <= thickness:
        return False
    apart = math.hypot(at[i, 0] - at[j, 0], at[i, 1] - at[j, 1]) - at[i, 2] - at[j, 2]
    return apart - c.surface_extent[i] - c.surface_extent[j] <= moved


@kernel
def met_by_rule(model: Model, q: FloatArray, most: float, recorder: Recorder) -> bool:
    """Whether a pair of the rule of the model may have met; ``most``: how far a body has moved [m]."""
    pairs = recorder.table.pairs
    found = near_pairs(model, recorder.table, 2.0 * most)
    if found < 0:
        return True  # too many to be told apart: they are examined
    for k in range(found):
        i = pairs.found[k, 0]
        j = pairs.found[k, 1]
        if is_barred(model, i, j):
            continue
        if is_node_side(model, i, j) and may_have_met(model, q, i, j, recorder):
            return True
        if is_node_side(model, j, i) and may_have_met(model, q, j, i, recorder):
            return True
    return False


@late_kernel
def passes_near(model: Model, q: FloatArray, most: float, recorder: Recorder) -> bool:
    """``may_pass`` pair by pair, for surfaces that may have met in the step; bodies moved by ``most`` [m] at most."""
    c = model.contacts
    bound(model, q, recorder.table)
    met = False
    for w in range(len(c.pass_node)):
        if may_have_met(model, q, c.pass_node[w], c.pass_feature[w], recorder):
            met = True
            break
    if not met and len(c.rule_rank) > 0:
        met = met_by_rule(model, q, most, recorder)
    if met:
        for k in range(len(q)):
            recorder.after[k] = q[k]
    return met
