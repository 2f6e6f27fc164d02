"""Structured meshes of 8-node hexahedra: box, bar, cylinder, tube, ball.

Elements are as long as ``size`` at most. ``near`` makes them smaller towards places of the surface where contact is
expected: name -> (place, finest), (place, finest, radius) or (place, finest, radius, growth). Within ``radius`` [m] of
the place (8 ``finest`` if omitted) their edges are at most ``finest`` long, and from there on each is ``growth`` times
its neighbour (1.28 if omitted; below 3). The quadrilaterals of the boundary within that radius are the face ``name``. A
place must be on the surface, to ``finest``. Small elements go on along their lines, through the whole body: no node
hangs on an edge. A ball with one place has shells about it instead, from there to its antipode, where these are fewer
elements.

A radius of contact of five elements gives the pressure of Hertz's contact to 3 %, three its force and size.

Curved boundaries have their nodes on them, so that volumes are below those of the shapes by a part that falls with the
square of ``size``. There are eight elements at least around each of them.

All functions raise :class:`ModelError` for lengths that are not positive, a mesh of more than a million elements
(before it is made), and in ``near``: places that are not on the surface, finest > size, a radius that no quadrilateral
fits into, and names that faces of the shape have.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.basics.arguments import array_of, positive, sequence_of, whole_number
from lcpflex.bodies.fem.faces import SURFACE
from lcpflex.bodies.fem.graded_lines import Pull, Spot, lines_between, refuse_many, spots_of
from lcpflex.bodies.fem.mesh import Mesh
from lcpflex.bodies.fem.round_map import RoundMap
from lcpflex.bodies.fem.shape_grids import Block, Grid, Round, Shape, Tube
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["ball", "bar", "box", "cylinder", "tube"]

ROUNDS = 10  # of making a mesh whose elements are too long by what its curves do to them; four have been enough
MARGIN = 0.01  # by which lines go closer together than they would have to at first: less may not make one line more
EXCESS = 1e-9  # of a length, which rounding may add


def box(
    sizes: npt.ArrayLike, size: float | None = None, *, near: Any = None, elements: Sequence[int] | None = None
) -> Mesh:
    """A rectangular block about the origin, its edges along the axes.

    Faces "left", "right" (x), "front", "back" (y), "bottom", "top" (z).

    Parameters
    ----------
    sizes : (3,) lengths along x, y, z [m]
    size : longest edge of an element [m]
    near : places with smaller elements, see the module
    elements : numbers along x, y, z, in the place of ``size``
    """
    edges = _lengths(sizes)
    return _block(-0.5 * edges, 0.5 * edges, size, near, elements)


def bar(
    length: float,
    height: float,
    width: float,
    size: float | None = None,
    *,
    near: Any = None,
    elements: Sequence[int] | None = None,
) -> Mesh:
    """A slender block along the x axis: 0 <= x <= length, |y| <= height / 2, |z| <= width / 2.

    Faces and other parameters are those of :func:`box`.
    """
    along, up, across = positive("length", length), positive("height", height), positive("width", width)
    low, high = np.array([0.0, -0.5 * up, -0.5 * across]), np.array([along, 0.5 * up, 0.5 * across])
    return _block(low, high, size, near, elements)


def cylinder(radius: float, length: float, size: float, *, near: Any = None) -> Mesh:
    """A cylinder along z about the origin: a core of bent squares, and layers around it.

    Faces "side", "bottom" (z = -length / 2), "top".

    Parameters
    ----------
    radius, length : [m]
    size : longest edge of an element [m]
    near : places with smaller elements, see the module
    """
    return _meshed(Round(RoundMap(2, positive("radius", radius)), positive("length", length), np.eye(2)), size, near)


def tube(inner: float, outer: float, length: float, size: float, *, near: Any = None) -> Mesh:
    """A hollow cylinder along z about the origin.

    Faces "inner", "outer", "bottom" (z = -length / 2), "top".

    Parameters
    ----------
    inner, outer : radii, 0 < inner < outer [m]
    length : [m]
    size : longest edge of an element [m]
    near : places with smaller elements, see the module
    """
    inside = positive("inner", inner)
    outside = positive("outer", in_range("outer", outer, inside, math.inf, open_ends=True))
    return _meshed(Tube(inside, outside, positive("length", length)), size, near)


def ball(radius: float, size: float, *, near: Any = None) -> Mesh:
    """A ball about the origin: a core of bent cubes and layers around it, or shells about a place. Face "surface".

    Parameters
    ----------
    radius : [m]
    size : longest edge of an element [m]
    near : places with smaller elements, see the module
    """
    return _meshed(Round(RoundMap(3, positive("radius", radius)), 0.0, np.eye(3)), size, near)


def _lengths(sizes: npt.ArrayLike) -> FloatArray:
    return np.array([positive(f"sizes[{k}]", edge) for k, edge in enumerate(array_of("sizes", sizes, (3,)).tolist())])


def _block(low: FloatArray, high: FloatArray, size: Any, near: Any, elements: Any) -> Mesh:
    """By the longest edge, or numbers of elements."""
    if (size is None) == (elements is None):
        given = f"{shown(size)} and {shown(elements)}"
        raise ModelError(f"size, elements: {given} were given, expected exactly one of the two")
    shape = Block(low, high)
    if elements is None:
        return _meshed(shape, size, near)
    if near is not None:
        raise ModelError("near: it was given with elements, expected size with it")
    three = sequence_of("elements", elements, "three numbers of elements", 3)
    if len(three) != 3:
        raise ModelError(f"elements: {len(three)} were given, expected three numbers of elements")
    counts = [whole_number(f"elements[{k}]", count, 1) for k, count in enumerate(three)]
    refuse_many(shape.count(counts), "elements")
    return shape.mesh([np.linspace(a, b, n + 1) for a, b, n in zip(low, high, counts, strict=True)])


def _meshed(shape: Shape, size: Any, near: Any) -> Mesh:
    """The mesh, made again with closer lines where its elements came out too long."""
    largest = positive("size", size)
    spots = [_on_surface(shape, spot) for spot in spots_of(near, largest, {*shape.names(), SURFACE})]
    asked, finest = largest, [spot.finest for spot in spots]
    grid = min(_grids(shape, spots, largest), key=lambda grid: _count(grid, _lines(grid, asked, spots, finest)))
    for attempt in range(ROUNDS):
        lines = _lines(grid, asked, spots, finest)
        refuse_many(_count(grid, lines), "near" if spots else "size")
        mesh = grid.mesh(lines)
        edges = mesh.longest_edges()
        excess = [_longest_at(mesh, edges, spot) / spot.finest for spot in spots]
        if max([edges.max() / largest, *excess]) <= 1.0 + EXCESS:
            break
        asked /= _closer(edges.max() / largest, attempt)
        finest = [value / _closer(times, attempt) for value, times in zip(finest, excess, strict=True)]
    named = {spot.name: _face_at(mesh, spot) for spot in spots}
    return replace(mesh, faces={**mesh.faces, **named})


def _grids(shape: Shape, spots: list[Spot], size: float) -> list[Grid]:
    """What the shape can be meshed on."""
    if not spots:
        return [shape]
    return [shape.turned_to(spots[0].place), *(shape.shells(spots[0], size) if len(spots) == 1 else [])]


def _count(grid: Grid, lines: list[FloatArray]) -> int:
    return grid.count([len(line) - 1 for line in lines])


def _closer(times: float, attempt: int) -> float:
    """By how much lines go closer together where elements are so many times too long."""
    return times * (1.0 + MARGIN * 2.0**attempt) if times > 1.0 + EXCESS else 1.0


def _on_surface(shape: Shape, spot: Spot) -> Spot:
    """The spot at the nearest place of the surface, which must be near."""
    there = shape.onto(spot.place)
    off = math.dist(there, spot.place)
    if not off <= spot.finest * (1.0 + EXCESS):
        raise ModelError(
            f"near[{spot.name!r}]: place: {spot.place.tolist()} was given, {off:.4g} m from the surface, expected one "
            f"on it, to the finest size of {spot.finest:g} m"
        )
    return spot._replace(place=there)


def _lines(grid: Grid, size: float, spots: list[Spot], finest: list[float]) -> list[FloatArray]:
    """Of each direction."""
    axes = grid.axes()
    pulls: list[list[Pull]] = [[] for _ in axes]
    for spot, edge in zip(spots, finest, strict=True):
        for axis, at, away, metric in grid.pulled(spot.place):
            within = (spot.radius + spot.finest) * spot.finest / edge  # wider, too, where curves made edges too long
            pulls[axis].append(Pull(at, away, metric, edge, within, math.log(spot.growth)))
    return [
        lines_between(axis.low, axis.high, size / axis.metric, axis.least, of)
        for axis, of in zip(axes, pulls, strict=True)
    ]


def _longest_at(mesh: Mesh, edges: FloatArray, spot: Spot) -> float:
    """The longest edge of the elements with a node within the radius."""
    inside = np.linalg.norm(mesh.places - spot.place, axis=1) <= spot.radius
    return float(edges[inside[mesh.cells].any(axis=1)].max(initial=0.0))


def _face_at(mesh: Mesh, spot: Spot) -> IntArray:
    """The quadrilaterals of the boundary within the radius that hang together with the place."""
    quads = np.concatenate(list(mesh.faces.values()))
    distance = np.linalg.norm(mesh.places - spot.place, axis=1)
    quads = quads[(distance <= spot.radius * (1.0 + EXCESS))[quads].all(axis=1)]
    if not len(quads):
        raise ModelError(
            f"near[{spot.name!r}]: radius: {spot.radius:g} m was given, and no face of an element lies within it, "
            f"expected some {3.0 * spot.finest:.3g} m at least"
        )
    nodes, number = np.unique(quads, return_inverse=True)
    links = np.stack([np.repeat(np.arange(len(quads)), 4), number.ravel()])
    size = len(quads), len(nodes)
    shared = libs.sparse.coo_matrix((np.ones(links.shape[1]), tuple(links)), shape=size).tocsr()
    _, part = libs.csgraph.connected_components(shared @ shared.T, directed=False)
    nearest = quads == nodes[distance[nodes].argmin()]
    return np.asarray(quads[part == part[nearest.any(axis=1).argmax()]])
