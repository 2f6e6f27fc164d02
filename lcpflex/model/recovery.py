"""What section forces and stresses of a flexible body are recovered from: its shapes along a line, or at all nodes.

Arrays alone, so that files keep them. No kernel takes them.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple, TypeAlias

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.arrays import frozen

__all__ = ["LARGEST", "NOTHING", "LineShapes", "MeshShapes", "Shapes", "SpatialLineShapes", "small_enough"]

NOTHING = frozen([])
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
    """A mesh of one kind of element with its material, in d = 2 or 3 dimensions, and its modes at its N nodes."""

    kind: str  # of the elements, by the names of :mod:`lcpflex.bodies.fem.mesh`
    places: FloatArray  # (N, d) in the frame of the body [m]
    cells: IntArray  # (elements, nodes of one)
    density: float  # [kg/m^3]
    lame: tuple[float, float]  # L and G [Pa], L that of plane stress for plane stress
    thickness: float | None  # [m]; None: a solid of revolution about y = 0; 1 in space
    plane_stress: bool
    phi: FloatArray  # (N, d, n) [kg^-1/2]


class SpatialLineShapes(NamedTuple):
    """A straight uniform beam of space along x, its middle at x = 0, and its modes at the nodes of its elements."""

    length: float  # [m]
    mass: float  # [kg]
    gyration: tuple[float, float]  # I_z / A and I_y / A of the cross-section, mean squares of y and of z in it [m^2]
    shear: tuple[float, float]  # s = 12 E I / (k G A h^2) of bending in the planes xy and xz
    shapes: FloatArray  # (nodes, 6, n) u, v, w, h phi, h b and h c of :mod:`lcpflex.bodies.spatial.beam_elements`
    # what the stiffness of bending counts with, at the nodes; empty for the linear beam, and in older files
    spin: FloatArray = NOTHING  # (nodes,) N at 1 rad/s across the axis [N s^2]
    given: FloatArray = NOTHING  # (nodes,) N of the axial force that was given [N]


Shapes: TypeAlias = LineShapes | MeshShapes | SpatialLineShapes


def small_enough(shapes: Iterable[Shapes | None]) -> tuple[Shapes | None, ...]:
    """Those that a file keeps; None for a mesh of more numbers than LARGEST, as one with all of its modes has."""
    return tuple(None if _numbers(one) > LARGEST else one for one in shapes)


def _numbers(one: Shapes | None) -> int:
    """How many numbers the modes of a mesh or of a beam of space are."""
    if isinstance(one, MeshShapes):
        return one.phi.size
    return one.shapes.size if isinstance(one, SpatialLineShapes) else 0
