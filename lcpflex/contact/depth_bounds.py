"""How deep below a surface a node still belongs to it, from undeformed shapes.

Which way out of a solid is the nearest is decided when contacts are detected, among the segments of one surface. That
needs a bound for what one surface alone cannot tell: that the body has another side, which belongs to no surface or to
another one.
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.jit.kernel import FloatArray

__all__ = ["below_chain", "below_hole", "is_solid"]

SAMPLES = (1e-6, 0.5, 1.0 - 1e-6)  # places on a segment from where the way through the solid is measured
SLACK = 1.01  # on exact bounds, so that nothing is lost half-way between two sides
ROWS = 256  # segments treated at once: memory grows with the square of their number


def below_chain(places: FloatArray, closed: bool, outline: FloatArray | None) -> FloatArray:
    """(segments, 3) reach [m] below the beginning, middle and end of each segment; between them it is linear.

    A node in a closed solid is no deeper than the radius of its largest inscribed circle, which is at most half the
    least width. An open chain, or one around a hole, reaches half the way through the solid to the other side of
    ``outline`` (k, 2), the closed outline of its body, or of the chain itself; and never farther than the chain is
    large: the radius of its bounding box.
    """
    ends = np.roll(places, -1, axis=0) if closed else places[1:]
    starts = places[: len(ends)]
    steps = ends - starts
    inward = np.stack([-steps[:, 1], steps[:, 0]], axis=1) / np.hypot(*steps.T)[:, None]
    size = 0.5 * float(np.hypot(*np.ptp(places, axis=0)))
    if is_solid(places, closed):
        return np.full((len(steps), 3), min(size, SLACK * _half_width(places, inward)))
    walls, along = starts, steps
    if outline is not None:
        walls = np.vstack([walls, outline])
        along = np.vstack([along, np.roll(outline, -1, axis=0) - outline])
    reach = np.empty((len(steps), 3))
    for column, sample in enumerate(SAMPLES):
        for first in range(0, len(steps), ROWS):
            rows = slice(first, first + ROWS)
            foot = starts[rows] + sample * steps[rows]
            reach[rows, column] = 0.5 * _way(foot, inward[rows], walls, along, 1e-9 * size)
    return np.minimum(reach, size)


def below_hole(center: FloatArray, radius: float, outline: FloatArray | None) -> float:
    """Half the thickness of the wall between a circular hole and the outline of its body [m], at most the radius."""
    if outline is None:
        return radius
    step = np.roll(outline, -1, axis=0) - outline
    apart = center - outline
    s = np.clip((apart * step).sum(axis=1) / np.maximum((step * step).sum(axis=1), 1e-300), 0.0, 1.0)
    wall = float(np.hypot(*(apart - s[:, None] * step).T).min()) - radius
    return min(radius, 0.5 * wall) if wall > 0.0 else radius


def is_solid(places: FloatArray, closed: bool) -> bool:
    """Whether a chain runs once around a solid, counter-clockwise."""
    ends = np.roll(places, -1, axis=0)
    return closed and float((places[:, 0] * ends[:, 1] - places[:, 1] * ends[:, 0]).sum()) > 0.0


def _half_width(places: FloatArray, normals: FloatArray) -> float:
    """Half the least width of the convex hull, among those in the directions of ``normals``."""
    widths = (float(np.ptp(normals[k : k + ROWS] @ places.T, axis=1).min()) for k in range(0, len(normals), ROWS))
    return 0.5 * min(widths)


def _way(foot: FloatArray, inward: FloatArray, walls: FloatArray, along: FloatArray, least: float) -> FloatArray:
    """(k,) how far it is from each foot (k, 2) in the direction inward to the first wall beyond ``least``, or inf."""
    apart = walls[None, :, :] - foot[:, None, :]
    cross = inward[:, None, 0] * along[None, :, 1] - inward[:, None, 1] * along[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        way = (apart[..., 0] * along[None, :, 1] - apart[..., 1] * along[None, :, 0]) / cross
        place = (apart[..., 0] * inward[:, None, 1] - apart[..., 1] * inward[:, None, 0]) / cross
        hit = (way > least) & (place >= -1e-9) & (place <= 1.0 + 1e-9)
    return np.asarray(np.where(hit, way, math.inf).min(axis=1))
