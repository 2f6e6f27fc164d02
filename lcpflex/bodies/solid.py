"""Solid elastic bodies in space from a mesh."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, TypeAlias

import numpy.typing as npt

from lcpflex.bodies.fem import solid_shapes as shapes
from lcpflex.bodies.fem.assembly import ElasticSolid, lame_constants
from lcpflex.bodies.fem.checked_mesh import spatial_mesh
from lcpflex.bodies.fem.elastic_mesh import finite_elements_of
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.fem.length_unit import check_size, metres
from lcpflex.bodies.fem.material import check_material
from lcpflex.bodies.fem.mesh import Mesh
from lcpflex.bodies.fem.stiffness_error import stiffness_error
from lcpflex.bodies.spatial.body import SpatialBody
from lcpflex.bodies.spatial.solid_reduction import reduce_solid
from lcpflex.errors import ModelError, ModelWarning, shown

__all__ = ["Solid"]

Near: TypeAlias = Mapping[str, tuple[Any, ...]]


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A linear elastic body in space of a mesh: rho u_tt = div sigma, sigma = L tr e + 2 G e.

    Elements are those of the mesh: tetrahedra of four or ten nodes, hexahedra of eight (with incompatible modes, so
    that they bend), 20 or 27. Mass is consistent and exact, curved elements included. All nodes are degrees of freedom.
    The body frame of a mesh is moved to the mass centre when the body is reduced; places are those of the mesh here.

    :meth:`box`, :meth:`bar`, :meth:`cylinder`, :meth:`tube` and :meth:`ball` make the mesh as well, of hexahedra of
    eight nodes.

    The surface is named "surface". Groups that the mesh came with keep their names, as sets of nodes and, where they
    are faces of the surface, as faces.

    Parameters
    ----------
    mesh : a scikit-fem mesh (MeshTet1, MeshTet2, MeshHex1, MeshHex2), or the name of a file (Gmsh, Abaqus, ...) with
        one kind of solid element. Places [m]
    density : [kg/m^3]
    youngs_modulus : [Pa]
    poissons_ratio : in (-1, 0.5)
    sets : name -> predicate f(x, y, z) -> bool of node places (arrays or numbers), node numbers, or the name of a group
        of the mesh. Nodes that are those of some faces of the surface are a face
    length_unit : of the places of the mesh: "m", "mm", "cm", "um", "in", "ft", or a number of metres; all else is in SI
        units, sets too. None: metres, with a warning where these can hardly be meant

    Raises
    ------
    ModelError
        For numbers out of range; meshes that are not connected through faces, have flat, folded or inverted elements or
        other kinds; files that cannot be read; sets that are empty, unknown, or whose predicate fails.

    Warns
    -----
    ModelWarning
        If no material has that wave speed sqrt(E / rho): a unit is wrong. If nodes without an element are left out, or
        nodes of the surface coincide and are not merged. For tetrahedra of four nodes, which are far too stiff. If the
        body is larger than solids of its material are, as a mesh in millimetres is that is taken for one in metres.
        When a body is made of it: if one of its three lowest modes is more than 10 % too stiff, by an estimate;
        :meth:`stiffness_error` computes it.
    """

    mesh: Any
    density: float
    youngs_modulus: float
    poissons_ratio: float
    sets: Mapping[str, Any] = field(default_factory=dict)
    length_unit: str | float | None = None
    _finite_elements: FiniteElements = field(init=False, repr=False)

    reduces_to: ClassVar[type[SpatialBody]] = SpatialBody

    def __post_init__(self) -> None:
        check_material(self)
        lame = lame_constants(self.youngs_modulus, self.poissons_ratio, plane_stress=False)
        mesh = spatial_mesh(self.mesh, metres(self.length_unit))
        _tell_linear(mesh)
        check_size(self, mesh)
        solid = ElasticSolid(mesh, self.density, lame, 1.0)
        speed = math.sqrt(self.youngs_modulus / self.density)
        object.__setattr__(self, "_finite_elements", finite_elements_of(solid, self.sets, speed))

    @classmethod
    def box(
        cls,
        sizes: npt.ArrayLike,
        size: float | None = None,
        *,
        near: Near | None = None,
        elements: Sequence[int] | None = None,
        **material: Any,
    ) -> Solid:
        """A rectangular block of hexahedra of eight nodes about the origin, its edges along the axes.

        Faces "left", "right" (x), "front", "back" (y), "bottom", "top" (z).

        Parameters
        ----------
        sizes : (3,) lengths along x, y, z [m]
        size : longest edge of an element [m]
        near : name -> (place (3,), finest), (place, finest, radius) [m] or (place, finest, radius, growth): where
            contact is expected, on the surface. Elements within the radius, 8 finest if omitted, are at most as long as
            ``finest``; from there on each is ``growth`` times its neighbour, 1.28 if omitted, up to ``size``. The faces
            within the radius have that name
        elements : numbers along x, y, z, in the place of ``size``
        **material : ``density``, ``youngs_modulus``, ``poissons_ratio``, ``sets``, and ``length_unit`` of all lengths
            here, as for :class:`Solid`
        """
        return cls._shaped(shapes.box(sizes, size, near=near, elements=elements), near, material)

    @classmethod
    def bar(
        cls,
        length: float,
        height: float,
        width: float,
        size: float | None = None,
        *,
        near: Near | None = None,
        elements: Sequence[int] | None = None,
        **material: Any,
    ) -> Solid:
        """A slender block along the x axis: 0 <= x <= length, |y| <= height / 2, |z| <= width / 2.

        length, height, width : [m]. Faces, size, near, elements and material : those of :meth:`box`.
        """
        return cls._shaped(shapes.bar(length, height, width, size, near=near, elements=elements), near, material)

    @classmethod
    def cylinder(cls, radius: float, length: float, size: float, *, near: Near | None = None, **material: Any) -> Solid:
        """A cylinder along z about the origin, of hexahedra of eight nodes; faces "side", "bottom", "top".

        Its nodes lie on the cylinder: volume and mass are below those of it, by 2.6 % with a size of half the radius,
        .6 % with a fifth of it.

        radius, length : [m]. size, near, material : as for :meth:`box`.
        """
        return cls._shaped(shapes.cylinder(radius, length, size, near=near), near, material)

    @classmethod
    def tube(
        cls, inner: float, outer: float, length: float, size: float, *, near: Near | None = None, **material: Any
    ) -> Solid:
        """A hollow cylinder along z about the origin; faces "inner", "outer", "bottom", "top".

        Volume and mass are below those of the tube by the same part as of a cylinder, of as many elements around it.

        inner, outer : radii, 0 < inner < outer [m]. length : [m]. size, near, material : as for :meth:`box`.
        """
        return cls._shaped(shapes.tube(inner, outer, length, size, near=near), near, material)

    @classmethod
    def ball(cls, radius: float, size: float, *, near: Near | None = None, **material: Any) -> Solid:
        """A ball about the origin, of hexahedra of eight nodes; ``near`` with one place costs few of them.

        Its nodes lie on the ball: volume and mass are below those of it, by 6.5 % with a size of half the radius, 1.7 %
        with a fifth of it.

        radius : [m]. size, near, material : as for :meth:`box`.
        """
        return cls._shaped(shapes.ball(radius, size, near=near), near, material)

    @classmethod
    def _shaped(cls, mesh: Mesh, near: Near | None, material: dict[str, Any]) -> Solid:
        """Of a mesh that was made here."""
        sets = material.get("sets")
        for name in near or ():
            if isinstance(sets, Mapping) and name in sets:
                raise ModelError(f"sets: the name {shown(name)} was given, expected another one: near has it")
        if "mesh" in material:
            raise ModelError("mesh: it was given, expected it for Solid(mesh, ...) alone")
        return cls(mesh, **material)

    def finite_elements(self) -> FiniteElements:
        """What every reduction starts from."""
        return self._finite_elements

    def stiffness_error(self) -> float:
        """How much too stiff the mesh is: the largest omega^2 / omega_f^2 - 1 [-] of its three lowest elastic modes.

        omega_f: the modes of the next finer mesh, which has quadratic elements for linear ones, eight for each
        quadratic one. It costs some twenty times as much as ``reduce(3)``; making a body estimates it, and warns beyond
        10 %.

        Raises
        ------
        ModelError
            For a mesh too large to be refined in memory.
        """
        return stiffness_error(self._finite_elements)

    reduce = reduce_solid


def _tell_linear(mesh: Mesh) -> None:
    if mesh.kind.name == "tetra":
        warnings.warn(
            f"{mesh.source}: tetrahedra of four nodes are far too stiff (frequencies of bending of a bar two of them "
            "thick by 29 %), expected tetrahedra of ten nodes (in Gmsh: Mesh.ElementOrder = 2), or hexahedra",
            ModelWarning,
            stacklevel=4,
        )
