"""Component mode synthesis: from a mesh and named nodes to the one kind of body, with as few coordinates as will do.

Each reduction spans the motion of the mesh by a basis T of displacements, then removes the rigid motions and turns T
into the own orthonormal basis of the body (:func:`lcpflex.bodies.finite_elements.body_of`): the frame is that of
Buckens (Tisserand), whatever the reduction.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from lcpflex.bodies.body import Body
from lcpflex.bodies.elastic_modes import FULL_LIMIT, FreeMesh, check_memory, fixed_modes, mesh_rank, orthonormal_frame
from lcpflex.bodies.finite_elements import FiniteElements, body_of
from lcpflex.bodies.node_choice import Nodes, chosen_nodes, rows_of
from lcpflex.bodies.own_basis import joined, own_basis
from lcpflex.bodies.reduction import Damping, check_damping, count_of_modes
from lcpflex.bodies.sparse_factor import NotPositive, positive_factor
from lcpflex.compiled import FloatArray, IntArray
from lcpflex.errors import ModelError

__all__ = ["Mesh", "craig_bampton", "free_interface", "residual_compliance", "sub_regional", "unreduced"]


class Mesh(Protocol):
    """What can be reduced: Matrices, Continuum, SolidOfRevolution."""

    def finite_elements(self) -> FiniteElements:
        """The matrices of the mesh and its named nodes."""
        ...


def free_interface(
    model: Mesh, modes: int | None = 8, *, damping: Damping | None = None, stiffening: Any = None
) -> Body:
    """The body with the ``modes`` lowest free-free modes of the mesh."""
    mesh = model.finite_elements()
    n = count_of_modes(modes, len(mesh.dofs) - mesh.rigid.shape[1])
    _early(mesh, damping, n)
    return _body(mesh, *FreeMesh(mesh).modes(n), damping, stiffening)


def craig_bampton(
    model: Mesh, boundary: Nodes, modes: int | None = 20, *, damping: Damping | None = None, stiffening: Any = None
) -> Body:
    """The body with constraint modes of the boundary nodes and ``modes`` modes of the mesh held there."""
    mesh = model.finite_elements()
    nodes = chosen_nodes(mesh, "boundary", boundary)
    held = rows_of(mesh, nodes)
    inner = np.setdiff1d(np.arange(len(mesh.dofs)), held)
    n = count_of_modes(modes, len(inner))
    columns = len(held) + n
    _early(mesh, damping, columns - mesh.rigid.shape[1])
    check_memory("boundary, modes", len(mesh.dofs), 5 * columns)
    basis = np.zeros((len(mesh.dofs), columns))
    basis[held, np.arange(len(held))] = 1.0
    rank = mesh_rank(mesh)
    if len(inner):
        stiffness = mesh.stiffness[inner][:, inner].tocsc()
        mass = mesh.mass[inner][:, inner].tocsc()
        try:
            factor = positive_factor(stiffness, rank[inner])
        except NotPositive:
            raise ModelError(_loose(len(nodes))) from None
        basis[inner, : len(held)] = -factor.solve(mesh.stiffness[inner][:, held].toarray())
        basis[inner, len(held) :] = fixed_modes(mass, stiffness, factor, n)[1]
    frame = orthonormal_frame(mesh.mass, mesh.rigid)
    return _body(mesh, *own_basis(mesh, frame, basis, holds_rigid=True), damping, stiffening)


def _loose(count: int) -> str:
    return (
        f"boundary: the rest of the mesh is loose with {count} node(s) held, expected a boundary that holds every "
        "piece of the rest (two nodes, one of an axisymmetric mesh)"
    )


def residual_compliance(
    model: Mesh, contact: Nodes, modes: int | None = 20, *, damping: Damping | None = None, stiffening: Any = None
) -> Body:
    """The body with its ``modes`` lowest free-free modes and the static response of the others at the contact nodes."""
    mesh = model.finite_elements()
    nodes = chosen_nodes(mesh, "contact", contact)
    n = count_of_modes(modes, len(mesh.dofs) - mesh.rigid.shape[1])
    rows = rows_of(mesh, nodes)
    check_memory("contact, modes", len(mesh.dofs), 5 * (len(rows) + n))
    free = FreeMesh(mesh)
    omega2, shapes = free.modes(n)
    rest = own_basis(mesh, free.frame, _residual(free, omega2, shapes, rows), holds_rigid=False)
    return _body(mesh, *joined((omega2, shapes), rest), damping, stiffening)


def _residual(free: FreeMesh, omega2: FloatArray, shapes: FloatArray, rows: IntArray) -> FloatArray:
    """(f, k) static displacements by unit loads at the rows, without what the kept modes have of them."""
    loads = np.zeros((len(shapes), len(rows)))
    loads[rows, np.arange(len(rows))] = 1.0
    static = free.flexibility(loads)
    for _ in range(2):
        static = static - shapes @ (shapes.T @ (free.mass @ static))
    return np.asarray(static)


def sub_regional(
    model: Mesh, region: Nodes, modes: int | None = 20, *, damping: Damping | None = None, stiffening: Any = None
) -> Body:
    """The body with the displacements of the nodes in a region, and modes of the rest."""
    mesh = model.finite_elements()
    nodes = chosen_nodes(mesh, "region", region)
    own = rows_of(mesh, nodes)
    rest = np.setdiff1d(np.arange(len(mesh.dofs)), own)
    if not len(rest):
        raise ModelError("region: it is the whole mesh, expected a part of it; use unreduced")
    r = mesh.rigid.shape[1]
    linked = abs(mesh.stiffness[rest][:, own]).sum(axis=0)
    border = own[np.asarray(linked).ravel() > 0.0]
    border = rows_of(mesh, np.unique(mesh.dofs[border] // 2))
    inside = np.setdiff1d(own, border)
    heavy = np.ones(len(mesh.dofs), dtype=bool)
    heavy[inside] = False
    n = count_of_modes(modes, len(rest))
    check_memory("region, modes", len(mesh.dofs), 5 * (len(own) + n + r))
    free = FreeMesh(mesh, _masked(mesh.mass, heavy), ~heavy)
    omega2, shapes = free.modes(n)
    nodal = np.zeros((len(mesh.dofs), len(inside)))
    nodal[inside, np.arange(len(inside))] = 1.0
    columns = [nodal, free.frame, shapes, _residual(free, omega2, shapes, border)]
    frame = orthonormal_frame(mesh.mass, mesh.rigid)
    return _body(mesh, *own_basis(mesh, frame, np.hstack(columns), holds_rigid=True), damping, stiffening)


def _masked(mass: Any, heavy: np.ndarray[Any, np.dtype[np.bool_]]) -> Any:
    from scipy.sparse import diags_array

    keep = diags_array(heavy.astype(float))
    return (keep @ mass @ keep).tocsc()


def unreduced(model: Mesh, *, damping: Damping | None = None, stiffening: Any = None) -> Body:
    """The body with all modes of the mesh: the motion of all nodes, a reference for reductions."""
    mesh = model.finite_elements()
    f = len(mesh.dofs)
    if f > FULL_LIMIT:
        raise ModelError(
            f"model: a mesh with {f} degrees of freedom was given, which needs about {4 * 8 * f * f / 2**30:.1f} GiB "
            f"unreduced, expected at most {FULL_LIMIT}; use a reduction"
        )
    n = f - mesh.rigid.shape[1]
    _early(mesh, damping, n)
    return _body(mesh, *FreeMesh(mesh).modes(n), damping, stiffening)


def _early(mesh: FiniteElements, damping: Damping | None, modes: int) -> None:
    """Refuse a damping that does not fit, before time is spent."""
    if damping is None:
        return
    if mesh.damping is not None:
        raise ModelError(f"damping: {damping!r} was given besides a damping matrix, expected one of the two")
    check_damping(damping, modes)


def _body(
    mesh: FiniteElements, omega2: FloatArray, shapes: FloatArray, damping: Damping | None, stiffening: Any
) -> Body:
    if stiffening is not None:
        raise ModelError(f"stiffening: {stiffening!r} was given, expected None")
    return replace(body_of(mesh, omega2, shapes, damping), ladder=None)
