"""Meshes of blocks of every kind of solid element."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.fem.assembly import reference_corners
from lcpflex.bodies.fem.mesh import KINDS, Mesh
from lcpflex.jit.kernel import FloatArray
from tests import libs

__all__ = ["EDGES", "QUIET", "SOLIDS", "STEEL", "bent", "meshed_block", "solid"]

STEEL: dict[str, Any] = {"density": 7850.0, "youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
EDGES = (0.3, 0.2, 0.1)
QUIET = pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")  # coarse meshes are too stiff
SOLIDS = ("tetra", "tetra10", "hexahedron", "hexahedron20", "hexahedron27")


def meshed_block(
    kind: str,
    edges: tuple[float, float, float],
    counts: tuple[int, int, int],
    bend: Callable[[FloatArray], FloatArray] | None = None,
) -> Mesh:
    """A block from the origin, of so many hexahedra, or as many blocks of tetrahedra; ``bend`` moves nodes."""
    chosen = KINDS[kind]
    lines = [np.linspace(0.0, edge, n + 1) for edge, n in zip(edges, counts, strict=True)]
    if chosen.simplex:
        flat = libs.skfem.MeshTet1.init_tensor(*lines)
        mesh = libs.skfem.MeshTet2.from_mesh(flat) if chosen.quadratic else flat
        places, cells = np.asarray(mesh.doflocs).T, np.asarray(mesh.dofs.element_dofs.T, dtype=np.int64)
        corners = places[cells[:, :4]]
        mirrored = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0.0
        cells = np.where(mirrored[:, None], cells[:, chosen.turned], cells)
    else:
        step = 2 if chosen.quadratic else 1
        lines = [np.linspace(0.0, edge, step * n + 1) for edge, n in zip(edges, counts, strict=True)]
        places = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
        number = np.arange(len(places)).reshape([len(line) for line in lines])
        corners = reference_corners(chosen)
        offsets = np.rint(step * np.array([corners[list(amid)].mean(axis=0) for amid in chosen.middles])).astype(int)
        whole = [number[tuple((step * np.array(at) + offsets).T)] for at in itertools.product(*map(range, counts))]
        used, cells = np.unique(np.array(whole), return_inverse=True)
        places, cells = places[used], cells.reshape(-1, chosen.nodes)
    return Mesh(chosen, places if bend is None else bend(places), cells)


def solid(kind: str = "tetra10", counts: tuple[int, int, int] = (3, 2, 1), bend: Any = None, **more: Any) -> lf.Solid:
    """A block of steel."""
    return lf.Solid(meshed_block(kind, EDGES, counts, bend), **{**STEEL, **more})


def bent(places: FloatArray) -> FloatArray:
    """A block sheared, twisted and bent."""
    x, y, z = places.T
    return np.column_stack([x + 0.3 * z + 0.4 * y**2, y - 0.2 * x * z, z + 0.5 * x * y])
