"""Meshes of simple shapes, as scikit-fem meshes with named boundaries.

Places are in metres. A mesh is moved with ``mesh.translated((dx, dy))``, refined with ``mesh.refined()``, and given
quadratic elements with :func:`quadratic`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lcpflex.bodies.body import whole_number
from lcpflex.compiled import FloatArray
from lcpflex.errors import ModelError, in_range

__all__ = ["bar", "quadratic", "rectangle"]


def rectangle(length: float, height: float, nx: int, ny: int, *, triangles: bool = False) -> Any:
    """Equal elements on 0 <= x <= length, 0 <= y <= height; boundaries "left", "right", "bottom", "top".

    Parameters
    ----------
    length, height : [m]
    nx, ny : numbers of elements along x and y
    triangles : two triangles in the place of each quadrilateral

    Raises
    ------
    ModelError
        For sizes that are not positive or numbers below 1.
    """
    size = [
        in_range(name, value, 0.0, math.inf, open_ends=True)
        for name, value in zip(("length", "height"), (length, height), strict=True)
    ]
    n = [whole_number(name, value, 1) for name, value in zip(("nx", "ny"), (nx, ny), strict=True)]
    return _grid(np.linspace(0.0, size[0], n[0] + 1), np.linspace(0.0, size[1], n[1] + 1), triangles)


def _grid(x: FloatArray, y: FloatArray, triangles: bool) -> Any:
    """The mesh of all pairs of the coordinates, with its four sides named."""
    import skfem

    mesh = (skfem.MeshTri1 if triangles else skfem.MeshQuad1).init_tensor(x, y)
    sides = {
        "left": lambda at: at[0] == x[0],
        "right": lambda at: at[0] == x[-1],
        "bottom": lambda at: at[1] == y[0],
        "top": lambda at: at[1] == y[-1],
    }
    return mesh.with_boundaries(sides)


def bar(length: float, height: float, elements: int, *, across: int = 1, triangles: bool = False) -> Any:
    """A slender rectangle 0 <= x <= length about the x axis, |y| <= height / 2: ``elements`` by ``across`` elements.

    Boundaries "left", "right", "bottom", "top". Raises :class:`ModelError` as :func:`rectangle` does.
    """
    return rectangle(length, height, elements, across, triangles=triangles).translated((0.0, -0.5 * float(height)))


def quadratic(mesh: Any) -> Any:
    """The mesh with quadratic elements: nodes amid straight edges, and amid quadrilaterals; names are kept.

    Raises :class:`ModelError` for anything but a MeshTri1 or MeshQuad1 of scikit-fem.
    """
    import skfem

    kinds = {"MeshTri1": "MeshTri2", "MeshQuad1": "MeshQuad2"}
    name = type(mesh).__name__
    if name not in kinds:
        raise ModelError(f"mesh: {name} was given, expected a MeshTri1 or MeshQuad1 of scikit-fem")
    raised = getattr(skfem, kinds[name]).from_mesh(mesh)
    if mesh.boundaries:
        raised = raised.with_boundaries({key: np.asarray(facets) for key, facets in mesh.boundaries.items()})
    return raised.with_subdomains(dict(mesh.subdomains)) if mesh.subdomains else raised
