"""What planar bodies and solids of revolution share: their finite elements."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from lcpflex.bodies.body import Resolution
from lcpflex.bodies.fem.assembly import Solid, geometric_stiffness, mass_matrix, stiffness_matrix
from lcpflex.bodies.fem.boundary import boundary_of, names_of
from lcpflex.bodies.fem.element_search import locator
from lcpflex.bodies.fem.excess_stiffness import excess_stiffness
from lcpflex.bodies.fem.finer_mesh import finer
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.errors import ModelError, ModelWarning
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["bare_elements", "finite_elements_of"]

LOCKED = 24.0  # L / G of a Poisson's ratio of 0.48: four linear elements across a bar bend at frequencies 17 % too high


def finite_elements_of(solid: Solid, sets: Mapping[str, Any], wave_speed: float) -> FiniteElements:
    """The free-free mesh with its names, and what lies between its nodes."""
    mesh = solid.mesh
    L, G = solid.lame
    locked = L > LOCKED * G and not mesh.kind.quadratic
    if locked:
        warnings.warn(
            f"poissons_ratio: {0.5 * L / (L + G):.6g} without change of thickness makes linear elements far too stiff "
            f"(they lock), expected less than 0.48, or quadratic elements: lcpflex.meshes.quadratic(mesh)",
            ModelWarning,
            stacklevel=4,
        )
    axisymmetric = solid.thickness is None
    boundary = boundary_of(mesh)
    names = names_of(mesh, boundary, sets, axisymmetric)
    bare = _without_names(solid)
    return replace(
        bare,
        points=names.points,
        sets=names.sets,
        chains=names.chains,
        locate=locator(mesh, boundary),
        geometric=partial(_geometric, solid, bare.dofs),
        resolution=Resolution(wave_speed, mesh.longest_edge()),
        excess=None  # known to be large where elements lock, and said above
        if locked
        else partial(_excess, solid, bare),
        finer=partial(_finer, solid),
    )


def bare_elements(solid: Solid) -> FiniteElements:
    """The free-free mesh without names, which knows what lies between its nodes; nothing is warned of again."""
    return replace(_without_names(solid), locate=locator(solid.mesh, boundary_of(solid.mesh)))


def _excess(solid: Solid, bare: FiniteElements, omega2: FloatArray, shapes: FloatArray) -> FloatArray:
    return excess_stiffness(solid, omega2, bare.nodal(shapes))


def _finer(solid: Solid) -> FiniteElements:
    return _without_names(replace(solid, mesh=finer(solid.mesh)))


def _without_names(solid: Solid) -> FiniteElements:
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


def _geometric(solid: Solid, dofs: IntArray, displacements: FloatArray) -> Any:
    given = np.asarray(displacements, dtype=np.float64)
    if given.size != len(dofs):
        raise ModelError(f"displacements: shape {given.shape} was given, expected ({len(dofs)},): one static state")
    whole = np.zeros(solid.mesh.places.size)
    whole[dofs] = given.ravel()
    stiffness = geometric_stiffness(solid, whole)
    return stiffness if len(dofs) == len(whole) else stiffness[dofs][:, dofs].tocsc()
