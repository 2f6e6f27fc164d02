"""Straight uniform beams of space."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.arguments import array_of, one_of, positive, sequence_of, whole_number
from lcpflex.bodies.body import Resolution
from lcpflex.bodies.fem.material import check_material
from lcpflex.bodies.line_body import check_positive
from lcpflex.bodies.reduction.again import reduction_by
from lcpflex.bodies.reduction.bases import Basis, elastic_count, loaded_basis
from lcpflex.bodies.reduction.damping import Damping, damped_modes
from lcpflex.bodies.reduction.interface import Interface
from lcpflex.bodies.reduction.mesh_body import Residual
from lcpflex.bodies.reduction.mesh_interfaces import MeshStatics
from lcpflex.bodies.reduction.stiffening import Stiffening
from lcpflex.bodies.spatial.beam_elements import (
    DOFS,
    BeamMesh,
    gauss_points,
    scattered,
    section_fields,
    strains,
)
from lcpflex.bodies.spatial.beam_stiffening import BeamStiffening, Section, beam_stiffening
from lcpflex.bodies.spatial.body import SpatialBody
from lcpflex.bodies.spatial.elastic import ElasticMesh, Integrals, PointOperator, Surface
from lcpflex.bodies.spatial.flexible import check_deformation, flexible_body
from lcpflex.bodies.spatial.interfaces import contact_columns, interface_columns, unit_loads
from lcpflex.errors import ModelError, as_number, in_range, shown
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.arrays import frozen
from lcpflex.model.recovery import NOTHING, SpatialLineShapes

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["SpatialBeam"]

Station: TypeAlias = str | float | tuple[float, float, float] | Interface

MOST = 300  # elements beyond which the bending stiffness drowns in rounding (omega^2 ~ elements^-4)
OFF = 1e-9  # of the length, beyond the ends


@dataclass(frozen=True, slots=True)
class SpatialBeam:
    """A straight uniform beam along x: stretching, torsion (St. Venant) and bending in two planes.

    The axis through the centroids runs from (-length / 2, 0, 0), point "left", to (length / 2, 0, 0), point "right";
    "center" is its middle, the mass centre, and the origin of the frame. (That of the planar :class:`Beam` is at its
    left end: ``scene.add(beam, position=..., point="left")``, or ``point="center"``, says the same of both.) y and z
    are principal axes of the section, its shear centre is the centroid. A material point (y, z) of a section moves with
    it as with a rigid one, [u - y b - z c, v - z phi, w + y phi]: rotary inertia is in the mass, warping is not.

    Bending is that of Timoshenko's beam: sections may turn against the axis by shear. With ``shear_factor=None`` they
    stay normal to it, b = v' (Euler and Bernoulli, with rotary inertia). Two-node elements with the exact static
    deflection between nodes (Hermite's cubics without shear) and consistent mass; all integrals are exact in them.
    Errors of frequencies fall with the square of the elements' length, in bending without shear with its fourth power.

    Parameters
    ----------
    length : along x [m]
    area : A of the section [m^2]
    second_moments : (I_y, I_z) = integrals of (z^2, y^2) dA [m^4]: bending in the planes xz and xy
    torsion_constant : I_t [m^4]; I_y + I_z of a round section, less of any other
    density : [kg/m^3]
    youngs_modulus : E [Pa]
    poissons_ratio : G = E / (2 (1 + nu)) then; or give ``shear_modulus``
    shear_modulus : G [Pa]
    shear_factor : k of the shear stiffness k G A: one number, or (k_y, k_z) for bending in the planes xy and xz; 5/6 of
        a rectangle, 0.9 of a circle, down to 0.3 of thin-walled sections; None for no shear strain
    elements : number of equal elements, 1 to 300

    Raises
    ------
    ModelError
        For anything that is not positive and finite, both or none of poissons_ratio and shear_modulus, a torsion
        constant above I_y + I_z, or a shear factor above 1.

    Warns
    -----
    ModelWarning
        If no material has that wave speed sqrt(E / rho): a unit is wrong. Numbers near 1 have no units.
    """

    length: float
    area: float
    second_moments: tuple[float, float]
    torsion_constant: float
    density: float
    youngs_modulus: float
    poissons_ratio: float | None = None
    shear_modulus: float | None = None
    shear_factor: float | tuple[float, float] | None = 5.0 / 6.0
    elements: int = 40

    reduces_to: ClassVar[type[SpatialBody]] = SpatialBody

    def __post_init__(self) -> None:
        check_positive(self, ("length", "area", "torsion_constant"))
        check_material(self, ratio=False)
        inertia = array_of("second_moments", self.second_moments, (2,))
        kept: dict[str, Any] = {
            "second_moments": tuple(positive("second_moments", value) for value in inertia),
            "shear_modulus": _shear_modulus(self.youngs_modulus, self.poissons_ratio, self.shear_modulus),
            "shear_factor": _shear_factor(self.shear_factor),
            "elements": whole_number("elements", self.elements, 1, MOST),
        }
        for name, value in kept.items():
            object.__setattr__(self, name, value)
        if self.torsion_constant > (1.0 + 1e-9) * sum(self.second_moments):
            raise ModelError(
                f"torsion_constant: {self.torsion_constant:.6g} m^4 was given, expected at most I_y + I_z = "
                f"{sum(self.second_moments):.6g}, that of a round section"
            )

    def reduce(
        self,
        modes: int | None = 8,
        damping: Damping | None = None,
        *,
        interfaces: Sequence[Station] = (),
        clamped: str | None = None,
        second_order: int | None = None,
        residual_damping: float | None = None,
        stiffening: Stiffening | None = None,
        deformation: str = "linear",
    ) -> SpatialBody:
        """The body with the ``modes`` lowest modes of the beam: bending, torsion and stretching together.

        Parameters
        ----------
        modes : at most 6 elements; None for all, 0 for a rigid body
        damping : damping ratio zeta of all modes, one for each (ascending frequencies), or :class:`Rayleigh`;
            None for no damping
        interfaces : places where joints hold the beam, or springs or loads act: "left", "center", "right", x, or
            (x, y, z), or :class:`Interface`. Each adds up to six residual modes behind the others, the static response
            to three forces and three moments, so that the compliance there is that of the mesh
        clamped : "left" or "right": the frame rides on that end, and the modes are those of a cantilever. None for the
            mean frame and free-free modes
        second_order : of how many of the first modes products are kept, as of :meth:`SpatialMatrices.reduce`
        residual_damping : damping ratio of the residual modes; None for that of the others, the last one of several
        stiffening : by spin and by a constant axial force, in bending and torsion (:class:`Stiffening`); None for the
            linear beam, which feels neither
        deformation : "linear" is the only one: the material moves by linear functions of the modal coordinates

        Raises
        ------
        ModelError
            For more modes than the mesh has, a damping that is negative or of the wrong length, places off the beam,
            or a stiffening that cannot be: compression beyond the buckling load.
        """
        check_deformation(deformation)
        line = self._line()
        if clamped is not None:
            one_of("clamped", clamped, ("left", "right"))
        stiff = beam_stiffening(line, self._section(), stiffening, clamped)
        mesh = self._elastic() if stiff is None else stiff.loaded(self._elastic())
        node = 0 if clamped == "left" else self.elements
        held = None if clamped is None else DOFS * node + np.arange(DOFS)
        most = elastic_count(mesh, held)
        n = damped_modes(modes, most, damping, residual_damping)
        places = [one if isinstance(one, Interface) else _place(self, one) for one in _listed(interfaces)]
        find = partial(_found, self, line)
        loads = interface_columns(find, len(mesh.rank), places)
        found, n = loaded_basis(mesh, loads, n, held)
        more = len(found[0]) - n
        residual = Residual(more, min(contact_columns(find, len(mesh.rank), places), more), residual_damping)
        basis = _by_strain(self._strains(line), found)
        return flexible_body(
            mesh, basis if stiff is None else stiff.modes(basis), damping, residual, second_order,
            clamped=held is not None, resolution=Resolution(math.sqrt(self.youngs_modulus / self.density), line.h),
            recover=partial(_recovered, self, line, stiff), stiffened=None if stiff is None else stiff.by_spin,
            statics=MeshStatics(mesh, partial(unit_loads, find, len(mesh.rank))),
            reduction=reduction_by(
                self.reduce, n, most, damping, interfaces=places, clamped=clamped, second_order=second_order,
                residual_damping=residual_damping, stiffening=stiffening,
            ),
        )  # fmt: skip

    def _line(self) -> BeamMesh:
        h = self.length / self.elements
        s = [0.0, 0.0]
        if self.shear_factor is not None:
            for plane, (k, inertia) in enumerate(zip(self._factors(), self._bending(), strict=True)):
                s[plane] = 12.0 * self.youngs_modulus * inertia / (k * self._shear() * self.area * h * h)
        return BeamMesh(self.elements, self.length, (s[0], s[1]))

    def _section(self) -> Section:
        Iy, Iz = self.second_moments
        return Section(
            self.density * self.area, (self.density * Iy, self.density * Iz), self.youngs_modulus * self.area
        )

    def _factors(self) -> tuple[float, float]:
        k = self.shear_factor
        return k if isinstance(k, tuple) else (float(k or 0.0),) * 2

    def _bending(self) -> tuple[float, float]:
        """I of bending in the planes xy and xz."""
        return self.second_moments[1], self.second_moments[0]

    def _shear(self) -> float:
        return float(self.shear_modulus or 0.0)

    def _strains(self, line: BeamMesh) -> csc_matrix[Any]:
        E, (in_xy, in_xz) = self.youngs_modulus, self._bending()
        return strains(line, E * self.area, self._shear() * self.torsion_constant, (E * in_xy, E * in_xz))

    def _elastic(self) -> ElasticMesh:
        """What every reduction starts from."""
        line = self._line()
        strain = self._strains(line)
        element, xi, dx = gauss_points(line)
        move, turn = section_fields(line, xi)
        fields = (move, _spin(turn, 1), _spin(turn, 2))  # displacement, and its change along y and z
        Iy, Iz = self.second_moments
        weights = [self.density * dx * size for size in (self.area, Iz, Iy)]
        sampled = [scattered(line, field, element) for field in fields]
        every = libs.sparse.vstack(sampled)
        weighed = libs.sparse.diags_array(np.concatenate([np.repeat(w, 3) for w in weights])) @ every
        mass = every.T @ weighed
        station = line.nodes[element] + xi * line.h
        f = DOFS * (self.elements + 1)
        return ElasticMesh(
            mass=(0.5 * (mass + mass.T)).tocsc(),
            stiffness=(strain.T @ strain).tocsc(),
            damping=None,
            rigid=_rigid_motions(line),
            rank=np.arange(f),
            centre=np.zeros(3),
            integrals=partial(_integrals, sampled, weights, station),
            locate=partial(_locate, self),
            points={
                name: partial(_operator, line, x, 0.0, 0.0)
                for name, x in (("left", -self.length / 2), ("center", 0.0), ("right", self.length / 2))
            },
            surface=_surface(self, line),
        )


def _recovered(
    beam: SpatialBeam, line: BeamMesh, stiff: BeamStiffening | None, shapes: FloatArray
) -> SpatialLineShapes:
    """What section forces come from, of shapes (f, n)."""
    Iy, Iz = beam.second_moments
    return SpatialLineShapes(
        length=beam.length,
        mass=beam.density * beam.area * beam.length,
        gyration=(Iz / beam.area, Iy / beam.area),
        shear=line.shear,
        shapes=frozen(shapes.reshape(line.elements + 1, DOFS, shapes.shape[1])),
        spin=NOTHING if stiff is None else frozen(stiff.tension(line.nodes)),
        given=NOTHING if stiff is None else frozen(stiff.given(line.nodes)),
    )


def _shear_modulus(E: float, ratio: float | None, modulus: float | None) -> float:
    if (ratio is None) == (modulus is None):
        raise ModelError(
            f"poissons_ratio, shear_modulus: {shown(ratio)} and {shown(modulus)} were given, expected exactly one of "
            "the two"
        )
    if ratio is None:
        return positive("shear_modulus", modulus)
    return E / (2.0 * (1.0 + in_range("poissons_ratio", ratio, -1.0, 0.5, open_ends=True)))


def _shear_factor(given: Any) -> float | tuple[float, float] | None:
    if given is None:
        return None
    if np.ndim(as_number(given)) == 0 and as_number(given) == as_number(given):
        return in_range("shear_factor", given, 1e-3, 1.0)
    k_y, k_z = (in_range("shear_factor", value, 1e-3, 1.0) for value in array_of("shear_factor", given, (2,)))
    return k_y, k_z


def _listed(interfaces: Any) -> list[Any]:
    if isinstance(interfaces, str | Interface):
        return [interfaces]
    return sequence_of("interfaces", interfaces, "a list of places, such as ['left', 0.1]", 10_000)


def _place(beam: SpatialBeam, given: Any) -> tuple[float, float, float]:
    """(x, y, z) of a name, a station, or a place."""
    half = beam.length / 2
    named = {"left": -half, "center": 0.0, "right": half}
    if isinstance(given, str):
        return named[one_of("interfaces", given, named)], 0.0, 0.0
    number = as_number(given)
    x, y, z = (number, 0.0, 0.0) if number == number else array_of("interfaces", given, (3,))
    return _on_beam(beam, "interfaces", float(x)), float(y), float(z)


def _found(beam: SpatialBeam, line: BeamMesh, name: str, place: Any) -> PointOperator:
    """The point at the place of an interface."""
    return _operator(line, *_place(beam, place))


def _on_beam(beam: SpatialBeam, name: str, x: float) -> float:
    half = beam.length / 2
    if not abs(x) <= half + OFF * beam.length:
        raise ModelError(f"{name}: x = {x:.6g} was given, expected {-half:.6g} to {half:.6g}, on the beam")
    return min(max(x, -half), half)


def _locate(beam: SpatialBeam, x: float, y: float, z: float) -> PointOperator:
    """The material at a place, carried by the section at x: y and z may reach beyond the section, as of a rigid arm."""
    return _operator(beam._line(), _on_beam(beam, "x", x), y, z)


def _operator(line: BeamMesh, x: float, y: float, z: float) -> PointOperator:
    element, xi = line.at(x)
    move, turn = (field[0] for field in section_fields(line, xi))
    arm = np.array([0.0, y, z])
    u = move + np.cross(turn.T, arm).T
    return PointOperator(np.array([x, y, z]), line.rows(element[0]), u.T.copy(), turn.T.copy())


def _spin(turn: FloatArray, axis: int) -> FloatArray:
    """(k, 3, 12) rotation x unit vector along an axis."""
    return np.cross(turn.transpose(0, 2, 1), np.eye(3)[axis]).transpose(0, 2, 1)


def _by_strain(strain: csc_matrix[Any], basis: Basis) -> Basis:
    """The same modes with frequencies from the strains: K loses digits to rounding, about elements^4 of them."""
    shapes = basis[1]
    if not shapes.shape[1]:
        return basis
    _, value, turn = np.linalg.svd(np.asarray(strain @ shapes), full_matrices=False)
    return np.asarray(value[::-1] ** 2), np.asarray(shapes @ turn[::-1].T)


def _integrals(
    sampled: list[csc_matrix[Any]], weights: list[FloatArray], station: FloatArray, shapes: FloatArray, n2: int,
    origin: FloatArray,
) -> Integrals:  # fmt: skip
    """Sums over the Gauss points of the axis; the integrals over a section are A, I_z and I_y."""
    n = shapes.shape[1]
    x = np.zeros((len(station), 3))
    x[:, 0] = station
    x -= origin
    places = (x, np.tile([0.0, 1.0, 0.0], (len(x), 1)), np.tile([0.0, 0.0, 1.0], (len(x), 1)))
    phi = [(field @ shapes).reshape(len(x), 3, n) for field in sampled]
    parts = list(zip(weights, places, phi, strict=True))
    return Integrals(
        mass=float(weights[0].sum()),
        moment=weights[0] @ x,
        second=np.asarray(sum(np.einsum("g,gi,gj->ij", w, at, at) for w, at, _ in parts)),
        S=np.einsum("g,gjk->kj", weights[0], phi[0]),
        first=np.asarray(sum(np.einsum("g,gi,gjk->kij", w, at, p) for w, at, p in parts)),
        products=np.asarray(
            sum(np.einsum("g,gil,gjk->lkij", w, p[:, :, :n2], p[:, :, :n2], optimize=True) for w, _, p in parts)
        ),
    )


def _rigid_motions(line: BeamMesh) -> FloatArray:
    """(f, 6) translations and rotations about the middle."""
    x, h = line.nodes, line.h
    rigid = np.zeros((len(x), DOFS, 6))
    rigid[:, [0, 1, 2], [0, 1, 2]] = 1.0
    rigid[:, 3, 3] = h
    rigid[:, 2, 4], rigid[:, 5, 4] = -x, -h
    rigid[:, 1, 5], rigid[:, 4, 5] = x, h
    return rigid.reshape(-1, 6)


def _surface(beam: SpatialBeam, line: BeamMesh) -> Surface:
    """What is drawn: the rectangle with the second moments of the section, along the nodes."""
    Iy, Iz = beam.second_moments
    a, b = (0.5 * math.sqrt(12.0 * inertia / beam.area) for inertia in (Iz, Iy))
    y, z = a * np.array([-1.0, 1.0, 1.0, -1.0]), b * np.array([-1.0, -1.0, 1.0, 1.0])
    x = line.nodes
    vertices = np.stack([np.repeat(x, 4), np.tile(y, len(x)), np.tile(z, len(x))], axis=1)
    ring = 4 * np.arange(line.elements)[:, None] + np.arange(4)
    after = 4 * np.arange(line.elements)[:, None] + np.array([1, 2, 3, 0])
    sides = np.concatenate([np.stack([ring, after, after + 4], -1), np.stack([ring, after + 4, ring + 4], -1)])
    last = 4 * line.elements
    ends: IntArray = np.array([[0, 2, 1], [0, 3, 2], [last, last + 1, last + 2], [last, last + 2, last + 3]])
    return Surface(vertices, np.concatenate([sides.reshape(-1, 3), ends]), partial(_drawn, line.h, y, z))


def _drawn(h: float, y: FloatArray, z: FloatArray, shapes: FloatArray) -> FloatArray:
    """(4 nodes, n, 3) displacements of the corners of the sections."""
    d = shapes.reshape(len(shapes) // DOFS, DOFS, shapes.shape[1])
    y, z = y[None, :, None], z[None, :, None]
    u, v, w, phi, b, c = (d[:, None, k] / (h if k > 2 else 1.0) for k in range(DOFS))
    moved = np.stack([u - y * b - z * c, v - z * phi, w + y * phi], axis=-1)
    return moved.reshape(4 * len(d), shapes.shape[1], 3)
