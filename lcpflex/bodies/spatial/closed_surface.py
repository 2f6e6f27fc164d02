"""Whether triangles are the whole boundary of a solid, seen from outside."""

from __future__ import annotations

import numpy as np

from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["check_closed"]

FLAT = 1e-12  # of the squared extent: twice the area of a triangle that has no normal


def check_closed(name: str, vertices: FloatArray, triangles: IntArray) -> None:
    """Raise ModelError for triangles (T, 3) of vertices (N, 3) that no solid lies behind.

    Each must have an area, each edge belong to two of them that pass it opposite ways, and the volume that they
    enclose, sum of det(a, b, c) / 6, be positive: counter-clockwise seen from outside.
    """
    corners = vertices[triangles]
    extent = float(np.ptp(vertices[triangles.ravel()], axis=0).max())
    double = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    flat = np.flatnonzero(~(double > FLAT * extent**2))
    if len(flat):
        raise ModelError(
            f"{name}: triangle {flat[0]} of vertices {triangles[flat[0]].tolist()} has twice the area "
            f"{double[flat[0]]:.3g} m^2, expected one with a normal"
        )
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    size = int(triangles.max()) + 1
    there, back = edges @ np.array([size, 1]), edges @ np.array([1, size])
    found, count = np.unique(there, return_counts=True)
    if (count > 1).any():
        twice = divmod(int(found[count > 1][0]), size)
        raise ModelError(
            f"{name}: two triangles pass the edge {twice} in the same direction, expected opposite ones: all "
            "counter-clockwise seen from outside"
        )
    lonely = np.flatnonzero(~np.isin(back, there))
    if len(lonely):
        raise ModelError(
            f"{name}: only one triangle has the edge {tuple(edges[lonely[0]].tolist())}, expected a closed surface"
        )
    middle = vertices[triangles.ravel()].mean(axis=0)
    volume = float(np.linalg.det(corners - middle).sum()) / 6.0
    if not volume > 0.0:
        raise ModelError(
            f"{name}: its triangles enclose {volume:.3g} m^3, expected a positive volume: counter-clockwise seen from "
            "outside, in a right-handed frame"
        )
