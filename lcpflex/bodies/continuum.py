"""Planar elastic bodies from a mesh."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from lcpflex.basics.arguments import positive
from lcpflex.bodies.body import Body
from lcpflex.bodies.fem.assembly import ElasticSolid, lame_constants
from lcpflex.bodies.fem.checked_mesh import planar_mesh
from lcpflex.bodies.fem.elastic_mesh import finite_elements_of
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.fem.length_unit import check_size, metres
from lcpflex.bodies.fem.material import check_material
from lcpflex.bodies.fem.stiffness_error import stiffness_error
from lcpflex.bodies.reduction.component_modes import free_interface
from lcpflex.errors import ModelError, shown

__all__ = ["Continuum"]


@dataclass(frozen=True, slots=True, eq=False)
class Continuum:
    """A planar linear elastic body of a mesh: rho u_tt = div sigma, in plane stress or plane strain.

    Elements are those of the mesh, linear or quadratic triangles or quadrilaterals with the shape functions of
    scikit-fem, fully integrated, with consistent mass. The body frame is that of the mesh. All nodes are degrees of
    freedom, those amid edges and elements included.

    Surfaces are named after loops of the boundary: "outline", the outer one, counter-clockwise; "hole1", "hole2", ...,
    clockwise (in the order of their middles in x, then y). Groups that the mesh came with keep their names, as sets
    and, where they are one unbroken row of boundary edges, as surfaces.

    Parameters
    ----------
    mesh : a scikit-fem mesh (MeshTri1, MeshTri2, MeshQuad1, MeshQuad2; :mod:`lcpflex.bodies.fem.meshes` makes some),
    or the
        name of a file of Gmsh (2.2, 4.1), Abaqus (.inp), or what meshio or meshlane reads if installed (VTK, ...), with
        one kind of planar element. Places [m]
    density : [kg/m^3]
    youngs_modulus : [Pa]
    poissons_ratio : in (-1, 0.5)
    thickness : out of the plane [m]
    plane_strain : True for a slice of a long body that cannot contract out of the plane
    sets : name -> predicate f(x, y) -> bool of node places (arrays or numbers), node numbers, or the name of a group of
        the mesh. One node is a named point; nodes that are those of one unbroken row of boundary edges are a surface
        (solid on its left); anything else, as an area or two separate rows, is a node set for reductions only.
    length_unit : of the places of the mesh: "m", "mm", "cm", "um", "in", "ft", or a number of metres; all else is in SI
        units, sets too. None: metres, with a warning where these can hardly be meant

    Raises
    ------
    ModelError
        For numbers out of range; meshes that are not connected through edges, have flat or folded elements or other
        kinds; files that cannot be read; sets that are empty, unknown, or whose predicate fails.

    Warns
    -----
    ModelWarning
        If no material has that wave speed sqrt(E / rho): a unit is wrong. If nodes without an element are left out. If
        linear elements lock: plane strain of a ratio above 0.48. If the body is larger than solids of its material are,
        as a mesh in millimetres is that is taken for one in metres. When a body is made of it: if one of its three
        lowest modes is more than 10 % too stiff, by an estimate; :meth:`stiffness_error` computes it.
    """

    mesh: Any
    density: float
    youngs_modulus: float
    poissons_ratio: float
    thickness: float = 1.0
    plane_strain: bool = False
    sets: Mapping[str, Any] = field(default_factory=dict)
    length_unit: str | float | None = None
    _finite_elements: FiniteElements = field(init=False, repr=False)

    reduces_to: ClassVar[type[Body]] = Body

    def __post_init__(self) -> None:
        check_material(self)
        object.__setattr__(self, "thickness", positive("thickness", self.thickness))
        if not isinstance(self.plane_strain, bool | np.bool_):
            raise ModelError(f"plane_strain: {shown(self.plane_strain)} was given, expected True or False")
        lame = lame_constants(self.youngs_modulus, self.poissons_ratio, plane_stress=not self.plane_strain)
        speed = math.sqrt(self.youngs_modulus / self.density)
        if self.plane_strain:
            speed /= math.sqrt(1.0 - self.poissons_ratio**2)
        mesh = planar_mesh(self.mesh, metres(self.length_unit))
        check_size(self, mesh)
        solid = ElasticSolid(mesh, self.density, lame, self.thickness, not self.plane_strain)
        object.__setattr__(self, "_finite_elements", finite_elements_of(solid, self.sets, speed))

    def finite_elements(self) -> FiniteElements:
        """What every reduction starts from."""
        return self._finite_elements

    def stiffness_error(self) -> float:
        """How much too stiff the mesh is: the largest omega^2 / omega_f^2 - 1 [-] of its three lowest elastic modes.

        Those of slender bodies bend, so that it is the error of bending stiffness. omega_f: the modes of the next finer
        mesh, which has quadratic elements for linear ones, four for each quadratic one. It costs some eight times as
        much as ``reduce(3)``; making a body estimates it, and warns beyond 10 %.

        Raises
        ------
        ModelError
            For a mesh too large to be refined in memory.
        """
        return stiffness_error(self._finite_elements)

    reduce = free_interface  # to the lowest free modes
