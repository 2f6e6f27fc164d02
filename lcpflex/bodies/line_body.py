"""What beams and bars share: material points of a strip, its outlines, and integrals along it."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from functools import partial
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np

from lcpflex.basics.arguments import positive
from lcpflex.bodies.body import Body, Chain, Lazily, MaterialPoint, Outline
from lcpflex.bodies.fem.line_elements import LineModes, interpolate
from lcpflex.bodies.reduction.interface import Interface
from lcpflex.bodies.reduction.line_interfaces import LineLoads, line_loads
from lcpflex.errors import in_range
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import frozen
from lcpflex.model.recovery import LineShapes

__all__ = [
    "FINE_ENOUGH",
    "Line",
    "body_of_line",
    "check_positive",
    "coarser",
    "contact_modes",
    "line_mass",
    "line_moments",
    "line_shapes",
]

FINE_ENOUGH = 100  # elements of a line whose static compliance stands for that of a finer one


class Line(NamedTuple):
    """A straight line of equal elements: length [m], mass [kg], thickness [m] and their number."""

    length: float
    mass: float
    thickness: float
    elements: int

    @property
    def nodes(self) -> FloatArray:
        """(elements + 1,) their places [m]."""
        return np.linspace(0.0, self.length, self.elements + 1)


class HasElements(Protocol):
    """A beam or a bar."""

    @property
    def elements(self) -> int:
        """Number of elements."""
        ...


Meshed = TypeVar("Meshed", bound=HasElements)


def coarser(line: Meshed, most: int) -> Meshed:
    """The beam or bar with at most so many elements; its material has been checked, and warned of, before."""
    if line.elements <= most:
        return line
    coarse = copy(line)
    object.__setattr__(coarse, "elements", most)
    return coarse


def check_positive(part: Any, names: tuple[str, ...]) -> None:
    """Make attributes floats > 0. Raises ModelError, naming the one that is not."""
    for name in names:
        object.__setattr__(part, name, positive(name, getattr(part, name)))


def line_mass(values: FloatArray, element_mass: float, lumped: bool) -> FloatArray:
    """M times nodal values (nodes, k), linear elements."""
    out = np.zeros_like(values)
    if lumped:
        out[:-1] += 0.5 * values[:-1]
        out[1:] += 0.5 * values[1:]
    else:
        out[:-1] += (2.0 * values[:-1] + values[1:]) / 6.0
        out[1:] += (values[:-1] + 2.0 * values[1:]) / 6.0
    return np.asarray(element_mass * out)


def line_moments(nodes: FloatArray, element_mass: float, stretch: FloatArray, lumped: bool) -> FloatArray:
    """(n, 2) <u> and <x u> of the stretches (nodes, n)."""
    return np.asarray(stretch.T @ line_mass(np.column_stack([np.ones_like(nodes), nodes]), element_mass, lumped))


def _located(modes: LineModes, h: float, x: FloatArray, y: FloatArray) -> tuple[MaterialPoint, ...]:
    """The material points at places of a strip, all at once: an outline has many."""
    stretch, deflection, slope = interpolate(modes, h, x)
    places = frozen(np.column_stack([x, y]))
    phi, psi = frozen(np.stack([stretch - y[:, None] * slope, deflection], axis=-1)), frozen(slope)
    return tuple(MaterialPoint(*point) for point in zip(places, phi, psi, strict=True))


def _locate(modes: LineModes, length: float, height: float, h: float, x: float, y: float) -> MaterialPoint:
    """The material point at (x, y) of a strip 0 <= x <= length, |y| <= height/2."""
    slack = 1e-12 * length
    along = in_range("x", x, -slack, length + slack)
    across = in_range("y", y, -0.5 * height - slack, 0.5 * height + slack)
    return _located(modes, h, np.array([along]), np.array([across]))[0]


def body_of_line(line: Line, modes: LineModes, free: int, inertia: float, a: FloatArray, **others: Any) -> Body:
    """The body of a line by its modes, of which ``free`` ones come before the residual ones.

    inertia: I0 [kg m^2]; a: <Phi^T x>. ``others`` of :class:`Body`: what is not the same for beams and bars.
    """
    n, h = len(modes.omega2), line.length / line.elements
    locate = partial(_locate, modes, line.length, line.thickness, h)
    return Body(
        mass=line.mass,
        inertia=inertia,
        moment=np.array([0.5 * line.mass * line.length, 0.0]),
        S=np.zeros((n, 2)),
        a=a,
        c=np.zeros(n),
        stiffness=modes.omega2,
        cross_damping=None,
        points={
            "left": locate(0.0, 0.0),
            "center": locate(0.5 * line.length, 0.0),
            "right": locate(line.length, 0.0),
        },
        surfaces=_strip(modes, h, line.nodes, 0.5 * line.thickness),
        locate=locate,
        residual_modes=n - free,
        **others,
    )


def line_shapes(line: Line, modes: LineModes, area: float, second_moment: float, lumped: bool = False) -> LineShapes:
    """What section forces are recovered from; ``second_moment``: 0 of a bar, which does not bend."""
    return LineShapes(
        line.length, line.mass, area, second_moment, line.thickness, lumped,
        frozen(modes.stretch), frozen(modes.deflection), frozen(modes.rotation),
    )  # fmt: skip


def contact_modes(line: Line, interfaces: tuple[Interface, ...], count: Callable[[LineLoads], int], most: int) -> int:
    """How many of ``most`` residual modes the interfaces make that something touches; ``count``: those of loads."""
    touched = tuple(one for one in interfaces if one.contact)
    return min(most, count(line_loads(line.length, line.thickness, touched))) if touched else 0


def _outline(modes: LineModes, h: float, x: FloatArray, y: FloatArray, closed: bool) -> Chain:
    return Chain(_located(modes, h, x, y), closed)


def _strip(modes: LineModes, h: float, nodes: FloatArray, half: float) -> Lazily[Outline]:
    """Outlines of a strip through its nodes, solid on the left: made when asked for, a fine mesh has many points."""
    forth = [float(x) for x in nodes]
    back = forth[::-1]
    left, right = forth[0], back[0]

    def chain(places: list[tuple[float, float]], closed: bool = False) -> Callable[[], Outline]:
        x, y = np.array(places).T
        return partial(_outline, modes, h, x, y, closed)

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
