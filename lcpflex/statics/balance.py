"""Forces and constraint rows of a configuration at rest, as dense arrays.

    h(q) + J^T mu + W_N lambda_N + W_T lambda_T = 0,    phi(q) = 0,    0 <= g(q)  _|_  lambda_N >= 0

h holds all generalised forces at u = 0 and one time; rows are ordered [joints; normals; tangents of contacts with
friction], in space two tangents of a contact one behind the other. Kernels are those of the steppers, so that what
balances here balances there. Forces and rows belong to velocities, and so do displacements dq: ndof numbers, of which a
configuration of space has one more a body (:mod:`lcpflex.kinematics.configuration`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lcpflex.contact.detection import detect
from lcpflex.dynamics import mechanics
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.kinematics.configuration import advance, difference
from lcpflex.kinematics.joint_rows import joint_residual
from lcpflex.model.coordinates import ANGULAR
from lcpflex.model.layout import is_spatial
from lcpflex.statics.stiffness_columns import lay_contacts, stiffness_columns

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene

__all__ = ["Balance", "Configuration", "Push"]


@dataclass(frozen=True, slots=True, eq=False)
class Configuration:
    """What :class:`Balance` tells of a configuration with r joint rows, n contacts and m tangential rows."""

    q: FloatArray  # (nq,), as many as ndof in the plane
    force: FloatArray  # (ndof,) h
    phi: FloatArray  # (r,) [m] or [rad]
    turns: NDArray[np.bool_]  # (r,) whether phi is in [rad]
    gap: FloatArray  # (n,) [m]
    friction: FloatArray  # (n,) mu
    tangent: IntArray  # (m,) contact of each tangential row
    d: int  # tangential rows of a contact with friction, one behind the other: 1, in space 2
    rows: FloatArray  # (r + n + m, ndof)

    @property
    def n_joint(self) -> int:
        """r."""
        return len(self.phi)

    @property
    def n_contacts(self) -> int:
        """n."""
        return len(self.gap)


@dataclass(slots=True, eq=False)
class Push:
    """A coordinate that is driven: by ``way`` [m] or [rad] along ``row`` (ndof,) from the configuration ``start``."""

    row: FloatArray
    start: FloatArray
    way: float
    turns: bool  # whether it is an angle


class Balance:
    """Forces and rows of a compiled scene at a ``time`` [s]. ``table`` holds what :meth:`look` found last.

    ``push``: what is driven beside the joints, as their last row; None for nothing.
    """

    def __init__(self, compiled: CompiledScene, time: float = 0.0) -> None:
        self.compiled, self.time = compiled, time
        self._system = compiled.system()
        self.model = self._system.model
        self._supply = self._system.hooks.get(mechanics.supply)
        self._still = np.zeros(len(compiled.u))
        self._work = self._system.workspace(16)
        self.n_contacts = 0
        self.push: Push | None = None

    @property
    def work(self) -> Workspace:
        """Memory, with the table of contacts and the rows laid last."""
        return self._work

    def moved(self, q: FloatArray, dq: FloatArray) -> FloatArray:
        """q (nq,) moved by dq (ndof,): their sum in the plane, rotations of space one behind the other."""
        there = np.empty(len(q))
        advance(self.model, q, dq, 1.0, there)
        return there

    def difference(self, q: FloatArray, before: FloatArray) -> FloatArray:
        """The dq (ndof,) that moves ``before`` (nq,) to q (nq,), rotations of space the shortest way."""
        dq = np.empty(len(self._still))
        difference(self.model, before, q, dq)
        return dq

    def tangents(self, k: int) -> FloatArray:
        """(2, 3) t1 and t2 of contact k, found last, world axes; in the plane (1, 1): a number is along t."""
        if not is_spatial(self.model):
            return np.eye(1)
        table: Any = self._work.rows.table
        return np.stack([table.tangent[k], np.cross(table.normal[k], table.tangent[k])])

    def crossing(self) -> NDArray[np.bool_]:
        """(n,) which contacts found last are where edges of space cross."""
        found = np.zeros(self.n_contacts, bool)
        if is_spatial(self.model) and self.n_contacts:
            from lcpflex.contact.spatial.table import WITH_EDGE  # which planar scenes do without

            found = WITH_EDGE[self._work.rows.table.kind[: self.n_contacts]]
        return found

    def pushed_to(self, q: FloatArray) -> None:
        """Count what is left of the push from q (nq,) on: of a turn in space no more than half of one can be told."""
        if self.push is not None and is_spatial(self.model):
            left = -self._off(self.push, q)
            self.push.start, self.push.way = q.copy(), left

    def _off(self, push: Push, q: FloatArray) -> float:
        """How far q is off the end of a push."""
        if is_spatial(self.model):
            return float(push.row @ self.difference(q, push.start)) - push.way
        return float(push.row @ q - (float(push.row @ push.start) + push.way))

    def look(self, q: FloatArray, margin: float) -> Configuration:
        """Forces and rows at q (nq,), with all contacts whose gap is ``margin`` [m] at most."""
        while (found := int(detect(self.model, q, margin, self._work.rows.table))) > len(self._work.rows.table.key):
            self._work = self._system.workspace(2 * found)
        self.n_contacts = found
        return self.again(q)

    def again(self, q: FloatArray) -> Configuration:
        """Forces and rows at q (nq,), with the contacts found last."""
        work, n = self._work, self.n_contacts
        self._lay(q)
        n_joint = len(work.scratch.residual)
        n_tangent = int(work.rows.n_tangents)
        total = n_joint + n + n_tangent
        rows = np.zeros((total, len(self._still) + 1))
        columns = self._columns(total)
        each = np.arange(total)[:, None]
        for side in range(2):
            np.add.at(rows, (each, columns[:, side]), work.rows.J[:total, side])
        rows, phi = rows[:, :-1].copy(), work.scratch.residual.copy()
        turns = ANGULAR[self.model.joints.kind]
        if self.push is not None:
            rows = np.insert(rows, n_joint, self.push.row, axis=0)
            phi, turns = np.append(phi, self._off(self.push, q)), np.append(turns, self.push.turns)
        return Configuration(
            q=q.copy(),
            force=work.free.total.copy(),
            phi=phi,
            turns=turns,
            gap=work.rows.table.gap[:n].copy(),
            friction=work.rows.mu[:n].copy(),
            tangent=work.rows.tangent[:n_tangent].copy(),
            d=int(work.rows.across),
            rows=rows,
        )

    def pull(self, q: FloatArray, p: FloatArray) -> FloatArray:
        """h + rows^T p (ndof,) at q (nq,) with the contacts found last and the multipliers p of all rows."""
        self._lay(q)
        pushed = np.zeros(len(self._still))
        if self.push is not None:
            n_joint = len(self._work.scratch.residual)
            pushed, p = p[n_joint] * self.push.row, np.delete(p, n_joint)
        columns = self._columns(len(p))
        parts = (self._work.rows.J[: len(p)] * p[:, None, None]).ravel()
        held = np.bincount(columns.ravel(), weights=parts, minlength=len(pushed) + 1)[:-1]
        return np.asarray(self._work.free.total + pushed + held)

    def stiffness(self, q: FloatArray, p: FloatArray, step: FloatArray) -> FloatArray:
        """-d(h + rows^T p)/dq (ndof, ndof) by central differences of ``step`` (ndof,), p of fixed size."""
        n = len(self._still)
        K = np.zeros((n, n), order="F")
        if self._supply is not None:
            return self._supplied_stiffness(q, p, step, K)
        work, r = self._work, len(self._work.scratch.residual)
        own = p if self.push is None else np.delete(p, r)
        self._lay(q)
        tangent = work.rows.tangent[: work.rows.n_tangents : int(work.rows.across)]
        first = np.full(self.n_contacts, -1)
        first[tangent] = r + self.n_contacts + int(work.rows.across) * np.arange(len(tangent))
        room = np.empty((2, len(q))), np.empty(n)
        stiffness_columns(self.model, self.time, q, self._still, step, own, first, *room, work, K)
        return K

    def _supplied_stiffness(self, q: FloatArray, p: FloatArray, step: FloatArray, K: FloatArray) -> FloatArray:
        """:meth:`stiffness` with forces by Python functions, which may depend on the state."""
        for i in range(len(step)):
            way = np.zeros(len(step))
            way[i] = step[i]
            ahead, behind = self.moved(q, way), self.moved(q, -way)
            apart = self.difference(ahead, behind)[i]  # which rounding of q makes another length than 2 steps
            K[:, i] = (self.pull(behind, p) - self.pull(ahead, p)) / apart
        return K

    def _lay(self, q: FloatArray) -> None:
        """Forces to ``work.free.total``, rows of joints and contacts to ``work.rows.J``."""
        model, work, n = self.model, self._work, self.n_contacts
        n_joint = len(work.scratch.residual)
        if self._supply is not None:
            self._supply(model, self.time, q, self._still, work)
        mechanics.forces(model, self.time, q, self._still, work)
        if n_joint:
            mechanics.fill_joint_rows(model, self.time, q, self._still, work.free.external, work.rows)
            joint_residual(model, self.time, q, work.free.external, work.scratch.residual)
        n_tangent = lay_contacts(model, q, n, n_joint, work.rows) if n else 0
        mechanics.count_rows(work.rows, n_joint, n, n_tangent)

    def _columns(self, total: int) -> IntArray:
        """(total, 2, width) of each entry of ``work.rows.J`` among the ndof; ndof where there is none."""
        dof, bodies = self._work.rows.dof, self._work.rows.body[:total]
        known = np.maximum(bodies, 0)
        columns = dof[known][:, :, None] + np.arange(self._work.rows.J.shape[2])
        columns[(columns >= dof[known + 1][:, :, None]) | (bodies < 0)[:, :, None]] = len(self._still)
        return np.asarray(columns)
