"""What nodes may touch, in blocks of few that share a bounding circle: most blocks are far, and cost one look."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from lcpflex.contact.narrow_phase.feature import SEGMENT, VERTEX
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.model.arrays import Model, frozen

__all__ = ["Feature", "blocks_of", "near_block"]

ASIDE = 1.75  # more than tan 60 degrees
BLOCK = 8  # features that share a bounding circle


@dataclass(slots=True)
class Feature:
    """A segment or an arc of a surface, in the frame of its body."""

    kind: int
    points: tuple[int, int]
    circle: tuple[float, float, float]  # about it; of a hole, about what is behind its wall, too
    normal: tuple[float, float] = (0.0, 0.0)  # of a segment of a chain
    radius: float = 0.0
    sense: float = 1.0
    reach: tuple[float, float, float] = (math.inf, math.inf, math.inf)
    span: tuple[float, float] = (0.0, 1.0)
    neighbour: tuple[int, int] = (-1, -1)


def blocks_of(
    features: Sequence[Feature], feature_start: Sequence[int]
) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """Successive features of a surface, few and of one kind; circles about each such block, and how high it is."""
    surface_block, block_start, circles, heights = [0], [0], [], []
    for first, last in pairwise(feature_start):
        vertices = [k for k in range(first, last) if features[k].kind == VERTEX]
        middle = vertices[0] if vertices else last
        for start, end in ((first, middle), (middle, last)):
            for k in range(start, end, BLOCK):
                block = features[k : min(k + BLOCK, end)]
                circle = np.array([f.circle for f in block])
                center = 0.5 * (circle[:, :2].min(axis=0) + circle[:, :2].max(axis=0))
                extent = np.hypot(*(circle[:, :2] - center).T) + circle[:, 2]
                deep = extent + [max(f.reach) if f.kind == SEGMENT else 0.0 for f in block]
                circles.append((*center, float(extent.max()), float(deep.max())))
                heights.append(_height(block))
                block_start.append(k + len(block))
        surface_block.append(len(block_start) - 1)
    return (
        frozen(surface_block, np.int64),
        frozen(block_start, np.int64),
        frozen(circles, columns=4),
        frozen(heights, columns=3),
    )


def _height(block: Sequence[Feature]) -> tuple[float, float, float]:
    """Mean normal n of segments that look about the same way, and the greatest n.x of their points; else 0, 0, 0."""
    normals = np.array([f.normal for f in block])
    mean = normals.sum(axis=0)
    length = math.hypot(*mean)
    if length == 0.0 or (normals @ mean).min() < 0.5 * length:
        return 0.0, 0.0, 0.0
    n = mean / length
    top = max(float(n @ f.circle[:2]) + f.circle[2] * abs(n[0] * f.normal[1] - n[1] * f.normal[0]) for f in block)
    return float(n[0]), float(n[1]), top


@kernel
def near_block(model: Model, block: int, x: float, y: float, reach: float) -> bool:
    """Whether a node at (x, y), in the frame of the features, may be within ``reach`` of a block of them, or below it.

    Normals of a block with a height deviate from their mean n by less than 60 degrees, so that what is h lower than
    its top is farther aside than its points by no more than h tan 60 degrees.
    """
    circle = model.contacts.block_circle
    height = model.contacts.block_height
    dx = x - circle[block, 0]
    dy = y - circle[block, 1]
    d2 = dx * dx + dy * dy
    if d2 <= (reach + circle[block, 2]) ** 2:
        return True
    if d2 > (reach + circle[block, 3]) ** 2:
        return False
    nx = height[block, 0]
    ny = height[block, 1]
    if nx == 0.0 and ny == 0.0:
        return True
    low = height[block, 2] + reach - nx * x - ny * y
    return low >= 0.0 and abs(nx * dy - ny * dx) <= circle[block, 2] + reach + ASIDE * low
