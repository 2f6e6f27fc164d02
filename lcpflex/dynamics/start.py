"""Consistent start: how far a state violates the joints, and its projection onto them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lcpflex.dynamics.mass_matrix import mass_matrix
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.leaf import in_space
from lcpflex.jit.struct import pack
from lcpflex.kinematics.configuration import advance
from lcpflex.kinematics.joint_rows import joint_residual, joint_rows
from lcpflex.model.arrays import Model
from lcpflex.model.layout import dimension

__all__ = ["Violation", "correctable", "project", "violation"]

ITERATIONS = 50
NO_STEP = 1e-15  # of the largest number in q: a correction that is rounding
INDEPENDENT = 1e-12  # singular values of J M^-1 J^T below this part of the largest belong to redundant joint rows


@dataclass(frozen=True, slots=True)
class Violation:
    """Joint constraints of a state, r rows."""

    position: FloatArray  # (r,) phi [m] or [rad]
    velocity: FloatArray  # (r,) phidot = J u + dphi/dt [m/s] or [rad/s]
    speed: FloatArray  # (r,) sum of |J_k u_k| and |dphi/dt|: the size that rounding in phidot is to be compared with
    rate: FloatArray  # (r,) dphi/dt
    rows: FloatArray  # (r, 2, width) J, the blocks of the two bodies of each row
    columns: IntArray  # (r, 2, width) of each entry of ``rows`` among the ndof; ndof where there is none
    ndof: int

    @property
    def jacobian(self) -> FloatArray:
        """(r, ndof) J, dense: its size is the square of that of a chain."""
        J = np.zeros((len(self.rows), self.ndof + 1))
        np.add.at(J, (np.arange(len(J))[:, None, None], self.columns), self.rows)
        return J[:, :-1].copy()


def violation(model: Model, q: FloatArray, u: FloatArray, external: FloatArray, time: float = 0.0) -> Violation:
    """phi, phidot and J of all joints at a ``time``; ``external`` (slots, 3) holds what callbacks supply then."""
    model = pack(model)
    count = int(model.joints.row[-1])
    dof = model.bodies.dof
    width = int(np.max(np.diff(dof), initial=1))
    rows = np.zeros((count, 2, width))
    row_body = np.zeros((count, 2), dtype=np.int64)
    wrench = np.zeros((count, dimension(model.bodies).rigid))
    phi, rate, bias = np.zeros(count), np.zeros(count), np.zeros(count)
    joint_residual(model, time, q, external, phi)
    joint_rows(model, time, q, u, external, rows, row_body, wrench, rate, bias)
    columns = dof[np.maximum(row_body, 0)][:, :, None] + np.arange(width)
    columns[(columns >= dof[np.maximum(row_body, 0) + 1][:, :, None]) | (row_body < 0)[:, :, None]] = len(u)
    moved = rows * np.append(u, 0.0)[columns]
    rates = moved.sum(axis=(1, 2)) + rate
    return Violation(phi, rates, np.abs(moved).sum(axis=(1, 2)) + np.abs(rate), rate, rows, columns, len(u))


def project(
    model: Model, q: FloatArray, u: FloatArray, external: FloatArray, tolerance: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The state nearest to (q, u), in the mass metric, that fulfils the joints to ``tolerance`` (r,).

    q by Newton steps with the velocity -M^-1 J^T (J M^-1 J^T)^-1 phi, u by one such step of phidot. Where the joints
    cannot be fulfilled the state returned still violates them: redundant ones that contradict each other as little as
    it can be.
    """
    model, q = pack(model), q.copy()
    for _ in range(ITERATIONS):
        state = violation(model, q, u, external)
        if (np.abs(state.position) <= tolerance).all():
            break
        moved = nearest(model, mass_matrix(model, q), state.jacobian, state.position)
        advance(model, q, -moved, 1.0, q)
        if not np.abs(moved).max(initial=0.0) > NO_STEP * (1.0 + np.abs(q).max()):
            break
    state = violation(model, q, u, external)
    J = state.jacobian
    return q, u - nearest(model, mass_matrix(model, q), J, J @ u + state.rate)


def correctable(model: Model, q: FloatArray, state: Violation) -> FloatArray:
    """(r,) the part of ``state.position`` at q that a projection would take away, to first order: |J dq|."""
    model, J = pack(model), state.jacobian
    return np.asarray(np.abs(J @ nearest(model, mass_matrix(model, q), J, state.position)))


@in_space("lcpflex.dynamics.spatial.start")
def nearest(model: Model, M: FloatArray, J: FloatArray, residual: FloatArray) -> FloatArray:
    """The shortest d, in the metric of M, with J d = residual; redundant rows allowed.

    Rows are made alike in size first: beside an angle in rad, a length of a small body in m would count as redundant.
    """
    spread = np.linalg.solve(M, J.T)
    S = J @ spread
    size = np.sqrt(np.maximum(np.diag(S), 0.0))
    unit = 1.0 / np.where(size > 0.0, size, 1.0)
    inverse = np.linalg.pinv(S * np.outer(unit, unit), rcond=INDEPENDENT, hermitian=True)
    return np.asarray(spread @ (unit * (inverse @ (unit * residual))))
