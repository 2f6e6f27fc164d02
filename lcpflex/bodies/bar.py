"""Straight uniform bars, through finite elements and free-interface modes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from lcpflex.basics.options import keep_flag
from lcpflex.bodies.body import Body, Displacement, whole_number
from lcpflex.bodies.fem.line_elements import LineModes, stretching_modes
from lcpflex.bodies.fem.material import check_material
from lcpflex.bodies.line_body import (
    FINE_ENOUGH,
    Line,
    body_of_line,
    check_positive,
    coarser,
    contact_modes,
    line_mass,
    line_moments,
    line_shapes,
)
from lcpflex.bodies.reduction.again import reduction_by
from lcpflex.bodies.reduction.damping import (
    Damping,
    damped_modes,
    sampled,
    vanish,
    with_residual,
)
from lcpflex.bodies.reduction.fidelity_levels import ModeLevels
from lcpflex.bodies.reduction.interface import Interfaces, interfaces_of
from lcpflex.bodies.reduction.line_interfaces import LineLoads, LineStatics, joined, line_loads, residual_line, taken
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray

__all__ = ["Bar"]

BAR_ELEMENTS = 20_000


@dataclass(frozen=True, slots=True)
class Bar:
    """A straight uniform bar that stretches and does not bend: rho A u_tt = E A u_xx, linear elements.

    The axis runs from (0, 0), point "left", to (length, 0), point "right"; "center" is its middle. The frame, at the
    left end (``scene.add(bar, position=..., point="center")`` puts the middle there), carries
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
        check_positive(self, ("length", "area"))
        check_material(self)
        object.__setattr__(self, "elements", whole_number("elements", self.elements, 1, BAR_ELEMENTS))
        keep_flag(self, "lumped")
        if self.height is not None:
            check_positive(self, ("height",))

    def reduce(
        self,
        modes: int | None = None,
        damping: Damping = 0.0,
        *,
        interfaces: Interfaces = (),
        residual_damping: float | None = None,
    ) -> Body:
        """The body with the ``modes`` lowest free-free modes; all of them give the motion of the nodal coordinates.

        Parameters
        ----------
        modes : at most the number of elements; None for all, 0 for a rigid bar
        damping : damping ratio zeta of all modes, one for each (ascending frequencies), or :class:`Rayleigh`
        interfaces : places where the bar is held, loaded or struck, as for :meth:`Beam.reduce`: each adds the residual
            mode of a force along x
        residual_damping : damping ratio of the residual modes; None for that of the others, the last one of several

        Raises
        ------
        ModelError
            For more modes than the mesh has, a damping that is negative or of the wrong length, or places off the bar.
        """
        n = damped_modes(modes, self.elements, damping, residual_damping)
        mass = self.density * self.area * self.length
        height = math.sqrt(self.area) if self.height is None else self.height
        line = Line(self.length, mass, height, self.elements)
        places = interfaces_of(interfaces)
        found = self._modes(n, mass, line_loads(self.length, height, places))
        residual = len(found.omega2) - n
        moments = partial(line_moments, line.nodes, mass / self.elements, lumped=self.lumped)
        S, a = moments(found.stretch).T
        vanish("S", S, math.sqrt(mass))
        return body_of_line(
            line,
            found,
            n,
            inertia=float(moments(line.nodes[:, None])[0, 1]),
            a=a,
            damping=with_residual(damping, residual_damping, np.sqrt(found.omega2), n),
            coupling=None,
            contact_modes=contact_modes(
                line, places, lambda loads: len(self._modes(n, mass, loads).omega2) - n, residual
            ),
            statics=LineStatics(partial(self._whole, mass), self.length),
            recovery=line_shapes(line, found, self.area, 0.0, self.lumped),
            fidelity_levels=ModeLevels(
                self.elements,
                partial(self.reduce, residual_damping=residual_damping),
                {"interfaces": places},
                damping,
                residual,
            ),
            reduction=reduction_by(
                self.reduce, n, self.elements, damping, interfaces=places, residual_damping=residual_damping
            ),
            products=partial(
                _bar_products,
                shapes=found.stretch,
                nodes=line.nodes,
                element_mass=mass / self.elements,
                lumped=self.lumped,
            ),
        )

    def _modes(self, n: int, mass: float, loads: LineLoads) -> LineModes:
        """The n lowest modes and the residual ones of the loads."""
        more = bool(len(loads.stretch))
        count = self.elements if more else n
        rigidity = self.youngs_modulus * self.area
        every = _stretching(*stretching_modes(self.elements, self.length, mass, rigidity, count, self.lumped))
        if not more:
            return every
        kept, left = taken(every, slice(n)), taken(every, np.arange(n, count))
        rest, _ = residual_line(left, np.ones(count - n, dtype=bool), self.length / self.elements, loads)
        return joined(kept, rest)

    def _whole(self, mass: float) -> LineModes:
        """All modes of the mesh, or of one that is coarser and fine enough for static compliance."""
        coarse = coarser(self, 2 * FINE_ENOUGH)
        return coarse._modes(coarse.elements, mass, line_loads(self.length, 0.0, ()))


def _stretching(omega2: FloatArray, shapes: FloatArray) -> LineModes:
    """Modes that stretch a line and do not bend it."""
    return LineModes(omega2, shapes, np.zeros_like(shapes), np.zeros_like(shapes))


def _bar_products(
    displacement: Displacement, shapes: FloatArray, nodes: FloatArray, element_mass: float, lumped: bool
) -> FloatArray:
    """<[1_x, 1_y, J x, Phi]^T d> of nodal values d (nodes, 2), with the mass matrix of the mesh."""
    values = sampled(displacement, np.column_stack([nodes, np.zeros_like(nodes)]))
    if len(values) != len(nodes):
        raise ModelError(f"displacement: {len(values)} nodal values were given, expected {len(nodes)}")
    weighed = line_mass(values, element_mass, lumped)
    return np.concatenate([weighed.sum(axis=0), [nodes @ weighed[:, 1]], shapes.T @ weighed[:, 0]])
