"""Instants of the massless-boundary scheme as they are stored: in the coordinates that bodies came with."""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID
from lcpflex.solvers.semidefinite import dot
from lcpflex.steppers.massless_boundary.memory import BoundaryScheme
from lcpflex.steppers.recorder import Recorder

__all__ = ["turn_back"]


@kernel
def turn_back(model: Model, scheme: BoundaryScheme, recorder: Recorder) -> None:
    """The instant just stored in the coordinates that its bodies came with."""
    row = recorder.n_instants - 1
    dof = model.bodies.dof
    for b in range(len(dof) - 1):
        start = scheme.turn_start[b]
        if scheme.turn_start[b + 1] > start:
            n = dof[b + 1] - dof[b] - N_RIGID
            move_frame(scheme, start, dof[b], n, recorder.q[row])
            for i in range(n):
                recorder.q[row, dof[b] + N_RIGID + i] = combined(scheme, start, N_RIGID + i, dof[b], n, scheme.q)
                recorder.u[row, dof[b] + N_RIGID + i] = combined(scheme, start, N_RIGID + i, dof[b], n, scheme.u)


@kernel
def move_frame(scheme: BoundaryScheme, start: int, first: int, n: int, q: FloatArray) -> None:
    """The frame at q[first], as the scheme has it, along with static coordinates, which have no velocity."""
    x, y = combined(scheme, start, 0, first, n, scheme.q), combined(scheme, start, 1, first, n, scheme.q)
    cos, sin = math.cos(q[first + 2]), math.sin(q[first + 2])
    q[first] += cos * x - sin * y
    q[first + 1] += sin * x + cos * y
    q[first + 2] += combined(scheme, start, 2, first, n, scheme.q)


@kernel
def combined(scheme: BoundaryScheme, start: int, i: int, first: int, n: int, values: FloatArray) -> float:
    """Row i of the matrix at ``start``, of the body at ``first`` with n modes, times its modal ``values``."""
    return dot(scheme.turn[start + i * n : start + (i + 1) * n], values, first + N_RIGID, n)
