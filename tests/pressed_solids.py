"""Linear statics of solids that touch, without friction: nodal displacements, and rows of the library's contacts.

    K u = f + W lambda,   0 <= lambda  _|_  g + W^T u >= 0

Stiffness, faces, rows W and gaps g are those that a scene of the solids has; what is held has given displacements.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

import lcpflex as lf
from lcpflex.bodies.fem.assembly import gradients_at, reference_corners
from lcpflex.bodies.fem.mesh import Mesh
from lcpflex.bodies.fem.sparse_factor import positive_factor
from lcpflex.contact.near import near, normal_row
from lcpflex.contact.rows import contact_point
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import pack
from lcpflex.solvers.auto import solve_lcp
from lcpflex.solvers.mixed.problems import MixedLcp
from tests.solid_meshes import meshed_block

__all__ = ["Part", "Pressed", "Rows", "centre_stress", "graded", "grid_block", "meet", "press", "touch_ground"]

CONTACT = "contact"


def graded(first: float, even: float, end: float, growth: float) -> FloatArray:
    """From 0 to ``end``: steps of ``first`` up to ``even``, from there on each ``growth`` times the one before."""
    count = round(even / first)
    steps = [even / count] * count
    while sum(steps) < end:
        steps.append(steps[-1] * growth)
    line = np.concatenate([[0.0], np.cumsum(steps)])
    if len(line) > count + 2 and end - line[-2] < 0.5 * steps[-1]:
        line = line[:-1]
    beyond = line > even * (1.0 + 1e-9)
    line[beyond] = even + (line[beyond] - even) * (end - even) / (line[-1] - even)
    return line


def grid_block(kind: str, lines: Sequence[FloatArray], skew: float = 0.0, bend: Any = None) -> Mesh:
    """A block of hexahedra between the lines, each split in six where the kind is of tetrahedra.

    skew: by how much inner corners are moved at random, in elements. bend: moves all nodes then.
    """
    nx, ny, nz = (len(line) - 1 for line in lines)
    mesh = meshed_block(kind, (float(nx), float(ny), float(nz)), (nx, ny, nz))
    grid = np.rint(mesh.places).astype(int)
    corner = np.abs(mesh.places - grid).max(axis=1) < 1e-9
    away = np.random.default_rng(3).uniform(-skew, skew, (nx + 1, ny + 1, nz + 1, 3))
    away[[0, -1], :, :, 0] = away[:, [0, -1], :, 1] = away[:, :, [0, -1], 2] = 0.0
    moved = mesh.places.copy()
    moved[corner] += away[tuple(grid[corner].T)]
    places = np.column_stack([np.interp(moved[:, c], np.arange(len(line)), line) for c, line in enumerate(lines)])
    for k, amid in enumerate(mesh.kind.middles):
        if len(amid) > 1:  # edges stay straight
            places[mesh.cells[:, k]] = places[mesh.cells[:, list(amid)]].mean(axis=1)
    return Mesh(mesh.kind, places if bend is None else bend(places), mesh.cells)


class Rows(NamedTuple):
    """What touches, k of them."""

    gap: FloatArray  # (k,) [m]
    area: FloatArray  # (k,) [m^2]
    share: FloatArray  # (k,) of a force law of the whole face
    place: FloatArray  # (k, 3) of the point of the slave
    normal: FloatArray  # (k, 3) towards the first solid
    nodal: list[tuple[IntArray, FloatArray]]  # of each solid, its nodes and (k, nodes, 3)


def _nodes(solid: lf.Solid) -> IntArray:
    mesh = solid.finite_elements()
    return np.unique(mesh.facets[mesh.faces[CONTACT]])


def _added(scene: lf.SpatialScene, solid: lf.Solid) -> Any:
    """Its body moves as all nodes of the face can; it stands where the mesh is."""
    mesh, nodes = solid.finite_elements(), _nodes(solid)
    basis = np.zeros((len(mesh.dofs), 3 * len(nodes)))
    basis[(3 * nodes[:, None] + np.arange(3)).ravel(), np.arange(3 * len(nodes))] = 1.0
    far = np.setdiff1d(np.unique(mesh.facets), nodes)
    body = solid.reduce(basis=basis, clamped=far)
    return scene.add(body, position=body.origin)


def _moving(handle: Any, solid: lf.Solid) -> FloatArray:
    """(nodes, 3, velocities) of the nodes of its face."""
    points = handle.face(CONTACT).shape.points
    places = solid.finite_elements().places[_nodes(solid)] - handle.source.origin
    np.testing.assert_allclose([point.place for point in points], places, atol=1e-9 * np.abs(places).max())
    turns = [np.cross(np.eye(3), place).T for place in places]  # columns: what a turn about each axis does
    return np.array([
        np.column_stack([np.eye(3), turn, point.phi.T]) for turn, point in zip(turns, points, strict=True)
    ])  # fmt: skip


def _looked_at(scene: lf.SpatialScene, handles: list[Any], solids: list[lf.Solid], margin: float) -> Rows:
    """The rows at the start of a scene, of nodal displacements."""
    compiled = scene.compile(indents=lambda name: True)
    model, q = pack(compiled.model), np.array(compiled.q)
    table, count = near(model, q, margin)
    rows = np.array([normal_row(model, q, table, k) for k in range(count)])
    nodal = []
    for handle, solid in zip(handles, solids, strict=True):
        first, last = compiled.model.bodies.dof[[handle.body, handle.body + 1]]
        moving = _moving(handle, solid)
        flat = moving.reshape(-1, moving.shape[2])
        own = np.linalg.lstsq(flat.T, rows[:, first:last].T, rcond=None)[0]
        np.testing.assert_allclose(flat.T @ own, rows[:, first:last].T, atol=1e-9 * np.abs(rows).max())
        nodal.append((_nodes(solid), own.T.reshape(count, -1, 3)))
    points = np.array([contact_point(model, q, table, k) for k in range(count)])
    gap, area, share, normal = (values[:count].copy() for values in (table.gap, table.area, table.weight, table.normal))
    return Rows(gap, area, share, points, normal, nodal)


def meet(first: lf.Solid, second: lf.Solid, by: str, slave: int, margin: float) -> Rows:
    """Of the faces "contact" of two solids; ``slave``: which of them has the nodes or areas."""
    scene = lf.SpatialScene(gravity=(0, 0, 0))
    handles = [_added(scene, first), _added(scene, second)]
    faces = [handle.face(CONTACT) for handle in handles]
    scene.contact(*faces, node_side=faces[slave], points=by)
    return _looked_at(scene, handles, [first, second], margin)


def touch_ground(solid: lf.Solid, ground: Any, by: str, margin: float) -> Rows:
    """Of the face "contact" of a solid with a surface that ``ground`` makes of the ground of a scene."""
    scene = lf.SpatialScene(gravity=(0, 0, 0))
    handle = _added(scene, solid)
    scene.contact(handle.face(CONTACT), ground(scene.ground), points=by)
    return _looked_at(scene, [handle], [solid], margin)


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A solid, and what acts on it beside the contact.

    held : (f,) which displacements are given
    given : (f,) they [m]; counted where held
    load : (f,) [N]
    far : (f,) what is given besides for each newton of the whole normal force [m/N]; counted where held
    loose : whether what is held lets it move along z; how far is found with the forces
    """

    solid: lf.Solid
    held: Any
    given: FloatArray | None = None
    load: FloatArray | None = None
    far: FloatArray | None = None
    loose: bool = False


