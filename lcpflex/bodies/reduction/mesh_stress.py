"""Stress of a meshed body: that of its modes, and the static part of what they leave out.

With the modal coordinates q of the modes Phi, the nodal loads f of all that acts (contacts, joints, loads, and inertia
M (g - a) of the moving body), and the flexibility G of the free mesh (:mod:`lcpflex.bodies.reduction.eigenmodes`),

    u = Phi q + [G - Phi (Phi^T K Phi)^-1 Phi^T] f

Static loads so have the displacements of the whole mesh, G f, whatever the reduction; what is left out of the motion is
that the modes that are not there follow without vibrating (mode acceleration; static correction).
Source: Craig & Kurdila, Fundamentals of Structural Dynamics, 2006.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from lcpflex.bodies.fem.assembly import ElasticSolid
from lcpflex.bodies.fem.elastic_mesh import bare_elements
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.fem.mesh import KINDS, Mesh
from lcpflex.bodies.fem.nodal_stress import NodalGradients, nodal_gradients, nodal_stress
from lcpflex.bodies.reduction.eigenmodes import FreeMesh
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.recovery import MeshShapes

__all__ = ["MeshStress"]


class MeshStress:
    """Displacements and stress at the N nodes of a mesh by its n modes; made when first asked for, its factor as well.

    shapes: the mesh and its modes. kept: (k,) numbers of the modes whose coordinates count.
    """

    def __init__(self, shapes: MeshShapes, kept: Any) -> None:
        self.shapes = shapes
        self.phi = np.asarray(shapes.phi[:, :, kept])
        mesh = Mesh(KINDS[shapes.kind], shapes.places, shapes.cells)
        self.solid = ElasticSolid(mesh, shapes.density, shapes.lame, shapes.thickness, shapes.plane_stress)

    @cached_property
    def mesh(self) -> FiniteElements:
        """Its matrices."""
        return bare_elements(self.solid)

    @cached_property
    def complete(self) -> bool:
        """Whether the modes are all of the mesh, which leave nothing out."""
        return self.phi.shape[2] >= len(self.mesh.dofs) - self.mesh.rigid.shape[1]

    @cached_property
    def _gradients(self) -> NodalGradients:
        return nodal_gradients(self.solid)

    @cached_property
    def _free(self) -> FreeMesh:
        return FreeMesh.of(self.mesh)

    @cached_property
    def _modes(self) -> tuple[FloatArray, FloatArray]:
        """Phi (f, k) and Phi (Phi^T K Phi)^-1."""
        N, d, k = self.phi.shape
        phi = self.phi.reshape(N * d, k)[self.mesh.dofs]
        stiff = phi.T @ (self.mesh.stiffness @ phi)
        return phi, np.asarray(np.linalg.solve(0.5 * (stiff + stiff.T), phi.T).T)

    def stress(self, displacements: FloatArray) -> FloatArray:
        """(4, N, m) sigma_xx, sigma_yy, sigma_xy, sigma_zz [Pa] of nodal displacements (N, 2, m) [m].

        In space (6, N, m) with sigma_yz and sigma_zx, of (N, 3, m).
        """
        return nodal_stress(self.solid, self._gradients, displacements)

    def left_out(self, loads: FloatArray) -> FloatArray:
        """(N, d, m) static displacements [m] under nodal loads (f, m) [N] beyond those of the modes."""
        phi, soft = self._modes
        return self.mesh.nodal(self._free.flexibility(loads) - soft @ (phi.T @ loads))
