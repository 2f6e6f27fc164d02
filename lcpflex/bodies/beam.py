"""Straight uniform beams and bars, through finite elements and free-interface modes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from lcpflex.bodies.beam_shortening import axial_loads, shortening_of
from lcpflex.bodies.beam_stiffening import Line, axis_of, bent_under_tension, spinning
from lcpflex.bodies.body import Body, Chain, Displacement, Lazily, MaterialPoint, Outline, array_of, whole_number
from lcpflex.bodies.ladder import mode_ladder
from lcpflex.bodies.line_interfaces import Interfaces, residual_line, stations_of, taken
from lcpflex.bodies.line_mesh import LineModes, bending_modes, interpolate, mixed_mass, stretching_modes
from lcpflex.bodies.material import check_material
from lcpflex.bodies.reduction import (
    Damping,
    check_damping,
    count_of_modes,
    modal_damping,
    sampled,
    skew,
    vanish,
    with_last,
)
from lcpflex.bodies.stiffening import Stiffening, check_stiffening
from lcpflex.compiled import FloatArray
from lcpflex.errors import ModelError, in_range
from lcpflex.model import frozen

__all__ = ["Bar", "Beam"]

BEAM_ELEMENTS = 1000  # beyond it the bending stiffness of free elements drowns in rounding (omega^2 ~ elements^-4)
BAR_ELEMENTS = 20_000


@dataclass(frozen=True, slots=True)
class Beam:
    """A straight uniform planar Euler-Bernoulli beam: rho A w_tt + E I w_xxxx = 0, and rho A u_tt = E A u_xx.

    The axis runs from (0, 0), point "left", to (length, 0), point "right", in the body frame; "center" is its middle.
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
        _check_positive(self, ("length", "width", "thickness"))
        check_material(self)
        object.__setattr__(self, "elements", whole_number("elements", self.elements, 1, BEAM_ELEMENTS))
        if not isinstance(self.axial, (bool, np.bool_)):
            raise ModelError(f"axial: {self.axial!r} was given, expected True or False")

    def reduce(
        self,
        modes: int | None = 8,
        damping: Damping = 0.0,
        *,
        stiffening: Stiffening | None = None,
        interfaces: Interfaces = (),
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
            "center", "right", x, or (x, y). Each adds up to three residual modes behind the free ones, the static
            response to a force along x, one along y, and a moment, so that the compliance there is that of the mesh;
            without, a beam that is held converges as 1/modes only. They have the last of several damping ratios, and
            high frequencies: explicit steps get shorter.

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
        n = count_of_modes(modes, available)
        check_damping(damping, n)
        mass = self.density * self.width * self.thickness * self.length
        line = Line(self.length, mass, self.thickness, self.elements)
        found, is_axial = self._modes(n, line, stiffening, stations_of(self.length, self.thickness, interfaces))
        damping, n = with_last(damping, n, len(found.omega2)), len(found.omega2)
        h = self.length / self.elements
        nodes = np.linspace(0.0, self.length, self.elements + 1)
        inertia = mass * self.length**2 / 3.0
        stretched, bent = found.stretch[:, is_axial], np.flatnonzero(~is_axial)
        moments = _line_moments(nodes, mass / self.elements, found.stretch, lumped=False)
        linear = np.column_stack([np.ones_like(nodes), nodes])
        raised = mixed_mass(linear, found.deflection, found.rotation, mass / self.elements, h).T  # <w>, <x w>
        vanish("S", np.concatenate([moments[:, 0], raised[:, 0]]), math.sqrt(mass))
        vanish("c", raised[:, 1], math.sqrt(inertia))
        coupling = np.zeros((n, n))
        bending = (found.deflection[:, bent], found.rotation[:, bent])
        mixed = mixed_mass(stretched, *bending, mass / self.elements, h)  # <u_k w_l>, D = <u_k w_l - w_k u_l>
        coupling[np.ix_(is_axial, ~is_axial)] = mixed
        coupling[np.ix_(~is_axial, is_axial)] = -mixed.T
        locate = _locator(found, self.length, self.thickness, h)
        return Body(
            mass=mass,
            inertia=inertia,
            moment=np.array([0.5 * mass * self.length, 0.0]),
            S=np.zeros((n, 2)),
            a=moments[:, 1],
            c=np.zeros(n),
            stiffness=found.omega2,
            damping=modal_damping(damping, np.sqrt(found.omega2)),
            coupling=skew(coupling),
            cross_damping=None,
            points=_end_points(locate, self.length),
            surfaces=_strip(found, h, nodes, 0.5 * self.thickness),
            locate=locate,
            geometric=None if actual else spinning(line, found, stiffening),  # spin is in the actual force
            shortening=shortening_of(line, found, is_axial, self.youngs_modulus * self.width * self.thickness)
            if actual
            else None,
            axis=axis_of(line, found, nodes, stiffening, self.youngs_modulus * self.width * self.thickness**3 / 12.0),
            ladder=lambda: mode_ladder(available, lambda k, z: self.reduce(k, z, stiffening=stiffening), damping),
            products=lambda displacement: _beam_products(displacement, found, nodes, mass),
        )

    def _modes(
        self, n: int, line: Line, stiffening: Stiffening | None, stations: FloatArray
    ) -> tuple[LineModes, np.ndarray[Any, np.dtype[np.bool_]]]:
        """The n lowest modes and the residual ones of the stations, and which of them are stretching modes."""
        area = self.width * self.thickness
        size = (self.elements, self.length, line.mass)
        along = axial_loads(line, stiffening, stations) if n and stiffening is not None and stiffening.actual else None
        bends = 2 * self.elements if len(stations) else min(n, 2 * self.elements)
        every_stretch = len(stations) > 0 or along is not None
        stretches = (self.elements if every_stretch else min(n, self.elements)) if self.axial else 0
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
        if not every_stretch:
            return found, axial
        h = line.length / line.elements
        rest, of_rest = residual_line(taken(every, left), is_axial[left], h, stations, along)
        return LineModes(*(np.concatenate(pair, axis=-1) for pair in zip(found, rest, strict=True))), np.concatenate(
            [axial, of_rest]
        )


@dataclass(frozen=True, slots=True)
class Bar:
    """A straight uniform bar that stretches and does not bend: rho A u_tt = E A u_xx, linear elements.

    The axis runs from (0, 0), point "left", to (length, 0), point "right"; "center" is its middle. The frame carries
    all motion across the axis; <x.x> = x^T M x with the mass matrix M of the mesh: rho A L^3 / 3 if consistent.

    Surfaces: "outline" (closed, through all nodes on both faces y = -+height/2), "bottom", "top", and the plane end
    faces "left" and "right", two points each. An end face against a wall makes two contacts that share the force; for
    one contact at an end use a node there, against a half-plane or against the end face of another bar.

    Parameters
    ----------
    length : along x [m]
    area : cross-section [m^2]
    density : [kg/m^3]
    youngs_modulus : [Pa]
    elements : number of equal elements
    lumped : diagonal mass matrix instead of the consistent one
    height : of the end faces, used for contact only [m]; None for that of a square section, sqrt(area)

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
    area: float
    density: float
    youngs_modulus: float
    elements: int = 100
    lumped: bool = False
    height: float | None = None

    def __post_init__(self) -> None:
        _check_positive(self, ("length", "area"))
        check_material(self)
        object.__setattr__(self, "elements", whole_number("elements", self.elements, 1, BAR_ELEMENTS))
        if not isinstance(self.lumped, (bool, np.bool_)):
            raise ModelError(f"lumped: {self.lumped!r} was given, expected True or False")
        if self.height is not None:
            _check_positive(self, ("height",))

    def reduce(self, modes: int | None = None, damping: Damping = 0.0, *, interfaces: Interfaces = ()) -> Body:
        """The body with the ``modes`` lowest free-free modes; all of them give the motion of the nodal coordinates.

        Parameters
        ----------
        modes : at most the number of elements; None for all, 0 for a rigid bar
        damping : damping ratio zeta of all modes, one for each (ascending frequencies), or :class:`Rayleigh`
        interfaces : places where the bar is held, loaded or struck, as for :meth:`Beam.reduce`: each adds the residual
            mode of a force along x

        Raises
        ------
        ModelError
            For more modes than the mesh has, a damping that is negative or of the wrong length, or places off the bar.
        """
        n = count_of_modes(modes, self.elements)
        check_damping(damping, n)
        mass = self.density * self.area * self.length
        height = math.sqrt(self.area) if self.height is None else self.height
        stations = stations_of(self.length, height, interfaces)
        count = self.elements if len(stations) else n
        omega2, shapes = stretching_modes(
            self.elements, self.length, mass, self.youngs_modulus * self.area, count, bool(self.lumped)
        )
        if len(stations):
            still = np.zeros_like(shapes)
            left = taken(LineModes(omega2, shapes, still, still), np.arange(n, count))
            every = np.ones(count - n, dtype=bool)
            rest, _ = residual_line(left, every, self.length / self.elements, stations)
            omega2, shapes = np.concatenate([omega2[:n], rest.omega2]), np.hstack([shapes[:, :n], rest.stretch])
            damping, n = with_last(damping, n, len(omega2)), len(omega2)
        nodes = np.linspace(0.0, self.length, self.elements + 1)
        moments = _line_moments(nodes, mass / self.elements, shapes, bool(self.lumped))
        vanish("S", moments[:, 0], math.sqrt(mass))
        still = np.zeros_like(shapes)
        found, h = LineModes(omega2, shapes, still, still), self.length / self.elements
        locate = _locator(found, self.length, height, h)
        inertia = float(_line_moments(nodes, mass / self.elements, nodes[:, None], bool(self.lumped))[0, 1])
        return Body(
            mass=mass,
            inertia=inertia,
            moment=np.array([0.5 * mass * self.length, 0.0]),
            S=np.zeros((n, 2)),
            a=moments[:, 1],
            c=np.zeros(n),
            stiffness=omega2,
            damping=modal_damping(damping, np.sqrt(omega2)),
            coupling=None,
            cross_damping=None,
            points=_end_points(locate, self.length),
            surfaces=_strip(found, h, nodes, 0.5 * height),
            locate=locate,
            ladder=lambda: mode_ladder(self.elements, self.reduce, damping),
            products=lambda field: _bar_products(field, shapes, nodes, mass / self.elements, bool(self.lumped)),
        )


def _check_positive(part: Any, names: tuple[str, ...]) -> None:
    for name in names:
        object.__setattr__(part, name, in_range(name, getattr(part, name), 0.0, math.inf, open_ends=True))


def _line_mass(values: FloatArray, element_mass: float, lumped: bool) -> FloatArray:
    """M times nodal values (nodes, k), linear elements."""
    out = np.zeros_like(values)
    if lumped:
        out[:-1] += 0.5 * values[:-1]
        out[1:] += 0.5 * values[1:]
    else:
        out[:-1] += (2.0 * values[:-1] + values[1:]) / 6.0
        out[1:] += (values[:-1] + 2.0 * values[1:]) / 6.0
    return np.asarray(element_mass * out)


def _line_moments(nodes: FloatArray, element_mass: float, stretch: FloatArray, lumped: bool) -> FloatArray:
    """(n, 2) <u> and <x u> of the stretches (nodes, n)."""
    return np.asarray(stretch.T @ _line_mass(np.column_stack([np.ones_like(nodes), nodes]), element_mass, lumped))


def _located(modes: LineModes, h: float, x: FloatArray, y: FloatArray) -> tuple[MaterialPoint, ...]:
    """The material points at places of a strip, all at once: an outline has many."""
    stretch, deflection, slope = interpolate(modes, h, x)
    places = frozen(np.column_stack([x, y]))
    phi, psi = frozen(np.stack([stretch - y[:, None] * slope, deflection], axis=-1)), frozen(slope)
    return tuple(MaterialPoint(*point) for point in zip(places, phi, psi, strict=True))


def _locator(modes: LineModes, length: float, height: float, h: float) -> Callable[[float, float], MaterialPoint]:
    """The material point at (x, y) of a strip 0 <= x <= length, |y| <= height/2."""

    def locate(x: float, y: float) -> MaterialPoint:
        slack = 1e-12 * length
        along = in_range("x", x, -slack, length + slack)
        across = in_range("y", y, -0.5 * height - slack, 0.5 * height + slack)
        return _located(modes, h, np.array([along]), np.array([across]))[0]

    return locate


def _end_points(locate: Callable[[float, float], MaterialPoint], length: float) -> dict[str, MaterialPoint]:
    return {"left": locate(0.0, 0.0), "center": locate(0.5 * length, 0.0), "right": locate(length, 0.0)}


def _strip(modes: LineModes, h: float, nodes: FloatArray, half: float) -> Lazily[Outline]:
    """Outlines of a strip through its nodes, solid on the left: made when asked for, a fine mesh has many points."""
    forth = [float(x) for x in nodes]
    back = forth[::-1]
    left, right = forth[0], back[0]

    def chain(places: list[tuple[float, float]], closed: bool = False) -> Callable[[], Outline]:
        x, y = np.array(places).T
        return lambda: Chain(_located(modes, h, x, y), closed)

    bottom = [(x, -half) for x in forth]
    top = [(x, half) for x in back]
    return Lazily(
        {
            "outline": chain(bottom + top, closed=True),
            "bottom": chain(bottom),
            "right": chain([(right, -half), (right, half)]),
            "top": chain(top),
            "left": chain([(left, half), (left, -half)]),
        }
    )


def _bar_products(
    displacement: Displacement, shapes: FloatArray, nodes: FloatArray, element_mass: float, lumped: bool
) -> FloatArray:
    """<[1_x, 1_y, J x, Phi]^T d> of nodal values d (nodes, 2), with the mass matrix of the mesh."""
    values = sampled(displacement, np.column_stack([nodes, np.zeros_like(nodes)]))
    if len(values) != len(nodes):
        raise ModelError(f"displacement: {len(values)} nodal values were given, expected {len(nodes)}")
    weighed = _line_mass(values, element_mass, lumped)
    return np.concatenate([weighed.sum(axis=0), [nodes @ weighed[:, 1]], shapes.T @ weighed[:, 0]])


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
