"""What beams and bars share: material points of a strip, its outlines, and integrals along it."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from functools import partial
from typing import Any, Protocol, TypeVar

import numpy as np

from lcpflex.basics.arguments import positive
from lcpflex.bodies.body import Chain, Lazily, MaterialPoint, Outline
from lcpflex.bodies.fem.line_elements import LineModes, interpolate
from lcpflex.errors import in_range
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import frozen

__all__ = ["FINE_ENOUGH", "check_positive", "coarser", "end_points", "line_mass", "line_moments", "locator", "strip"]

FINE_ENOUGH = 100  # elements of a line whose static compliance stands for that of a finer one


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


def locator(modes: LineModes, length: float, height: float, h: float) -> Callable[[float, float], MaterialPoint]:
    """The material point at (x, y) of a strip 0 <= x <= length, |y| <= height/2."""
    return partial(_locate, modes, length, height, h)


def _locate(modes: LineModes, length: float, height: float, h: float, x: float, y: float) -> MaterialPoint:
    slack = 1e-12 * length
    along = in_range("x", x, -slack, length + slack)
    across = in_range("y", y, -0.5 * height - slack, 0.5 * height + slack)
    return _located(modes, h, np.array([along]), np.array([across]))[0]


def end_points(locate: Callable[[float, float], MaterialPoint], length: float) -> dict[str, MaterialPoint]:
    """The named points of a line."""
    return {"left": locate(0.0, 0.0), "center": locate(0.5 * length, 0.0), "right": locate(length, 0.0)}


def _outline(modes: LineModes, h: float, x: FloatArray, y: FloatArray, closed: bool) -> Chain:
    return Chain(_located(modes, h, x, y), closed)


def strip(modes: LineModes, h: float, nodes: FloatArray, half: float) -> Lazily[Outline]:
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
