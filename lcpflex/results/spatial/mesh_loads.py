"""What acts on a meshed body of space, as loads of its nodes: that of which stresses have a static part.

A force F and a moment M about a material point, in the axes of the body, are u F + psi M on the nodes, with the
operators u and psi by which the point is displaced and turned by them (:mod:`lcpflex.bodies.spatial.nodes`). The
inertia of the nodes is M_FE (g - a) with

    a = A^T R'' + omega' x s + omega x (omega x s) + 2 omega x Phi eta' + Phi eta'',   s = x + Phi eta
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lcpflex.bodies.spatial.nodes import NodePoints
from lcpflex.errors import ModelError
from lcpflex.kinematics.spatial.frames import matrices
from lcpflex.model.spatial import N_PLACE, N_RIGID
from lcpflex.results.spatial.acting_forces import Acting, SpatialActingForces

if TYPE_CHECKING:
    from lcpflex.bodies.reduction.mesh_stress import MeshStress
    from lcpflex.bodies.spatial.elastic import PointOperator
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.result import Result
    from lcpflex.results.spatial.point_wrench import PointWrench

__all__ = ["ActingOnMesh", "SpatialMeshLoads", "moved"]


class ActingOnMesh(NamedTuple):
    """At an instant, N nodes."""

    acting: Acting
    A: FloatArray  # (3, 3) of the body
    bent: FloatArray  # (N, 3) displacements by the modes [m]
    felt: FloatArray  # (N, 3) g - a in the axes of the body [m/s^2]


class SpatialMeshLoads:
    """On body ``b`` of a compiled spatial scene; ``step``: mean one of the run [s].

    still : modes that are taken as static, see :mod:`lcpflex.results.acting_forces`; of u
    modes : the others, numbers of the modes of the body
    """

    def __init__(self, result: Result, compiled: CompiledScene, b: int, step: float) -> None:
        self._result, self._compiled, self._b = result, compiled, b
        self._acting = SpatialActingForces(compiled, step, result.outside)
        self.still = self._acting.still
        bodies = compiled.model.bodies
        self._place, self._dof = int(bodies.place[b]), int(bodies.dof[b])
        self.modes = np.setdiff1d(np.arange(self._dof + N_RIGID, int(bodies.dof[b + 1])), self.still) - self._dof
        self.modes -= N_RIGID
        self._points: NodePoints | None = None
        self._known: dict[int, PointOperator] = {}

    def of(self, mesh: MeshStress, record: int) -> FloatArray:
        """(f,) nodal loads of all that acts at a stored instant, inertia as well [N], in the axes of the body."""
        now = self.at(mesh, record)
        total = np.asarray(mesh.mesh.mass @ now.felt.ravel())
        for load in now.acting.loads:
            if load.body == self._b:
                for rows, forces in self.shares(mesh, load, now):
                    np.add.at(total, rows, forces)
        return total

    def at(self, mesh: MeshStress, record: int) -> ActingOnMesh:
        """What acts at a stored instant."""
        result, k = self._result, record
        q, u = result.q[k], result.u[k].copy()
        u[self.still] = 0.0
        found = self._acting.at(k, result.contact_points.at(k), float(result.times[k]), q, u)
        A = matrices(q[self._place + 3 : self._place + N_PLACE])
        bent = mesh.phi @ q[self._place + N_PLACE + self.modes]
        return ActingOnMesh(found, A, bent, self._felt(mesh.phi, mesh.shapes.places + bent, A, u, found.acceleration))

    def _felt(self, phi: FloatArray, s: FloatArray, A: FloatArray, u: FloatArray, rate: FloatArray) -> FloatArray:
        """(N, 3) g - a of the nodes in the axes of the body [m/s^2]; rate: udot."""
        d, modal = self._dof, self._dof + N_RIGID + self.modes
        omega, alpha = u[d + 3 : d + N_RIGID], rate[d + 3 : d + N_RIGID]
        weight = A.T @ (self._compiled.model.loads.gravity - rate[d : d + 3])
        swept = np.cross(omega, s) + 2.0 * (phi @ u[modal])
        return np.asarray(weight - np.cross(alpha, s) - np.cross(omega, swept) - phi @ rate[modal])

    def shares(self, mesh: MeshStress, load: PointWrench, now: ActingOnMesh) -> list[tuple[IntArray, FloatArray]]:
        """A load as forces [N] on degrees of freedom of the mesh, of each of its points."""
        force = now.A.T @ load.block[:3]
        points = self.operators(mesh, load)
        arm = sum((w * moved(one, now) for one, w in points), np.zeros(3))
        moment = load.block[3:N_RIGID] - np.cross(arm, force)
        return [(one.rows, weight * (one.u @ force + one.psi @ moment)) for one, weight in points]

    def operators(self, mesh: MeshStress, load: PointWrench) -> list[tuple[PointOperator, float]]:
        """The points of a load, and their weights."""
        return [(self._operator(mesh, p), weight) for p, weight in load.points]

    def _operator(self, mesh: MeshStress, p: int) -> PointOperator:
        """Of a material point: the mean of some nodes, or the material at its place."""
        if self._points is None:
            self._points = NodePoints(mesh.mesh)
        if p not in self._known:
            if p in self._compiled.spread:
                self._known[p] = self._points.of_nodes(*self._compiled.spread[p])
            else:
                self._known[p] = _carrying(self._points, mesh, self._compiled.model.points.place[p])
        return self._known[p]


def moved(one: PointOperator, now: ActingOnMesh) -> FloatArray:
    """(3,) where a point is in the frame of the body [m]."""
    return np.asarray(one.place + one.u.T @ now.bent.ravel()[one.rows])


def _carrying(points: NodePoints, mesh: MeshStress, place: FloatArray) -> PointOperator:
    """Of the material at a place, or, off the mesh, at the nearest node."""
    try:
        return points.at(*place.tolist())
    except ModelError:  # carried by the material beside it
        nearest = int(np.linalg.norm(mesh.shapes.places - place, axis=1).argmin())
        return points.of_nodes([nearest])
