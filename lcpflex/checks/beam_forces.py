"""What accelerates a scene at stored instants, what pulls at its beams, and what holds them: see
:mod:`lcpflex.checks.axial_loads`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.checks.buckling import Support
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.contact.near import near
from lcpflex.contact.rows import contact_point, contact_rows
from lcpflex.dynamics.applied_forces import TORQUE, applied_forces, spring_stretch
from lcpflex.dynamics.body_forces import elastic_forces, inertial_forces
from lcpflex.dynamics.inertia import arrow, factorise
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import pack
from lcpflex.kinematics.joint_rows import joint_rows
from lcpflex.kinematics.relative import coordinate_gradient, relative_motion
from lcpflex.model.arrays import STICK, Loads
from lcpflex.model.planar import N_RIGID
from lcpflex.results.acting_forces import accelerations
from lcpflex.results.result import Result

__all__ = ["BeamForces", "Pulls"]

NEAR = 1e-3  # of the size of the scene: pairs among which those that press are looked for
REDUNDANT = 1e-12

Pulls = list[tuple[float, FloatArray]]  # station [m] and force (2,) [N], world axes


class BeamForces:
    """Accelerations of a scene, and what pulls at its beams, at stored instants."""

    def __init__(self, compiled: CompiledScene, beams: list[int]) -> None:
        self._compiled = compiled
        self._beams = beams
        self._model: Any = pack(compiled.model)
        bodies = compiled.model.bodies
        self._arrow = arrow(len(bodies.mass), len(bodies.stiffness))
        self._loads = [(b, x, pack(compiled.model._replace(loads=one))) for b, x, one in _single(compiled, beams)]
        self.supports: list[Support] = []  # joints, and contacts that press, at the instant that was looked at
        count, width = int(compiled.model.joints.row[-1]), int(np.diff(bodies.dof).max())
        rows = np.zeros((count, 2, width)), np.zeros((count, 2), dtype=np.int64), np.zeros((count, N_RIGID))
        self._rows = *rows, np.zeros(count), np.zeros(count)
        self._stretching = np.concatenate([_stretching(compiled, b) for b in beams])

    def at(self, result: Result, k: int) -> tuple[FloatArray, dict[int, Pulls]] | None:
        """udot (ndof,) and the pulls at each beam; None where a Python function of the scene cannot be asked again."""
        model, t, q, u = self._model, float(result.times[k]), result.q[k].copy(), result.u[k].copy()
        u[self._stretching] = 0.0
        external = np.zeros((self._compiled.n_external, 3))
        try:
            for callback in self._compiled.callbacks:
                callback.fill(t, self._compiled.state(t, q, u), external)
        except Exception:  # it was asked in the run: what is wrong with it now is no matter of the run
            return None
        pulls: dict[int, Pulls] = {b: [] for b in self._beams}
        self.supports = []
        force, span = np.zeros_like(q), np.zeros(2)
        for b, x, alone in self._loads:
            force[:] = 0.0
            applied_forces(alone, t, q, u, span, external, force, force, force)
            d = int(self._compiled.model.bodies.dof[b])
            pulls[b].append((x, force[d : d + 2].copy()))
        self._draw(q, u, pulls)
        force[:] = 0.0
        inertial_forces(model.bodies, model.loads, q, u, force)
        elastic_forces(model.bodies, q, u, force, force)
        applied_forces(model, t, q, u, span, external, force, force, force)
        self._press(result, k, q, force, pulls)
        return self._accelerated(t, q, u, external, force, pulls), pulls

    def _draw(self, q: FloatArray, u: FloatArray, pulls: dict[int, Pulls]) -> None:
        """Add the forces of springs and dampers, which may be between two points of one beam."""
        bodies, points, loads = self._model.bodies, self._model.points, self._model.loads
        for k in range(len(loads.spring_kind)):
            ends = [int(p) for p in loads.spring_point[k]]
            if not any(int(points.body[p]) in pulls for p in ends):
                continue
            at, motion, _ = relative_motion(bodies, points, q, u, *ends)
            of = int(loads.spring_kind[k]), at, motion, *loads.spring_axis[k].tolist()
            gx, gy, turn_p, turn_q, _ = coordinate_gradient(*of)
            rate = gx * motion.vx + gy * motion.vy + turn_p * motion.spin_p + turn_q * motion.spin_q
            stiffness, damping, _ = loads.spring_value[k]
            pull = -(stiffness * spring_stretch(self._model, q, k) + damping * rate) * np.array([gx, gy])
            for p, force in zip(ends, (pull, -pull), strict=True):
                if int(points.body[p]) in pulls:
                    pulls[int(points.body[p])].append((float(points.place[p, 0]), force))

    def _press(self, result: Result, k: int, q: FloatArray, force: FloatArray, pulls: dict[int, Pulls]) -> None:
        """Add the contact forces that were stored, on the pairs that touch there."""
        touching = result.contact_points
        pressing = np.flatnonzero((touching.record == k) & (touching.force[:, 0] > 0.0))
        if not len(pressing):
            return
        table, found = near(self._model, q, NEAR * self._compiled.size)
        places = np.array([contact_point(self._model, q, table, i) for i in range(found)]).reshape(found, 2)
        dof = self._compiled.model.bodies.dof
        rows = np.zeros((2, 2, int(np.diff(dof).max())))
        for point in pressing:
            own = np.flatnonzero(table.law[:found] == touching.contact[point])
            if not len(own):
                continue
            i = int(own[np.hypot(*(places[own] - touching.place[point]).T).argmin()])
            contact_rows(self._model, q, table, i, rows[0], rows[1:])
            self._hold(q, rows, table.body[i], touching, int(point))
            row = touching.force[point, 0] * rows[0] + touching.force[point, 1] * rows[1]
            for side, b in enumerate(table.body[i].tolist()):
                if b < 0:
                    continue
                force[dof[b] : dof[b + 1]] += row[side, : dof[b + 1] - dof[b]]
                if b in pulls:
                    d, away = int(dof[b]), touching.place[point] - q[dof[b] : dof[b] + 2]
                    pulls[b].append((float(np.cos(q[d + 2]) * away[0] + np.sin(q[d + 2]) * away[1]), row[side, :2]))

    def _hold(self, q: FloatArray, rows: FloatArray, bodies: IntArray, touching: Any, point: int) -> None:
        """A contact that presses holds its bodies along its normal, one that sticks along its tangent, too."""
        one, other = bodies.tolist()
        places = np.array([self._local(q, b, touching.place[point]) for b in (one, other)])
        for row in rows if touching.state[point] == STICK else rows[:1]:
            self.supports.append(Support(row.copy(), (one, other), places))

    def _local(self, q: FloatArray, b: int, place: FloatArray) -> FloatArray:
        """A place in the axes of body b."""
        if b < 0:
            return place
        d = int(self._compiled.model.bodies.dof[b])
        away, (cos, sin) = place - q[d : d + 2], (np.cos(q[d + 2]), np.sin(q[d + 2]))
        return np.array([cos * away[0] + sin * away[1], cos * away[1] - sin * away[0]])

    def _accelerated(
        self, t: float, q: FloatArray, u: FloatArray, external: FloatArray, force: FloatArray, pulls: dict[int, Pulls]
    ) -> FloatArray:
        """udot (ndof,); adds the reactions of the joints to the pulls."""
        model, (rows, owner, wrench, rate, bias) = self._model, self._rows
        points, joints, dof = self._compiled.model.points, self._compiled.model.joints, self._compiled.model.bodies.dof
        factorise(model.bodies, q, 0.0, 0.0, self._arrow)
        if not len(rate):
            return self._solved(force)
        joint_rows(model, t, q, u, external, rows, owner, wrench, rate, bias)
        J = np.zeros((len(rate), len(q)))
        for r, side in np.argwhere(owner >= 0).tolist():
            b = int(owner[r, side])
            J[r, dof[b] : dof[b + 1]] += rows[r, side, : dof[b + 1] - dof[b]]
        held = self._held(J)
        J, bias = np.vstack([J, held]), np.concatenate([bias, np.zeros(len(held))])
        free = self._solved(force)
        spread = np.column_stack([self._solved(row) for row in J])
        reaction = -np.linalg.pinv(J @ spread, rcond=REDUNDANT, hermitian=True) @ (J @ free + bias)
        for joint in range(len(joints.point)):
            own = slice(joints.row[joint], joints.row[joint + 1])
            places = points.place[joints.point[joint]]
            for r in range(own.start, own.stop):
                one, other = owner[r].tolist()
                self.supports.append(Support(rows[r].copy(), (one, other), places))
            for side in range(2):
                p = int(joints.point[joint, side])
                if int(points.body[p]) in pulls:
                    pulled = reaction[own] @ rows[own, side, :2]
                    pulls[int(points.body[p])].append((float(points.place[p, 0]), pulled))
        return np.asarray(free + spread @ reaction)

    def _held(self, J: FloatArray) -> FloatArray:
        """(k, ndof) rows that keep beams from vibrating along their axis; none where joints hold them there twice."""
        still = J.copy()
        still[:, self._stretching] = 0.0
        if np.linalg.matrix_rank(still) < np.linalg.matrix_rank(J):
            return np.zeros((0, J.shape[1]))
        return np.asarray(np.eye(J.shape[1])[self._stretching])

    def _solved(self, force: FloatArray) -> FloatArray:
        return accelerations(self._model.bodies, self._arrow, force)


def _stretching(compiled: CompiledScene, b: int) -> IntArray:
    """Coordinates of a beam that do not bend it."""
    axis, first = compiled.layout.axes[b], int(compiled.model.bodies.dof[b]) + N_RIGID
    assert axis is not None
    return first + np.flatnonzero(~axis.slope.any(axis=0))


def _single(compiled: CompiledScene, beams: list[int]) -> list[tuple[int, float, Loads]]:
    """Each force on a beam by itself: the beam, the station [m], and loads that are this one only."""
    loads, points = compiled.model.loads, compiled.model.points
    found = []
    for k in np.flatnonzero(loads.force_kind != TORQUE).tolist():
        p, one, none = int(loads.force_point[k]), slice(k, k + 1), slice(0, 0)
        if points.body[p] in beams:
            alone = loads._replace(
                spring_kind=loads.spring_kind[none], spring_point=loads.spring_point[none],
                spring_axis=loads.spring_axis[none], spring_value=loads.spring_value[none],
                force_kind=loads.force_kind[one], force_point=loads.force_point[one],
                force_signal=loads.force_signal[one],
            )  # fmt: skip
            found.append((int(points.body[p]), float(points.place[p, 0]), alone))
    return found
