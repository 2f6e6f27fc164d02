"""What planar bodies, solids of revolution and solids in space share: their finite elements."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from lcpflex.bodies.body import Resolution
from lcpflex.bodies.fem.assembly import ElasticSolid, geometric_stiffness, mass_matrix, stiffness_matrix
from lcpflex.bodies.fem.boundary import boundary_of, names_of
from lcpflex.bodies.fem.element_search import locator
from lcpflex.bodies.fem.excess_stiffness import excess_stiffness
from lcpflex.bodies.fem.faces import faces_of
from lcpflex.bodies.fem.finer_mesh import finer
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.fem.mesh import Mesh
from lcpflex.errors import ModelError, ModelWarning
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["bare_elements", "finite_elements_of"]

LOCKED = 24.0  # L / G of a Poisson's ratio of 0.48: four linear elements across a bar bend at frequencies 17 % too high


def finite_elements_of(solid: ElasticSolid, sets: Mapping[str, Any], wave_speed: float) -> FiniteElements:
    """The free-free mesh with its names, and what lies between its nodes."""
    mesh = solid.mesh
    L, G = solid.lame
    gives_way = mesh.kind.quadratic or mesh.kind.name == "hexahedron"  # by its bubbles
    locked = L > LOCKED * G and not gives_way
    if locked:
        remedy = "" if mesh.kind.dimension == 3 else ": lcpflex.meshes.quadratic(mesh)"
        warnings.warn(
            f"poissons_ratio: {0.5 * L / (L + G):.6g} without change of thickness makes linear elements far too stiff "
            f"(they lock), expected less than 0.48, or quadratic elements{remedy}",
            ModelWarning,
            stacklevel=4,
        )
    bare = _without_names(solid)
    return replace(
        bare,
        **_names(solid, sets),
        geometric=None if mesh.kind.dimension == 3 else partial(_geometric, solid, bare.dofs),
        resolution=Resolution(wave_speed, mesh.longest_edge()),
        excess=None  # known to be large where elements lock, and said above
        if locked
        else partial(_excess, solid, bare),
        finer=partial(_finer, solid),
    )


def _names(solid: ElasticSolid, sets: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of named nodes, and of what lies on the boundary and between nodes."""
    mesh = solid.mesh
    if mesh.kind.dimension == 3:
        faces = faces_of(mesh, sets)
        return {
            "points": faces.points,
            "sets": faces.sets,
            "facets": faces.facets,
            "faces": faces.named,
            "locate": locator(mesh, _edges_of_facets(mesh, faces.facets)),
        }
    boundary = boundary_of(mesh)
    names = names_of(mesh, boundary, sets, solid.thickness is None)
    return {
        "points": names.points,
        "sets": names.sets,
        "chains": names.chains,
        "locate": locator(mesh, boundary.pieces(mesh.places)),
    }


def _edges_of_facets(mesh: Mesh, facets: IntArray) -> FloatArray:
    """(k, 2, 3) both ends of the edges between corners of facets, some of them twice."""
    corners = mesh.places[facets[:, : mesh.kind.facet_corners]]
    return np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2, 3)


def bare_elements(solid: ElasticSolid) -> FiniteElements:
    """The free-free mesh without names, which knows what lies between its nodes; nothing is warned of again."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)
        return replace(_without_names(solid), locate=_names(solid, {})["locate"])


def _excess(solid: ElasticSolid, bare: FiniteElements, omega2: FloatArray, shapes: FloatArray) -> FloatArray:
    return excess_stiffness(solid, omega2, bare.nodal(shapes))


def _finer(solid: ElasticSolid) -> FiniteElements:
    return _without_names(replace(solid, mesh=finer(solid.mesh)))


def _without_names(solid: ElasticSolid) -> FiniteElements:
    """The matrices of the mesh."""
    places, axisymmetric = solid.mesh.places, solid.thickness is None
    dofs = _dofs(places, axisymmetric)
    mass, stiffness = mass_matrix(solid), stiffness_matrix(solid)
    if len(dofs) < places.size:
        mass, stiffness = mass[dofs][:, dofs].tocsc(), stiffness[dofs][:, dofs].tocsc()
    return FiniteElements(mass, stiffness, None, places, dofs, axisymmetric, solid=solid)


def _dofs(places: FloatArray, axisymmetric: bool) -> IntArray:
    """All degrees of freedom but the radial ones on the axis of a solid of revolution."""
    kept = np.ones(places.size, dtype=np.bool_)
    if axisymmetric:
        kept[1::2] = places[:, 1] > 0.0
    return np.flatnonzero(kept)


def _geometric(solid: ElasticSolid, dofs: IntArray, displacements: FloatArray) -> Any:
    given = np.asarray(displacements, dtype=np.float64)
    if given.size != len(dofs):
        raise ModelError(f"displacements: shape {given.shape} was given, expected ({len(dofs)},): one static state")
    whole = np.zeros(solid.mesh.places.size)
    whole[dofs] = given.ravel()
    stiffness = geometric_stiffness(solid, whole)
    return stiffness if len(dofs) == len(whole) else stiffness[dofs][:, dofs].tocsc()
