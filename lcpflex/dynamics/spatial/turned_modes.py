"""Spatial bodies in other modal coordinates: see :mod:`lcpflex.dynamics.turned_modes`."""

from __future__ import annotations

import numpy as np

from lcpflex.dynamics.spatial.static_modes import square_products, with_products
from lcpflex.dynamics.turned_modes import turn_squares
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import changed
from lcpflex.model.spatial import N_RIGID, SpatialBodies

__all__ = ["reach_of", "shifted", "turned_bodies"]


def shifted(
    bodies: SpatialBodies, phi: FloatArray, psi: FloatArray, shift: FloatArray, place: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """phi and psi (n, 3) of a point at ``place``, with the frame's own motions ``shift`` (6, n)."""
    return phi + shift[:3].T + np.cross(shift[3:].T, place), psi + shift[3:].T


def reach_of(bodies: SpatialBodies, shift: FloatArray, places: FloatArray) -> FloatArray:
    """(n,) how far these motions ``shift`` (6, n) move a point at one of ``places`` (points, 3), at most."""
    radius = np.linalg.norm(places, axis=1).max()
    return np.asarray(np.linalg.norm(shift[:3], axis=0) + np.linalg.norm(shift[3:], axis=0) * radius)


def turned_bodies(bodies: SpatialBodies, stiffness: FloatArray, turn: list[FloatArray | None]) -> SpatialBodies:
    """The bodies in the modal coordinates of ``turn``, (n, n) of each, with their ``stiffness`` there."""
    flat = {name: getattr(bodies, name).copy() for name in ("S", "first", "damping", "cross_damping", "geometric")}
    products = []
    for b, T in enumerate(turn):
        P = square_products(bodies, b)
        if T is not None:
            own = slice(int(bodies.dof[b]) - N_RIGID * b, int(bodies.dof[b + 1]) - N_RIGID * (b + 1))
            for name in ("S", "first"):
                flat[name][own] = T.T @ flat[name][own]
            turn_squares(bodies, b, T, own, flat, ("cross_damping",))
            P = np.einsum("al,bk,abi->lki", T, T, P, optimize=True)
            start, end = bodies.geometric_start[b : b + 2] if len(bodies.geometric) else (0, 0)
            if end > start:
                G = flat["geometric"][start:end].reshape(*T.shape, -1)
                flat["geometric"][start:end] = np.einsum("al,bk,abi->lki", T, T, G, optimize=True).ravel()
        products.append(P)
    return changed(SpatialBodies, with_products(bodies, products), stiffness=stiffness, **flat)
