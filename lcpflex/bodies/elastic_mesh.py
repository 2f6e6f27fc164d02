"""What planar bodies and solids of revolution share: checked numbers, finite elements, reduction to few modes."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from lcpflex.bodies.body import Resolution
from lcpflex.bodies.element_integrals import Solid, geometric_stiffness, mass_matrix, stiffness_matrix
from lcpflex.bodies.element_search import locator
from lcpflex.bodies.finite_elements import FiniteElements
from lcpflex.bodies.mesh_surfaces import boundary_of, names_of
from lcpflex.compiled import FloatArray, IntArray
from lcpflex.errors import ModelError, ModelWarning, in_range

__all__ = ["check_material", "finite_elements_of"]

SPEEDS = (10.0, 20_000.0)  # [m/s] of waves in a soft rubber, and more than in diamond


def check_material(part: Any) -> None:
    """Positive finite density and modulus, a ratio in (-1, 0.5); warns of a wave speed that no material has."""
    for name in ("density", "youngs_modulus"):
        object.__setattr__(part, name, in_range(name, getattr(part, name), 0.0, math.inf, open_ends=True))
    object.__setattr__(
        part, "poissons_ratio", in_range("poissons_ratio", part.poissons_ratio, -1.0, 0.5, open_ends=True)
    )
    E, density = part.youngs_modulus, part.density
    speed = math.sqrt(E / density)
    if SPEEDS[0] <= speed <= SPEEDS[1]:
        return
    warnings.warn(
        f"youngs_modulus, density: {E:g} Pa and {density:g} kg/m^3 give waves of {speed:.3g} m/s, expected "
        f"{SPEEDS[0]:g} to {SPEEDS[1]:g} m/s: {_suspect(E, density)}",
        ModelWarning,
        stacklevel=4,
    )


def _suspect(E: float, density: float) -> str:
    """The unit that is wrong most likely."""
    if density < 1e-6:
        return "the numbers look like N, mm and t; write the modulus in Pa, the density in kg/m^3 and lengths in m"
    if math.sqrt(E / density) > SPEEDS[1]:
        return f"a density in g/cm^3? {density:g} g/cm^3 are {1e3 * density:g} kg/m^3"
    giga, mega = math.sqrt(1e9 * E / density), math.sqrt(1e6 * E / density)
    if SPEEDS[0] * 50.0 <= mega <= SPEEDS[1]:
        return f"a modulus in MPa? {E:g} MPa are {1e6 * E:g} Pa"
    if giga <= SPEEDS[1]:
        return f"a modulus in GPa? {E:g} GPa are {1e9 * E:g} Pa"
    return "the modulus is in Pa and the density in kg/m^3"


def finite_elements_of(solid: Solid, sets: Mapping[str, Any], wave_speed: float) -> FiniteElements:
    """The free-free mesh with its names, and what lies between its nodes."""
    mesh = solid.mesh
    axisymmetric = solid.thickness is None
    boundary = boundary_of(mesh)
    names = names_of(mesh, boundary, sets, axisymmetric)
    dofs = _dofs(mesh.places, axisymmetric)
    mass, stiffness = mass_matrix(solid), stiffness_matrix(solid)
    if len(dofs) < mesh.places.size:
        mass, stiffness = mass[dofs][:, dofs].tocsc(), stiffness[dofs][:, dofs].tocsc()
    return FiniteElements(
        mass=mass,
        stiffness=stiffness,
        damping=None,
        places=mesh.places,
        dofs=dofs,
        axisymmetric=axisymmetric,
        points=names.points,
        sets=names.sets,
        chains=names.chains,
        locate=locator(mesh, boundary),
        geometric=lambda displacements: _geometric(solid, dofs, displacements),
        resolution=Resolution(wave_speed, mesh.longest_edge()),
    )


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
