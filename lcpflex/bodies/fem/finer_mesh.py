"""The next finer mesh of the same body: quadratic elements for linear ones, four for each quadratic one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lcpflex.bodies.fem.assembly import shape_functions
from lcpflex.bodies.fem.planar_mesh import KINDS, PlanarMesh
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["finer"]

# Places (s, t) of the reference element in quarters, of a quadratic element that is split in four: the corners and the
# nodes amid edges and element of each part, in the order of PlanarMesh.
TRIANGLE = ((0, 0), (4, 0), (0, 4), (2, 0), (2, 2), (0, 2))
TRIANGLES = (((0, 0), 1), ((2, 0), 1), ((0, 2), 1), ((2, 2), -1))  # origin, and direction: the one amid points back
SQUARE = ((0, 0), (4, 0), (4, 4), (0, 4), (2, 0), (4, 2), (2, 4), (0, 2), (2, 2))
SQUARES = (((0, 0), 1), ((2, 0), 1), ((2, 2), 1), ((0, 2), 1))


def finer(mesh: PlanarMesh) -> PlanarMesh:
    """A mesh of quadratic elements on the same area, without groups: one for each linear element, or four for each
    quadratic one; curved edges stay as they are.
    """
    return _split(mesh) if mesh.kind.quadratic else _raised(mesh)


def _raised(mesh: PlanarMesh) -> PlanarMesh:
    """Nodes amid the straight edges, and amid quadrilaterals."""
    count, corners = len(mesh.places), mesh.cells
    _, first, edge = np.unique(mesh.edge_keys(), return_index=True, return_inverse=True)
    ends = corners[:, mesh.kind.edges()].reshape(-1, 2)[first]
    places = [mesh.places, mesh.places[ends].mean(axis=1)]
    cells = [corners, count + edge.reshape(corners.shape)]
    if mesh.kind.corners == 4:
        places.append(mesh.places[corners].mean(axis=1))
        cells.append(count + len(first) + np.arange(len(corners))[:, None])
    kind = KINDS["triangle6" if mesh.kind.corners == 3 else "quad9"]
    return PlanarMesh(kind, np.concatenate(places), np.column_stack(cells), source=mesh.source)


def _split(mesh: PlanarMesh) -> PlanarMesh:
    """Four elements for each, on the same shape functions."""
    element, parts = (TRIANGLE, TRIANGLES) if mesh.kind.corners == 3 else (SQUARE, SQUARES)
    children = [
        [tuple(int(o) + way * q // 2 for o, q in zip(at, spot, strict=True)) for spot in element] for at, way in parts
    ]
    spots = sorted({spot for child in children for spot in child})
    number, places = _nodes(mesh, spots, element)
    column = {spot: k for k, spot in enumerate(spots)}
    cells = np.concatenate([number[:, [column[spot] for spot in child]] for child in children])
    used, cells = np.unique(cells, return_inverse=True)
    return replace(mesh, places=places[used], cells=cells.reshape(-1, mesh.kind.nodes), groups={})


def _nodes(
    mesh: PlanarMesh, spots: list[tuple[int, ...]], element: tuple[tuple[int, int], ...]
) -> tuple[IntArray, FloatArray]:
    """(m, spots) numbers of the nodes at the spots of each element, and the places of all."""
    count, cells, corners = len(mesh.places), mesh.cells, mesh.kind.corners
    _, edge = np.unique(mesh.edge_keys(), return_inverse=True)
    edge = edge.reshape(len(cells), corners)
    on_edges = count + 2 * (int(edge.max()) + 1)
    number = np.empty((len(cells), len(spots)), dtype=np.int64)
    inside = 0
    for k, spot in enumerate(spots):
        if spot in element:
            number[:, k] = cells[:, element.index(spot)]
            continue
        side = _quarter_of(spot, element, corners)
        if side is None:
            number[:, k] = on_edges + inside * len(cells) + np.arange(len(cells))
            inside += 1
        else:  # two for each edge: the first is nearer to its end of lower number
            e, near = side
            far = (e + 1) % corners if near == e else e
            number[:, k] = count + 2 * edge[:, e] + (cells[:, near] > cells[:, far])
    X = 0.25 * np.array(spots, dtype=np.float64).T
    places = np.empty((on_edges + inside * len(cells), 2))
    places[number] = np.einsum("qn,mni->mqi", shape_functions(mesh, X)[0], mesh.places[cells])
    places[:count] = mesh.places
    return number, places


def _quarter_of(spot: tuple[int, ...], element: tuple[tuple[int, int], ...], corners: int) -> tuple[int, int] | None:
    """The edge on which the spot lies and the corner next to it; None inside."""
    for e in range(corners):
        a, b = np.array(element[e]), np.array(element[(e + 1) % corners])
        for near, here in ((e, (3 * a + b) // 4), ((e + 1) % corners, (a + 3 * b) // 4)):
            if tuple(here) == spot:
                return e, near
    return None
