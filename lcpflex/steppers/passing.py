"""Whether a step of fixed length may have taken a body through another: a bound that costs next to nothing.

What it cannot exclude is examined outside of the loop (:mod:`lcpflex.steppers.passages`).
"""

from __future__ import annotations

import math

from lcpflex.contact.detection import bound
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.kinematics.configuration import advance
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID
from lcpflex.steppers.recorder import Tape

__all__ = ["may_pass", "set_out", "set_out_freely"]


@kernel
def set_out(q: FloatArray, tape: Tape) -> None:
    """Keep the configuration at the start of a step."""
    for i in range(len(q)):
        tape.before[i] = q[i]


@kernel
def set_out_freely(model: Model, q: FloatArray, u: FloatArray, step: float, tape: Tape) -> None:
    """``set_out``, and keep where the bodies would be without contact: what is moved out again was met by luck."""
    set_out(q, tape)
    advance(model, q, u, step, tape.free)


@kernel
def travelled(model: Model, b: int, q: FloatArray, tape: Tape) -> float:
    """How far the points of body b have moved against its frame in the step, at most [m]."""
    d = model.bodies.dof[b]
    sway = 0.0
    for m in range(d + N_RIGID, model.bodies.dof[b + 1]):
        sway += abs(q[m] - tape.before[m])
    return tape.farthest * abs(q[d + 2] - tape.before[d + 2]) + tape.sway[b] * sway


@kernel
def may_pass(model: Model, q: FloatArray, tape: Tape) -> bool:
    """Whether two bodies may have moved, in the step to q, by more than they can be inside each other."""
    least = tape.thinnest
    if least == math.inf:
        return False
    most = 0.0
    for b in range(len(model.bodies.mass)):
        d = model.bodies.dof[b]
        moved = abs(q[d] - tape.before[d]) + abs(q[d + 1] - tape.before[d + 1])
        most = max(most, moved + travelled(model, b, q, tape))
    return 2.0 * most > least and passes_near(model, q, tape)


@late_kernel
def passes_near(model: Model, q: FloatArray, tape: Tape) -> bool:
    """``may_pass`` pair by pair, for surfaces that may have met in the step."""
    c = model.contacts
    at = tape.table.bound
    bound(model, q, tape.table)
    for w in range(len(c.pass_slave)):
        if tape.pass_thickness[w] == math.inf:
            continue
        moved = 0.0
        x = 0.0
        y = 0.0
        sign = 1.0
        for s in (c.pass_slave[w], c.pass_feature[w]):
            b = c.surface_body[s]
            if b >= 0:
                d = model.bodies.dof[b]
                x += sign * (q[d] - tape.before[d])
                y += sign * (q[d + 1] - tape.before[d + 1])
                moved += travelled(model, b, q, tape)
            sign = -1.0
        moved += math.hypot(x, y)
        if moved <= tape.pass_thickness[w]:
            continue
        i = c.pass_slave[w]
        j = c.pass_feature[w]
        apart = math.hypot(at[i, 0] - at[j, 0], at[i, 1] - at[j, 1]) - at[i, 2] - at[j, 2]
        if apart - c.surface_extent[i] - c.surface_extent[j] <= moved:
            for k in range(len(q)):
                tape.after[k] = q[k]
            return True
    return False
