"""Areas that contact forces act on, as cells in the colours of their pressures."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lcpflex.basics import libs
from lcpflex.errors import ModelError
from lcpflex.results.spatial.surfaces import cut
from lcpflex.results.words import prefix_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.contact_history import ContactPoints
    from lcpflex.results.result import Result

__all__ = ["Colours", "PressedAreas", "cells_of", "colours_of", "draw_bar", "draw_cells"]

WIDE = 1.6  # farthest corner of a cell over the root of its area: of a node in a corner of squares 1.41
SIDES = 24  # of a cell without neighbours
SAME = 1e-6  # of that root: two places that are one
LARGER, HALVED = 0.3, 10  # share of its area that a cell may be too large; steps of the search for its radius if it is
FLAT = 0.9  # cosine of the largest angle of a normal to the mean one
COLOURS = "viridis"
EDGE = "#202020"


class Colours(NamedTuple):
    """Pressures from ``least`` to ``largest`` [Pa], in the unit ``factor`` Pa, which has that prefix."""

    least: float
    largest: float
    factor: float
    prefix: str


def colours_of(pressures: FloatArray) -> Colours:
    """From 0, or the largest pull, to the largest pressure."""
    least, largest = float(pressures.min(initial=0.0)), float(pressures.max(initial=0.0))
    return Colours(least, largest, *prefix_of(max(largest, -least)))


class PressedAreas:
    """Cells and pressures of the touching points that have an area; one range of colours for all ``records``."""

    def __init__(self, result: Result, records: IntArray) -> None:
        every = result.contact_points
        if not (every.area > 0.0).any():
            raise ModelError(
                "pressure: True was given, expected False where no force of the run acts on an area; see "
                'scene.contact(..., points="areas")'
            )
        self._points = every.take(np.flatnonzero((every.area > 0.0) & np.isin(every.record, records)))
        self.colours = colours_of(_pressures(self._points))

    def at(self, record: int) -> tuple[list[FloatArray], FloatArray]:
        """Polygons (n, 3) [m] and their pressures (k,) [Pa] at a stored instant: each contact has cells of its own."""
        points = self._points.at(record)
        cells: list[FloatArray] = []
        order = np.argsort(points.contact, kind="stable")
        for own in np.split(order, np.flatnonzero(np.diff(points.contact[order])) + 1):
            cells += cells_of(points.place[own], points.normal[own], points.area[own])
        return cells, _pressures(points)[order]


def _pressures(points: ContactPoints) -> FloatArray:
    return np.asarray(points.force[:, 0] / points.area)


def cells_of(places: FloatArray, normals: FloatArray, areas: FloatArray) -> list[FloatArray]:
    """(k,) polygons (n, 3), each in the plane across its normal: what is nearer to its place than to any other one.

    They end where the outline of the patch does; beside what is open, a cell ends where it is as large as its area.
    """
    if not len(places):
        return []
    reach = WIDE * np.sqrt(areas)
    near = libs.cKDTree(places).query_ball_point(places, reach + reach.max())
    rim = _outline(places, normals, areas)
    found = []
    for place, normal, area, others in zip(places, normals, areas, near, strict=True):
        ways = places[others] - place
        square = np.sum(ways**2, axis=1)
        order = np.argsort(square, kind="stable")  # behind the nearest ones, others have nothing to cut
        order = order[square[order] > SAME**2 * area]
        own = np.column_stack([ways[order], 0.5 * square[order]])
        sides = np.concatenate([own, np.column_stack([rim[:, :3], rim[:, 3] - rim[:, :3] @ place])])
        found.append(place + _cell(normal, float(area), sides))
    return found


def _cell(normal: FloatArray, area: float, sides: FloatArray) -> FloatArray:
    """(n, 3) about 0 across ``normal``, within x . s <= c of all sides (s, c) (k, 4), not larger than ``area``."""
    across = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    first = across / np.linalg.norm(across)
    angles = 2.0 * np.pi * (np.arange(SIDES) + 0.5) / SIDES
    circle = np.outer(np.cos(angles), first) + np.outer(np.sin(angles), np.cross(normal, first))
    low, high = 0.0, WIDE * area**0.5
    cell = _within(high * circle, sides)
    if _size(cell, normal) <= (1.0 + LARGER) * area:
        return cell
    for _ in range(HALVED):
        radius = 0.5 * (low + high)
        cell = _within(radius * circle, sides)
        low, high = (radius, high) if _size(cell, normal) < area else (low, radius)
    return cell


def _within(polygon: FloatArray, sides: FloatArray) -> FloatArray:
    for side in sides:
        height = side[3] - polygon @ side[:3]
        if height.min() < 0.0:
            polygon = cut(polygon, height)
            if len(polygon) < 3:
                return np.zeros((0, 3))
    return polygon


def _size(polygon: FloatArray, normal: FloatArray) -> float:
    """Area of a plane polygon about ``normal``."""
    return 0.5 * float(np.cross(polygon, np.roll(polygon, -1, axis=0)).sum(axis=0) @ normal)


def _outline(places: FloatArray, normals: FloatArray, areas: FloatArray) -> FloatArray:
    """(k, 4) sides x . s <= c of a flat patch: the convex hull of its places, widened until it holds all areas.

    Nodes at the rim of a face are on its outline, middles of areas within it. None of a patch that is not flat, and of
    one with places on a line, whose areas tell where they end.
    """
    mean = normals.sum(axis=0)
    size = float(np.linalg.norm(mean))
    if len(places) < 3 or float((normals @ mean).min()) < FLAT * size:
        return np.zeros((0, 4))
    mean /= size
    right = np.cross(mean, np.eye(3)[int(np.argmin(np.abs(mean)))])
    plane = np.stack([right, np.cross(mean, right)]) / np.linalg.norm(right)
    middle = places.mean(axis=0)
    at = (places - middle) @ plane.T
    try:
        hull = libs.ConvexHull(at / np.sqrt(areas.sum()))
    except libs.QhullError:
        return np.zeros((0, 4))
    around, missing = float(hull.area), max(1.0 - float(hull.volume), 0.0)  # of a plane hull, its length and area
    wider = 2.0 * missing / (around + np.sqrt(around**2 + 4.0 * np.pi * missing))
    outward = hull.equations[:, :2] @ plane
    return np.column_stack([outward, outward @ middle + (wider - hull.equations[:, 2]) * np.sqrt(areas.sum())])


def draw_cells(
    ax: Axes, cells: Sequence[FloatArray], pressures: FloatArray, colours: Colours, front: float = 1.0
) -> None:
    """Polygons (n, 2) in the axes, at the height ``front``."""
    drawn = libs.PolyCollection(
        cells, array=pressures / colours.factor, cmap=COLOURS, edgecolors=EDGE, linewidths=0.15, zorder=front
    )
    drawn.set_clim(colours.least / colours.factor, colours.largest / colours.factor)
    ax.add_collection(drawn, autolim=False)


def draw_bar(ax: Axes, colours: Colours, shrink: float = 1.0) -> None:
    """The scale of the colours beside the axes, ``shrink`` of their height; none where nothing presses or pulls."""
    if colours.largest == colours.least:
        return
    scale = libs.ScalarMappable(cmap=COLOURS)
    scale.set_clim(colours.least / colours.factor, colours.largest / colours.factor)
    figure = ax.get_figure()
    assert figure is not None
    figure.colorbar(scale, ax=ax, shrink=shrink, label=f"pressure [{colours.prefix}Pa]")