class Pressed(NamedTuple):
    """What contact makes of solids."""

    force: FloatArray  # (k,) normal forces [N]
    moved: list[FloatArray]  # of each solid, displacements (N, 3) [m]


def press(rows: Rows, parts: list[Part]) -> Pressed:
    """Solve for the normal forces and the displacements of all nodes."""
    k, loose = len(rows.gap), [part.loose for part in parts]
    M = np.zeros((k + sum(loose), k + sum(loose)))
    q = np.concatenate([rows.gap, np.zeros(sum(loose))])
    whole = []
    for part, (nodes, nodal) in zip(parts, rows.nodal, strict=True):
        W = np.zeros((k, part.solid.finite_elements().places.shape[0], 3))
        W[:, nodes] = nodal
        W = W.reshape(k, -1)
        moved = _moves(part, W)  # of no force, of each force
        M[:k, :k] += W @ moved[:, 1:]
        q[:k] += W @ moved[:, 0]
        if part.loose:
            at = k + sum(loose[: len(whole)])
            M[:k, at] = W[:, 2::3].sum(axis=1)
            M[at, :k] = -M[:k, at]
            q[at] = -float(part.load[2::3].sum())  # type: ignore[index]
        whole.append(moved)
    found = solve_lcp(MixedLcp(M, q, np.arange(len(q)) >= k)).z
    force = found[:k]
    shift = iter(found[k:])
    displaced = []
    for part, moved in zip(parts, whole, strict=True):
        u = (moved[:, 0] + moved[:, 1:] @ force).reshape(-1, 3)
        u[:, 2] += next(shift) if part.loose else 0.0
        displaced.append(u)
    return Pressed(force, displaced)


def _moves(part: Part, W: FloatArray) -> FloatArray:
    """(f, 1 + k) displacements by what acts without contact, and by each unit force of the contact."""
    mesh = part.solid.finite_elements()
    held = np.array(part.held)
    if part.loose:  # by one node, whose force is none in the end
        held[np.flatnonzero(~held & (mesh.dofs % 3 == 2))[-1]] = True
    free = np.flatnonzero(~held)
    K = mesh.stiffness.tocsc()
    moved = np.zeros((len(held), 1 + len(W)))
    right = np.zeros_like(moved)
    right[:, 1:] = W.T
    if part.load is not None:
        right[:, 0] += part.load
    if part.given is not None:
        moved[part.held, 0] = part.given[part.held]
    if part.far is not None:
        normal = np.abs(W[:, 2::3].sum(axis=1))
        moved[part.held, 1:] = np.outer(part.far[part.held], normal)
    right -= K @ moved
    factor = positive_factor(K[free][:, free].tocsc(), mesh.rank[free])
    moved[free] = factor.solve(right[free])
    return moved


def centre_stress(solid: lf.Solid, moved: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Places (e, 3) of the centres of the elements, and sigma_zz (e,) there [Pa]; bubbles have no gradient there."""
    elastic = solid.finite_elements().solid
    assert elastic is not None
    centre = reference_corners(elastic.mesh.kind).mean(axis=0)[:, None]
    at, _, slopes = gradients_at(elastic, centre)
    gradient = np.einsum("eqkd,ekc->ecd", slopes, moved[elastic.mesh.cells])
    L, G = elastic.lame
    return at[:, 0], L * np.trace(gradient, axis1=1, axis2=2) + 2.0 * G * gradient[:, 2, 2]
