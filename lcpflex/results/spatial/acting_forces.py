"""What acts on the bodies of a spatial scene at a stored instant: every force and moment, and accelerations.

As :mod:`lcpflex.results.acting_forces` in the plane: loads at (t, q, u), contact forces as they were stored
(:mod:`lcpflex.results.spatial.contact_wrenches`), and reactions of joints from

    M udot = h + W lambda_c + J^T lambda,   J udot + b = 0.

Joints in space are redundant as a rule. Of all lambda with the same motion the reactions of the least norm are taken,
sum of |F|^2 + |M|^2 / L^2 over all joints, M about P and L the extent of the largest body, as those of
:class:`lcpflex.results.joint_reaction.JointReaction`. With lambda_0 one of them, N a basis of J^T N = 0, and G lambda
the F and M / L of all joints,

    lambda = lambda_0 - N (G N)^+ G lambda_0.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.dynamics.spatial.applied_forces import effort
from lcpflex.dynamics.spatial.body_forces import elastic_forces, inertial_forces, weight_forces
from lcpflex.dynamics.spatial.inertia import factorise, factors
from lcpflex.dynamics.spatial.inertia_solve import solve_block
from lcpflex.dynamics.spatial.load_rows import spring_blocks
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import pack
from lcpflex.kinematics.spatial.frames import matrices
from lcpflex.kinematics.spatial.joint_rows import joint_rows
from lcpflex.model.arrays import frozen
from lcpflex.model.spatial import N_PLACE, N_RIGID, SpatialModel
from lcpflex.results.contact_history import ContactPoints
from lcpflex.results.spatial.contact_wrenches import contact_wrenches
from lcpflex.results.spatial.point_wrench import PointWrench

__all__ = ["Acting", "SpatialActingForces"]

DEPENDENT = 1e-10  # of the largest eigenvalue of J M^-1 J^T with a unit diagonal: rows that depend on others
SHARED = 1e-4  # of a combination of rows that moves nothing: the part that loads a body
FOLLOWED = 2.0  # omega h: three steps a period
STILL = 1e12  # inertia of a mode that is held, over its own


class Acting(NamedTuple):
    """All there is at an instant."""

    acceleration: FloatArray  # udot (nu,)
    loads: list[PointWrench]  # but weight
    shared: set[int]  # bodies whose joints share their load in ways that the motion does not tell


class Rows(NamedTuple):
    """Rows of joints at an instant."""

    blocks: FloatArray  # (r, 2, width)
    owner: IntArray  # (r, 2) body of each, -1: the ground
    bias: FloatArray  # (r,)
    J: FloatArray  # (r, nu)


class SpatialActingForces:
    """Forces and accelerations of a compiled spatial scene at stored instants; ``step``: mean one of the run [s].

    values: (m, slots, 3) of functions of a user's, where they are not here any more (:mod:`..outside_values`).

    Raises
    ------
    ModelError
        Where functions of time of the scene are not there any more, as in a result that was loaded.
    """

    def __init__(self, compiled: CompiledScene, step: float, values: FloatArray | None = None) -> None:
        model, self._values = compiled.model, values
        if values is None and compiled.functions_are_lost:
            raise ModelError(
                "result: its scene has Python functions of time, which no file holds, and what they gave was not "
                "saved; expected the result of a run in this process, not one that was loaded"
            )
        assert isinstance(model, SpatialModel)
        self._compiled, self._own = compiled, model
        self._model: Any = pack(model)
        bodies = model.bodies
        still = np.sqrt(bodies.stiffness) * step > FOLLOWED
        # in the place of damping, which no acceleration counts with
        self._held: Any = pack(bodies._replace(damping=frozen(STILL * still)))
        self.still = np.concatenate(
            [np.arange(d + N_RIGID, end)[still[d - N_RIGID * b : end - N_RIGID * (b + 1)]]
             for b, (d, end) in enumerate(pairwise(bodies.dof.tolist()))]
        )  # fmt: skip
        self._arrow = factors(bodies)
        self._width = int(np.diff(bodies.dof).max())

    def outside(self, k: int, t: float, q: FloatArray, u: FloatArray) -> FloatArray:
        """(slots, 3) what functions of a user's give at the stored instant k."""
        if self._values is not None:
            return np.asarray(self._values[k])
        external = np.zeros((self._compiled.n_external, 3))
        for callback in self._compiled.callbacks:
            callback.fill(t, self._compiled.state(t, q, u), external)
        return external

    def at(self, k: int, touching: ContactPoints, t: float, q: FloatArray, u: FloatArray) -> Acting:
        """What acts at the stored instant k; touching: the contacts there. u has no rates of the modes ``still``.

        Raises
        ------
        ModelError
            Where a contact force cannot be told the points it acts on.
        """
        model, q, u = self._model, q.copy(), u.copy()
        external = self.outside(k, t, q, u)
        force, lost = np.zeros_like(u), np.zeros_like(u)
        inertial_forces(model.bodies, q, u, self._arrow, force)
        weight_forces(model.bodies, model.loads, q, self._arrow, force)
        elastic_forces(model.bodies, q, u, force, lost)
        force += lost
        loads = [*self._efforts(t, q, external), *self._springs(q, u)]
        loads += contact_wrenches(self._compiled, model, touching, t, q)
        for load in loads:
            force[self._dofs(load.body)] += load.block
        if not int(self._own.joints.row[-1]):
            factorise(self._held, q, 1.0, 0.0, self._arrow)
            return Acting(self._solved(force), loads, set())
        return self._joined(self._rows(t, q, u, external), q, force, loads)

    def _dofs(self, b: int) -> slice:
        dof = self._own.bodies.dof
        return slice(int(dof[b]), int(dof[b + 1]))

    def _wrenches(self, ends: list[int], blocks: FloatArray) -> list[PointWrench]:
        """On material points but those of the ground."""
        owners = [int(self._own.points.body[p]) for p in ends]
        size = [self._dofs(b).stop - self._dofs(b).start for b in owners]
        return [
            PointWrench(b, ((p, 1.0),), block[:n].copy())
            for b, p, block, n in zip(owners, ends, blocks, size, strict=True)
            if b >= 0
        ]

    def _efforts(self, t: float, q: FloatArray, external: FloatArray) -> list[PointWrench]:
        found = []
        for k, p in enumerate(self._own.loads.force_point.tolist()):
            b = int(self._own.points.body[p])
            if b >= 0:
                force = np.zeros(int(self._own.bodies.dof[-1]))
                effort(self._model, q, k, t, np.zeros(2), external, force)
                found.append(PointWrench(b, ((p, 1.0),), force[self._dofs(b)]))
        return found

    def _springs(self, q: FloatArray, u: FloatArray) -> list[PointWrench]:
        """Of springs and dampers, which may be between two points of one body."""
        found: list[PointWrench] = []
        for k, ends in enumerate(self._own.loads.spring_point.tolist()):
            blocks = np.zeros((2, self._width))
            spring_blocks(self._model, q, u, k, *blocks)
            found += self._wrenches(ends, blocks)
        return found

    def _rows(self, t: float, q: FloatArray, u: FloatArray, external: FloatArray) -> Rows:
        count = int(self._own.joints.row[-1])
        blocks, owner = np.zeros((count, 2, self._width)), np.zeros((count, 2), dtype=np.int64)
        wrench, rate, bias = np.zeros((count, N_RIGID)), np.zeros(count), np.zeros(count)
        joint_rows(self._model, t, q, u, external, blocks, owner, wrench, rate, bias)
        J = np.zeros((count, len(u)))
        for r, side in np.argwhere(owner >= 0).tolist():
            own = self._dofs(int(owner[r, side]))
            J[r, own] += blocks[r, side, : own.stop - own.start]
        return Rows(blocks, owner, bias, J)

    def _joined(self, rows: Rows, q: FloatArray, force: FloatArray, loads: list[PointWrench]) -> Acting:
        """With the reactions of joints."""
        spread, scale, value, mode = self._spectrum(rows.J, q)
        free, kept = self._solved(force), value > DEPENDENT * value[-1]
        inverse = (mode[:, kept] / value[kept]) @ mode[:, kept].T
        reaction = -scale * (inverse @ (scale * (rows.J @ free + rows.bias)))
        shared: set[int] = set()
        if not kept.all():
            idle = scale[:, None] * mode[:, ~kept]
            G = self._geometry(rows, q)
            reaction = reaction - idle @ np.linalg.lstsq(G @ idle, G @ reaction, rcond=None)[0]
            shared = self._sharing(rows, idle)
        for joint, ends in enumerate(self._own.joints.point.tolist()):
            own = self._rows_of(joint)
            loads += self._wrenches(ends, np.einsum("r,rsw->sw", reaction[own], rows.blocks[own]))
        return Acting(np.asarray(free + spread @ reaction), loads, shared)

    def _rows_of(self, joint: int) -> slice:
        row = self._own.joints.row
        return slice(int(row[joint]), int(row[joint + 1]))

    def _spectrum(self, J: FloatArray, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """M^-1 J^T, a scale of the rows, and eigenvalues and modes of J M^-1 J^T so scaled; A is factorised then.

        The modes ``still`` are held, unless joints hold bodies by them alone.
        """
        factorise(self._held, q, 0.0, 0.0, self._arrow)
        spread = np.column_stack([self._solved(row) for row in J])
        W = J @ spread
        diagonal = np.diag(W)
        scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        value, mode = np.linalg.eigh(scale[:, None] * W * scale)
        if not len(self.still):
            return spread, scale, value, mode
        factorise(self._held, q, 1.0, 0.0, self._arrow)
        stiff = np.column_stack([self._solved(row) for row in J])
        rigid = np.linalg.eigh(scale[:, None] * (J @ stiff) * scale)
        if _rank(rigid[0]) == _rank(value):
            return stiff, scale, *rigid
        factorise(self._held, q, 0.0, 0.0, self._arrow)
        return spread, scale, value, mode

    def _geometry(self, rows: Rows, q: FloatArray) -> FloatArray:
        """(6 nj, r) F and M / L on the body of P, M about P, of all joints, by multipliers; each in axes of a body."""
        G = np.zeros((6 * len(self._own.joints.point), len(rows.J)))
        for joint, (p, other) in enumerate(self._own.joints.point.tolist()):
            side = 0 if self._own.points.body[p] >= 0 else 1
            b = int(self._own.points.body[p if side == 0 else other])
            if b < 0:
                continue
            own, i = self._rows_of(joint), int(self._own.bodies.place[b])
            A = matrices(q[i + 3 : i + N_PLACE])
            arm = A.T @ (self._place(p, q) - q[i : i + 3])
            force = rows.blocks[own, side, :3] @ A
            moment = rows.blocks[own, side, 3:6] - np.cross(arm, force)
            G[6 * joint : 6 * joint + 3, own] = force.T
            G[6 * joint + 3 : 6 * joint + 6, own] = moment.T / self._compiled.size
        return G

    def _place(self, p: int, q: FloatArray) -> FloatArray:
        """r of a material point (3,) [m]."""
        points, b = self._own.points, int(self._own.points.body[p])
        if b < 0:
            return np.asarray(points.place[p])
        i, end = int(self._own.bodies.place[b]), int(self._own.bodies.place[b + 1])
        s = points.place[p] + q[i + N_PLACE : end] @ points.phi[int(points.start[p]) : int(points.start[p + 1])]
        return np.asarray(q[i : i + 3] + matrices(q[i + 3 : i + N_PLACE]) @ s)

    def _sharing(self, rows: Rows, idle: FloatArray) -> set[int]:
        """Bodies that combinations ``idle`` (r, k) of rows, which move nothing, load by several joints or points."""
        weight = np.array([1.0] * 3 + [1.0 / self._compiled.size] * 3)
        wrench: dict[int, list[FloatArray]] = {}
        for joint in range(len(self._own.joints.point)):
            own = self._rows_of(joint)
            for side in range(2):
                b = int(rows.owner[own.start, side])
                if b >= 0:
                    part = np.einsum("rk,rw->kw", idle[own], rows.blocks[own, side, :6]) * weight
                    wrench.setdefault(b, []).append(part)
        size = {b: max(float(np.abs(part).max()) for part in parts) for b, parts in wrench.items()}
        largest = max(size.values(), default=0.0)
        return {b for b, one in size.items() if one > SHARED * largest}

    def _solved(self, force: FloatArray) -> FloatArray:
        out, bodies = force.copy(), self._held
        for b in range(len(self._own.bodies.mass)):
            block = out[self._dofs(b)]
            solve_block(bodies, self._arrow, b, block, block)
        return out


def _rank(values: FloatArray) -> int:
    return int(np.count_nonzero(values > DEPENDENT * values[-1]))
