"""Refinement of triangles towards a zone, with the adaptive splitting of scikit-fem."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray

__all__ = ["Zone", "named_again", "refined_to"]

ELEMENTS = 1_000_000  # beyond it neither memory nor patience would do
ROUNDS = 100


@dataclass(frozen=True, slots=True, eq=False)
class Zone:
    """Longest edges allowed: min(size, finest + growth (distance - within)), and not below finest.

    Attributes
    ----------
    line : (1, 2) a place or (2, 2) two ends of a line [m]
    finest, size, within : [m]
    growth : [-]
    """

    line: FloatArray
    finest: float
    size: float
    within: float
    growth: float

    def allowed(self, places: FloatArray) -> FloatArray:
        """(k,) longest edges at the places (k, 2) [m]."""
        start, along = self.line[0], self.line[-1] - self.line[0]
        square = float(along @ along)
        share = np.clip((places - start) @ along / square, 0.0, 1.0) if square > 0.0 else np.zeros(len(places))
        distance = np.hypot(*(places - start - share[:, None] * along).T)
        return np.asarray(np.minimum(self.size, self.finest + self.growth * np.maximum(distance - self.within, 0.0)))


def refined_to(mesh: Any, zone: Zone, shaped: Callable[[Any], Any] | None) -> Any:
    """The triangles, split until no edge is longer than the zone allows; ``shaped`` puts new nodes where they belong.

    Raises
    ------
    ModelError
        If more than a million elements were needed.
    """
    mesh = libs.skfem.MeshTri1(mesh.p, mesh.t)  # without names: scikit-fem cannot keep them, and says so
    for _ in range(ROUNDS):
        corners = mesh.p.T[mesh.t.T]
        arms = np.roll(corners, -1, axis=1) - corners
        longest = np.hypot(arms[..., 0], arms[..., 1]).max(axis=1)
        places = np.concatenate([corners, corners.mean(axis=1, keepdims=True)], axis=1)
        allowed = zone.allowed(places.reshape(-1, 2)).reshape(-1, 4).min(axis=1)
        marked = np.flatnonzero(longest > allowed * (1.0 + 1e-9))
        if not len(marked):
            return mesh
        if len(longest) + len(marked) > ELEMENTS:
            break
        mesh = mesh.refined(marked)
        if shaped is not None:
            mesh = shaped(mesh)
    raise ModelError(f"finest: {shown(zone.finest)} m was given, expected a mesh of less than {ELEMENTS} elements")


def named_again(fine: Any, coarse: Any) -> Any:
    """The refined mesh with the boundaries of the coarse one: edges that lie on its edges."""
    if not coarse.boundaries:
        return fine
    edges = fine.boundary_facets()
    middles = 0.5 * (fine.p[:, fine.facets[0, edges]] + fine.p[:, fine.facets[1, edges]]).T
    slack = 1e-9 * float(np.ptp(coarse.p, axis=1).max())
    names = {}
    for name, facets in coarse.boundaries.items():
        on = np.zeros(len(edges), dtype=np.bool_)
        for a, b in coarse.p.T[coarse.facets[:, np.asarray(facets)].T]:
            along = b - a
            share = np.clip((middles - a) @ along / (along @ along), 0.0, 1.0)
            on |= np.hypot(*(middles - a - share[:, None] * along).T) <= slack
        names[name] = edges[on]
    return fine.with_boundaries(names)
