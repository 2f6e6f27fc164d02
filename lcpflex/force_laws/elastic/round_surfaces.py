"""Radii of two surfaces that touch, so that laws need not be told them again."""

from __future__ import annotations

import math
from typing import Protocol

from lcpflex.bodies.surface import Kind, Surface
from lcpflex.errors import ModelError, shown

__all__ = ["Shaped", "radii_between"]

EXPECTED = "expected a disc, a round part of a body or a hole"


class Shaped(Protocol):
    """A surface of a scene: made by ``body.circle``, ``body.hole``, ``body.arc``, ``body.node``, ``body.surface``."""

    @property
    def shape(self) -> Surface: ...
    @property
    def label(self) -> str: ...


def radii_between(a: Shaped, b: Shaped) -> tuple[float, float]:
    """Radii of a and b [m]: that of a hole is negative, that of a half-plane infinite.

    Raises
    ------
    ModelError
        For what is no surface, nodes without radius and chains, which have no radius, and two surfaces of which none
        is a disc or a round part of a body.
    """
    radii = (_radius("a", a), _radius("b", b))
    if not any(0.0 < radius < math.inf for radius in radii):
        raise ModelError(f"b: {b.label!r} was given for {a.label!r}, expected a disc or a round part of a body")
    return radii


def _radius(argument: str, surface: Shaped) -> float:
    shape = getattr(surface, "shape", None)
    if not isinstance(shape, Surface):
        raise ModelError(
            f"{argument}: {shown(surface)} was given, expected a surface such as body.circle((0, 0), 0.01)"
        )
    if shape.kind is Kind.HALF_PLANE:
        return math.inf
    if shape.kind is Kind.HOLE:
        return -shape.radius
    if shape.kind in (Kind.CIRCLE, Kind.ARC):
        return shape.radius
    raise ModelError(f"{argument}: {surface.label!r} (a {shape.kind.value} without a radius) was given, {EXPECTED}")
