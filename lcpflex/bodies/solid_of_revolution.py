"""Elastic solids of revolution from a mesh of their half section, for impacts along the axis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from lcpflex.bodies.body import Body
from lcpflex.bodies.fem.assembly import ElasticSolid, lame_constants
from lcpflex.bodies.fem.checked_mesh import planar_mesh
from lcpflex.bodies.fem.elastic_mesh import finite_elements_of
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.fem.length_unit import check_size, metres
from lcpflex.bodies.fem.material import check_material
from lcpflex.bodies.fem.mesh import FLAT, Mesh
from lcpflex.bodies.fem.stiffness_error import stiffness_error
from lcpflex.bodies.reduction.component_modes import free_interface
from lcpflex.errors import ModelError

__all__ = ["SolidOfRevolution"]


@dataclass(frozen=True, slots=True, eq=False)
class SolidOfRevolution:
    """A linear elastic solid of revolution about the x axis: strains e_xx, e_rr, gamma_xr and u_r / r around the axis.

    The mesh is that of half a section: x along the axis, y = r >= 0 the radius. Integrals are those of the whole
    solid, dV = 2 pi r dx dr, and a force at a node is that on its whole circle. Nodes on the axis have no radial
    displacement. Elements, sets, groups and "hole1", ... are those of :class:`Continuum`.

    The body moves along its axis only, and a scene refuses it unless a joint holds it so: a ``Prismatic`` joint along
    the axis, or a weld, at its point "axis" (the mass centre, which rides with the frame of the body) or at material on
    the axis. A contact at nodes off the axis stands for that of their circles, so that what the body meets must have
    the same axis, or be a plane across it.

    Surfaces: "outline" is the loop around the half section, along the axis as well; "surface" is the outer one
    without the axis, from its far end (largest x) to its near one; further rows of edges off the axis are "hole1", ...

    Parameters
    ----------
    mesh : of the half section, as for :class:`Continuum` [m]
    density : [kg/m^3]
    youngs_modulus : [Pa]
    poissons_ratio : in (-1, 0.5)
    sets, length_unit : as for :class:`Continuum`

    Raises
    ------
    ModelError
        As for :class:`Continuum`, and for nodes below the axis.

    Warns
    -----
    ModelWarning
        As for :class:`Continuum`.
    """

    mesh: Any
    density: float
    youngs_modulus: float
    poissons_ratio: float
    sets: Mapping[str, Any] = field(default_factory=dict)
    length_unit: str | float | None = None
    _finite_elements: FiniteElements = field(init=False, repr=False)

    reduces_to: ClassVar[type[Body]] = Body

    def __post_init__(self) -> None:
        check_material(self)
        lame = lame_constants(self.youngs_modulus, self.poissons_ratio, plane_stress=False)
        mesh = planar_mesh(self.mesh, metres(self.length_unit))
        check_size(self, mesh)
        solid = ElasticSolid(_above_axis(mesh), self.density, lame, None)
        speed = math.sqrt(self.youngs_modulus / self.density)
        object.__setattr__(self, "_finite_elements", finite_elements_of(solid, self.sets, speed))

    def finite_elements(self) -> FiniteElements:
        """What every reduction starts from."""
        return self._finite_elements

    def stiffness_error(self) -> float:
        """How much too stiff the mesh is: the largest omega^2 / omega_f^2 - 1 [-] of its three lowest elastic modes.

        omega_f: the modes of the next finer mesh, which has quadratic elements for linear ones, four for each quadratic
        one. It costs some eight times as much as ``reduce(3)``; making a body estimates it, and warns beyond 10 %.

        Raises
        ------
        ModelError
            For a mesh too large to be refined in memory.
        """
        return stiffness_error(self._finite_elements)

    reduce = free_interface  # to the lowest free modes


def _above_axis(mesh: Mesh) -> Mesh:
    """The mesh with its nodes near the axis on it; refuses nodes below."""
    places = mesh.places.copy()
    lowest = int(places[:, 1].argmin())
    x, y = places[lowest]
    slack = FLAT * mesh.size
    if y < -slack:
        raise ModelError(
            f"{mesh.source}: node {lowest} at ({x:.6g}, {y:.6g}) lies below the axis, expected y >= 0: the mesh is "
            f"that of half a section, with its axis on y = 0"
        )
    places[places[:, 1] <= slack, 1] = 0.0
    return replace(mesh, places=places)
