"""Straight uniform beams, through finite elements and free-interface modes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from lcpflex.basics.options import keep_flag
from lcpflex.bodies.body import Body, Displacement, array_of, whole_number
from lcpflex.bodies.fem.line_elements import LineModes, bending_modes, interpolate, mixed_mass, stretching_modes
from lcpflex.bodies.fem.material import check_material
from lcpflex.bodies.line_body import (
    FINE_ENOUGH,
    Line,
    body_of_line,
    check_positive,
    coarser,
    contact_modes,
    line_moments,
    line_shapes,
)
from lcpflex.bodies.reduction.again import reduction_by
from lcpflex.bodies.reduction.beam_shortening import shortening_of, with_axial_loads
from lcpflex.bodies.reduction.beam_stiffening import axis_of, bent_under_tension, spinning
from lcpflex.bodies.reduction.damping import (
    Damping,
    damped_modes,
    sampled,
    skew,
    vanish,
    with_residual,
)
from lcpflex.bodies.reduction.fidelity_levels import ModeLevels
from lcpflex.bodies.reduction.interface import Interface, Interfaces, interfaces_of
from lcpflex.bodies.reduction.line_interfaces import (
    BoolArray,
    LineLoads,
    LineStatics,
    joined,
    line_loads,
    residual_line,
    taken,
)
from lcpflex.bodies.reduction.stiffening import Stiffening, check_stiffening
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray

__all__ = ["Beam"]

BEAM_ELEMENTS = 1000  # beyond it the bending stiffness of free elements drowns in rounding (omega^2 ~ elements^-4)


@dataclass(frozen=True, slots=True)
class Beam:
    """A straight uniform planar Euler-Bernoulli beam: rho A w_tt + E I w_xxxx = 0, and rho A u_tt = E A u_xx.

    The axis runs from (0, 0), point "left", to (length, 0), point "right", in the body frame; "center" is its middle.
    So the frame is at the left end, other than that of :class:`SpatialBeam`, which is in the middle:
    ``scene.add(beam, position=..., point="center")``, or ``point="left"``, says the same of both.
    A = width thickness, I = width thickness^3 / 12. Mass is carried by the axis (no rotary inertia of the
    sections: rho A L^3 / 3 about the left end). Cubic Hermite elements in bending, linear ones in stretching, both with
    consistent mass. A point off the axis turns with its section: u - y w', w.

    Surfaces, through the nodes of the mesh on both faces y = -+thickness/2: "outline" (closed), "bottom", "top", and
    the straight end faces "left", "right".

    Parameters
    ----------
    length : along x [m]
    width : out of the plane [m]
    thickness : along y, over which the beam bends [m]
    density : [kg/m^3]
    youngs_modulus : [Pa]
    elements : number of equal elements, 1 to 1000
    axial : False leaves the stretching modes out

    Raises
    ------
    ModelError
        For anything that is not positive and finite.

    Warns
    -----
    ModelWarning
        If no material has that wave speed sqrt(E / rho): a unit is wrong. Numbers near 1 have no units.
    """

    length: float
    width: float
    thickness: float
    density: float
    youngs_modulus: float
    elements: int = 40
    axial: bool = True

    def __post_init__(self) -> None:
        check_positive(self, ("length", "width", "thickness"))
        check_material(self)
        object.__setattr__(self, "elements", whole_number("elements", self.elements, 1, BEAM_ELEMENTS))
        keep_flag(self, "axial")

    def reduce(
        self,
        modes: int | None = 8,
        damping: Damping = 0.0,
        *,
        stiffening: Stiffening | None = None,
        interfaces: Interfaces = (),
        residual_damping: float | None = None,
    ) -> Body:
        """The body with the ``modes`` lowest free-free modes of the mesh, bending and stretching together.

        Parameters
        ----------
        modes : at most 3 elements (2 elements without ``axial``); None for all, 0 for no free modes
        damping : damping ratio zeta of all modes, one for each (ascending frequencies), or :class:`Rayleigh`
        stiffening : by spin and by an axial force; None for the linear beam, which feels neither. With the actual
            axial force (:class:`Stiffening`), residual axial modes make it exact for what changes slowly: up to three,
            for forces at the ends and spin, and one for each place along the beam where it is held or in
            ``interfaces``
        interfaces : places where joints hold the beam, springs or loads act on it, or something strikes it: "left",
            "center", "right", x, (x, y), or an :class:`Interface`. Each adds up to three residual modes behind the free
            ones, the static response to a force along x, one along y, and a moment, so that the compliance there is
            that of the mesh; without, a beam that is held converges as 1/modes only. They have high frequencies:
            explicit steps get shorter. ``scene.add(beam, modes=8)`` finds the interfaces itself.
        residual_damping : damping ratio of the residual modes; None for that of the others, the last one of several

        Raises
        ------
        ModelError
            For more modes than the mesh has, a damping that is negative or of the wrong length, places off the beam,
            or a stiffening that cannot be: compression beyond the buckling load.
        """
        check_stiffening(stiffening)
        actual = stiffening is not None and stiffening.actual
        if actual and not self.axial:
            raise ModelError("axial_force: 'actual' was given for a beam with axial=False, expected one that stretches")
        available = (3 if self.axial else 2) * self.elements
        n = damped_modes(modes, available, damping, residual_damping)
        mass = self.density * self.width * self.thickness * self.length
        line = Line(self.length, mass, self.thickness, self.elements)
        places = interfaces_of(interfaces)
        found, is_axial = self._modes(n, line, stiffening, self._loads(line, places, stiffening if n else None))
        residual = len(found.omega2) - n
        inertia = mass * self.length**2 / 3.0
        a, coupling = _integrals(line, found, is_axial, inertia)
        area = self.width * self.thickness
        rigidity = self.youngs_modulus * area
        return body_of_line(
            line,
            found,
            n,
            inertia=inertia,
            a=a,
            damping=with_residual(damping, residual_damping, np.sqrt(found.omega2), n),
            coupling=coupling,
            geometric=None if actual else spinning(line, found, stiffening),  # spin is in the actual force
            shortening=shortening_of(line, found, is_axial, rigidity) if actual else None,
            axis=axis_of(line, found, stiffening, rigidity * self.thickness**2 / 12.0),
            recovery=line_shapes(line, found, area, area * self.thickness**2 / 12.0),
            contact_modes=contact_modes(
                line, places, lambda loads: len(self._modes(n, line, stiffening, loads)[0].omega2) - n, residual
            ),
            statics=LineStatics(partial(self._whole, line, stiffening), self.length),
            fidelity_levels=ModeLevels(
                available,
                partial(self.reduce, stiffening=stiffening, residual_damping=residual_damping),
                {"interfaces": places},
                damping,
                residual,
            ),
            reduction=reduction_by(
                partial(self.reduce, stiffening=stiffening),
                n,
                available,
                damping,
                interfaces=places,
                residual_damping=residual_damping,
            ),
            products=partial(_beam_products, modes=found, nodes=line.nodes, mass=mass),
        )

    def _loads(self, line: Line, places: tuple[Interface, ...], stiffening: Stiffening | None) -> LineLoads:
        """Of interfaces, and those that an actual axial force asks for."""
        loads = line_loads(self.length, self.thickness, places)
        return with_axial_loads(line, stiffening, loads) if stiffening is not None and stiffening.actual else loads

    def _whole(self, line: Line, stiffening: Stiffening | None) -> LineModes:
        """All modes of the mesh, or of one that is coarser and fine enough for static compliance."""
        coarse = coarser(self, FINE_ENOUGH)
        every = (3 if self.axial else 2) * coarse.elements
        return coarse._modes(every, line._replace(elements=coarse.elements), stiffening, self._loads(line, (), None))[0]

    def _modes(
        self, n: int, line: Line, stiffening: Stiffening | None, loads: LineLoads
    ) -> tuple[LineModes, BoolArray]:
        """The n lowest modes and the residual ones of the loads, and which of them are stretching modes."""
        area = self.width * self.thickness
        size = (self.elements, self.length, line.mass)
        more = loads.any()
        bends = 2 * self.elements if len(loads.bend) else min(n, 2 * self.elements)
        stretches = (self.elements if more else min(n, self.elements)) if self.axial else 0
        rigidity = self.youngs_modulus * area * self.thickness**2 / 12.0
        if stiffening is None or stiffening.constant == 0.0:
            bend2, w, slope = bending_modes(*size, rigidity, bends)
        else:
            unloaded = bending_modes(*size, rigidity, 2 * self.elements)
            bend2, w, slope = bent_under_tension(line, *unloaded, stiffening, bends)
        stretch2, u = stretching_modes(*size, self.youngs_modulus * area, stretches, lumped=False)
        no_stretch, no_bend = np.zeros_like(w), np.zeros_like(u)
        every = LineModes(
            np.concatenate([bend2, stretch2]),
            np.hstack([no_stretch, u]),
            np.hstack([w, no_bend]),
            np.hstack([slope, no_bend]),
        )
        is_axial = np.arange(len(every.omega2)) >= len(bend2)
        order = np.argsort(every.omega2, kind="stable")
        kept, left = order[:n], order[n:]
        found, axial = taken(every, kept), is_axial[kept]
        if not more:
            return found, axial
        rest, of_rest = residual_line(taken(every, left), is_axial[left], line.length / line.elements, loads)
        return joined(found, rest), np.concatenate([axial, of_rest])


def _integrals(
    line: Line, modes: LineModes, is_axial: BoolArray, inertia: float
) -> tuple[FloatArray, FloatArray | None]:
    """<Phi^T x> and D = <u_k w_l - w_k u_l> of the modes, which have no part of rigid motion."""
    nodes, element, h = line.nodes, line.mass / line.elements, line.length / line.elements
    S, a = line_moments(nodes, element, modes.stretch, lumped=False).T
    linear = np.column_stack([np.ones_like(nodes), nodes])
    raised, turned = mixed_mass(linear, modes.deflection, modes.rotation, element, h)  # <w>, <x w>
    vanish("S", np.concatenate([S, raised]), math.sqrt(line.mass))
    vanish("c", turned, math.sqrt(inertia))
    coupling = np.zeros((len(a), len(a)))
    bending = (modes.deflection[:, ~is_axial], modes.rotation[:, ~is_axial])
    mixed = mixed_mass(modes.stretch[:, is_axial], *bending, element, h)
    coupling[np.ix_(is_axial, ~is_axial)] = mixed
    coupling[np.ix_(~is_axial, is_axial)] = -mixed.T
    return a, skew(coupling)


def _beam_products(displacement: Displacement, modes: LineModes, nodes: FloatArray, mass: float) -> FloatArray:
    """<[1_x, 1_y, J x, Phi]^T d> on the axis, by four Gauss points an element (exact for nodal values)."""
    elements = len(nodes) - 1
    h = float(nodes[-1]) / elements
    place, weight = np.polynomial.legendre.leggauss(4)
    station = (h * (np.arange(elements)[:, None] + 0.5 * (place + 1.0))).ravel()
    if callable(displacement):
        values = sampled(displacement, np.column_stack([station, np.zeros_like(station)]))
    else:
        nodal = array_of("displacement", displacement, (elements + 1, 3))
        field = LineModes(np.zeros(1), nodal[:, :1], nodal[:, 1:2], nodal[:, 2:])
        values = np.hstack(interpolate(field, h, station)[:2])
    stretch, deflection, _ = interpolate(modes, h, station)
    values = values * (np.tile(0.5 * weight, elements) * (mass / elements))[:, None]
    modal = stretch.T @ values[:, 0] + deflection.T @ values[:, 1]
    return np.concatenate([values.sum(axis=0), [station @ values[:, 1]], modal])
