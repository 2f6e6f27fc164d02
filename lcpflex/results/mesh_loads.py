"""What acts on a meshed planar body, as loads of its nodes: that of which stresses have a static part."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.bodies.fem.nodal_material import displacement_rows, material_weights, neighbours
from lcpflex.kinematics.places import turned
from lcpflex.model.planar import N_RIGID
from lcpflex.results.acting_forces import ActingForces

if TYPE_CHECKING:
    from lcpflex.bodies.reduction.mesh_stress import MeshStress
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result

__all__ = ["PlanarMeshLoads"]


class PlanarMeshLoads:
    """On body ``b`` of a compiled scene; ``step``: mean one of the run [s].

    still : modes that are taken as static, see :mod:`lcpflex.results.acting_forces`
    """

    def __init__(self, result: Result, compiled: CompiledScene, b: int, step: float) -> None:
        self._result, self._model, self._b = result, compiled.model, b
        self._acting = ActingForces(compiled, step, result.outside)
        self.still = self._acting.still
        d, end = (int(k) for k in compiled.model.bodies.dof[b : b + 2])
        self._frame = slice(d, d + N_RIGID)
        self._modal = np.setdiff1d(np.arange(d + N_RIGID, end), self.still)
        self._known: dict[tuple[float, float], FloatArray] = {}
        self._near_to: Any = None

    def of(self, mesh: MeshStress, record: int) -> FloatArray:
        """(f,) nodal loads of all that acts at a stored instant, inertia as well [N], in the axes of the body."""
        result, model, k = self._result, self._model, record
        q, u = result.q[k], result.u[k].copy()
        u[self.still] = 0.0
        acceleration, loads = self._acting.at(k, result.contact_points.at(k), float(result.times[k]), q, u)
        felt = self._felt(mesh, q, u, acceleration).ravel()[mesh.mesh.dofs]
        total = np.asarray(mesh.mesh.mass @ felt)
        back = np.array(-q[self._frame][2])
        for load in loads:
            if load.body == self._b:
                at = [(*model.points.place[p].tolist(), weight) for p, weight in load.points]
                rows = sum((w * self._rows(mesh, x, y) for x, y, w in at), np.zeros((len(total), 3)))
                total += rows[:, :2] @ turned(back, load.force) + rows[:, 2] * load.moment
        return total

    def _rows(self, mesh: MeshStress, x: float, y: float) -> FloatArray:
        """(f, 3) nodal loads of unit forces and a unit moment on the material at (x, y)."""
        if self._near_to is None:
            self._near_to = neighbours(mesh.mesh)
        if (x, y) not in self._known:
            at = material_weights(mesh.mesh, x, y)
            self._known[x, y] = displacement_rows(mesh.mesh, at, self._near_to)
        return self._known[x, y]

    def _felt(self, mesh: MeshStress, q: FloatArray, u: FloatArray, acceleration: FloatArray) -> FloatArray:
        """(N, 2) g - rddot of the nodes in the frame of the body [m/s^2]."""
        frame, modal = self._frame, self._modal
        phi = mesh.phi
        s = mesh.shapes.places + phi @ q[modal]
        omega, alpha = float(u[frame][2]), float(acceleration[frame][2])
        across = alpha * s + 2.0 * omega * (phi @ u[modal])
        turning = np.column_stack([-across[:, 1], across[:, 0]])
        weight = turned(np.array(-q[frame][2]), self._model.loads.gravity - acceleration[frame][:2])
        return np.asarray(weight - turning + omega * omega * s - phi @ acceleration[modal])
