"""The two sides of a contact as they are compiled: what of a surface touches the other.

A face of a solid touches with its nodes or areas. So it is compiled once for each of these ways.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from lcpflex.bodies.spatial.surface import SpatialKind
from lcpflex.compile.spatial.assembly import SpatialAssembly
from lcpflex.compile.spatial.contact_surfaces import nodes_of
from lcpflex.compile.spatial.face_areas import AREAS, LINEAR, NODES, face_parts
from lcpflex.compile.spatial.mesh_features import node_facings, node_normals
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.scene.declared import DeclaredContact
from lcpflex.scene.placed_surface import PlacedSurface

__all__ = ["Carrying", "Side", "carrying_of", "side_of", "sides_of_contact"]

NO_POINTS: IntArray = np.zeros(0, np.int64)


class Side(NamedTuple):
    """A surface, and what it touches with."""

    surface: PlacedSurface
    by: str = ""

    @property
    def key(self) -> tuple[Any, ...]:
        """The same of sides that are compiled once."""
        return self.surface.label, self.by


class Carrying(NamedTuple):
    """The nodes of a side, k of them, and the s samples that those of a face are means of."""

    points: list[int]
    radii: FloatArray  # (k,)
    normals: FloatArray  # (k, 3)
    facings: FloatArray  # (k,)
    pressed: FloatArray  # (k,)
    spread: FloatArray  # (k, 6)
    areas: list[IntArray]  # of each node, its samples
    shares: list[FloatArray]
    samples: list[tuple[IntArray, FloatArray]]  # points and weights
    outward: FloatArray  # (s, 3)


def side_of(surface: PlacedSurface) -> Side:
    """A surface by itself, as a rule for all has it."""
    if surface.shape.kind is not SpatialKind.FACE:
        return Side(surface)
    return Side(surface, NODES if all(len(cell) in LINEAR for cell in surface.shape.cells) else AREAS)


def sides_of_contact(contact: DeclaredContact) -> tuple[Side, Side]:
    """Of the surfaces of a contact, in their order."""
    first, second = contact.pair
    return _side(contact, first), _side(contact, second)


def _side(contact: DeclaredContact, surface: PlacedSurface) -> Side:
    if surface.shape.kind is not SpatialKind.FACE:
        return Side(surface)
    touches = contact.node_side is None or contact.node_side.label == surface.label
    return Side(surface, contact.points if touches else NODES)


def carrying_of(side: Side, indices: list[int], assembly: SpatialAssembly) -> Carrying:
    """The nodes of a side, whose points have these ``indices``."""
    shape = side.surface.shape
    if shape.kind is SpatialKind.FACE:
        return _of_face(side, indices, assembly)
    carrying = nodes_of(shape, indices)
    k = len(carrying)
    round_ones = shape.radius > 0.0 or not len(shape.triangles)
    normals = np.zeros((k, 3)) if round_ones else node_normals(shape)
    facings = np.zeros(k) if round_ones else node_facings(shape, normals)
    radii = np.array([radius for _, radius in carrying])
    none = [NO_POINTS] * k
    points = [point for point, _ in carrying]
    return Carrying(points, radii, normals, facings, np.zeros(k), np.zeros((k, 6)), none, [], [], np.zeros((0, 3)))


def _of_face(side: Side, indices: list[int], assembly: SpatialAssembly) -> Carrying:
    parts = face_parts(side.surface.shape, side.by)
    numbers = np.array(indices, dtype=np.int64)
    return Carrying(
        [assembly.point(side.surface.body, point) for point in parts.points],
        np.zeros(len(parts.points)),
        parts.normals,
        np.zeros(len(parts.points)),
        parts.pressed,
        parts.spread,
        parts.samples,
        parts.shares,
        [(numbers[nodes], weights) for nodes, weights in zip(parts.nodes, parts.weights, strict=True)],
        parts.outward,
    )
