"""What acts on the bodies of a scene at a stored instant: every force and moment with its point, and accelerations.

Loads, springs and dampers are those of the scene at (t, q, u); contact forces are those that were stored, on the pairs
that touch; reactions of joints follow from

    M udot = h + W lambda_c + J^T lambda,   J udot + b = 0

with the least lambda where joints are redundant. So all that is here balances to rounding, for every body.

Modes that the steps of a run do not follow (omega h > FOLLOWED, h the mean step, 0 of explicit methods with error
control, which follow all) swing with the steps, from a static state to as much on the other side, and not as the body
would: they are taken as static, qddot = qdot = 0 with whatever K q balances the rest. Where joints hold a body by such
modes alone they are not, for nothing else tells the reactions.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.contact.narrow_phase.feature import SEGMENT
from lcpflex.contact.rows import contact_rows
from lcpflex.contact.table import ContactTable
from lcpflex.dynamics.applied_forces import applied_forces, spring_stretch
from lcpflex.dynamics.body_forces import elastic_forces, inertial_forces
from lcpflex.dynamics.inertia import Arrow, arrow, factorise, solve_block
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.kinematics.joint_rows import joint_rows
from lcpflex.kinematics.relative import coordinate_gradient, relative_motion
from lcpflex.model.arrays import Loads, Model, frozen
from lcpflex.model.planar import N_RIGID
from lcpflex.results.contact_history import ContactPoints
from lcpflex.results.touching_pairs import TouchingPairs

__all__ = ["ActingForces", "PointLoad", "accelerations", "material_of"]

REDUNDANT = 1e-12
FOLLOWED = 2.0  # omega h: three steps a period
STILL = 1e12  # inertia of a mode that is held, over its own


class PointLoad(NamedTuple):
    """A force and a moment on the material of a body at a point, or between two as the weights say."""

    body: int
    points: tuple[tuple[int, float], ...]  # material points and their weights, of sum 1
    force: FloatArray  # (2,) [N], world axes
    moment: float  # about the point [N m]


class Material(NamedTuple):
    """The material at a point, in the frame of its body."""

    place: FloatArray  # x (2,) [m], undeformed
    moved: FloatArray  # s = x + Phi q (2,) [m]
    phi: FloatArray  # (n, 2)
    psi: FloatArray  # (n,)


def material_of(model: Model, q: FloatArray, load: PointLoad) -> Material:
    """The material that a load acts on."""
    points, dof = model.points, model.bodies.dof
    modal = q[int(dof[load.body]) + N_RIGID : int(dof[load.body + 1])]
    place, phi, psi = np.zeros(2), np.zeros((len(modal), 2)), np.zeros(len(modal))
    for p, weight in load.points:
        own = slice(int(points.start[p]), int(points.start[p + 1]))
        place, phi, psi = (
            place + weight * points.place[p],
            phi + weight * points.phi[own],
            psi + weight * points.psi[own],
        )
    return Material(place, place + modal @ phi, phi, psi)


class ActingForces:
    """Forces and accelerations of a compiled scene at stored instants; ``step``: mean one of the run [s].

    values: (m, slots, 3) of functions of a user's, where they are not here any more (:mod:`.outside_values`).

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
        self._compiled = compiled
        self._model: Any = pack(model)
        bodies = model.bodies
        still = np.sqrt(bodies.stiffness) * step > FOLLOWED
        # in the place of damping, which no acceleration counts with
        self._held: Any = pack(model._replace(bodies=bodies._replace(damping=frozen(STILL * still))))
        self.still = np.concatenate(
            [np.arange(d + N_RIGID, end)[still[d - N_RIGID * b : end - N_RIGID * (b + 1)]]
             for b, (d, end) in enumerate(pairwise(bodies.dof.tolist()))]
        )  # fmt: skip
        self._arrow = arrow(len(model.bodies.mass), len(model.bodies.stiffness))
        self._alone = [pack(model._replace(loads=one)) for one in _one_by_one(model.loads)]
        self._width = int(np.diff(model.bodies.dof).max())

    def outside(self, k: int, t: float, q: FloatArray, u: FloatArray) -> FloatArray:
        """(slots, 3) what functions of a user's give at the stored instant k."""
        if self._values is not None:
            return np.asarray(self._values[k])
        external = np.zeros((self._compiled.n_external, 3))
        for callback in self._compiled.callbacks:
            callback.fill(t, self._compiled.state(t, q, u), external)
        return external

    def at(
        self, k: int, touching: ContactPoints, t: float, q: FloatArray, u: FloatArray
    ) -> tuple[FloatArray, list[PointLoad]]:
        """udot (ndof,) and all loads at points of bodies, but weight, at the stored instant k.

        touching: the contacts there. u has no rates of the modes ``still``.

        Raises
        ------
        ModelError
            Where a contact force cannot be told the points it acts on.
        """
        model, q, u = self._model, q.copy(), u.copy()
        external = self.outside(k, t, q, u)
        loads: list[PointLoad] = []
        for alone in self._alone:
            self._apply(alone, t, q, u, external, loads)
        self._draw(q, u, loads)
        self._press(touching, t, q, loads)
        force = np.zeros_like(q)
        inertial_forces(model.bodies, model.loads, q, u, force)
        elastic_forces(model.bodies, q, u, force, force)
        for load in loads:
            self._add(q, load, force)
        return self._accelerated(t, q, u, external, force, loads), loads

    def _apply(
        self, alone: Any, t: float, q: FloatArray, u: FloatArray, external: FloatArray, loads: list[PointLoad]
    ) -> None:
        """Add one force or torque."""
        force, p, bodies = np.zeros_like(q), int(alone.loads.force_point[0]), self._compiled.model.bodies
        applied_forces(alone, t, q, u, np.zeros(2), external, force, force, force)
        b = int(self._compiled.model.points.body[p])
        if b >= 0:
            loads.append(self._load(q, p, force[int(bodies.dof[b]) : int(bodies.dof[b + 1])]))

    def _draw(self, q: FloatArray, u: FloatArray, loads: list[PointLoad]) -> None:
        """Add springs and dampers, which may be between two points of one body."""
        model, own = self._model, self._compiled.model.loads
        for k, (P, Q) in enumerate(own.spring_point.tolist()):
            at, motion, _ = relative_motion(model.bodies, model.points, q, u, P, Q)
            axis = own.spring_axis[k].tolist()
            gx, gy, turn_p, turn_q, _ = coordinate_gradient(int(own.spring_kind[k]), at, motion, *axis)
            rate = gx * motion.vx + gy * motion.vy + turn_p * motion.spin_p + turn_q * motion.spin_q
            size = -float(own.spring_value[k, 0] * spring_stretch(model, q, k) + own.spring_value[k, 1] * rate)
            for p, sign, turn in ((P, 1.0, turn_p), (Q, -1.0, turn_q)):
                b = int(self._compiled.model.points.body[p])
                if b >= 0:
                    loads.append(PointLoad(b, ((p, 1.0),), sign * size * np.array([gx, gy]), size * turn))

    def _press(self, touching: ContactPoints, t: float, q: FloatArray, loads: list[PointLoad]) -> None:
        """Add the contact forces."""
        rows = np.zeros((2, 2, self._width))
        pairs = TouchingPairs(self._compiled, self._model, t, q)
        for c in np.flatnonzero(touching.force.any(axis=1)).tolist():
            table, k, *_ = pairs.of(touching, c)
            contact_rows(self._model, q, table, k, rows[0], rows[1:])
            row = touching.force[c, 0] * rows[0] + touching.force[c, 1] * rows[1]
            if table.body[k, 0] >= 0:
                loads.append(self._load(q, int(table.node[k]), row[0]))
            if table.body[k, 1] >= 0:
                loads.append(self._on_feature(q, table, k, row[1]))

    def _on_feature(self, q: FloatArray, table: ContactTable, k: int, row: FloatArray) -> PointLoad:
        """On the centre of an arc, or between the ends of a segment."""
        if table.kind[k] != SEGMENT:
            return self._load(q, int(table.a[k]), row)
        s = float(table.s[k])
        ends = (int(table.a[k]), 1.0 - s), (int(table.b[k]), s)
        return PointLoad(int(table.body[k, 1]), ends, row[:2].copy(), 0.0)

    def _accelerated(
        self, t: float, q: FloatArray, u: FloatArray, external: FloatArray, force: FloatArray, loads: list[PointLoad]
    ) -> FloatArray:
        """udot (ndof,); adds the reactions of joints to the loads."""
        points, joints, dof = self._compiled.model.points, self._compiled.model.joints, self._compiled.model.bodies.dof
        count = int(joints.row[-1])
        if not count:
            factorise(self._held.bodies, q, 1.0, 0.0, self._arrow)
            return self._solved(force)
        rows, owner = np.zeros((count, 2, self._width)), np.zeros((count, 2), dtype=np.int64)
        wrench, rate, bias = np.zeros((count, N_RIGID)), np.zeros(count), np.zeros(count)
        joint_rows(self._model, t, q, u, external, rows, owner, wrench, rate, bias)
        J = np.zeros((count, len(q)))
        for r, side in np.argwhere(owner >= 0).tolist():
            b = int(owner[r, side])
            J[r, dof[b] : dof[b + 1]] += rows[r, side, : dof[b + 1] - dof[b]]
        factorise(self._held.bodies, q, float(self._may_hold(J)), 0.0, self._arrow)
        free = self._solved(force)
        spread = np.column_stack([self._solved(row) for row in J])
        reaction = -np.linalg.pinv(J @ spread, rcond=REDUNDANT, hermitian=True) @ (J @ free + bias)
        for joint, ends in enumerate(joints.point.tolist()):
            own = slice(int(joints.row[joint]), int(joints.row[joint + 1]))
            for side, p in enumerate(ends):
                if points.body[p] >= 0:
                    loads.append(self._load(q, p, reaction[own] @ rows[own, side]))
        return np.asarray(free + spread @ reaction)

    def _may_hold(self, J: FloatArray) -> bool:
        """Whether joints with the rows J hold bodies without the modes that are taken as static, too."""
        if not len(self.still):
            return True
        rest = J.copy()
        rest[:, self.still] = 0.0
        return bool(np.linalg.matrix_rank(rest) == np.linalg.matrix_rank(J))

    def _load(self, q: FloatArray, p: int, row: FloatArray) -> PointLoad:
        """The load at point p by its generalised force on the frame of the body: force, and moment about that frame."""
        model = self._compiled.model
        load = PointLoad(int(model.points.body[p]), ((p, 1.0),), row[:2].copy(), 0.0)
        s = material_of(model, q, load).moved
        x, y = _turned(-q[int(model.bodies.dof[load.body]) + 2], row[:2])
        return load._replace(moment=float(row[2] - s[0] * y + s[1] * x))

    def _add(self, q: FloatArray, load: PointLoad, force: FloatArray) -> None:
        """force += L^T F + the generalised force of the moment."""
        _, s, phi, psi = material_of(self._compiled.model, q, load)
        d = int(self._compiled.model.bodies.dof[load.body])
        own = _turned(-q[d + 2], load.force)
        force[d : d + 2] += load.force
        force[d + 2] += s[0] * own[1] - s[1] * own[0] + load.moment
        force[d + N_RIGID : d + N_RIGID + len(psi)] += phi @ own + psi * load.moment

    def _solved(self, force: FloatArray) -> FloatArray:
        return accelerations(self._held.bodies, self._arrow, force)


def accelerations(bodies: Any, work: Arrow, force: FloatArray) -> FloatArray:
    """M^-1 times a force (ndof,), by the factors of packed bodies."""
    out, dof = force.copy(), bodies.dof
    for b in range(len(dof) - 1):
        block = out[dof[b] : dof[b + 1]]
        solve_block(bodies, work, b, block, block)
    return out


def _turned(angle: float, v: FloatArray) -> FloatArray:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([cos * v[0] - sin * v[1], sin * v[0] + cos * v[1]])


def _one_by_one(loads: Loads) -> list[Loads]:
    """Each force and torque by itself."""
    none = {name: getattr(loads, name)[:0] for name in loads._fields if name != "gravity"}
    forces = [name for name in none if name.startswith("force_")]
    return [
        loads._replace(**none | {name: getattr(loads, name)[k : k + 1] for name in forces})
        for k in range(len(loads.force_kind))
    ]
