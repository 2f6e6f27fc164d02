"""Meshes of solid blocks as matrices, by scikit-fem."""

from __future__ import annotations

from functools import cache
from itertools import product
from typing import Any

import numpy as np

import lcpflex as lf
from tests import libs

__all__ = ["block", "bar", "box_with_surface"]

STEEL = {"density": 7850.0, "youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
ELEMENTS = {
    "hex1": ("MeshHex", "ElementHex1", 4),
    "hex2": ("MeshHex", "ElementHex2", 6),
    "tet1": ("MeshTet", "ElementTetP1", 3),
    "tet2": ("MeshTet", "ElementTetP2", 5),
}


def block(
    edges: tuple[float, float, float],
    cells: tuple[int, int, int],
    kind: str = "hex2",
    *,
    density: float = STEEL["density"],
    youngs_modulus: float = STEEL["youngs_modulus"],
    poissons_ratio: float = STEEL["poissons_ratio"],
    skew: float = 0.0,
) -> dict[str, Any]:
    """Mass, stiffness and coordinates of a block from the origin to its edges, x sheared by ``skew`` z."""
    skfem, h = libs.skfem, libs.skfem_helpers
    mesh_type, element, order = ELEMENTS[kind]
    lines = [np.linspace(0.0, edge, n + 1) for edge, n in zip(edges, cells, strict=True)]
    mesh = getattr(skfem, mesh_type).init_tensor(*lines)
    if skew:
        mesh = mesh.translated((0.0, 0.0, 0.0))
        mesh = type(mesh)(mesh.p + np.outer([skew, 0.0, 0.0], mesh.p[2]), mesh.t)
    basis = skfem.Basis(mesh, skfem.ElementVector(getattr(skfem, element)()), intorder=order)
    lam, mu = libs.elasticity.lame_parameters(youngs_modulus, poissons_ratio)

    @skfem.BilinearForm
    def stiffness(u, v, _):
        e, d = h.sym_grad(u), h.sym_grad(v)
        return 2.0 * mu * h.ddot(e, d) + lam * h.trace(e) * h.trace(d)

    @skfem.BilinearForm
    def mass(u, v, _):
        return density * h.dot(u, v)

    # degrees of freedom of one place, x y z after each other
    order_of = np.lexsort((np.arange(basis.N), *np.round(basis.doflocs / max(edges), 9)))
    M, K = (form.assemble(basis).tocsr()[order_of][:, order_of] for form in (mass, stiffness))
    places = basis.doflocs.T[order_of]
    return {"mass": M, "stiffness": K, "coordinates": places[0::3]}


def bar(cells: tuple[int, int, int], kind: str = "hex2") -> dict[str, Any]:
    """The steel bar 0.2 x 0.02 x 0.02 along x, its origin at the middle of its end face."""
    made = block((0.2, 0.02, 0.02), cells, kind)
    return made | {"coordinates": made["coordinates"] - [0.0, 0.01, 0.01]}


@cache
def box_with_surface(
    edges: tuple[float, float, float], cells: tuple[int, int, int], modes: int, damping: float, **material: float
) -> lf.SpatialBody:
    """A block of linear elements about the origin, its mesh as its surface, two facets a cell, reduced to ``modes``."""
    made = block(edges, cells, "hex1", **material)
    places = made["coordinates"] - 0.5 * np.array(edges)
    grid = np.round((places / edges + 0.5) * cells).astype(int)
    node = {tuple(at): k for k, at in enumerate(grid.tolist())}
    triangles = []
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        for side, i, j in product((0, 1), range(cells[first]), range(cells[second])):
            at = np.zeros((4, 3), int)
            at[:, axis] = side * cells[axis]
            at[:, first] = [i, i + 1, i + 1, i]
            at[:, second] = [j, j, j + 1, j + 1]
            a, b, c, d = (node[tuple(corner)] for corner in at.tolist())
            triangles += [(a, b, c), (a, c, d)] if side else [(a, c, b), (a, d, c)]
    given = made | {"coordinates": places}
    return lf.SpatialMatrices(**given, triangles=np.array(triangles)).reduce(modes=modes, damping=damping)
