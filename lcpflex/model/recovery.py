"""What section forces and stresses of a flexible body are recovered from: its shapes along a line, or at all nodes.

Arrays alone, so that files keep them. No kernel takes them.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple, TypeAlias

from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["LARGEST", "LineShapes", "MeshShapes", "Shapes", "small_enough"]

LARGEST = 2_000_000  # numbers of the shapes of a body that a file keeps: 16 MB


class LineShapes(NamedTuple):
    """A straight uniform beam or bar and its modes at the nodes of its equal elements."""

    length: float  # [m]
    mass: float  # [kg]
    area: float  # of the cross-section [m^2]
    second_moment: float  # I of the cross-section [m^4]; 0: it does not bend
    height: float  # of the cross-section [m]
    lumped: bool  # whether its mass is at its nodes
    stretch: FloatArray  # (nodes, n) u [kg^-1/2]
    deflection: FloatArray  # (nodes, n) w [kg^-1/2]
    rotation: FloatArray  # (nodes, n) w' [kg^-1/2 / m]


class MeshShapes(NamedTuple):
    """A planar mesh of one kind of element with its material, and its modes at its N nodes."""

    kind: str  # of the elements, by the names of :mod:`lcpflex.bodies.fem.planar_mesh`
    places: FloatArray  # (N, 2) [m]
    cells: IntArray  # (elements, nodes of one)
    density: float  # [kg/m^3]
    lame: tuple[float, float]  # L and G [Pa], L that of plane stress for plane stress
    thickness: float | None  # [m]; None: a solid of revolution about y = 0
    plane_stress: bool
    phi: FloatArray  # (N, 2, n) [kg^-1/2]


Shapes: TypeAlias = LineShapes | MeshShapes


def small_enough(shapes: Iterable[Shapes | None]) -> tuple[Shapes | None, ...]:
    """Those that a file keeps; None for a mesh of more numbers than LARGEST, as one with all of its modes has."""
    return tuple(None if isinstance(one, MeshShapes) and one.phi.size > LARGEST else one for one in shapes)
