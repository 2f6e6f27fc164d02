"""Pictures of triangles and lines by a depth buffer: at each pixel what is nearest to the viewer, bodies that cut into
each other included.

Places are (column, row, depth) in pixels, rows from below, the depth growing towards the viewer in any unit. A canvas
is ``FINER`` times as fine as the picture that is made of it, so that its edges are smooth.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from lcpflex.jit.kernel import FloatArray, IntArray, kernel

__all__ = ["FINER", "NOBODY", "Canvas", "blank", "fill_shadow", "fill_strokes", "fill_triangles", "resolved"]

FINER = 2
NOBODY = -1
INK = 0.3  # share of the light that is left along outlines
Depths = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]


class Canvas(NamedTuple):
    """What is nearest at each pixel."""

    depth: Depths  # (rows, columns) -inf where there is nothing
    colour: Bytes  # (rows, columns, 3)
    owner: npt.NDArray[np.int32]  # (rows, columns) body, or NOBODY


def blank(rows: int, columns: int) -> Canvas:
    """An empty canvas for a picture of so many pixels."""
    shape = FINER * rows, FINER * columns
    return Canvas(
        np.full(shape, -np.inf, np.float32), np.zeros((*shape, 3), np.uint8), np.full(shape, NOBODY, np.int32)
    )


@kernel
def fill_triangles(
    places: FloatArray,
    light: FloatArray,
    tint: FloatArray,
    owners: IntArray,
    depth: Depths,
    colour: Bytes,
    owner: npt.NDArray[np.int32],
) -> None:
    """Triangles (T, 3, 3) with the light (T, 3) at their corners from 0 to 1, tints (T, 3) in bytes, owners (T,)."""
    rows, columns = depth.shape
    for t in range(len(places)):
        ax, ay, az = places[t, 0, 0], places[t, 0, 1], places[t, 0, 2]
        bx, by, bz = places[t, 1, 0] - ax, places[t, 1, 1] - ay, places[t, 1, 2] - az
        cx, cy, cz = places[t, 2, 0] - ax, places[t, 2, 1] - ay, places[t, 2, 2] - az
        area = bx * cy - cx * by
        if abs(area) < 1e-12:
            continue
        left = max(0, math.ceil(ax + min(0.0, bx, cx) - 0.5))
        right = min(columns - 1, math.floor(ax + max(0.0, bx, cx) - 0.5))
        low = max(0, math.ceil(ay + min(0.0, by, cy) - 0.5))
        high = min(rows - 1, math.floor(ay + max(0.0, by, cy) - 0.5))
        for i in range(low, high + 1):
            y = i + 0.5 - ay
            for j in range(left, right + 1):
                x = j + 0.5 - ax
                b = (x * cy - cx * y) / area
                c = (bx * y - x * by) / area
                if b < 0.0 or c < 0.0 or b + c > 1.0:
                    continue
                z = az + b * bz + c * cz
                if z <= depth[i, j]:
                    continue
                shade = light[t, 0] + b * (light[t, 1] - light[t, 0]) + c * (light[t, 2] - light[t, 0])
                depth[i, j] = z
                owner[i, j] = owners[t]
                for k in range(3):
                    colour[i, j, k] = int(shade * tint[t, k])


@kernel
def fill_strokes(
    ends: FloatArray,
    radius: FloatArray,
    tint: FloatArray,
    owners: IntArray,
    lift: float,
    behind: float,
    depth: Depths,
    colour: Bytes,
    owner: npt.NDArray[np.int32],
) -> None:
    """Lines (k, 2, 3) with round ends, so many pixels from their middle to their border, tints (k, 3), owners (k,).

    lift: how much nearer they are taken to be, so that lines of a surface lie on it. behind: share of the tint with
    which they shine through what hides them. The owner of a pixel stays where there is one: lines have no outlines.
    """
    rows, columns = depth.shape
    for s in range(len(ends)):
        ax, ay, az = ends[s, 0, 0], ends[s, 0, 1], ends[s, 0, 2]
        ex, ey, ez = ends[s, 1, 0] - ax, ends[s, 1, 1] - ay, ends[s, 1, 2] - az
        length = ex * ex + ey * ey
        r = radius[s]
        left = max(0, math.ceil(ax + min(0.0, ex) - r - 0.5))
        right = min(columns - 1, math.floor(ax + max(0.0, ex) + r - 0.5))
        low = max(0, math.ceil(ay + min(0.0, ey) - r - 0.5))
        high = min(rows - 1, math.floor(ay + max(0.0, ey) + r - 0.5))
        for i in range(low, high + 1):
            for j in range(left, right + 1):
                x, y = j + 0.5 - ax, i + 0.5 - ay
                share = 0.5
                if length > 0.0:
                    share = min(1.0, max(0.0, (x * ex + y * ey) / length))
                if (x - share * ex) ** 2 + (y - share * ey) ** 2 > r * r:
                    continue
                z = az + share * ez + lift
                if z >= depth[i, j]:
                    depth[i, j] = z
                    if owner[i, j] == NOBODY:
                        owner[i, j] = owners[s]
                    for k in range(3):
                        colour[i, j, k] = int(tint[s, k])
                elif behind > 0.0:
                    for k in range(3):
                        colour[i, j, k] = int(behind * tint[s, k] + (1.0 - behind) * colour[i, j, k])


@kernel
def fill_shadow(places: FloatArray, shadow: Depths) -> None:
    """Put 1 where one of the triangles (T, 3, 2) is."""
    rows, columns = shadow.shape
    for t in range(len(places)):
        ax, ay = places[t, 0, 0], places[t, 0, 1]
        bx, by = places[t, 1, 0] - ax, places[t, 1, 1] - ay
        cx, cy = places[t, 2, 0] - ax, places[t, 2, 1] - ay
        area = bx * cy - cx * by
        if abs(area) < 1e-12:
            continue
        left = max(0, math.ceil(ax + min(0.0, bx, cx) - 0.5))
        right = min(columns - 1, math.floor(ax + max(0.0, bx, cx) - 0.5))
        low = max(0, math.ceil(ay + min(0.0, by, cy) - 0.5))
        high = min(rows - 1, math.floor(ay + max(0.0, by, cy) - 0.5))
        for i in range(low, high + 1):
            y = i + 0.5 - ay
            for j in range(left, right + 1):
                x = j + 0.5 - ax
                b = (x * cy - cx * y) / area
                c = (bx * y - x * by) / area
                if b >= 0.0 and c >= 0.0 and b + c <= 1.0:
                    shadow[i, j] = 1.0


@kernel
def resolved(
    depth: Depths,
    colour: Bytes,
    owner: npt.NDArray[np.int32],
    step: float,
    reach: int,
    shadow: Depths,
    picture: Bytes,
) -> None:
    """The picture (rows, columns, 4) of a canvas, with outlines of bodies, over a black shadow (rows, columns), 0 to 1.

    step: how much farther what lies beside an outline is at least, if it belongs to the same body. reach: pixels of the
    canvas that an outline is wide.
    """
    rows, columns = depth.shape
    for i in range(len(picture)):
        for j in range(picture.shape[1]):
            red, green, blue, covered = 0.0, 0.0, 0.0, 0.0
            for m in range(FINER * i, FINER * (i + 1)):
                for n in range(FINER * j, FINER * (j + 1)):
                    here = owner[m, n]
                    if here == NOBODY:
                        continue
                    light = 1.0
                    for side in range(4):
                        y = m + (reach if side == 0 else -reach if side == 1 else 0)
                        x = n + (reach if side == 2 else -reach if side == 3 else 0)
                        if y < 0 or x < 0 or y >= rows or x >= columns:
                            continue
                        drop = depth[m, n] - depth[y, x]
                        if (owner[y, x] != here and drop > 0.0) or drop > step:
                            light = INK
                    red += light * colour[m, n, 0]
                    green += light * colour[m, n, 1]
                    blue += light * colour[m, n, 2]
                    covered += 1.0
            solid = covered / FINER**2
            alpha = solid + (1.0 - solid) * shadow[i, j]
            if alpha <= 0.0:
                picture[i, j, 3] = 0
                continue
            share = 1.0 / (FINER**2 * alpha)
            picture[i, j, 0] = int(red * share + 0.5)
            picture[i, j, 1] = int(green * share + 0.5)
            picture[i, j, 2] = int(blue * share + 0.5)
            picture[i, j, 3] = int(255.0 * alpha + 0.5)
