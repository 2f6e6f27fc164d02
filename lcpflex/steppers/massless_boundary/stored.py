"""Instants of the massless-boundary scheme as they are stored: in the coordinates that bodies came with."""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.modal_places import first_amplitude, first_rate
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID
from lcpflex.solvers.semidefinite import dot
from lcpflex.steppers.massless_boundary.memory import BoundaryScheme
from lcpflex.steppers.recorder import Recorder

__all__ = ["combined", "turn_back"]


@kernel
def turn_back(model: Model, scheme: BoundaryScheme, recorder: Recorder) -> None:
    """The instant just stored in the coordinates that its bodies came with."""
    row = recorder.n_instants - 1
    dof = model.bodies.dof
    for b in range(len(dof) - 1):
        start = scheme.turn_start[b]
        if scheme.turn_start[b + 1] > start:
            d, e = first_rate(model, b), first_amplitude(model, b)
            rigid, n = d - dof[b], dof[b + 1] - d
            move_frame(model, scheme, start, b, n, recorder.q[row])
            for i in range(n):
                recorder.q[row, e + i] = combined(scheme, start, rigid + i, e, n, scheme.q)
                recorder.u[row, d + i] = combined(scheme, start, rigid + i, d, n, scheme.u)


@in_space("lcpflex.steppers.spatial.massless")
@kernel
def move_frame(model: Model, scheme: BoundaryScheme, start: int, b: int, n: int, q: FloatArray) -> None:
    """The frame of body b in q, as the scheme has it, along with static coordinates, which have no velocity."""
    e = first_amplitude(model, b)
    first = e - N_RIGID
    x, y = combined(scheme, start, 0, e, n, scheme.q), combined(scheme, start, 1, e, n, scheme.q)
    cos, sin = math.cos(q[first + 2]), math.sin(q[first + 2])
    q[first] += cos * x - sin * y
    q[first + 1] += sin * x + cos * y
    q[first + 2] += combined(scheme, start, 2, e, n, scheme.q)


@kernel
def combined(scheme: BoundaryScheme, start: int, i: int, first: int, n: int, values: FloatArray) -> float:
    """Row i of the matrix at ``start``, of a body with n modes, times its modal ``values``, from ``first`` on."""
    return dot(scheme.turn[start + i * n : start + (i + 1) * n], values, first, n)
