"""Meshes of solids that are damaged, and arguments that cannot be: refused by name."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.fem.assembly import own_order
from lcpflex.bodies.fem.mesh import KINDS, Mesh
from lcpflex.jit.kernel import FloatArray
from tests import libs
from tests.solid_meshes import EDGES, QUIET, STEEL, meshed_block, solid


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: lf.Solid(3, **STEEL), "mesh: 3 was given, expected a scikit-fem mesh"),
        (lambda: lf.Solid(libs.skfem.MeshTri(), **STEEL), "mesh: MeshTri1 was given, .* scikit-fem mesh .MeshTet1"),
        (lambda: lf.Continuum(libs.skfem.MeshTet(), **STEEL), "mesh: MeshTet1 was given, expected a scikit-fem mesh"),
        (lambda: solid(sets={"a": lambda x, y, z: x > 9.0}), "no node fulfils the predicate, .*<= z <="),
        (lambda: solid(sets={"surface": [0]}), "the whole surface has it"),
        (lambda: solid().reduce(contact=[0], boundary=[1, 2, 3]), "boundary, contact: all were given"),
        (lambda: solid().reduce(contact=[0], rows="both"), "rows: 'both' was given"),
        (lambda: solid().reduce(interfaces=[(9.0, 0.0, 0.0)]), r"interfaces\[0\]: x, y, z: .* a place on the body"),
        (lambda: solid().reduce(interfaces=[lf.Interface(0, along=(1.0, 0.0))]), "expected a direction .x, y, z."),
        (lambda: lf.craig_bampton(solid(), [0, 1, 2], 3, stiffening=lf.Stiffening()), "given for a solid in space"),
        (lambda: lf.free_interface(solid(), 3, stiffening=lf.Stiffening()), "given for a solid in space"),
        (lambda: lf.Solid.box((1, 1, 1), 0.5, **STEEL, mesh=1), "mesh: it was given"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(make: Any, words: str) -> None:
    with pytest.raises(lf.ModelError, match=words):
        make()


def damaged(kind: str, cells: Any = None, places: Any = None) -> lf.Solid:
    mesh = meshed_block(kind, EDGES, (3, 2, 1))
    skm = {"tetra": libs.skfem.MeshTet1, "hexahedron": libs.skfem.MeshHex1}[kind]
    ours = mesh.cells if cells is None else cells(mesh.cells.copy())
    theirs = np.empty_like(ours)
    theirs[:, own_order(KINDS[kind])] = ours
    at = mesh.places if places is None else places(mesh.places.copy())
    return lf.Solid(skm(at.T.copy(), theirs.T.copy(), sort_t=False, validate=False), **STEEL)


@QUIET
@pytest.mark.parametrize("kind", ["tetra", "hexahedron"])
def test_damaged_meshes_are_refused_by_name(kind: str) -> None:
    def inverted(places: FloatArray) -> FloatArray:
        places[5] += [0.3, 0.0, 0.0]  # through its neighbours
        return places

    with pytest.raises(lf.ModelError, match=r"elements .* lie on the same side of a face \(one is inverted|is folded"):
        damaged(kind, places=inverted)

    def flat(places: FloatArray) -> FloatArray:
        places[:, 2] = 0.0
        return places

    with pytest.raises(lf.ModelError, match=r"element 0 at .* has the volume 0"):
        damaged(kind, places=flat)
    with pytest.raises(lf.ModelError, match="and a node twice"):
        damaged(kind, cells=lambda c: np.where(c == 5, 4, c))
    with pytest.raises(lf.ModelError, match="elements share a face"):
        damaged(kind, cells=lambda c: np.vstack([c, c[-1:], c[-1:]]))
    with pytest.raises(lf.ModelError, match="places of the nodes"):
        damaged(kind, places=lambda p: np.where(p == p[3, 0], np.nan, p))
    mirrored = damaged(kind, cells=lambda c: c[:, KINDS[kind].turned])
    assert mirrored.reduce(2).frequencies() == pytest.approx(damaged(kind).reduce(2).frequencies(), rel=1e-9)


def test_nodes_that_are_not_merged_are_told() -> None:
    mesh = meshed_block("hexahedron", EDGES, (3, 1, 1))
    cut = mesh.cells.copy()
    double = np.concatenate([mesh.places, mesh.places[mesh.cells[1, [1, 2, 6, 5]]]])
    cut[2, [0, 3, 7, 4]] = len(mesh.places) + np.arange(4)
    with pytest.raises(lf.ModelError, match=r"2 parts that share no face .* merge nodes that coincide"):
        lf.Solid(_as_skfem(double, cut), **STEEL)
    ring = meshed_block("hexahedron", EDGES, (2, 2, 1))  # cut between two of four elements that meet in a line
    places, cells = _cut(ring)
    with pytest.warns(lf.ModelWarning, match="nodes of its surface coincide"):
        lf.Solid(_as_skfem(places, cells), **STEEL)


def _as_skfem(places: FloatArray, cells: Any) -> Any:
    theirs = np.empty_like(cells)
    theirs[:, own_order(KINDS["hexahedron"])] = cells
    return libs.skfem.MeshHex1(places.T.copy(), theirs.T.copy(), sort_t=False, validate=False)


def _cut(mesh: Mesh) -> tuple[FloatArray, Any]:
    """Of the face between elements 0 and 1 (along y), the two outer nodes doubled in element 1."""
    outer = [k for k in np.intersect1d(mesh.cells[0], mesh.cells[1]) if mesh.places[k, 0] < 1e-9]
    cells = mesh.cells.copy()
    for row, node in enumerate(outer):
        cells[1][cells[1] == node] = len(mesh.places) + row
    return np.concatenate([mesh.places, mesh.places[outer]]), cells


def test_nodes_that_hang_on_faces_are_told() -> None:
    """A cube beside four small ones, which are joined to it by an arch."""
    places: list[FloatArray] = []

    def number(place: FloatArray) -> int:
        same = [k for k, one in enumerate(places) if np.allclose(one, place)]
        if not same:
            places.append(place)
        return same[0] if same else len(places) - 1

    def element(low: tuple[float, ...], high: tuple[float, ...], wide: float | None = None) -> list[int]:
        ends = np.array([low, high])
        corners = [np.array([ends[i, 0], ends[j, 1], ends[k, 2]]) for k in (0, 1) for i, j in AROUND]
        if wide is not None:  # at its far end along x
            corners = [np.array([x, wide if x == high[0] and y == high[1] else y, z]) for x, y, z in corners]
        return [number(corner) for corner in corners]

    small = [element((1.0, y, z), (1.5, y + 0.5, z + 0.5)) for y in (0.0, 0.5) for z in (0.0, 0.5)]
    up = [element((x, 0.0, z), (x + 1.0, 1.0, z + 1.0)) for x in (0.0, 3.0) for z in (1.0, 2.0)]
    arch = [
        element((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)),
        element((1.0, 0.0, 2.0), (3.0, 1.0, 3.0)),
        element((3.0, 0.0, 0.5), (4.0, 1.0, 1.0)),
    ]
    beam = element((1.5, 0.0, 0.5), (3.0, 0.5, 1.0), wide=1.0)
    with pytest.raises(lf.ModelError, match=r"2 parts that share no face .* let no node hang"):
        _solid_of(places, [*small, *up, *arch])
    with pytest.warns(lf.ModelWarning, match="4 of its faces lie on others, with other nodes at"):
        _solid_of(places, [*small, *up, *arch, beam])


AROUND = ((0, 0), (1, 0), (1, 1), (0, 1))


def _solid_of(places: list[FloatArray], cells: list[list[int]]) -> lf.Solid:
    used, numbers = np.unique(np.array(cells), return_inverse=True)
    return lf.Solid(_as_skfem(np.array(places)[used], numbers.reshape(-1, 8)), **STEEL)
